//! How many statements a second one task executes.
//!
//! `cargo run --release -p karel --example statements_per_second`
//!
//! Two loops: one of INTEGER assignments and an IF, one that calls a routine, indexes an array and
//! computes with REALs. Assignments, IF, FOR rounds, RETURN and calls count as statements; the
//! programs count them themselves by their loop bounds.

use std::time::{Duration, Instant};

use karel::{
    FileId, Host, Input, InputEnd, Limits, Machine, MotionId, MotionRequest, OpenMode, Position,
    Program, Progress, Run, RuntimeError, Status, SysPath, SysValue, TaskId, Value, XyzwprExt,
};

const ROUNDS: u32 = 3_000_000;

const INTEGERS: &str = "
PROGRAM integers
VAR i, a, b, odd : INTEGER
BEGIN
  a = 0
  odd = 0
  FOR i = 1 TO 3000000 DO
    a = a + i MOD 7
    b = a * 2 - i
    IF (b > 5) AND (a <> 3) THEN
      odd = odd + 1
    ENDIF
    a = a - 3
  ENDFOR
END integers
";

const MIXED: &str = "
PROGRAM mixed
VAR
  i : INTEGER
  sum : REAL
  list : ARRAY[10] OF REAL
ROUTINE scale(value : REAL; by : REAL) : REAL
BEGIN
  RETURN (value * by / 3)
END scale
BEGIN
  FOR i = 1 TO 10 DO
    list[i] = i
  ENDFOR
  sum = 0
  FOR i = 1 TO 3000000 DO
    list[i MOD 10 + 1] = scale(list[i MOD 10 + 1], 2.5)
    sum = sum + list[3] / 1000
    list[3] = 1
  ENDFOR
END mixed
";

#[expect(clippy::print_stdout, reason = "an example prints its result")]
fn main() -> Result<(), Box<dyn std::error::Error>> {
    for (name, source, statements) in [("integers", INTEGERS, 6), ("mixed", MIXED, 6)] {
        let program = Program::parse_and_check(source.as_bytes(), name)
            .map_err(|diagnostics| karel::render(&diagnostics))?;
        let mut machine = Machine::new(Limits::default());
        machine.load(program)?;
        let task = machine.start(name)?;
        let start = now();
        let mut instructions = 0_u64;
        loop {
            let slice = machine.run(task, 10_000, &mut NoHost);
            instructions += u64::from(slice.used);
            if slice.run != Run::OutOfFuel {
                println!("{name}: {:?}", slice.run);
                break;
            }
        }
        let seconds = start.elapsed().as_secs_f64();
        let statements = f64::from(ROUNDS) * f64::from(statements);
        println!(
            "  {:.1} million statements/s, {instructions} instructions in {seconds:.2} s",
            statements / seconds / 1e6
        );
    }
    Ok(())
}

#[expect(
    clippy::disallowed_methods,
    reason = "the crate reads no clock; its benchmark does"
)]
fn now() -> Instant {
    Instant::now()
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
