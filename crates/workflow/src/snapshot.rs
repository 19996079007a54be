//! What all facts amount to, to be kept instead of being folded again.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::book::{Book, Live};
use crate::cell::Cell;
use crate::setup::Setup;

/// The durable half of a [`Cell`]: what a replay of its facts would make, and nothing of what is seen right now.
///
/// A field is added with `#[serde(default)]`, so that older ones are read. Where that is not enough, or the fold of a
/// fact changes its meaning, [`Snapshot::FORMAT`] is raised, and older ones are not read: the facts are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    setup: Arc<Setup>,
    book: Book,
}

impl Snapshot {
    /// The number of the way it is written and read.
    pub const FORMAT: u32 = 1;
}

impl Cell {
    /// What its facts amount to. Cheap: what is large is shared.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        Snapshot {
            setup: Arc::clone(&self.setup),
            book: self.book.clone(),
        }
    }

    /// The cell after the facts that `snapshot` stands for, as [`Cell::replay`] of each would leave it.
    #[must_use]
    pub fn of_snapshot(snapshot: Snapshot) -> Self {
        Self {
            setup: snapshot.setup,
            book: snapshot.book,
            live: Live::default(),
        }
    }
}
