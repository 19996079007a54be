//! Motions as durable resources: intent in the journal before the first byte, outcome after, and what is known of
//! each at any time.
//!
//! ```text
//! POST ─▶ key, checks ─▶ door (one motion of a robot after the other): intent durable ─▶ link ─▶ controller
//!                                                                                         │
//!         book (in memory: what is shown and waited for) ◀── outcome durable ◀────────────┘
//! ```
//! The [`Permit`] to send comes from here alone, and here it comes from the journal: a motion without a durable
//! intent cannot be given to a link. Where the configuration names no journal, nothing outlives the process, and the
//! thesis's own routes, which take no keys, leave the journal out.

mod ask;
mod book;
mod doubts;
mod history;
mod idempotency;
mod intent;
mod numbered;
mod plans;
mod record;
mod seed;

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex as StdMutex, MutexGuard, PoisonError};

use api::ProblemCode;
use jiff::Timestamp;
use journal::{Begun, Claim, DurableIntent};
use tokio::sync::Mutex;
use tokio_util::task::TaskTracker;
use uuid::Uuid;

pub(crate) use ask::{actual, joint_duration, line_duration, resolve};
pub(crate) use book::{Book, Entry};
pub(crate) use doubts::{Respond, RespondError, Responded, intervention};
pub(crate) use history::recover;
pub(crate) use idempotency::{InFlight, KeyGuard, RequestKey};
use numbered::Leftover;
pub(crate) use numbered::Numbered;
pub(crate) use plans::{KEPT as PLAN_KEPT, Plan, Planned, Plans};
pub(crate) use record::{
    Asked, End, Progress, Record, Speed, apart, point_of_thousandths, thousandths_of,
};
pub(crate) use seed::{Accepted, CommandFailure, Start, Started, no_base, problem_of};

use crate::clock::WallClock;
use crate::config::RobotPlan;
use crate::journal::{Keeps, SharedJournal, Trouble};

/// The motions of one robot.
#[derive(Debug)]
pub(crate) struct Motions {
    plan: Arc<RobotPlan>,
    clock: Arc<dyn WallClock>,
    journal: SharedJournal,
    tracker: TaskTracker,
    pub(crate) book: Book,
    /// How the last intent was numbered. Whoever holds it is the only one whose motion goes to the journal and then to
    /// the link, so that the order there is the order here.
    door: Mutex<Door>,
    /// What an earlier process left behind, until the controller has been asked.
    leftovers: StdMutex<Vec<Leftover>>,
    recovering: AtomicUsize,
    /// How often a stop was asked for. A motion that came before the last one is not sent.
    stops: AtomicU64,
    pub(crate) plans: Plans,
}

/// How the last intent was numbered.
#[derive(Debug, Default)]
struct Door {
    number: u64,
    /// The epoch on the wire the number counts in, for a controller that keeps numbers.
    wire_epoch: Option<u32>,
    /// Which start of the controller it is.
    boot: Option<u32>,
}

impl Door {
    /// Numbers begin anew in each epoch of the wire.
    fn enter_wire_epoch(&mut self, epoch: u32, boot: Option<u32>) {
        if self.wire_epoch != Some(epoch) {
            self.wire_epoch = Some(epoch);
            self.number = 0;
        }
        self.boot = boot;
    }
}

/// The permission to send one motion, once. It cannot be copied.
#[derive(Debug)]
pub(crate) struct Permit(Kind);

#[derive(Debug)]
enum Kind {
    Durable(DurableIntent),
    /// Nothing outlives the process, so that there is nothing to keep.
    Unkept(Uuid),
}

/// What became of the beginning of a motion.
#[derive(Debug)]
pub(crate) enum Entered {
    New(Permit),
    /// The key stands for this motion; nothing is to be sent.
    Replayed(Uuid),
}

impl Permit {
    /// The motion.
    pub(crate) fn motion(&self) -> Uuid {
        match &self.0 {
            Kind::Durable(intent) => intent.motion().0,
            Kind::Unkept(motion) => *motion,
        }
    }
}

impl Motions {
    pub(crate) fn new(
        plan: Arc<RobotPlan>,
        clock: Arc<dyn WallClock>,
        journal: SharedJournal,
        tracker: TaskTracker,
    ) -> Self {
        Self {
            plan,
            clock,
            journal,
            tracker,
            book: Book::default(),
            door: Mutex::new(Door::default()),
            leftovers: StdMutex::new(Vec::new()),
            recovering: AtomicUsize::new(0),
            stops: AtomicU64::new(0),
            plans: Plans::default(),
        }
    }

    pub(crate) fn now(&self) -> Timestamp {
        self.clock.now()
    }

    fn leftovers(&self) -> MutexGuard<'_, Vec<Leftover>> {
        self.leftovers
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn journal(&self) -> &SharedJournal {
        &self.journal
    }

    /// Whether the controller can hold a motion and let it go on.
    pub(crate) fn holds(&self) -> bool {
        self.plan.tier.capabilities().hold_and_continue
    }

    /// Whether a motion of nobody's key is kept over a restart.
    fn keeps_all(&self) -> bool {
        self.journal.keeps() == Keeps::OverRestarts
    }

    /// Makes the intent of a motion durable and enters it in the book.
    async fn begin(
        &self,
        entry: Entry,
        claim: Option<Claim>,
        door: &mut Door,
    ) -> Result<Entered, Trouble> {
        let created_at = self.clock.now();
        let id = self.book.new_id(created_at);
        // A number whose intent is not kept stays unused: nobody knows whether it was.
        door.number += 1;
        let intent = self.intent(id, &entry, door, claim);
        match self.journal.begin_motion(created_at, intent).await? {
            Begun::New(durable) => {
                let _id = self.book.enter(entry, Some(id), created_at);
                Ok(Entered::New(Permit(Kind::Durable(durable))))
            }
            Begun::Replayed(replay) => match replay.first.record.motion() {
                Some(motion) => Ok(Entered::Replayed(motion.0)),
                // A job took the key.
                None => Err(Trouble::Refused(journal::Refusal::KeyReused {
                    first: replay.first.position,
                })),
            },
        }
    }

    /// Enters a motion that nobody keeps.
    fn begin_unkept(&self, entry: Entry) -> Permit {
        Permit(Kind::Unkept(self.book.enter(entry, None, self.clock.now())))
    }

    /// Begins a motion whose target only the link's owner could tell, from there.
    pub(crate) async fn begin_in_link(&self, entry: Entry) -> Result<Permit, Trouble> {
        if !self.keeps_all() {
            return Ok(self.begin_unkept(entry));
        }
        let mut door = self.door.lock().await;
        match self.begin(entry, None, &mut door).await? {
            Entered::New(permit) => Ok(permit),
            Entered::Replayed(_) => Err(Trouble::Unavailable(
                "a motion without a key was taken for another".to_owned(),
            )),
        }
    }

    /// From here on bytes may be on their way; `false` if the motion was taken back before.
    pub(crate) fn dispatch(&self, id: Uuid) -> bool {
        self.book.update(id, |progress| {
            matches!(progress, Progress::Queued).then_some(Progress::Dispatched)
        })
    }

    /// Makes a motion's end durable, shows it, and returns when that was.
    ///
    /// The journal comes first: nobody is told an end that a restart would take back. If it cannot be written, the end
    /// is shown all the same, because it is true; after a restart the motion is then in doubt.
    pub(crate) async fn end(&self, id: Uuid, end: End) -> Timestamp {
        let at = self.clock.now();
        let ended = self.book.look(id, |record| record.progress.end().is_some());
        if ended == Some(true) {
            // Taken back before its turn: that is its end, and is kept as such.
            return at;
        }
        if let Err(trouble) = self.keep_end(id, &end, at).await {
            tracing::error!(
                robot.id = self.plan.id,
                motion = %id,
                state = ?end.state(),
                error = %trouble,
                "the end of a motion could not be kept"
            );
        }
        // Not over another end: a motion may have been taken back while this one waited for the journal.
        let _shown = self.book.update(id, |progress| {
            progress
                .end()
                .is_none()
                .then_some(Progress::Ended { at, end })
        });
        at
    }

    async fn keep_end(&self, id: Uuid, end: &End, at: Timestamp) -> Result<(), Trouble> {
        let Some(in_journal) = self.book.look(id, |record| record.in_journal) else {
            return Ok(());
        };
        if !in_journal {
            if !matches!(end, End::InDoubt { .. }) {
                return Ok(());
            }
            // Somebody has to decide about it, and a decision needs what it is about.
            let Some(record) = self.book.get(id) else {
                return Ok(());
            };
            let mut door = self.door.lock().await;
            door.number += 1;
            let intent = self.intent(id, &record.entry(), &door, None);
            let _begun = self.journal.begin_motion(at, intent).await?;
        }
        let _kept = self.journal.append(at, intent::ended(id, end)).await?;
        Ok(())
    }

    /// Counts the stops.
    pub(crate) fn stops(&self) -> u64 {
        self.stops.load(Ordering::Acquire)
    }

    /// Takes back every motion that waits, at once: what is shown does not wait for the journal, which follows.
    ///
    /// A motion that is on its way to the journal now is taken back when it comes from there.
    pub(crate) fn stop(self: &Arc<Self>) -> Vec<Uuid> {
        let _before = self.stops.fetch_add(1, Ordering::AcqRel);
        let mut taken = self.book.queued();
        taken.retain(|id| self.take_back(*id));
        taken
    }

    /// Takes back a motion that a stop came before.
    fn heed_stop(self: &Arc<Self>, id: Uuid, stops: u64) {
        if self.stops() != stops {
            let _taken = self.take_back(id);
        }
    }

    /// Takes back a motion that waits for the link; `false` if it does not wait.
    pub(crate) fn take_back(self: &Arc<Self>, id: Uuid) -> bool {
        let at = self.clock.now();
        let end = End::NotExecuted {
            code: ProblemCode::MotionCanceled,
            why: Some("taken back before it was sent".into()),
        };
        let taken = self.book.update(id, |progress| {
            matches!(progress, Progress::Queued).then(|| Progress::Ended {
                at,
                end: end.clone(),
            })
        });
        if taken {
            let this = Arc::clone(self);
            drop(self.tracker.spawn(async move {
                if let Err(trouble) = this.keep_end(id, &end, at).await {
                    tracing::error!(motion = %id, error = %trouble, "a cancellation could not be kept");
                }
            }));
        }
        taken
    }
}
