//! The one task that owns a robot: it moves time, signals, messages and questions between the world and the core.

mod link;

use std::time::Duration;

use api::OutboxMessage;
use client::MobileRobotClient;
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::{Instant, sleep_until};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::cell;
use crate::clock::{Clock, Step, Timekeeper};
use crate::config::LinkSection;
use crate::core::{Advance, Core};
use crate::error::Refusal;
use crate::fault::Fault;
use crate::ledger::LedgerEntry;
use crate::state::State;
use link::{Link, News};

/// The most of a robot's time that passes before others get their turn.
const TURN: Duration = Duration::from_secs(5);
/// A robot that runs by itself looks up so often, not more.
const LOOK: Duration = Duration::from_millis(20);
/// Questions that may wait for an answer.
pub(crate) const COMMAND_QUEUE: usize = 64;

/// A question or an order to the robot.
#[derive(Debug)]
pub(crate) enum Command {
    State(oneshot::Sender<State>),
    Ledger {
        after: u64,
        answer: oneshot::Sender<Page>,
    },
    SetFault {
        fault: Fault,
        answer: oneshot::Sender<Result<u64, Refusal>>,
    },
    ClearFaults(oneshot::Sender<usize>),
    Put {
        slot: String,
        load: String,
        answer: oneshot::Sender<Result<(), Refusal>>,
    },
    Take {
        slot: String,
        answer: oneshot::Sender<Result<String, Refusal>>,
    },
    Visit {
        point: String,
        answer: oneshot::Sender<Result<(), Refusal>>,
    },
    Push {
        message: Box<OutboxMessage>,
        answer: oneshot::Sender<Result<(), Refusal>>,
    },
}

/// Entries of the ledger, and how many were dropped from it.
#[derive(Debug)]
pub(crate) struct Page {
    pub(crate) entries: Vec<LedgerEntry>,
    pub(crate) dropped: u64,
}

/// The owner of one robot.
#[derive(Debug)]
pub(crate) struct Driver {
    core: Core,
    time: Timekeeper,
    commands: mpsc::Receiver<Command>,
    state: watch::Sender<State>,
    robot: MobileRobotClient,
    settings: LinkSection,
    stop: CancellationToken,
}

/// What the handle needs to reach a driver.
#[derive(Clone, Debug)]
pub(crate) struct Lines {
    pub(crate) commands: mpsc::Sender<Command>,
    pub(crate) state: watch::Receiver<State>,
}

impl Driver {
    pub(crate) fn prepare(
        core: Core,
        clock: Clock,
        robot: MobileRobotClient,
        settings: LinkSection,
        stop: CancellationToken,
    ) -> (Self, Lines) {
        let (sender, commands) = mpsc::channel(COMMAND_QUEUE);
        let (state, states) = watch::channel(core.state());
        let driver = Self {
            time: Timekeeper::start(clock),
            core,
            commands,
            state,
            robot,
            settings,
            stop,
        };
        let lines = Lines {
            commands: sender,
            state: states,
        };
        (driver, lines)
    }

    /// Runs the robot until it is stopped.
    pub(crate) async fn run(self, tracker: TaskTracker) {
        let id = self.robot.id().to_owned();
        tracing::info!(robot.id = %id, "The mobile robot is on.");
        match self.time {
            Timekeeper::Running { .. } => self.run_by_itself(&tracker).await,
            Timekeeper::Stepped(_) => self.run_in_steps().await,
        }
        tracing::info!(robot.id = %id, "The mobile robot is off.");
    }

    /// Time passes by itself; signals and messages travel meanwhile.
    async fn run_by_itself(mut self, tracker: &TaskTracker) {
        let mut link = Link::start(&self.robot, &self.settings, &self.stop, tracker);
        loop {
            let target = self.time.target();
            let behind = target.saturating_sub(self.core.now()) > TURN;
            self.advance_over_link(target.min(self.core.now().saturating_add(TURN)), &mut link);
            let _previous = self.state.send_replace(self.core.state());
            link.listen_after(self.core.after());
            let wake = self.core.next_wake();
            let wake = wake.and_then(|time| self.time.instant_of(time));
            let wake = wake.map(|instant| instant.max(Instant::now() + LOOK));
            tokio::select! {
                biased;
                () = self.stop.cancelled() => break,
                Some(command) = self.commands.recv() => {
                    self.advance_over_link(self.time.target(), &mut link);
                    self.answer(command);
                }
                Some(news) = link.news() => {
                    self.advance_over_link(self.time.target(), &mut link);
                    self.hear(news, &mut link);
                }
                () = tokio::task::yield_now(), if behind => {}
                () = wait_until(wake), if !behind => {}
            }
        }
    }

    fn advance_over_link(&mut self, target: Duration, link: &mut Link) {
        while self.core.advance(target) == Advance::Sending {
            for sending in self.core.take_sends() {
                if let Err((signal, outcome)) = link.send(sending.signal) {
                    self.core.outcome(&signal, outcome);
                }
            }
        }
    }

    fn hear(&mut self, news: News, link: &mut Link) {
        match news {
            News::Outcome(signal, outcome) => self.core.outcome(&signal, outcome),
            News::Messages(messages, taken) => {
                self.core.cell_is(None);
                for message in messages {
                    self.core.message(message);
                }
                // The next question acknowledges them.
                link.listen_after(self.core.after());
                // Nobody waits any more if the robot is being stopped.
                let _stopping = taken.send(());
            }
            News::Away(reason) => self.core.cell_is(Some(reason)),
        }
    }

    /// Time passes in steps, and stands while signals and messages travel.
    async fn run_in_steps(mut self) {
        loop {
            let _previous = self.state.send_replace(self.core.state());
            tokio::select! {
                biased;
                () = self.stop.cancelled() => break,
                Some(command) = self.commands.recv() => self.answer(command),
                step = self.time.next_step() => self.one_step(step).await,
            }
        }
    }

    async fn one_step(&mut self, step: Step) {
        let target = self.core.now().saturating_add(step.by);
        let interval = Duration::from_millis(self.settings.step_poll_ms);
        loop {
            self.ask_for_messages().await;
            let until = target.min(self.core.now().saturating_add(interval));
            let before = self.core.now();
            while self.core.advance(until) == Advance::Sending {
                for sending in self.core.take_sends() {
                    let post = cell::post(&self.robot, &sending.signal);
                    let Some(outcome) = self.stop.run_until_cancelled(post).await else {
                        return;
                    };
                    self.core.outcome(&sending.signal, outcome);
                }
            }
            if until >= target || self.core.now() == before {
                break;
            }
        }
        // What came of the last signals belongs to this step.
        self.ask_for_messages().await;
        let _previous = self.state.send_replace(self.core.state());
        // Nobody waits any more if the test gave up.
        let _given_up = step.done.send(self.core.now());
    }

    /// One question for messages, without waiting for one.
    async fn ask_for_messages(&mut self) {
        let Some(after) = self.core.after() else {
            return;
        };
        if !self.settings.poll {
            return;
        }
        let query = api::OutboxQuery { after, wait_s: 0 };
        let asked = self
            .stop
            .run_until_cancelled(cell::poll(&self.robot, query))
            .await;
        match asked {
            None => {}
            Some(Ok(messages)) => {
                self.core.cell_is(None);
                for message in messages {
                    self.core.message(message);
                }
            }
            Some(Err(reason)) => self.core.cell_is(Some(reason)),
        }
    }

    fn answer(&mut self, command: Command) {
        let polls = self.settings.poll;
        // An error means that whoever asked has gone.
        let _gone: Result<(), ()> = match command {
            Command::State(answer) => answer.send(self.core.state()).map_err(drop),
            Command::Ledger { after, answer } => {
                let page = Page {
                    entries: self.core.ledger_after(after),
                    dropped: self.core.ledger_dropped(),
                };
                answer.send(page).map_err(drop)
            }
            Command::SetFault { fault, answer } => {
                answer.send(self.core.set_fault(fault)).map_err(drop)
            }
            Command::ClearFaults(answer) => answer.send(self.core.clear_faults()).map_err(drop),
            Command::Put { slot, load, answer } => {
                answer.send(self.core.put(&slot, &load)).map_err(drop)
            }
            Command::Take { slot, answer } => answer.send(self.core.take(&slot)).map_err(drop),
            Command::Visit { point, answer } => answer.send(self.core.visit(&point)).map_err(drop),
            Command::Push { message, answer } => {
                answer.send(self.core.pushed(*message, polls)).map_err(drop)
            }
        };
    }
}

async fn wait_until(wake: Option<Instant>) {
    match wake {
        Some(instant) => sleep_until(instant).await,
        None => std::future::pending().await,
    }
}
