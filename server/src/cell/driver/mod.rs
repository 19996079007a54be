mod effects;

use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use journal::{Appended, CellDecided, Claim, Head, LookupError, Record, Replay};
use tokio::sync::{mpsc, watch};
use tokio::time::Instant;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use workflow::{Cell, Fact, Input, Refusal, Reply};

use super::arm::ArmPort;
use super::clock::CellClock;
use super::handle::{Ask, CellHandle, Refused, Told};
use super::ids::Ids;
use super::places::Places;
use super::recovered::Recovered;
use super::snapshots::Snapshots;
use super::told::TellTimes;
use crate::clock::WallClock;
use crate::journal::{SharedJournal, Trouble};
use effects::follow;

/// Inputs that may wait. An arm has one operation at a time and is looked at a few times a second, so this only fills
/// if the journal stands still.
const WAITING: usize = 1_024;
/// How often a result that could not be kept is tried again.
const RETRY: Duration = Duration::from_millis(500);

/// The one task that owns a cell.
pub(crate) struct Driver {
    pub(crate) id: String,
    pub(crate) journal: SharedJournal,
    pub(crate) clock: CellClock,
    pub(crate) wall: Arc<dyn WallClock>,
    pub(crate) arms: BTreeMap<String, Arc<dyn ArmPort>>,
    pub(crate) tracker: TaskTracker,
    pub(crate) stop: CancellationToken,
}

/// What a snapshot is taken of.
pub(super) struct State<'a> {
    pub(super) id: &'a str,
    pub(super) cell: &'a Cell,
    pub(super) places: &'a Places,
    pub(super) told: &'a TellTimes,
}

impl Driver {
    /// Starts the task. Its first decision is the recovery.
    pub(crate) fn spawn(self, recovered: Recovered) -> CellHandle {
        let (asks, asked) = mpsc::channel(WAITING);
        let view = watch::Sender::new(Arc::new(recovered.cell.clone()));
        let places = recovered.places;
        let handle = CellHandle::new(
            asks.clone(),
            view.subscribe(),
            self.clock.clone(),
            places.clone(),
            recovered.told.clone(),
        );
        let ids = Ids::new(Arc::clone(&self.wall));
        let tracker = self.tracker.clone();
        let snapshots = Snapshots::new(
            u64::from(self.journal.upkeep().snapshot_after),
            recovered.decisions,
            recovered.snapshot_bytes,
        );
        let task = Task {
            snapshots,
            kept: None,
            cell: recovered.cell,
            told: recovered.told,
            decided_at: self.wall.now(),
            driver: self,
            ids,
            view,
            places,
            asks: asks.downgrade(),
            unkept: VecDeque::new(),
            said_unkept: false,
            writable: true,
            retry_at: None,
        };
        drop(tracker.spawn(task.run(asked, asks)));
        handle
    }
}

struct Task {
    cell: Cell,
    snapshots: Snapshots,
    /// The last decision, if it is not in the state yet as a whole.
    kept: Option<Head>,
    told: TellTimes,
    /// When the last decision was kept.
    decided_at: Timestamp,
    driver: Driver,
    ids: Ids,
    view: watch::Sender<Arc<Cell>>,
    places: Places,
    asks: mpsc::WeakSender<Ask>,
    /// What happened and could not be kept yet. It did happen, so it is not forgotten.
    unkept: VecDeque<Input>,
    said_unkept: bool,
    writable: bool,
    /// When what could not be kept is tried again.
    retry_at: Option<Instant>,
}

impl Task {
    async fn run(mut self, mut asked: mpsc::Receiver<Ask>, asks: mpsc::Sender<Ask>) {
        let stop = self.driver.stop.clone();
        self.happened(Input::Recover).await;
        for arm in self.driver.arms.values() {
            let look = follow(arm.watch(), asks.clone(), stop.clone());
            drop(self.driver.tracker.spawn(look));
        }
        drop(asks);
        loop {
            let deadline = self.deadline();
            let ask = tokio::select! {
                biased;
                () = stop.cancelled() => break,
                ask = asked.recv() => ask,
                () = sleep_until(deadline) => {
                    self.time_passed().await;
                    continue;
                }
            };
            let Some(Ask {
                input,
                claim,
                answer,
            }) = ask
            else {
                break;
            };
            match answer {
                None => self.happened(input).await,
                Some(answer) => {
                    let answered = self.asked(&input, claim).await;
                    if answer.send(answered).is_err() {
                        tracing::debug!("the caller went away before its answer");
                    }
                }
            }
        }
        asked.close();
        while let Some(ask) = asked.recv().await {
            if let Some(answer) = ask.answer {
                let _gone = answer.send(Err(Refused::Stopping));
            }
        }
    }

    fn deadline(&mut self) -> Option<Instant> {
        let clock = &self.driver.clock;
        let timer = self.cell.next_deadline().map(|at| clock.instant(at));
        if self.writable && self.unkept.is_empty() {
            self.retry_at = None;
            return timer;
        }
        // A timer that cannot be kept either must not spin. What is asked meanwhile does not put it off.
        Some(*self.retry_at.get_or_insert_with(|| Instant::now() + RETRY))
    }

    async fn time_passed(&mut self) {
        self.retry_at = None;
        if !self.writable && !self.try_journal().await {
            return;
        }
        while let Some(input) = self.unkept.pop_front() {
            if let Some(input) = self.take_notice(input).await {
                self.unkept.push_front(input);
                return;
            }
        }
        self.happened(Input::Tick).await;
    }

    /// Something happened, whoever likes it or not. What cannot be kept now is kept later, in its order.
    async fn happened(&mut self, input: Input) {
        // A timer fires again, and an arm is looked at again, by themselves.
        let comes_again = matches!(input, Input::Tick | Input::ArmObserved(_));
        let unkept = if comes_again || self.unkept.is_empty() {
            self.take_notice(input).await
        } else {
            Some(input)
        };
        if let Some(input) = unkept.filter(|_| !comes_again) {
            // Said once for as long as it stays.
            if !std::mem::replace(&mut self.said_unkept, true) {
                tracing::warn!(
                    cell.id = self.driver.id,
                    "what happened could not be kept yet"
                );
            }
            self.unkept.push_back(input);
        }
    }

    /// Decides what follows from something that happened; gives it back where that could not be kept.
    async fn take_notice(&mut self, input: Input) -> Option<Input> {
        match self.decide(&input, None).await {
            Ok(_) => {
                self.said_unkept = false;
                None
            }
            Err(Refused::Busy | Refused::Stopping) => None,
            Err(Refused::NotKept(_) | Refused::Cell(Refusal::JournalUnavailable)) => Some(input),
            Err(Refused::Cell(refusal)) => {
                tracing::debug!(cell.id = self.driver.id, %refusal, "the cell took no notice");
                None
            }
        }
    }

    /// Somebody asks, with a key or without.
    async fn asked(&mut self, input: &Input, claim: Option<Claim>) -> Result<Told, Refused> {
        if let Some(claim) = &claim {
            let now = self.driver.wall.now();
            match self.driver.journal.lookup(claim, now).await {
                Ok(None) => {}
                Ok(Some(replay)) => return Ok(told_before(&replay)),
                Err(LookupError::Refused(refusal)) => {
                    return Err(Refused::NotKept(Trouble::Refused(refusal)));
                }
                Err(error @ LookupError::Read(_)) => {
                    return Err(Refused::NotKept(Trouble::Unavailable(error.to_string())));
                }
            }
        }
        if matches!(input, Input::CreateJob { .. }) {
            // What runs gets its end on the reserve of a full disk; a job would begin something.
            self.driver.journal.room().map_err(Refused::NotKept)?;
        }
        self.decide(input, claim).await
    }

    /// Decides, keeps, applies, and sets off what follows: in this order.
    async fn decide(&mut self, input: &Input, claim: Option<Claim>) -> Result<Told, Refused> {
        let now = self.driver.clock.now();
        let decision = self
            .cell
            .decide(now, input.clone(), &mut self.ids)
            .map_err(Refused::Cell)?;
        let durable: Vec<&Fact> = decision
            .facts
            .iter()
            .filter(|fact| fact.is_durable())
            .collect();
        if !durable.is_empty()
            && let Some(replay) = self.keep(&durable, claim).await?
        {
            return Ok(told_before(&replay));
        }
        for fact in &decision.facts {
            for effect in self.cell.apply(self.driver.clock.now(), fact) {
                self.carry_out(effect);
            }
        }
        let _before = self.view.send_replace(Arc::new(self.cell.clone()));
        self.take_snapshot();
        Ok(Told {
            reply: decision.reply,
            replayed: false,
        })
    }

    /// Takes a snapshot where one is due. All facts of the last decision are folded.
    fn take_snapshot(&mut self) {
        let Some(covers) = self.kept.take() else {
            return;
        };
        let state = State {
            id: &self.driver.id,
            cell: &self.cell,
            places: &self.places,
            told: &self.told,
        };
        self.snapshots.take(
            &state,
            covers,
            &self.driver.journal,
            &self.driver.wall,
            &self.driver.tracker,
        );
    }

    /// Keeps a decision, unless its key stands for an earlier one.
    async fn keep(
        &mut self,
        facts: &[&Fact],
        claim: Option<Claim>,
    ) -> Result<Option<Box<Replay>>, Refused> {
        let text = serde_json::to_string(facts).unwrap_or_else(|error| {
            unreachable!("facts are plain data and always have a JSON form: {error}")
        });
        let bytes = text.len();
        let decided = CellDecided {
            cell: self.driver.id.clone(),
            facts: text,
            claim,
        };
        let now = self.driver.wall.now();
        let kept = self.driver.journal.decide_cell(now, decided).await;
        // What is told in this decision was told then, and still is after a restart.
        self.decided_at = now;
        // A record that breaks a rule says nothing about the journal.
        let writable = !matches!(
            kept,
            Err(Trouble::Full(_) | Trouble::Busy(_) | Trouble::Unavailable(_))
        );
        // That it can be written again the cell hears by the very decision that was kept first; see `try_journal`.
        if self.writable && !writable {
            tracing::error!(
                cell.id = self.driver.id,
                "nothing new is begun: the journal cannot be written"
            );
            self.tell_journal(false);
        }
        self.writable = writable;
        match kept.map_err(Refused::NotKept)? {
            Appended::New(receipt) => {
                let position = receipt.head.position;
                self.snapshots.count(bytes);
                self.kept = Some(receipt.head);
                self.places.note(position, facts.iter().copied());
                Ok(None)
            }
            Appended::Replayed(replay) => Ok(Some(replay)),
        }
    }

    /// The cell knows that the journal cannot be written. That itself is nothing to keep.
    fn tell_journal(&mut self, writable: bool) {
        let now = self.driver.clock.now();
        let decided = self
            .cell
            .decide(now, Input::Journal { writable }, &mut self.ids);
        let Ok(decision) = decided else { return };
        for fact in decision.facts.iter().filter(|fact| !fact.is_durable()) {
            for effect in self.cell.apply(now, fact) {
                self.carry_out(effect);
            }
        }
        let _before = self.view.send_replace(Arc::new(self.cell.clone()));
    }

    /// Whether it is worth trying to write again. What follows from a journal that can be written, jobs on hold, is the
    /// first thing that is kept.
    async fn try_journal(&mut self) -> bool {
        match self.decide(&Input::Journal { writable: true }, None).await {
            // Where there was nothing to keep, nothing was tried; the next record will be.
            Ok(_) => {
                self.writable = true;
                true
            }
            // It was never told that the journal could not be written: its recovery itself is still to be kept.
            Err(Refused::Cell(_)) => true,
            Err(Refused::NotKept(_) | Refused::Busy | Refused::Stopping) => false,
        }
    }
}

/// What the key's first request was answered with. A decision that made no job had nothing more to tell.
pub(crate) fn told_before(replay: &Replay) -> Told {
    let facts = if let Record::CellDecided(decided) = &replay.first.record {
        serde_json::from_str::<Vec<Fact>>(&decided.facts).unwrap_or_default()
    } else {
        Vec::new()
    };
    let job = facts.into_iter().find_map(|fact| {
        if let Fact::JobCreated { job, .. } = fact {
            Some(job)
        } else {
            None
        }
    });
    Told {
        reply: job.map_or(Reply::Unchanged, Reply::Created),
        replayed: true,
    }
}

async fn sleep_until(at: Option<Instant>) {
    match at {
        Some(at) => tokio::time::sleep_until(at).await,
        None => std::future::pending().await,
    }
}
