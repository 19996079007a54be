use std::sync::atomic::{AtomicU64, Ordering};

use super::SharedJournal;
use crate::authority::{EpochStore, NextEpoch};
use crate::identity::NotRecorded;

/// Leases one start of the server may give; more would run into the epochs of the next start.
const LEASES: u64 = 1_000_000;

/// Numbers leases by the journal's own epoch and a count.
///
/// The journal's epoch is durable before the server starts, in the journal and beside it, and grows with each opening,
/// also after a crash and over a backup that was put back. So the first lease of a start has a greater epoch than the
/// last one of the start before, whatever was or was not written meanwhile, and giving a lease needs no write:
/// whoever takes control does not wait for a disk that stalls, and gets it when the disk is full. A journal in memory
/// begins anew with each start, and so do these numbers.
#[derive(Debug)]
pub(crate) struct JournalEpochs {
    journal: SharedJournal,
    given: AtomicU64,
}

impl JournalEpochs {
    pub(crate) fn new(journal: SharedJournal) -> Self {
        Self {
            journal,
            given: AtomicU64::new(0),
        }
    }
}

impl EpochStore for JournalEpochs {
    fn next(&self, _cell: &str) -> NextEpoch<'_> {
        let number = self.given.fetch_add(1, Ordering::SeqCst) + 1;
        let epoch = if number < LEASES {
            Ok(self.journal.epoch().0 * LEASES + number)
        } else {
            Err(NotRecorded {
                reason: format!("this start of the server has given {LEASES} leases, and no more"),
            })
        };
        Box::pin(std::future::ready(epoch))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_start_does_not_give_the_epochs_of_the_next_one() {
        let epochs = JournalEpochs::new(SharedJournal::volatile());
        assert_eq!(epochs.next("c1").await, Ok(LEASES + 1));
        epochs.given.store(LEASES - 2, Ordering::SeqCst);
        assert_eq!(epochs.next("c2").await, Ok(2 * LEASES - 1));
        assert!(epochs.next("c1").await.is_err());
    }
}
