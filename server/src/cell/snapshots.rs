//! When what a cell's decisions amount to is kept, so that a start folds few of them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use journal::Head;
use tokio_util::task::TaskTracker;

use super::places::Places;
use super::recovered::Taken;
use super::told::TellTimes;
use crate::clock::WallClock;
use crate::journal::SharedJournal;

/// What was decided since the last snapshot.
///
/// One is taken after so many decisions as the configuration says, and not before they are half as long as the last
/// one was: what is written for snapshots stays in proportion to what is written for decisions, however much a cell
/// remembers.
#[derive(Debug)]
pub(super) struct Snapshots {
    after: u64,
    decisions: u64,
    bytes: u64,
    last: Arc<Last>,
}

#[derive(Debug)]
struct Last {
    bytes: AtomicU64,
    under_way: AtomicBool,
}

impl Snapshots {
    /// `bytes`: of the snapshot there is.
    pub(super) fn new(after: u64, decisions: usize, bytes: u64) -> Self {
        Self {
            after,
            decisions: decisions as u64,
            bytes: 0,
            last: Arc::new(Last {
                bytes: AtomicU64::new(bytes),
                under_way: AtomicBool::new(false),
            }),
        }
    }

    /// Counts a decision that was kept.
    pub(super) fn count(&mut self, bytes: usize) {
        self.decisions += 1;
        self.bytes += bytes as u64;
    }

    /// Takes one now, if it is due; it is written beside the driver, which does not wait for it.
    pub(super) fn take(
        &mut self,
        state: &super::driver::State<'_>,
        covers: Head,
        journal: &SharedJournal,
        wall: &Arc<dyn WallClock>,
        tracker: &TaskTracker,
    ) {
        let long = self.bytes >= self.last.bytes.load(Ordering::SeqCst) / 2;
        if self.decisions < self.after || !long || self.last.under_way.swap(true, Ordering::SeqCst)
        {
            return;
        }
        (self.decisions, self.bytes) = (0, 0);
        let taken = state.taken(covers);
        let (journal, wall, last) = (journal.clone(), Arc::clone(wall), Arc::clone(&self.last));
        let id = state.id.to_owned();
        drop(tracker.spawn(async move {
            match keep(taken, &journal, &wall).await {
                Ok(bytes) => {
                    last.bytes.store(bytes, Ordering::SeqCst);
                    tracing::debug!(cell.id = id, bytes, %covers.position, "a snapshot was kept");
                }
                // The decisions are all there: a start takes longer.
                Err(why) => tracing::warn!(cell.id = id, why, "no snapshot was kept"),
            }
            last.under_way.store(false, Ordering::SeqCst);
        }));
    }
}

async fn keep(
    taken: Taken,
    journal: &SharedJournal,
    wall: &Arc<dyn WallClock>,
) -> Result<u64, String> {
    // Some megabytes of text are no work for a thread that answers requests.
    let written = tokio::task::spawn_blocking(move || taken.write()).await;
    let snapshot = written.map_err(|error| error.to_string())??;
    let bytes = snapshot.body.len() as u64;
    let kept = journal.keep_snapshot(wall.now(), snapshot).await;
    kept.map(|_| bytes).map_err(|trouble| trouble.to_string())
}

impl super::driver::State<'_> {
    fn taken(&self, covers: Head) -> Taken {
        let (places, told): (&Places, &TellTimes) = (self.places, self.told);
        Taken::new(self.id, covers, self.cell, places, told)
    }
}
