//! The deterministic core of a virtual controller.
//!
//! Events go in, effects come out, time is told. The same programs, events and times give the same ledger, byte for
//! byte: nothing here reads a clock, waits, or iterates in the order of a hash.
//!
//! Tasks run in turn. Each may execute a number of instructions in a millisecond of controller time
//! ([`crate::config::Limits::instructions_per_ms`]), anew after each wait that something else ended; an endless loop
//! spends its share and rests.

mod data;
mod faults;
mod load;
mod operate;
mod power;
mod programs;
mod remote;
mod schedule;
mod snapshot;
mod steps;
mod stops;
mod values;
mod views;
mod wired;

pub use data::{ItemKind, SYSTEM, kind_of};
pub use operate::{OperateError, Operation};
pub use power::CmosMemory;
pub use programs::{Lines, ProgramKind, ProgramView, TaskError, TaskSeen};
pub use remote::{ProgramSelection, RemoteStart};
pub(crate) use snapshot::task_in_words;
pub use steps::{TRACE_LINES, TraceEntry, TraceError};
pub use values::{
    DataError, IoView, JointsValue, PoseValue, RegisterView, ValueBody, VariableItem, value_of_text,
};
pub use wired::PortSet;

use std::time::Duration;

use karel::{Machine, Port, PortValue, Status, TaskId, Wait};

use crate::alarms::Severity;
use crate::config::{ControllerConfig, Limits};
use crate::effects::{ConnectionId, Effect, Event};
use crate::error::StartError;
use crate::faults::{Passed, Wire};
use crate::hardware::Hardware;
use crate::hardware::safety::StopCategory;
use crate::ports::SetInputError;

use faults::Faults;
use programs::Loaded;
use remote::Remote;
use steps::{Place, Trace};

/// The period in which a task may spend its instructions.
const SHARE_PERIOD: Duration = Duration::from_millis(1);

/// SYST-999: everything was aborted from outside. A number of our own.
const SYST_ABORTED: Status = Status::new(24, 999);

/// Whether the core has more to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Advance {
    /// Something happened; there may be effects, and more may happen before the time that was asked for.
    Worked,
    /// It is the time that was asked for, and every task waits.
    Reached,
}

/// One controller: the KAREL machine, its tasks, and the hardware around it.
#[derive(Debug)]
pub struct Controller {
    machine: Machine,
    hardware: Hardware,
    tasks: Vec<Task>,
    /// [`Machine::task_changes`] that `tasks` follows.
    task_changes: u64,
    limits: Limits,
    /// Programs that run from power-on.
    run: Vec<String>,
    /// How often the power was switched on again.
    power_cycles: u32,
    /// While the power is off: when it is switched on again.
    off_until: Option<Duration>,
    /// What is loaded, in order.
    loaded: Vec<Loaded>,
    wire: Wire,
    faults: Faults,
    /// Effects that the wire has let through.
    released: Vec<Effect>,
    trace: Trace,
    /// The STEP key.
    single_step: bool,
    /// How emergency stop buttons stop the arm.
    stop_category: StopCategory,
    /// The signals that start programs, if any do.
    remote: Option<Remote>,
}

#[derive(Debug)]
struct Task {
    id: TaskId,
    phase: Phase,
    /// Instructions left in the present period.
    share: u32,
    /// When the present period began.
    period: Duration,
    /// When its condition handlers look again, whatever it waits for.
    look: Option<Duration>,
    /// Pauses as soon as it is at another line than this one.
    step_from: Option<Place>,
    /// The last line that was traced.
    traced: Option<Place>,
}

#[derive(Debug)]
enum Phase {
    Ready,
    Waiting(Wait),
    /// The share is spent.
    Resting,
    Over,
}

impl Controller {
    /// Loads the programs, puts the arm at its start, and makes the tasks ready at time zero.
    ///
    /// # Errors
    /// A program that is missing, too long, or not correct; start joints outside of the limits.
    pub fn try_new(config: &ControllerConfig) -> Result<Self, StartError> {
        config
            .model
            .check_limits(&config.start_joints)
            .map_err(|violations| StartError::StartJoints {
                model: config.model.name().to_owned(),
                violations,
            })?;
        load::check_gripper(config)?;
        let limits = config.limits;
        let mut machine = Machine::new(karel::Limits::default());
        machine.set_byte_order(config.byte_order);
        let loaded = load::load(
            &mut machine,
            &config.programs,
            &config.includes,
            config.generation.into(),
            limits,
        )?;
        // With signals that start programs, nothing else starts one unless it is told to.
        let run = if config.run.is_empty() && config.remote_start.is_none() {
            let first = loaded.first().map(|program| program.name.clone());
            first.into_iter().collect()
        } else {
            config.run.clone()
        };
        let mut controller = Self {
            machine,
            hardware: Hardware::new(config),
            tasks: Vec::new(),
            task_changes: 0,
            limits,
            run: run.clone(),
            power_cycles: 0,
            off_until: None,
            loaded,
            wire: Wire::new(config.seed),
            faults: Faults::default(),
            released: Vec::new(),
            trace: Trace::default(),
            single_step: false,
            stop_category: config.stop_category,
            remote: config.remote_start.map(Remote::new),
        };
        for name in run {
            let _task = controller
                .start_task(&name)
                .map_err(|error| StartError::Task {
                    name,
                    reason: error.to_string(),
                })?;
        }
        controller.follow_tasks();
        controller.wire_remote();
        for (item, text) in &config.presets {
            let set = controller.set_item(item, text);
            set.map_err(|error| StartError::Preset {
                item: item.clone(),
                reason: error.to_string(),
            })?;
        }
        for fault in &config.faults {
            let injected = controller.inject(fault.clone());
            let _id = injected.map_err(|error| StartError::Fault {
                fault: fault.fault.name(),
                reason: error.to_string(),
            })?;
        }
        if config.trace {
            controller.trace_everything();
        }
        Ok(controller)
    }

    /// Controller time since power-on.
    #[must_use]
    pub fn now(&self) -> Duration {
        self.hardware.now
    }

    /// Something happened on a socket, now.
    pub fn event(&mut self, event: Event) {
        if let Event::Connected {
            tag, connection, ..
        } = &event
        {
            let port = self.hardware.place_of(*tag);
            self.wire.connected(*connection, *tag, port);
        }
        let mut passed = Passed::default();
        self.wire.incoming(self.hardware.now, event, &mut passed);
        self.take_passed(passed);
    }

    /// Does what is due now, or else goes to the next moment at which something is due, but not beyond `until`.
    ///
    /// One call costs at most one share of each task, so the caller can look after other things in between.
    pub fn advance(&mut self, until: Duration) -> Advance {
        self.follow_signals();
        if self.run_ready_tasks() {
            return Advance::Worked;
        }
        match self.next_wake() {
            Some(wake) if wake <= until => {
                self.hardware.now = self.hardware.now.max(wake);
                self.hardware.follow_motions();
                self.hardware.end_gripping();
                self.machine.follow(&mut self.hardware);
                self.end_faults();
                self.deliver();
                self.wake_tasks();
                Advance::Worked
            }
            Some(_) | None => {
                self.hardware.now = self.hardware.now.max(until);
                Advance::Reached
            }
        }
    }

    /// [`Self::advance`] until the time is reached. For callers without sockets; an endless loop in a program costs
    /// its share for every millisecond.
    pub fn advance_fully(&mut self, until: Duration) {
        while self.advance(until) == Advance::Worked {}
    }

    /// When something is due without any event from outside. In the past or now: at once.
    #[must_use]
    pub fn next_wake(&self) -> Option<Duration> {
        let frozen = self.faults.frozen;
        let tasks = self.tasks.iter().filter(|_| !frozen);
        let tasks = tasks.filter_map(|task| match &task.phase {
            Phase::Ready => Some(self.hardware.now),
            Phase::Waiting(Wait::Until(time) | Wait::ReadableUntil(_, time)) => {
                Some(task.look.map_or(*time, |look| look.min(*time)))
            }
            Phase::Waiting(_) => task.look,
            // Its condition handlers look when it has its next share, not before.
            Phase::Resting => Some(task.period.saturating_add(SHARE_PERIOD)),
            Phase::Over => None,
        });
        tasks
            .chain(self.machine.next_due())
            .chain(self.hardware.executor.next_due())
            .chain(self.hardware.gripper_arrives())
            .chain(self.wire.next_due())
            .chain(self.faults.next_end())
            .chain(self.off_until)
            .chain(self.remote.as_ref().and_then(Remote::next_due))
            .min()
    }

    /// What is to be done outside, in order.
    pub fn take_effects(&mut self) -> Vec<Effect> {
        let mut passed = Passed {
            effects: std::mem::take(&mut self.released),
            events: Vec::new(),
        };
        for effect in self.hardware.take_effects() {
            self.wire.outgoing(self.hardware.now, effect, &mut passed);
        }
        let effects = std::mem::take(&mut passed.effects);
        self.take_passed(passed);
        effects
    }

    /// How many more bytes a connection may bring now; 0 makes the peer wait.
    #[must_use]
    pub fn room(&self, connection: ConnectionId) -> usize {
        let held = self.wire.held(connection);
        self.hardware.room(connection).saturating_sub(held)
    }

    /// ABORT ALL: every task ends, the arm brakes, connections close.
    pub fn abort_all(&mut self) {
        for task in &mut self.tasks {
            if !matches!(task.phase, Phase::Over) {
                self.machine.abort(task.id, &mut self.hardware);
                self.hardware.release_ports(task.id);
                task.phase = Phase::Over;
                task.look = None;
            }
        }
        self.hardware.close_connections();
        let text = "All tasks were aborted by the operator";
        self.hardware.stop_arm(text);
        self.hardware
            .post(SYST_ABORTED, text.to_owned(), Severity::Warn);
    }

    /// Sets an input, as the world outside does.
    ///
    /// # Errors
    /// Not an input, no such port, or a value that it cannot have.
    pub fn set_input(
        &mut self,
        port: Port,
        number: u16,
        value: PortValue,
    ) -> Result<(), SetInputError> {
        if self.hardware.ports.set_input(port, number, value)? {
            tracing::info!(
                controller = %self.hardware.name,
                "The input {port}[{number}] was set to {value:?} from outside.",
            );
            self.follow_signals();
        }
        Ok(())
    }
}
