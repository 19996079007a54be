//! What the machine asks of the world: files and sockets, system variables, motion, time.
//!
//! The machine does no I/O and reads no clock. Every call here returns at once; what cannot be
//! answered yet is [`Progress::Pending`], the task is suspended, and [`crate::Run::Blocked`] tells
//! the caller what to wait for. When the task runs again, the same call is made again with the
//! same arguments. Waking a task too early is harmless.

mod answers;
mod motion;

use std::time::Duration;

use crate::{
    error::RuntimeError,
    port::{Port, PortValue},
    position::{JointPosition, Position, XyzwprExt},
    registers::Registers,
    status::Status,
    syspath::SysPath,
    value::{SysValue, Value},
};

pub use answers::{
    AlarmSeverity, AlarmView, FileId, FileOperation, HandAction, Input, InputEnd, MotionId,
    OpenMode, ProgramAlarm, Progress, TaskId, Wait,
};
pub use motion::{Interpolation, MotionPath, MotionRequest, MoveEnd, TpMotion, TpSpeed, TpTarget};

/// The controller around the machine.
///
/// Tags are given in upper case and without their colon: `S3` for a program's `'s3:'`.
pub trait Host {
    /// Controller time since power-on. Never goes back.
    fn now(&self) -> Duration;

    /// Waits for a client of a server tag, or connects a client tag. The first call starts to
    /// listen; a status other than 0 ends the wait.
    fn msg_connect(&mut self, task: TaskId, tag: &str) -> Progress<Status>;

    /// Closes the connection and the listener of a tag. Harmless on an idle tag.
    fn msg_disco(&mut self, task: TaskId, tag: &str) -> Status;

    /// Opens `name`, given as the program wrote it (`S3:`, `MC:log.txt`).
    ///
    /// # Errors
    /// The status that `IO_STATUS` shall report.
    fn open_file(&mut self, task: TaskId, mode: OpenMode, name: &str) -> Result<FileId, Status>;

    /// Flushes and closes a file. The connection of a tag stays until `MSG_DISCO`.
    fn close_file(&mut self, file: FileId) -> Status;

    /// Breaks reads and writes in progress. Output that was written is not discarded.
    fn cancel_file(&mut self, file: FileId) -> Status;

    /// Bytes received and not yet consumed; of [`FileId::KEYBOARD`], what was typed.
    fn input(&self, file: FileId) -> Input<'_>;

    /// Drops the first `count` bytes of [`Host::input`]; `count` is at most their number.
    fn consume(&mut self, file: FileId, count: usize);

    /// Writes the bytes of one WRITE statement: all of them, in one segment if possible.
    fn output(&mut self, file: FileId, bytes: &[u8]) -> Progress<Status>;

    /// WRITE without a file variable: text for the pendant's USER screen.
    fn display(&mut self, task: TaskId, text: &[u8]);

    /// Reads a whole system variable or array element; never a component such as `$UTOOL.X`,
    /// which the machine takes out of the value of `$UTOOL` itself.
    ///
    /// # Errors
    /// [`Status::VARS_UNKNOWN`], [`Status::VARS_INDEX`], or [`Status::INTP_UNINIT`] if the
    /// variable exists and has no value.
    fn system_variable(&self, task: TaskId, path: &SysPath) -> Result<Value, Status>;

    /// Stores a whole system variable or array element.
    ///
    /// The value of a variable that this crate knows has that variable's type: REAL for `$SPEED`
    /// even if the program wrote an INTEGER, POSITION for frames and tools. `SET_VAR` on a
    /// variable that it does not know passes on what the program gave.
    ///
    /// # Errors
    /// [`Status::VARS_UNKNOWN`], [`Status::VARS_INDEX`] or [`Status::VARS_TYPE`].
    fn set_system_variable(
        &mut self,
        task: TaskId,
        path: &SysPath,
        value: SysValue,
    ) -> Result<(), Status>;

    /// The value of a port; `number` as the program computed it.
    ///
    /// # Errors
    /// [`Status::PRIO_PORT_NUMBER`] if there is no such port; the task ends with it. A host without
    /// ports keeps this answer.
    fn port(&self, _port: Port, _number: i32) -> Result<PortValue, Status> {
        Err(Status::PRIO_PORT_NUMBER)
    }

    /// Sets an output or a flag; never an input.
    ///
    /// # Errors
    /// As [`Host::port`]; [`Status::INTP_ARGUMENT`] for a number that the port cannot have.
    fn set_port(
        &mut self,
        _task: TaskId,
        _port: Port,
        _number: i32,
        _value: PortValue,
    ) -> Result<(), Status> {
        Err(Status::PRIO_PORT_NUMBER)
    }

    /// Whether programs see another value of a port than the world puts on it.
    fn port_is_simulated(&self, _port: Port, _number: i32) -> bool {
        false
    }

    /// Lets programs see this value of a port, or again what the world puts on it.
    ///
    /// # Errors
    /// As [`Host::port`]; [`Status::INTP_ARGUMENT`] for a port that cannot be simulated. A host that
    /// simulates nothing keeps this answer.
    fn simulate_port(
        &mut self,
        _task: TaskId,
        _port: Port,
        _number: i32,
        _value: Option<PortValue>,
    ) -> Result<(), Status> {
        Err(Status::INTP_ARGUMENT)
    }

    /// Where `$UTOOL` is in `$UFRAME` now, with the configuration filled in. `group` from 1.
    ///
    /// # Errors
    /// A status that ends the task.
    fn current_position(&mut self, task: TaskId, group: i32) -> Result<XyzwprExt, Status>;

    /// Status 0 if `tool` can be brought to `position` in `user_frame`, inside the joint limits
    /// and in the position's configuration. Does not move and checks no path.
    fn check_position(
        &mut self,
        task: TaskId,
        position: &XyzwprExt,
        user_frame: &Position,
        tool: &Position,
        group: i32,
    ) -> Status;

    /// Where the joints of a group are now. `group` from 1.
    ///
    /// # Errors
    /// A status that ends the task. A host without an arm keeps this answer; so with the next three.
    fn current_joints(&mut self, _task: TaskId, _group: i32) -> Result<JointPosition, Status> {
        Err(Status::INTP_UNDEFINED_BUILTIN)
    }

    /// Status 0 if the joints are those of the group and inside of its limits.
    fn check_joints(&mut self, _task: TaskId, _joints: &JointPosition, _group: i32) -> Status {
        Status::INTP_UNDEFINED_BUILTIN
    }

    /// Where `tool` is in `user_frame` at these joints, with the configuration filled in.
    ///
    /// # Errors
    /// The status that the program sees.
    fn joints_to_position(
        &mut self,
        _task: TaskId,
        _joints: &JointPosition,
        _user_frame: &Position,
        _tool: &Position,
        _group: i32,
    ) -> Result<XyzwprExt, Status> {
        Err(Status::INTP_UNDEFINED_BUILTIN)
    }

    /// The joints that bring `tool` to `position` in `user_frame`, inside the joint limits and in
    /// the position's configuration.
    ///
    /// # Errors
    /// The status that the program sees.
    fn position_to_joints(
        &mut self,
        _task: TaskId,
        _position: &XyzwprExt,
        _user_frame: &Position,
        _tool: &Position,
        _group: i32,
    ) -> Result<JointPosition, Status> {
        Err(Status::INTP_UNDEFINED_BUILTIN)
    }

    /// Queues a motion. `Err` means that an alarm was raised; the task ends with it.
    fn start_motion(
        &mut self,
        task: TaskId,
        motion: MotionRequest,
    ) -> Progress<Result<MotionId, Status>>;

    /// Status 0 when the motion met its termination criterion; another status ends the task.
    fn motion_ended(&mut self, motion: MotionId) -> Progress<Status>;

    /// How long a motion that runs takes from now on; `None` if nobody knows.
    fn motion_left(&self, _motion: MotionId) -> Option<Duration> {
        None
    }

    /// Status 0 when the motion is over for good: at a standstill, or another motion has taken over
    /// behind a rounded corner. A host whose motions all end at a standstill keeps this answer.
    fn motion_rests(&mut self, motion: MotionId) -> Progress<Status> {
        self.motion_ended(motion)
    }

    /// `CANCEL`: the arm brakes, whoever moves it. A MOVE that waits for it goes on as if it had
    /// arrived: [`Host::motion_ended`] answers with status 0.
    fn cancel_arm(&mut self, _task: TaskId) {}

    /// The period of the controller's interpolation: a `DELAY` lasts a whole number of these. Zero for any time.
    fn interpolation_period(&self) -> Duration {
        Duration::ZERO
    }

    /// A program did something that is correct and has another effect than many expect: `why` says which. For people;
    /// nothing that a program can see depends on it.
    fn explain(&mut self, _task: TaskId, _place: (&str, u32), _why: &dyn Fn() -> String) {}

    /// `STOP` and `HOLD`: the arm brakes and keeps what it was to do.
    fn hold_arm(&mut self, task: TaskId) {
        self.hold_motions(task);
    }

    /// `RESUME` and `UNHOLD`: the arm goes on with what was held.
    fn resume_arm(&mut self, task: TaskId) {
        self.continue_motions(task);
    }

    /// `RESET`: no alarm is active any more and the drives get power. `false` if something forbids it, or there are none.
    fn reset(&mut self) -> bool {
        false
    }

    /// `OPEN HAND`, `CLOSE HAND` and `RELAX HAND`.
    ///
    /// # Errors
    /// The status that ends the task. A host without hands keeps this answer.
    fn hand(&mut self, _task: TaskId, _action: HandAction, _number: i32) -> Result<(), Status> {
        Err(Status::INTP_UNDEFINED_BUILTIN)
    }

    /// Cancels what a task moves; another task aborted it and wants that.
    fn cancel_motions(&mut self, _task: TaskId) {}

    /// Queues a motion of a TP program. `Err` means that an alarm was raised; the task ends with
    /// it. `registers` are those of the controller at this moment.
    fn start_tp_motion(
        &mut self,
        _task: TaskId,
        _motion: TpMotion,
        _registers: &Registers,
    ) -> Progress<Result<MotionId, Status>> {
        Progress::Ready(Err(Status::INTP_UNDEFINED_BUILTIN))
    }

    /// Another task paused this one and wants what it moves to be held.
    fn hold_motions(&mut self, _task: TaskId) {}

    /// Another task continued this one: what was held of its motions goes on.
    fn continue_motions(&mut self, _task: TaskId) {}

    /// `RSR[n]=ENABLE` and `DISABLE`: whether a signal of the cell's controller starts its program.
    ///
    /// # Errors
    /// [`Status::INTP_ARGUMENT`] if there is no such signal. A host without them keeps this answer.
    fn enable_request(&mut self, _task: TaskId, _number: i32, _on: bool) -> Result<(), Status> {
        Err(Status::INTP_ARGUMENT)
    }

    /// Whether the mode switch says AUTO.
    fn in_auto_mode(&self) -> bool {
        true
    }

    /// Whether the teach pendant is enabled.
    fn pendant_enabled(&self) -> bool {
        false
    }

    /// The alarm with this number of the history, or the newest one before it.
    fn alarm(&self, _newest: i32) -> Option<AlarmView> {
        None
    }

    /// `MSG_PING`: status 0 if a host answers.
    fn ping(&mut self, _task: TaskId, _host: &str) -> Status {
        Status::HOST_NO_ANSWER
    }

    /// `POST_ERR`: a program raises an alarm. What it stops of the tasks is done by the machine, what
    /// it stops of the arm is the host's.
    fn raise_alarm(&mut self, _task: TaskId, _alarm: ProgramAlarm) {}

    /// Does something with files that are not open: copies, deletes, renames.
    fn file_operation(&mut self, _task: TaskId, _operation: FileOperation<'_>) -> Status {
        Status::FILE_NO_DEVICE
    }

    /// Names of the files that a pattern such as `MC:*.TXT` means, in order.
    ///
    /// # Errors
    /// The status that the program sees.
    fn list_files(&mut self, _task: TaskId, _pattern: &str) -> Result<Vec<String>, Status> {
        Err(Status::FILE_NO_DEVICE)
    }

    /// The machine reports the error that ends a task. Called once for each such end.
    fn post_alarm(&mut self, task: TaskId, alarm: &RuntimeError);
}
