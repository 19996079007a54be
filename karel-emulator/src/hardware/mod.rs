//! Everything of the controller that is not the interpreter: arm, tags, files, variables, alarms, ledger.
//!
//! The KAREL machine sees it as its [`karel::Host`]. It stands beside the machine, not above it, so that the machine
//! can run with a mutable borrow of it.

mod arm;
mod arm_notes;
mod connections;
mod explain;
pub(crate) mod gripping;
mod host;
pub(crate) mod operator;
pub(crate) mod safety;
mod sockets;
mod tp;
pub(crate) mod wrist;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use karel::{AlarmSeverity, FileId, MotionId, ProgramAlarm, RuntimeError, Status, TaskId, Wait};

use crate::alarms::{Alarm, AlarmLog, Severity, meaning};
use crate::config::{ControllerConfig, Hosts, InterpolationPeriod, ScreenSink};
use crate::controller::CmosMemory;
use crate::devices::Devices;
use crate::effects::{ConnectionId, Effect, Tag};
use crate::faults::ControllerOption;
use crate::fidelity::{ControllerGeneration, Fidelity, Notes};
use crate::ledger::{CommandId, Ledger, MotionKind, PoseMmDeg, seconds};
use crate::motion::{Executor, Planner, Refusal};
use crate::ports::Ports;
use crate::sysvars::SystemVariables;
use crate::tags::ServerTag;
use gripping::Gripper;
use operator::Operator;

/// Lines of the USER screen that are kept.
const SCREEN_LINES: usize = 20;
/// Characters of one line of the USER screen.
const SCREEN_COLUMNS: usize = 80;

/// The parts around the interpreter.
#[derive(Debug)]
pub(crate) struct Hardware {
    pub(crate) name: Arc<str>,
    pub(crate) now: Duration,
    pub(crate) planner: Planner,
    pub(crate) variables: SystemVariables,
    pub(crate) ports: Ports,
    pub(crate) executor: Executor<MotionTag>,
    pub(crate) override_percent: i32,
    pub(crate) ledger: Ledger,
    pub(crate) alarms: AlarmLog,
    pub(crate) tags: Vec<ServerTag>,
    pub(crate) screen: VecDeque<String>,
    screen_sink: Option<ScreenSink>,
    /// What was typed at the pendant and no program has read.
    keyboard: Vec<u8>,
    pub(crate) operator: Operator,
    pub(crate) gripper: Option<Gripper>,
    /// Where programs note the command that they carry out.
    command_registers: Option<(u16, u16)>,
    /// The task whose statements are executed now.
    pub(crate) running: Option<TaskId>,
    /// Signals RSR1 to RSR8 that a program has disabled, the first in bit 0.
    pub(crate) requests_off: u8,
    /// A fault: the general override does not go beyond this.
    pub(crate) override_limit: Option<i32>,
    pub(crate) fidelity: Fidelity,
    pub(crate) generation: ControllerGeneration,
    pub(crate) interpolation_period: InterpolationPeriod,
    pub(crate) notes: Notes,
    /// Options that the controller was delivered without.
    pub(crate) missing: BTreeSet<ControllerOption>,
    /// The built-in that the running task called and that does not exist without an option.
    pub(crate) missing_call: Option<&'static str>,
    effects: Vec<Effect>,
    wakes: Vec<Wake>,
    files: BTreeMap<FileId, OpenFile>,
    pub(crate) devices: Devices,
    /// Hosts that programs may connect to.
    hosts: Hosts,
    last_file: u32,
    last_motion: u64,
    /// How the latest motions ended, for tasks that wait for them.
    outcomes: VecDeque<(MotionId, Status)>,
    /// The newest motion whose program goes on although the arm has not arrived.
    passed: Option<MotionId>,
    /// Why the arm was stopped last.
    stop_reason: String,
    /// What tasks see that wait for a motion that was stopped.
    stop_status: Status,
    /// Whose bytes each task read last.
    origins: BTreeMap<TaskId, Origin>,
    /// Why the last call of a task failed, in more words than a status has.
    refusals: BTreeMap<TaskId, Refusal>,
}

/// What the executor carries for each motion.
#[derive(Clone, Debug)]
pub(crate) struct MotionTag {
    pub(crate) id: MotionId,
    task: TaskId,
    kind: MotionKind,
    target: PoseMmDeg,
    speed_mm_s: f64,
    speed_percent: Option<f64>,
    command: Option<CommandId>,
    program: Arc<str>,
    line: u32,
    origin: Origin,
}

/// Where a task's latest input came from.
#[derive(Clone, Debug, Default)]
struct Origin {
    peer: Option<SocketAddr>,
    request_id: Option<String>,
}

#[derive(Debug)]
struct OpenFile {
    connection: ConnectionId,
    task: TaskId,
    cancelled: bool,
}

/// A wait that may be over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wake {
    /// Bytes, an end, or a cancellation.
    Readable(FileId),
    /// Room to write.
    Writable(FileId),
    /// A client, or a failure to listen.
    Connect(Tag),
    /// A place in the motion queue.
    MotionQueue,
    /// The end of a motion.
    Motion(MotionId),
}

impl Wake {
    /// Whether this is what a task waits for.
    pub(crate) fn ends(self, wait: &Wait) -> bool {
        match wait {
            Wait::Readable(file) | Wait::ReadableUntil(file, _) => self == Wake::Readable(*file),
            Wait::Writable(file) => self == Wake::Writable(*file),
            Wait::Connect(name) => Tag::parse(name).is_some_and(|tag| self == Wake::Connect(tag)),
            Wait::MotionQueue => self == Wake::MotionQueue,
            Wait::Motion(motion) => self == Wake::Motion(*motion),
            Wait::Until(_) | Wait::Continue => false,
        }
    }
}

impl Hardware {
    pub(crate) fn new(config: &ControllerConfig) -> Self {
        let gripper = config
            .gripper
            .map(|gripper| Gripper::new(gripper, config.workpieces.clone()));
        let mut hardware = Self {
            name: config.name.as_str().into(),
            now: Duration::ZERO,
            planner: Planner::new(config.model.clone()),
            variables: SystemVariables::of(config.generation),
            ports: Ports::new(config.ports),
            executor: Executor::new(config.start_joints, 1.0),
            override_percent: 100,
            ledger: Ledger::new(config.limits.ledger_entries),
            alarms: AlarmLog::new(config.limits.alarms),
            tags: Tag::all().map(ServerTag::new).collect(),
            screen: VecDeque::new(),
            screen_sink: config.screen.clone(),
            keyboard: Vec::new(),
            operator: Operator::default(),
            gripper,
            command_registers: config.command_registers,
            running: None,
            requests_off: 0,
            override_limit: None,
            fidelity: config.fidelity,
            generation: config.generation,
            interpolation_period: config.interpolation_period,
            notes: Notes::default(),
            missing: config.missing_options.clone(),
            missing_call: None,
            effects: Vec::new(),
            wakes: Vec::new(),
            files: BTreeMap::new(),
            devices: Devices::default(),
            hosts: config.hosts.clone(),
            last_file: 0,
            last_motion: 0,
            outcomes: VecDeque::new(),
            passed: None,
            stop_reason: String::new(),
            stop_status: Status::OK,
            origins: BTreeMap::new(),
            refusals: BTreeMap::new(),
        };
        for (name, bytes) in &config.files {
            if !hardware.devices.insert(name.clone(), bytes.clone()) {
                tracing::warn!(controller = %config.name, "There is no room for the file {name}.");
            }
        }
        hardware.show_gripper();
        hardware
    }

    pub(crate) fn take_effects(&mut self) -> Vec<Effect> {
        std::mem::take(&mut self.effects)
    }

    /// Whether the option for sockets is missing; what calls `builtin` ends then.
    fn lacks_sockets(&mut self, builtin: &'static str) -> bool {
        let missing = self.missing.contains(&ControllerOption::R648);
        if missing {
            self.missing_call = Some(builtin);
        }
        missing
    }

    pub(crate) fn take_wakes(&mut self) -> Vec<Wake> {
        std::mem::take(&mut self.wakes)
    }

    /// Power off and on: connections end, the arm brakes; without a battery, variables are as when new.
    pub(crate) fn power_cycle(&mut self, memory: CmosMemory) {
        self.close_connections();
        for slot in &mut self.tags {
            slot.task = None;
            slot.wedged = false;
        }
        self.stop_arm("The power was switched off");
        self.operator.hold = false;
        let _nothing_goes_on = self.executor.resume(self.now);
        self.alarms.reset();
        let _powered = self.power_drives();
        self.screen.clear();
        self.keyboard.clear();
        self.forget_tasks(&[]);
        self.wakes.clear();
        if memory == CmosMemory::Lost {
            self.variables = SystemVariables::of(self.generation);
            self.requests_off = 0;
        }
        self.ports.power_cycle();
        self.devices.power_cycle();
        self.follow_override();
    }

    /// Drops what is remembered of tasks that do not exist any more.
    pub(crate) fn forget_tasks(&mut self, alive: &[TaskId]) {
        self.origins.retain(|task, _| alive.contains(task));
        self.refusals.retain(|task, _| alive.contains(task));
    }

    /// Adds an alarm to the log, and to the trace.
    pub(crate) fn post(&mut self, status: Status, text: String, severity: Severity) {
        self.post_at(status, text, severity, None);
    }

    fn post_at(
        &mut self,
        status: Status,
        text: String,
        severity: Severity,
        place: Option<(&Arc<str>, u32)>,
    ) {
        let alarm = Alarm {
            seq: 0,
            time_s: seconds(self.now),
            facility: status.facility_name().unwrap_or("SYST").to_owned(),
            number: status.number().unsigned_abs(),
            text,
            severity,
            program: place.map(|(program, _)| program.to_string()),
            line: place.map(|(_, line)| line),
            active: true,
        };
        tracing::warn!(
            controller = %self.name,
            time_s = alarm.time_s,
            "The controller raised the alarm {}.",
            alarm.headline(),
        );
        self.alarms.post(alarm);
    }

    /// The error that ended a task, with the better words of the call that failed if there are any.
    fn post_error(&mut self, task: TaskId, error: &RuntimeError) {
        let text = match self.refusals.remove(&task) {
            Some(refusal) if refusal.status == error.status => refusal.text,
            Some(_) | None => error.message.clone(),
        };
        let place = Some((&error.program, error.line));
        self.post_at(error.status, text, Severity::Abort, place);
    }

    /// `POST_ERR`: the arm stops with the tasks that the machine stops.
    fn alarm_of_program(&mut self, task: TaskId, alarm: &ProgramAlarm) {
        let severity = match alarm.severity {
            AlarmSeverity::Warn => Severity::Warn,
            AlarmSeverity::Pause => Severity::Pause,
            AlarmSeverity::Abort => Severity::Abort,
        };
        let place = Some((&alarm.program, alarm.line));
        let text = match alarm.text.as_str() {
            "" => meaning(alarm.status).to_owned(),
            text => text.to_owned(),
        };
        self.post_at(alarm.status, text, severity, place);
        match alarm.severity {
            AlarmSeverity::Warn => {}
            AlarmSeverity::Pause => self.hold_arm(false),
            AlarmSeverity::Abort => {
                let text = format!("{} of task {} aborted the tasks", alarm.status, task.0);
                self.stop_arm(&text);
            }
        }
    }

    /// Text for the USER screen: the last lines are kept, control bytes are not.
    fn show(&mut self, text: &[u8]) {
        if let Some(ScreenSink(sink)) = &self.screen_sink {
            sink(text);
        }
        for line in text.split(|&byte| byte == b'\n' || byte == b'\r') {
            let line: String = line
                .iter()
                .filter(|byte| !byte.is_ascii_control() && **byte < 128)
                .take(SCREEN_COLUMNS)
                .map(|&byte| char::from(byte))
                .collect();
            if line.is_empty() {
                continue;
            }
            tracing::debug!(controller = %self.name, "The program wrote to the USER screen: {line}");
            if self.screen.len() >= SCREEN_LINES {
                let _oldest = self.screen.pop_front();
            }
            self.screen.push_back(line);
        }
    }
}
