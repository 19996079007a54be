//! Why a journal did not do what was asked, and what that means for the arm.

use std::error::Error as StdError;
use std::sync::Arc;

use thiserror::Error;

use crate::{Broken, MAX_PAGE, Position, Refusal};

/// The cause of a failure of the store. Shared, because one failed write fails for everyone in the same group.
pub type Cause = Arc<dyn StdError + Send + Sync>;

/// A record was not kept, or it is not known whether it was.
#[derive(Clone, Debug, Error)]
pub enum AppendError {
    /// It breaks a rule. Nothing was written; the journal goes on.
    #[error("the record was refused")]
    Refused(#[source] Refusal),
    /// Too many wait already. Nothing was written; the journal goes on.
    #[error("{capacity} records wait to be written already")]
    Busy {
        /// How many may wait.
        capacity: usize,
    },
    /// The disk is full. What ends work that has begun is still kept, in the reserve; this would have begun some.
    /// Nothing was written; the journal goes on, and takes it again when there is room.
    #[error(
        "the disk is full; the reserve of {} is kept for the ends of what has begun",
        size(*.reserve)
    )]
    NoRoom {
        /// The reserve, in bytes.
        reserve: u64,
    },
    /// Writing failed. The journal takes nothing more until it is opened again.
    #[error("{step} failed; the journal takes nothing more until it is opened again")]
    Failed {
        /// What was being done.
        step: &'static str,
        /// Whether the record may be found later.
        effect: Effect,
        /// Why.
        #[source]
        source: Cause,
    },
    /// An earlier write failed. Nothing was written.
    ///
    /// A write that failed is never tried again as if nothing had happened: after a failed fsync the kernel may have
    /// dropped the bytes and marked them as clean, and a second fsync then succeeds without them. What is on the
    /// disk is known again only after reading it, which is what opening does.
    #[error(
        "the journal takes nothing more until it is opened again, because an earlier write failed"
    )]
    Poisoned(#[source] Cause),
    /// The journal was closed, or its owner is gone, before the answer came.
    #[error("the journal is closed")]
    Closed {
        /// Whether the record may be found later.
        effect: Effect,
    },
}

/// Whether a record that was not confirmed may be found in the journal later.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Effect {
    /// It will not.
    None,
    /// It may. An intent of this kind was never sent, and recovery lists it as open.
    Unknown,
}

impl AppendError {
    /// Whether the record may be found later.
    #[must_use]
    pub fn effect(&self) -> Effect {
        match self {
            Self::Refused(_) | Self::Busy { .. } | Self::NoRoom { .. } | Self::Poisoned(_) => {
                Effect::None
            }
            Self::Failed { effect, .. } | Self::Closed { effect } => *effect,
        }
    }

    /// Whether it was not kept for want of room, as far as the store tells.
    #[must_use]
    pub fn is_disk_full(&self) -> bool {
        let cause = match self {
            Self::Failed { source, .. } | Self::Poisoned(source) => source,
            Self::NoRoom { .. } => return true,
            Self::Refused(_) | Self::Busy { .. } | Self::Closed { .. } => return false,
        };
        if let Some(error) = cause.downcast_ref::<std::io::Error>() {
            return error.kind() == std::io::ErrorKind::StorageFull;
        }
        cause.downcast_ref().is_some_and(is_full)
    }

    /// Whether the journal takes further records.
    #[must_use]
    pub fn is_fatal(&self) -> bool {
        match self {
            Self::Refused(_) | Self::Busy { .. } | Self::NoRoom { .. } => false,
            Self::Failed { .. } | Self::Poisoned(_) | Self::Closed { .. } => true,
        }
    }
}

/// A record could not be read.
#[derive(Clone, Debug, Error)]
pub enum ReadError {
    /// More was asked for than a page holds.
    #[error("a page has 1 to {MAX_PAGE} records, {limit} were asked for")]
    Limit {
        /// What was asked for.
        limit: usize,
    },
    /// The store failed.
    #[error("reading the journal")]
    Store(#[source] Cause),
    /// A record is not what was written.
    #[error("the journal is damaged")]
    Broken(#[source] Arc<Broken>),
    /// A record that is referred to is not there.
    #[error("record {position}, to which the index refers, is not there")]
    Absent {
        /// Where it should be.
        position: Position,
    },
    /// The journal was closed.
    #[error("the journal is closed")]
    Closed,
}

/// What a key stands for could not be said.
#[derive(Clone, Debug, Error)]
pub enum LookupError {
    /// It may not be used like this.
    #[error("the idempotency key cannot be used")]
    Refused(#[source] Refusal),
    /// Reading failed.
    #[error("looking up the idempotency key")]
    Read(#[source] ReadError),
}

/// Whether SQLite says that there is no room (`SQLITE_FULL`): of a full disk, and of its own limit.
pub(crate) fn is_full(error: &sqlx::Error) -> bool {
    if let sqlx::Error::Io(error) = error {
        return error.kind() == std::io::ErrorKind::StorageFull;
    }
    error
        .as_database_error()
        .and_then(sqlx::error::DatabaseError::code)
        .is_some_and(|code| code == "13")
}

fn size(bytes: u64) -> String {
    const MIB: u64 = 1 << 20;
    if bytes.is_multiple_of(MIB) {
        format!("{} MiB", bytes / MIB)
    } else {
        format!("{} KiB", bytes >> 10)
    }
}

pub(crate) fn check_limit(limit: usize) -> Result<(), ReadError> {
    if (1..=MAX_PAGE).contains(&limit) {
        Ok(())
    } else {
        Err(ReadError::Limit { limit })
    }
}
