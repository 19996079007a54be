//! What the journal says about itself: what its records amount to, and which of them it has no more.

use serde::{Deserialize, Serialize};

use crate::{Digest, Epoch, Head, KeyRetention};

/// What all decisions of a cell amount to was kept beside the records. Written by the journal itself.
///
/// A start reads it instead of them, so they may be removed; this record is what ties it into the chain.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct SnapshotTaken {
    /// The cell.
    pub cell: String,
    /// The last decision in it.
    pub covers: Head,
    /// How it is written; who cannot read this format reads the decisions.
    pub format: u32,
    /// Its size.
    pub bytes: u64,
    /// The digest of its bytes.
    pub digest: Digest,
}

/// The oldest records were removed, in the same transaction. Written by the journal itself.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct Pruned {
    /// The last one that was removed. What follows begins with its hash.
    pub through: Head,
    /// How many were removed with it.
    pub records: u64,
    /// The epoch then.
    pub epoch: Epoch,
    /// How long keys were remembered then.
    pub keys: KeyRetention,
    /// The file they were written out to before, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub archive: Option<String>,
}
