//! Who did what, into the journal, without anybody waiting who must not.
//!
//! ```text
//! note ──▶ bounded queue ──▶ one task ──▶ journal, in order       full, or the journal takes nothing: the log alone,
//! record ─────┘  └─ waits for the receipt, at most 5 s                and a count, which the journal is told later
//! ```
//!
//! What grants a right for longer than a lease (a token) is recorded before it is done: a right nobody can trace is not
//! given. What takes a right away, gives control or takes it, or stops something is done at once and noted: no disk
//! keeps a person from the arm. Nothing moves meanwhile in any case, because a motion needs its own record first.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use journal::{Audit, AuditResult, Clocks, Record};
use tokio::sync::{mpsc, oneshot};
use tokio::time::{sleep, timeout};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::{SharedJournal, Trouble};
use crate::clock::WallClock;
use crate::identity::{AuditSink, NotRecorded, Recorded, TracingAudit};

/// Entries that may wait. A person makes a few in a minute; a script that takes and gives back control, a few hundred
/// in a second.
const QUEUE: usize = 4_096;
/// How long a request waits for its record.
const RECORD_WITHIN: Duration = Duration::from_secs(5);
/// Until the journal's own queue is asked again after it was full.
const RETRY: Duration = Duration::from_millis(20);

/// Keeps entries in the journal, and shows them in the log.
#[derive(Debug)]
pub(crate) struct JournalAudit {
    queue: mpsc::Sender<Queued>,
    journal: SharedJournal,
    clock: Arc<dyn WallClock>,
    health: AuditHealth,
}

/// How many entries are in the log alone. Cheap to clone.
#[derive(Clone, Debug, Default)]
pub(crate) struct AuditHealth(Arc<Lost>);

#[derive(Debug, Default)]
struct Lost {
    /// Since the start.
    all: AtomicU64,
    /// Of these, those the journal was told of.
    told: AtomicU64,
}

#[derive(Debug)]
struct Queued {
    at: Clocks,
    entry: Audit,
    answer: Option<oneshot::Sender<Result<(), Trouble>>>,
}

impl AuditHealth {
    /// How many entries since the start are in the log and not in the journal.
    pub(crate) fn lost(&self) -> u64 {
        self.0.all.load(Ordering::SeqCst)
    }

    fn untold(&self) -> u64 {
        let told = self.0.told.load(Ordering::SeqCst);
        self.lost().saturating_sub(told)
    }

    /// Says it once, until the journal has taken entries again.
    fn lose(&self, reason: &str) {
        if self.untold() == 0 {
            tracing::error!(
                reason,
                "the record of who did what does not get into the journal; until it does again it is in this log alone"
            );
        }
        let _before = self.0.all.fetch_add(1, Ordering::SeqCst);
    }
}

impl JournalAudit {
    /// Starts the task. It ends when nobody can make entries any more; after `stop`, within `grace`.
    pub(crate) fn spawn(
        journal: SharedJournal,
        clock: Arc<dyn WallClock>,
        grace: Duration,
        tracker: &TaskTracker,
        stop: CancellationToken,
    ) -> Self {
        let (queue, queued) = mpsc::channel(QUEUE);
        let health = AuditHealth::default();
        let writer = Writer {
            journal: journal.clone(),
            clock: Arc::clone(&clock),
            health: health.clone(),
        };
        drop(tracker.spawn(writer.run(queued, grace, stop)));
        Self {
            queue,
            journal,
            clock,
            health,
        }
    }

    pub(crate) fn health(&self) -> AuditHealth {
        self.health.clone()
    }

    fn enqueue(
        &self,
        entry: Audit,
        answer: Option<oneshot::Sender<Result<(), Trouble>>>,
    ) -> Result<(), &'static str> {
        let at = self.journal.reading(self.clock.now());
        let queued = Queued { at, entry, answer };
        self.queue.try_send(queued).map_err(|error| match error {
            mpsc::error::TrySendError::Full(_) => "too many entries wait already",
            mpsc::error::TrySendError::Closed(_) => "the server is stopping",
        })
    }
}

impl AuditSink for JournalAudit {
    fn record(&self, entry: Audit) -> Recorded<'_> {
        TracingAudit.note(entry.clone());
        let (answer, answered) = oneshot::channel();
        let queued = self.enqueue(entry, Some(answer));
        Box::pin(async move {
            let not = |reason: String| NotRecorded { reason };
            queued.map_err(|reason| not(reason.to_owned()))?;
            match timeout(RECORD_WITHIN, answered).await {
                Ok(Ok(kept)) => kept.map_err(|trouble| not(trouble.to_string())),
                Ok(Err(_)) => Err(not("the server is stopping".to_owned())),
                Err(_) => Err(not(format!(
                    "the disk has not taken it within {} s",
                    RECORD_WITHIN.as_secs()
                ))),
            }
        })
    }

    fn note(&self, entry: Audit) {
        TracingAudit.note(entry.clone());
        if let Err(reason) = self.enqueue(entry, None) {
            self.health.lose(reason);
        }
    }
}

struct Writer {
    journal: SharedJournal,
    clock: Arc<dyn WallClock>,
    health: AuditHealth,
}

impl Writer {
    async fn run(
        self,
        mut queued: mpsc::Receiver<Queued>,
        grace: Duration,
        stop: CancellationToken,
    ) {
        let write = async {
            while let Some(one) = queued.recv().await {
                self.keep(one).await;
            }
        };
        let stopped = async {
            stop.cancelled().await;
            sleep(grace).await;
        };
        tokio::select! {
            biased;
            () = write => return,
            () = stopped => {}
        }
        queued.close();
        while let Ok(left) = queued.try_recv() {
            if left.answer.is_none() {
                self.health.lose("the server has stopped");
            }
        }
    }

    async fn keep(&self, Queued { at, entry, answer }: Queued) {
        let kept = self.append(at, entry).await;
        match (answer, kept) {
            (Some(answer), kept) => {
                // Whoever asked has gone away; what is kept is kept.
                let _gone = answer.send(kept);
            }
            (None, Err(trouble)) => self.health.lose(&trouble.to_string()),
            (None, Ok(())) => self.tell_of_lost().await,
        }
    }

    async fn append(&self, at: Clocks, entry: Audit) -> Result<(), Trouble> {
        loop {
            let record = Record::Audit(entry.clone());
            match self.journal.append_at(at, record).await {
                Ok(_kept) => return Ok(()),
                Err(Trouble::Busy(_)) => sleep(RETRY).await,
                Err(trouble) => return Err(trouble),
            }
        }
    }

    /// A gap in the journal has an entry of its own, so that nobody takes it for a quiet hour.
    async fn tell_of_lost(&self) {
        let lost = self.health.untold();
        if lost == 0 {
            return;
        }
        let entry = Audit {
            principal: "server".to_owned(),
            action: "audit.lost".to_owned(),
            object: format!("{lost} entries before this one, which the log has"),
            result: AuditResult::Failed,
            request_id: None,
            cell: None,
            role: None,
            source: None,
            lease: None,
            before: None,
            after: None,
        };
        let at = self.journal.reading(self.clock.now());
        if self.append(at, entry).await.is_ok() {
            let _before = self.health.0.told.fetch_add(lost, Ordering::SeqCst);
            tracing::warn!(
                lost,
                "the record of who did what gets into the journal again; the entries meanwhile are in this log alone"
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use journal::{KeyRetention, MemoryDisk, MemoryJournal, Opening};

    use super::*;
    use crate::clock::SystemClock;

    struct World {
        disk: MemoryDisk,
        audit: JournalAudit,
        tracker: TaskTracker,
        stop: CancellationToken,
    }

    fn world() -> World {
        let disk = MemoryDisk::new();
        let opening = Opening {
            at: Clocks {
                wall: SystemClock.now(),
                monotonic: Duration::ZERO,
            },
            program: "test".into(),
            keys: KeyRetention::default(),
        };
        let journal = SharedJournal::durable(MemoryJournal::open(&disk, &opening).unwrap());
        let (tracker, stop) = (TaskTracker::new(), CancellationToken::new());
        let grace = Duration::from_secs(1);
        let audit = JournalAudit::spawn(
            journal,
            Arc::new(SystemClock),
            grace,
            &tracker,
            stop.clone(),
        );
        World {
            disk,
            audit,
            tracker,
            stop,
        }
    }

    fn entry(n: usize) -> Audit {
        let principal = crate::identity::Principal::demo();
        crate::identity::entry(&principal, "test.act", format!("{n}"), "q")
    }

    /// The objects of the entries in the journal, in their order.
    fn kept(disk: &MemoryDisk) -> Vec<String> {
        let rows = disk.rows();
        let stored = rows
            .iter()
            .map(|row| journal::Stored::decode(&row.body).unwrap());
        stored
            .filter_map(|stored| {
                let Record::Audit(audit) = stored.record else {
                    return None;
                };
                Some(audit.object)
            })
            .collect()
    }

    #[tokio::test(start_paused = true)]
    async fn entries_are_kept_in_their_order_and_none_is_left_at_the_end() {
        let world = world();
        world.disk.hold_syncs();
        for n in 0..5 {
            world.audit.note(entry(n));
        }
        assert!(kept(&world.disk).is_empty());
        world.disk.release_syncs();
        world.audit.record(entry(5)).await.unwrap();
        world.stop.cancel();
        drop(world.audit);
        let _closed = world.tracker.close();
        world.tracker.wait().await;
        assert_eq!(kept(&world.disk), ["0", "1", "2", "3", "4", "5"]);
    }

    /// Covers: D9.
    #[tokio::test(start_paused = true)]
    async fn d9_a_stalled_disk_is_waited_for_by_records_for_a_while_and_by_notes_not_at_all() {
        let world = world();
        world.disk.hold_syncs();
        for n in 0..QUEUE + 10 {
            world.audit.note(entry(n));
        }
        let lost = world.audit.health().lost();
        assert!((9..=10).contains(&lost), "{lost}");
        let refused = world.audit.record(entry(0)).await.unwrap_err();
        assert!(refused.reason.contains("wait already"), "{refused}");
        world.disk.release_syncs();
        while kept(&world.disk).len() < QUEUE {
            tokio::task::yield_now().await;
        }
        // The gap is told of, behind what was kept.
        world.audit.record(entry(1)).await.unwrap();
        assert!(
            kept(&world.disk)
                .iter()
                .any(|one| one.contains("which the log has"))
        );
        world.disk.hold_syncs();
        let refused = world.audit.record(entry(2)).await.unwrap_err();
        assert!(refused.reason.contains("5 s"), "{refused}");
        // A disk that never comes back does not keep the server from stopping.
        world.audit.note(entry(3));
        world.stop.cancel();
        let _closed = world.tracker.close();
        world.tracker.wait().await;
    }

    #[tokio::test(start_paused = true)]
    async fn what_a_broken_journal_does_not_take_is_counted() {
        let world = world();
        world.disk.fail_next("audit", journal::Fault::Refuse);
        for n in 0..3 {
            world.audit.note(entry(n));
        }
        assert!(world.audit.record(entry(3)).await.is_err());
        assert_eq!(world.audit.health().lost(), 3);
        assert!(kept(&world.disk).is_empty());
    }
}
