//! A KAREL machine with nothing around it.

use std::time::Duration;

use anyhow::{Result, bail};
use karel::{
    FileId, Host, Input, InputEnd, Limits, Machine, MotionId, MotionRequest, OpenMode, Position,
    Program, Progress, Run, RuntimeError, Status, SysPath, SysValue, TaskId, Value, XyzwprExt,
};

/// Instructions that a task gets at a time; a controller gives 2,000.
const FUEL: u32 = 2_000;

/// Runs a program to its end; how many instructions that took.
pub(crate) fn run(source: &str) -> Result<u64> {
    let program = Program::parse_and_check(source.as_bytes(), "bench.kl")
        .map_err(|diagnostics| anyhow::anyhow!(karel::render(&diagnostics)))?;
    let name = program.name().to_owned();
    let mut machine = Machine::new(Limits::default());
    machine.load(program)?;
    let task = machine.start(&name)?;
    let mut instructions = 0_u64;
    loop {
        let slice = machine.run(task, FUEL, &mut NoHost);
        instructions += u64::from(slice.used);
        match slice.run {
            Run::OutOfFuel => {}
            Run::Ended => return Ok(instructions),
            other @ (Run::Blocked(_) | Run::Aborted(_)) => bail!("{other:?}"),
        }
    }
}

/// A host that is never asked.
struct NoHost;

impl Host for NoHost {
    fn now(&self) -> Duration {
        Duration::ZERO
    }
    fn msg_connect(&mut self, _: TaskId, _: &str) -> Progress<Status> {
        Progress::Ready(Status::HOST_TAG)
    }
    fn msg_disco(&mut self, _: TaskId, _: &str) -> Status {
        Status::OK
    }
    fn open_file(&mut self, _: TaskId, _: OpenMode, _: &str) -> Result<FileId, Status> {
        Err(Status::INTP_OPEN_FAILED)
    }
    fn close_file(&mut self, _: FileId) -> Status {
        Status::OK
    }
    fn cancel_file(&mut self, _: FileId) -> Status {
        Status::OK
    }
    fn input(&self, _: FileId) -> Input<'_> {
        Input {
            bytes: &[],
            end: InputEnd::Closed(Status::FILE_END),
        }
    }
    fn consume(&mut self, _: FileId, _: usize) {}
    fn output(&mut self, _: FileId, _: &[u8]) -> Progress<Status> {
        Progress::Ready(Status::INTP_WRITE_FAILED)
    }
    fn display(&mut self, _: TaskId, _: &[u8]) {}
    fn system_variable(&self, _: TaskId, _: &SysPath) -> Result<Value, Status> {
        Err(Status::VARS_UNKNOWN)
    }
    fn set_system_variable(&mut self, _: TaskId, _: &SysPath, _: SysValue) -> Result<(), Status> {
        Err(Status::VARS_UNKNOWN)
    }
    fn current_position(&mut self, _: TaskId, _: i32) -> Result<XyzwprExt, Status> {
        Err(Status::MOTN_UNREACHABLE)
    }
    fn check_position(
        &mut self,
        _: TaskId,
        _: &XyzwprExt,
        _: &Position,
        _: &Position,
        _: i32,
    ) -> Status {
        Status::MOTN_UNREACHABLE
    }
    fn start_motion(&mut self, _: TaskId, _: MotionRequest) -> Progress<Result<MotionId, Status>> {
        Progress::Ready(Err(Status::MOTN_UNREACHABLE))
    }
    fn motion_ended(&mut self, _: MotionId) -> Progress<Status> {
        Progress::Ready(Status::OK)
    }
    fn post_alarm(&mut self, _: TaskId, _: &RuntimeError) {}
}
