//! The events of the newest records, kept once for all streams.
//!
//! Nothing is made while nobody listens: whoever comes later reads what was missed from the journal.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use jiff::Timestamp;
use journal::Position;
use tokio::sync::{Notify, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::id::{Epochs, EventId};
use super::project::{Batch, Projector};
use crate::cell::CellHandle;
use crate::journal::SharedJournal;

/// Records whose events are kept, and how much they may be.
const RECORDS: usize = 4_096;
const BYTES: usize = 8 * 1024 * 1024;
const PAGE: usize = 256;

/// What happens, for every stream of a server.
#[derive(Clone, Debug)]
pub(crate) struct Events(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    journal: SharedJournal,
    epochs: Epochs,
    cells: Vec<(Arc<str>, CellHandle)>,
    ring: Mutex<Ring>,
    news: watch::Sender<EventId>,
    /// Somebody listens again.
    wake_up: Notify,
    stop: CancellationToken,
}

#[derive(Debug)]
struct Ring {
    /// The last record that is not in it any more.
    before: Position,
    batches: VecDeque<Arc<Batch>>,
    bytes: usize,
    /// Nobody listened when a record came. Until somebody does, nothing is read.
    asleep: bool,
}

impl Ring {
    fn behind(before: Position) -> Self {
        Self {
            before,
            batches: VecDeque::new(),
            bytes: 0,
            asleep: false,
        }
    }
}

/// What the ring has behind a place.
pub(super) enum Ahead {
    /// These follow; none if nothing happened since.
    Batches(Vec<Arc<Batch>>),
    /// The place is further back than the ring.
    Lapped,
}

impl Events {
    /// Starts the task that reads each new record once. It ends once `stop` is cancelled.
    pub(crate) fn start(
        journal: SharedJournal,
        now: Timestamp,
        cells: Vec<(Arc<str>, CellHandle)>,
        tracker: &TaskTracker,
        stop: CancellationToken,
    ) -> Self {
        let epochs = Epochs::of(&journal, now);
        let head = head(&journal, epochs);
        let this = Self(Arc::new(Inner {
            journal,
            epochs,
            cells,
            ring: Mutex::new(Ring::behind(head.position)),
            news: watch::Sender::new(head),
            wake_up: Notify::new(),
            stop: stop.clone(),
        }));
        let tail = this.clone();
        drop(tracker.spawn(async move { stop.run_until_cancelled(tail.follow()).await }));
        this
    }

    /// The newest event there is, as it changes. As long as this is held, events are made.
    pub(super) fn listen(&self) -> watch::Receiver<EventId> {
        let mut ring = self.ring();
        let news = self.0.news.subscribe();
        if ring.asleep {
            let head = head(&self.0.journal, self.0.epochs);
            *ring = Ring::behind(head.position);
            let _before = self.0.news.send_replace(head);
            self.0.wake_up.notify_one();
        }
        news
    }

    #[cfg(test)]
    pub(super) fn has_listeners(&self) -> bool {
        self.0.news.receiver_count() > 0
    }

    /// The newest event there is.
    pub(super) fn newest(&self) -> EventId {
        *self.0.news.borrow()
    }

    fn ring(&self) -> MutexGuard<'_, Ring> {
        self.0.ring.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn stop(&self) -> &CancellationToken {
        &self.0.stop
    }

    pub(super) fn journal(&self) -> &SharedJournal {
        &self.0.journal
    }

    /// A projector for a stream that reads the journal itself.
    pub(super) fn projector(&self) -> Projector {
        Projector::new(self.0.journal.clone(), self.0.epochs, &self.0.cells)
    }

    pub(super) fn behind(&self, after: Position, limit: usize) -> Ahead {
        let ring = self.ring();
        if after < ring.before {
            return Ahead::Lapped;
        }
        let first = ring
            .batches
            .partition_point(|batch| batch.id.position <= after);
        Ahead::Batches(ring.batches.range(first..).take(limit).cloned().collect())
    }

    async fn follow(&self) {
        let mut kept = self.0.journal.watch();
        let mut projector = self.projector();
        let mut after = self.newest().position;
        loop {
            let _seen = *kept.borrow_and_update();
            if self.falls_asleep() {
                self.0.wake_up.notified().await;
                projector = self.projector();
                after = self.ring().before;
            }
            match self.0.journal.page(after, PAGE).await {
                Ok(page) if !page.is_empty() => {
                    for stored in &page {
                        after = stored.position;
                        let batch = projector.events(stored).await;
                        let id = batch.id;
                        self.push(batch);
                        let _before = self.0.news.send_replace(id);
                    }
                    continue;
                }
                Ok(_) => {}
                // Read again with the next record; streams fall back to the journal and hear of it there.
                Err(error) => tracing::warn!(%error, "new records have no events yet"),
            }
            if kept.changed().await.is_err() {
                return;
            }
        }
    }

    /// Whether nobody listens. Then the next who does begins with an empty ring.
    fn falls_asleep(&self) -> bool {
        let mut ring = self.ring();
        if self.0.news.receiver_count() == 0 {
            *ring = Ring::behind(ring.before);
            ring.asleep = true;
        }
        ring.asleep
    }

    fn push(&self, batch: Batch) {
        let mut ring = self.ring();
        ring.bytes += batch.bytes();
        ring.batches.push_back(Arc::new(batch));
        while ring.batches.len() > RECORDS || ring.bytes > BYTES {
            let Some(oldest) = ring.batches.pop_front() else {
                return;
            };
            ring.bytes -= oldest.bytes();
            ring.before = oldest.id.position;
        }
    }
}

fn head(journal: &SharedJournal, epochs: Epochs) -> EventId {
    EventId {
        epoch: epochs.shown(journal.epoch()),
        position: journal.head().position,
    }
}
