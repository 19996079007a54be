//! The one task that owns a controller: it moves bytes, time and questions between the world and the core.
//!
//! Nothing polls: an idle controller sleeps until a socket, a timer, a question or the stopper wakes it.

mod connection;
pub(crate) mod net;
mod port;

use std::collections::BTreeMap;
use std::future::poll_fn;

use karel::{Port, PortValue};
use tokio::sync::{mpsc, oneshot, watch};
use tokio::time::sleep_until;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::alarms::Alarm;
use crate::clock::{Clock, Timekeeper};
use crate::config::ControllerConfig;
use crate::controller::{Advance, CmosMemory, Controller, OperateError, Operation};
use crate::effects::Event;
use crate::error::StartError;
use crate::labels::PeerLabels;
use crate::ledger::LedgerEntry;
use crate::ports::SetInputError;
use crate::state::State;
use net::{Addresses, Net, News};

/// Moments of controller time handled before others get their turn.
const MOMENTS_A_TURN: usize = 4;

/// Questions that may wait for an answer.
pub(crate) const COMMAND_QUEUE: usize = 64;

/// A question or an order to the controller.
#[derive(Debug)]
pub(crate) enum Command {
    State(oneshot::Sender<State>),
    Ledger {
        after: u64,
        answer: oneshot::Sender<Page<LedgerEntry>>,
    },
    Alarms(oneshot::Sender<Page<Alarm>>),
    Screen(oneshot::Sender<Vec<String>>),
    AbortAll(oneshot::Sender<()>),
    SetInput {
        port: Port,
        number: u16,
        value: PortValue,
        answer: oneshot::Sender<Result<(), SetInputError>>,
    },
    Registers(oneshot::Sender<karel::Registers>),
    PowerCycle {
        memory: CmosMemory,
        answer: oneshot::Sender<()>,
    },
    Operate {
        operation: Operation,
        answer: oneshot::Sender<Result<(), OperateError>>,
    },
    Visit(Visit),
}

/// Anything else that is asked of a driver, between two moments.
pub(crate) struct Visit(pub(crate) Box<dyn FnOnce(&mut Driver) + Send>);

impl std::fmt::Debug for Visit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Visit")
    }
}

/// Entries of a bounded log, and how many were dropped from it.
#[derive(Debug)]
pub(crate) struct Page<T> {
    pub(crate) entries: Vec<T>,
    pub(crate) dropped: u64,
}

/// The owner of one controller.
#[derive(Debug)]
pub(crate) struct Driver {
    pub(crate) core: Controller,
    net: Net,
    pub(crate) time: Timekeeper,
    commands: mpsc::Receiver<Command>,
    state: watch::Sender<State>,
    stop_after: Option<std::time::Duration>,
    stop: CancellationToken,
}

/// What the handle needs to reach a driver.
#[derive(Debug)]
pub(crate) struct Lines {
    pub(crate) commands: mpsc::Sender<Command>,
    pub(crate) addresses: watch::Receiver<Addresses>,
    pub(crate) port_failure: watch::Receiver<Option<String>>,
    pub(crate) state: watch::Receiver<State>,
}

impl Driver {
    /// Builds the core and reserves the ports; nothing runs yet.
    pub(crate) fn prepare(
        config: &ControllerConfig,
        clock: Clock,
        labels: PeerLabels,
        tracker: TaskTracker,
        stop: CancellationToken,
    ) -> Result<(Self, Lines), StartError> {
        let core = Controller::try_new(config)?;
        let (command_sender, commands) = mpsc::channel(COMMAND_QUEUE);
        let (address_sender, addresses) = watch::channel(BTreeMap::new());
        let (failure_sender, port_failure) = watch::channel(None);
        let news = News {
            addresses: address_sender,
            port_failure: failure_sender,
        };
        let (state, state_receiver) = watch::channel(core.state());
        let net = Net::start(config, labels, news, tracker, stop.clone())?;
        let driver = Self {
            core,
            net,
            time: Timekeeper::start(clock),
            commands,
            state,
            stop_after: config.stop_after,
            stop,
        };
        Ok((
            driver,
            Lines {
                commands: command_sender,
                addresses,
                port_failure,
                state: state_receiver,
            },
        ))
    }

    /// Runs the controller until it is stopped.
    pub(crate) async fn run(mut self) {
        let name = self.core.state().controller;
        tracing::info!(controller = %name, "The controller is on.");
        loop {
            let behind = self.work();
            let _previous = self.state.send_replace(self.core.state());
            let wake = self
                .core
                .next_wake()
                .filter(|time| self.stop_after.is_none_or(|end| *time <= end))
                .and_then(|time| self.time.instant_of(time));
            let stepping = self.time.is_stepping();
            let Self {
                core,
                net,
                time,
                commands,
                stop,
                ..
            } = &mut self;
            tokio::select! {
                biased;
                () = stop.cancelled() => break,
                Some(command) = commands.recv() => self.answer(command),
                step = time.next_step(), if !stepping => {
                    self.time.begin(self.core.now(), step);
                    // What came before the step belongs to the time before it.
                    while self.sweep() {}
                }
                event = poll_fn(|cx| net.poll(cx, |id| core.room(id))) => self.event(event),
                () = tokio::task::yield_now(), if behind => {}
                () = wait_until(wake), if !behind && wake.is_some() => {}
            }
        }
        tracing::info!(controller = %name, "The controller is off.");
    }

    /// Brings the core up to the clock, but not for longer than one turn. Whether more is to be done at once.
    fn work(&mut self) -> bool {
        for _ in 0..MOMENTS_A_TURN {
            let target = self.time.target(self.core.now(), self.core.next_wake());
            let target = self.stop_after.map_or(target, |end| target.min(end));
            let advance = self.core.advance(target);
            self.apply_effects();
            let swept = self.time.is_still() && self.sweep();
            if advance == Advance::Reached && !swept {
                self.finish_step();
                return false;
            }
        }
        true
    }

    fn apply_effects(&mut self) {
        for effect in self.core.take_effects() {
            self.net.apply(effect);
        }
    }

    /// Hands everything that the sockets hold to the core. Whether there was anything.
    fn sweep(&mut self) -> bool {
        let mut found = false;
        while let Some(event) = self.net.sweep(|id| self.core.room(id)) {
            self.core.event(event);
            self.apply_effects();
            found = true;
        }
        found
    }

    fn finish_step(&mut self) {
        self.time.finish_step(self.core.now());
    }

    fn event(&mut self, event: Event) {
        // What was due before the event comes before it.
        let _behind = self.work();
        self.core.event(event);
    }

    fn answer(&mut self, command: Command) {
        let _behind = self.work();
        // An error means that whoever asked has gone.
        let _gone: Result<(), ()> = match command {
            Command::State(answer) => answer.send(self.core.state()).map_err(drop),
            Command::Ledger { after, answer } => {
                let page = Page {
                    entries: self.core.ledger(after),
                    dropped: self.core.ledger_dropped(),
                };
                answer.send(page).map_err(drop)
            }
            Command::Alarms(answer) => {
                let page = Page {
                    entries: self.core.alarms(),
                    dropped: self.core.alarms_dropped(),
                };
                answer.send(page).map_err(drop)
            }
            Command::Screen(answer) => answer.send(self.core.screen()).map_err(drop),
            Command::AbortAll(answer) => {
                self.core.abort_all();
                answer.send(()).map_err(drop)
            }
            Command::SetInput {
                port,
                number,
                value,
                answer,
            } => {
                let set = self.core.set_input(port, number, value);
                answer.send(set).map_err(drop)
            }
            Command::Registers(answer) => answer.send(self.core.registers().clone()).map_err(drop),
            Command::PowerCycle { memory, answer } => {
                self.core.power_cycle(memory);
                self.apply_effects();
                answer.send(()).map_err(drop)
            }
            Command::Operate { operation, answer } => {
                let done = self.core.operate(operation);
                self.apply_effects();
                answer.send(done).map_err(drop)
            }
            Command::Visit(Visit(visit)) => {
                visit(self);
                self.apply_effects();
                Ok(())
            }
        };
    }
}

async fn wait_until(wake: Option<tokio::time::Instant>) {
    match wake {
        Some(instant) => sleep_until(instant).await,
        None => std::future::pending().await,
    }
}
