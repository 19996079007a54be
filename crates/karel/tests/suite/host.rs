//! A host for tests: a script says what the world does, a trace says what the program did.

use std::{
    collections::{BTreeMap, VecDeque},
    fmt::Write as _,
    time::Duration,
};

use karel::{
    AlarmView, FileId, HandAction, Host, Input, InputEnd, JointPosition, Limits, Machine, MotionId,
    MotionPath, MotionRequest, MoveEnd, OpenMode, Port, PortValue, Position, Program, ProgramAlarm,
    Progress, Registers, Run, RuntimeError, Status, SysPath, SysValue, TaskId, Text, TpMotion,
    TpTarget, Value, Wait, Xyzwpr, XyzwprExt,
};

/// What the world does, in this order; each is done when the program waits for it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Event {
    /// A client connects.
    Connect,
    /// It sends these bytes in one piece.
    Send(Vec<u8>),
    /// It sends nothing until a READ gives up.
    Silence,
    /// It closes its side.
    Close,
    /// The operator aborts the task.
    Abort,
    /// The operator pauses the task.
    Pause,
    /// The operator continues the task.
    Continue,
    /// A `MSG_CONNECT` that fails with this status.
    FailConnect(i32),
    /// The motion queue refuses with this status.
    FailMotion(i32),
}

#[derive(Debug)]
pub(crate) struct ScriptedHost {
    pub(crate) script: VecDeque<Event>,
    pub(crate) trace: String,
    /// Bytes written since the last connect, per connection.
    pub(crate) replies: Vec<Vec<u8>>,
    /// Number of `output` calls.
    pub(crate) segments: usize,
    pub(crate) moves: Vec<MotionRequest>,
    pub(crate) variables: BTreeMap<String, Value>,
    pub(crate) ports: BTreeMap<(Port, i32), PortValue>,
    pub(crate) alarms: Vec<RuntimeError>,
    now: Duration,
    connected: bool,
    refusal: Option<Status>,
    received: Vec<u8>,
    closed: bool,
    moving: Option<MotionId>,
    /// Whether the program goes on before the motion ends.
    rounds: bool,
    tp_motions: u64,
    next_file: u32,
    /// Files of the device `FR:` by name.
    files: BTreeMap<String, Vec<u8>>,
    /// Those that are open, and how far they were read.
    open: BTreeMap<FileId, (String, usize)>,
    simulated: BTreeMap<(Port, i32), PortValue>,
}

impl ScriptedHost {
    /// The bytes of a file of the device `FR:`.
    pub(crate) fn file(&self, name: &str) -> Vec<u8> {
        self.files.get(name).cloned().unwrap_or_default()
    }

    pub(crate) fn new(script: Vec<Event>) -> ScriptedHost {
        let zero = Value::Position(Position::default());
        let variables = [("$UTOOL", zero.clone()), ("$UFRAME", zero)];
        ScriptedHost {
            script: script.into(),
            trace: String::new(),
            replies: Vec::new(),
            segments: 0,
            moves: Vec::new(),
            variables: variables
                .map(|(name, value)| (name.to_owned(), value))
                .into(),
            ports: BTreeMap::new(),
            alarms: Vec::new(),
            now: Duration::ZERO,
            connected: false,
            refusal: None,
            received: Vec::new(),
            closed: false,
            moving: None,
            rounds: false,
            tp_motions: 0,
            next_file: 1,
            files: BTreeMap::new(),
            open: BTreeMap::new(),
            simulated: BTreeMap::new(),
        }
    }

    fn note(&mut self, line: &str) {
        self.trace.push_str(line);
        self.trace.push('\n');
    }

    /// Does what the program waits for. `false` if the script has nothing for it.
    pub(crate) fn satisfy(&mut self, wait: &Wait) -> bool {
        match wait {
            Wait::Until(until) => self.now = (*until).max(self.now),
            Wait::Motion(_) => self.moving = None,
            Wait::MotionQueue | Wait::Writable(_) | Wait::Continue => return false,
            Wait::Connect(_) => match self.script.pop_front() {
                Some(Event::Connect) => {
                    self.connected = true;
                    self.closed = false;
                    self.received.clear();
                    self.replies.push(Vec::new());
                }
                Some(Event::FailConnect(status)) => self.refusal = Some(Status(status)),
                other => return self.unfit(other),
            },
            Wait::ReadableUntil(_, until) if self.script.front() == Some(&Event::Silence) => {
                let _silence = self.script.pop_front();
                self.now = (*until).max(self.now);
            }
            Wait::Readable(_) | Wait::ReadableUntil(..) => match self.script.pop_front() {
                Some(Event::Send(bytes)) => self.received.extend(bytes),
                Some(Event::Close) => self.closed = true,
                other => return self.unfit(other),
            },
        }
        true
    }

    fn unfit(&mut self, event: Option<Event>) -> bool {
        if let Some(event) = event {
            self.script.push_front(event);
        }
        false
    }
}

fn quoted(bytes: &[u8]) -> String {
    format!("{:?}", Text::from(bytes).to_string())
}

fn shown(value: &Value) -> String {
    match value {
        Value::Integer(value) => value.to_string(),
        Value::Real(value) => format!("{value:?}"),
        Value::Boolean(value) => value.to_string(),
        Value::String(text) => format!("{text:?}"),
        Value::Config(config) => config.to_string(),
        Value::Joints(joints) => format!("{:?}", joints.axes),
        Value::Xyzwpr(_) | Value::XyzwprExt(_) | Value::Position(_) => {
            let p = value.as_xyzwprext().unwrap();
            format!(
                "({} {} {} {} {} {} '{}')",
                p.x, p.y, p.z, p.w, p.p, p.r, p.config
            )
        }
    }
}

impl Host for ScriptedHost {
    fn now(&self) -> Duration {
        self.now
    }

    fn msg_connect(&mut self, _task: TaskId, tag: &str) -> Progress<Status> {
        if let Some(status) = self.refusal.take() {
            self.note(&format!("connect {tag} failed {status}"));
            return Progress::Ready(status);
        }
        if !self.connected {
            return Progress::Pending(Wait::Connect(tag.to_owned()));
        }
        self.note(&format!("connect {tag}"));
        Progress::Ready(Status::OK)
    }

    fn msg_disco(&mut self, _task: TaskId, tag: &str) -> Status {
        self.note(&format!("disconnect {tag}"));
        self.connected = false;
        Status::OK
    }

    fn open_file(&mut self, _: TaskId, mode: OpenMode, name: &str) -> Result<FileId, Status> {
        let file = name.to_ascii_uppercase();
        if file.starts_with("FR:") {
            match mode {
                OpenMode::ReadOnly if !self.files.contains_key(&file) => {
                    return Err(Status::FILE_NOT_FOUND);
                }
                OpenMode::ReadOnly => {}
                OpenMode::ReadWrite | OpenMode::Append | OpenMode::Update => {
                    drop(self.files.insert(file.clone(), Vec::new()));
                }
            }
            let id = FileId(1000 + self.next_file);
            self.next_file += 1;
            let _new = self.open.insert(id, (file, 0));
            return Ok(id);
        }
        self.note(&format!("open {name} {mode:?}"));
        if !self.connected {
            return Err(Status::INTP_OPEN_FAILED);
        }
        self.next_file += 1;
        Ok(FileId(self.next_file - 1))
    }

    fn close_file(&mut self, file: FileId) -> Status {
        if self.open.remove(&file).is_some() {
            return Status::OK;
        }
        self.note(&format!("close {}", file.0));
        Status::OK
    }

    fn cancel_file(&mut self, file: FileId) -> Status {
        self.note(&format!("cancel {}", file.0));
        Status::OK
    }

    fn input(&self, file: FileId) -> Input<'_> {
        if let Some((name, from)) = self.open.get(&file) {
            return Input {
                bytes: self
                    .files
                    .get(name)
                    .and_then(|bytes| bytes.get(*from..))
                    .unwrap(),
                end: InputEnd::Closed(Status::FILE_END),
            };
        }
        let end = if self.closed {
            InputEnd::Closed(Status::HOST_PEER_CLOSED)
        } else {
            InputEnd::Open
        };
        Input {
            bytes: &self.received,
            end,
        }
    }

    fn consume(&mut self, file: FileId, count: usize) {
        if let Some((_, from)) = self.open.get_mut(&file) {
            *from += count;
            return;
        }
        drop(self.received.drain(..count));
    }

    fn output(&mut self, file: FileId, bytes: &[u8]) -> Progress<Status> {
        if let Some((name, _)) = self.open.get(&file) {
            self.files.get_mut(name).unwrap().extend_from_slice(bytes);
            return Progress::Ready(Status::OK);
        }
        self.note(&format!("write {} {}", file.0, quoted(bytes)));
        self.segments += 1;
        if let Some(reply) = self.replies.last_mut() {
            reply.extend_from_slice(bytes);
        }
        Progress::Ready(Status::OK)
    }

    fn display(&mut self, _: TaskId, text: &[u8]) {
        self.note(&format!("display {}", quoted(text)));
    }

    fn system_variable(&self, _: TaskId, path: &SysPath) -> Result<Value, Status> {
        self.variables
            .get(&path.to_string())
            .cloned()
            .ok_or(Status::INTP_UNINIT)
    }

    fn set_system_variable(
        &mut self,
        _: TaskId,
        path: &SysPath,
        value: SysValue,
    ) -> Result<(), Status> {
        if path.root() == "$NO_SUCH" {
            return Err(Status::VARS_UNKNOWN);
        }
        match value {
            SysValue::Value(value) => {
                self.note(&format!("set {path} = {}", shown(&value)));
                let _ = self.variables.insert(path.to_string(), value);
            }
            SysValue::Uninit => {
                self.note(&format!("set {path} uninit"));
                let _ = self.variables.remove(&path.to_string());
            }
        }
        Ok(())
    }

    fn current_position(&mut self, _: TaskId, _: i32) -> Result<XyzwprExt, Status> {
        Ok(XyzwprExt {
            x: 985.0,
            z: 940.0,
            w: -180.0,
            ..XyzwprExt::default()
        })
    }

    /// Everything within two meters is reachable.
    fn check_position(
        &mut self,
        _: TaskId,
        position: &XyzwprExt,
        _: &Position,
        _: &Position,
        _: i32,
    ) -> Status {
        let distance = position.x.hypot(position.y).hypot(position.z);
        if distance <= 2000.0 {
            Status::OK
        } else {
            Status::MOTN_UNREACHABLE
        }
    }

    /// Eight ports of each kind.
    fn port(&self, port: Port, number: i32) -> Result<PortValue, Status> {
        if !(1..=8).contains(&number) {
            return Err(Status::PRIO_PORT_NUMBER);
        }
        let off = if port.is_switch() {
            PortValue::Switch(false)
        } else {
            PortValue::Number(0)
        };
        if let Some(simulated) = self.simulated.get(&(port, number)) {
            return Ok(*simulated);
        }
        let set = self.ports.get(&(port, number)).copied();
        // The first digital input comes on after a while.
        if (port, number) == (Port::DigitalIn, 1) && self.now >= Duration::from_millis(100) {
            return Ok(PortValue::Switch(true));
        }
        Ok(set.unwrap_or(off))
    }

    fn set_port(
        &mut self,
        _: TaskId,
        port: Port,
        number: i32,
        value: PortValue,
    ) -> Result<(), Status> {
        let _bounds = self.port(port, number)?;
        self.note(&format!("{port}[{number}] = {value:?}"));
        let _old = self.ports.insert((port, number), value);
        Ok(())
    }

    fn port_is_simulated(&self, port: Port, number: i32) -> bool {
        self.simulated.contains_key(&(port, number))
    }

    /// Only inputs.
    fn simulate_port(
        &mut self,
        _: TaskId,
        port: Port,
        number: i32,
        value: Option<PortValue>,
    ) -> Result<(), Status> {
        if !port.is_input() {
            return Err(Status::INTP_ARGUMENT);
        }
        let _before = match value {
            Some(value) => self.simulated.insert((port, number), value),
            None => self.simulated.remove(&(port, number)),
        };
        Ok(())
    }

    fn enable_request(&mut self, _: TaskId, number: i32, on: bool) -> Result<(), Status> {
        self.note(&format!("RSR[{number}] enabled: {on}"));
        Ok(())
    }

    fn cancel_arm(&mut self, _: TaskId) {
        self.note("cancel motion");
        self.moving = None;
    }

    fn hold_arm(&mut self, _: TaskId) {
        self.note("hold motion");
    }

    fn resume_arm(&mut self, _: TaskId) {
        self.note("resume motion");
    }

    /// Two hands.
    fn hand(&mut self, _: TaskId, action: HandAction, number: i32) -> Result<(), Status> {
        if !(1..=2).contains(&number) {
            return Err(Status::PRIO_PORT_NUMBER);
        }
        self.note(&format!("{action:?} hand {number}"));
        Ok(())
    }

    fn raise_alarm(&mut self, _: TaskId, alarm: ProgramAlarm) {
        let ProgramAlarm {
            status,
            text,
            severity,
            program,
            line,
        } = alarm;
        self.note(&format!(
            "{severity:?} alarm {status} ({program}, {line}) {text}"
        ));
    }

    fn ping(&mut self, _: TaskId, host: &str) -> Status {
        self.note(&format!("ping {host}"));
        if host == "127.0.0.1" {
            Status::OK
        } else {
            Status::HOST_NO_ANSWER
        }
    }

    fn alarm(&self, newest: i32) -> Option<AlarmView> {
        let count = i32::try_from(self.alarms.len()).unwrap();
        let seq = newest.min(count);
        let index = usize::try_from(seq).ok()?.checked_sub(1)?;
        let alarm = self.alarms.get(index)?;
        Some(AlarmView {
            seq,
            code: alarm.status.0,
            message: alarm.message.clone(),
            severity: 2,
            program: alarm.program.to_string(),
        })
    }

    fn current_joints(&mut self, _: TaskId, _: i32) -> Result<JointPosition, Status> {
        Ok(JointPosition {
            axes: vec![0.0, 10.0, -20.5, 0.0, 90.0, 180.0],
        })
    }

    /// Six axes, each within half a turn.
    fn check_joints(&mut self, _: TaskId, joints: &JointPosition, _: i32) -> Status {
        let six = joints.axes.len() == 6;
        if six && joints.axes.iter().all(|angle| angle.abs() <= 180.0) {
            Status::OK
        } else {
            Status::MOTN_LIMIT
        }
    }

    /// An arm whose joints are the components of its position.
    fn joints_to_position(
        &mut self,
        _: TaskId,
        joints: &JointPosition,
        _: &Position,
        _: &Position,
        _: i32,
    ) -> Result<XyzwprExt, Status> {
        let components = <[f32; 6]>::try_from(joints.axes.as_slice());
        let components = components.map_err(|_| Status::MOTN_LIMIT)?;
        Ok(Xyzwpr::from_components(components).into())
    }

    fn position_to_joints(
        &mut self,
        task: TaskId,
        position: &XyzwprExt,
        user_frame: &Position,
        tool: &Position,
        group: i32,
    ) -> Result<JointPosition, Status> {
        let status = self.check_position(task, position, user_frame, tool, group);
        if !status.is_ok() {
            return Err(status);
        }
        let axes = Xyzwpr::from(*position).components().to_vec();
        Ok(JointPosition { axes })
    }

    fn start_motion(
        &mut self,
        _: TaskId,
        motion: MotionRequest,
    ) -> Progress<Result<MotionId, Status>> {
        if let Some(Event::FailMotion(status)) = self.script.front() {
            let status = Status(*status);
            let _ = self.script.pop_front();
            return Progress::Ready(Err(status));
        }
        let word = match motion.end {
            MoveEnd::Wait => "wait",
            MoveEnd::NoWait => "nowait",
        };
        let place = shown(&Value::XyzwprExt(motion.target));
        let mut line = format!("move {place} {word} line {}", motion.line);
        if let Some(via) = motion.via {
            let _ = write!(line, " via {}", shown(&Value::XyzwprExt(via)));
        }
        if let Some(joints) = &motion.joints {
            let _ = write!(line, " joints {:?}", joints.axes);
        }
        if motion.path == MotionPath::Straight {
            line += " straight";
        }
        self.note(&line);
        self.moves.push(motion);
        let id = MotionId(self.moves.len() as u64);
        self.moving = Some(id);
        Progress::Ready(Ok(id))
    }

    fn motion_ended(&mut self, motion: MotionId) -> Progress<Status> {
        if self.moving == Some(motion) && !self.rounds {
            return Progress::Pending(Wait::Motion(motion));
        }
        self.note("motion ended");
        Progress::Ready(Status::OK)
    }

    fn motion_left(&self, motion: MotionId) -> Option<Duration> {
        (self.moving == Some(motion)).then_some(Duration::from_millis(10))
    }

    fn start_tp_motion(
        &mut self,
        _: TaskId,
        motion: TpMotion,
        _: &Registers,
    ) -> Progress<Result<MotionId, Status>> {
        if let Some(Event::FailMotion(status)) = self.script.front() {
            let status = Status(*status);
            let _ = self.script.pop_front();
            return Progress::Ready(Err(status));
        }
        let place = |target: &TpTarget| match target {
            TpTarget::Cartesian(position) => shown(&Value::XyzwprExt(*position)),
            TpTarget::Joints(joints) => format!("{:?}", joints.axes),
        };
        let mut line = format!("{:?} ", motion.interpolation);
        if let Some(via) = &motion.via {
            write!(line, "over {} ", place(via)).unwrap();
        }
        write!(line, "to {} at {:?}", place(&motion.target), motion.speed).unwrap();
        if let Some(percent) = motion.rounding_percent {
            write!(line, " rounds {percent}").unwrap();
        }
        if motion.incremental {
            line += " incremental";
        }
        if motion.wrist_joint {
            line += " wrist joint";
        }
        let (percent, number) = (motion.acceleration_percent, motion.line);
        self.note(&format!("{line} acc {percent} line {number}"));
        self.rounds = motion.rounding_percent.is_some();
        self.tp_motions += 1;
        let id = MotionId(self.tp_motions);
        self.moving = Some(id);
        Progress::Ready(Ok(id))
    }

    fn motion_rests(&mut self, motion: MotionId) -> Progress<Status> {
        if self.moving == Some(motion) {
            return Progress::Pending(Wait::Motion(motion));
        }
        self.note("motion rests");
        Progress::Ready(Status::OK)
    }

    fn post_alarm(&mut self, _: TaskId, alarm: &RuntimeError) {
        self.alarms.push(alarm.clone());
    }
}

/// Loads a program, or panics with its diagnostics.
pub(crate) fn machine_with(source: &[u8], file: &str) -> (Machine, TaskId) {
    let program = Program::parse_and_check(source, file)
        .unwrap_or_else(|diagnostics| panic!("{}", karel::render(&diagnostics)));
    let name = program.name().to_owned();
    let mut machine = Machine::new(Limits::default());
    machine.load(program).unwrap();
    let task = machine.start(&name).unwrap();
    (machine, task)
}

/// What the script lets the operator do now.
fn operate(machine: &mut Machine, task: TaskId, host: &mut ScriptedHost, wait: &Wait) -> bool {
    match host.script.front() {
        Some(Event::Abort) => {
            host.note("the operator aborts");
            machine.request_abort(task, host);
        }
        Some(Event::Pause) => {
            host.note("the operator pauses");
            let _changed = machine.pause(task);
        }
        Some(Event::Continue) if *wait == Wait::Continue => {
            host.note("the operator continues");
            let _changed = machine.resume(task);
        }
        _ => return false,
    }
    let _done = host.script.pop_front();
    true
}

/// Runs a task until it ends or waits for what the script does not have; notes the end.
pub(crate) fn run(machine: &mut Machine, task: TaskId, host: &mut ScriptedHost) {
    let mut idle = 0;
    for _ in 0..10_000 {
        let slice = machine.run(task, 1_000, host);
        match slice.run {
            Run::OutOfFuel => {}
            Run::Blocked(wait) => {
                if operate(machine, task, host, &wait) {
                    continue;
                }
                let until = if let Wait::Until(until) = wait {
                    until
                } else {
                    Duration::MAX
                };
                // Conditions are looked at while the task waits.
                let wake = [slice.wake_by, machine.next_due()];
                let wake = wake.into_iter().flatten().min().filter(|by| *by < until);
                let satisfied = match wake {
                    Some(by) if until < Duration::MAX => host.satisfy(&Wait::Until(by)),
                    Some(by) => {
                        idle += 1;
                        let moves = matches!(wait, Wait::Motion(_)) && idle % 4 != 0;
                        (!moves && host.satisfy(&wait))
                            || (idle < 50 && host.satisfy(&Wait::Until(by)))
                    }
                    None => host.satisfy(&wait),
                };
                if !satisfied {
                    host.note(&format!("waits for {wait:?}"));
                    return;
                }
                machine.follow(host);
            }
            Run::Ended => return host.note("end"),
            Run::Aborted(error) => {
                host.note(&format!("aborted: {error}"));
                for (depth, call) in error.calls.iter().enumerate() {
                    let hidden = depth >= 3 && depth + 1 < error.calls.len();
                    if !hidden {
                        let (program, routine, line) = (&call.program, &call.routine, call.line);
                        host.note(&format!("  {depth}: {program} {routine} line {line}"));
                    }
                }
                return;
            }
        }
    }
    host.note("out of patience");
}
