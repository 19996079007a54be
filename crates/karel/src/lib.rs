//! KAREL, the language of FANUC robot controllers: lexer, parser, checker and machine.
//!
//! The crate runs `.kl` sources as they are. It does no I/O and reads no clock: sockets, system
//! variables, motion and time are asked of a [`Host`], so the same program runs against an
//! emulated robot, a test script, or a clock that stands still.
//!
//! ```text
//! bytes ─ lexer ─ tokens ─ parser ─ tree ─ checker ─ typed tree ─ lowering ─ instructions ─ Machine
//!              └──────────── Diagnostic: message, line, caret ──┘                          │   ▲
//!                                                                                calls     ▼   │ answers
//!                                                                                         Host
//! ```
//!
//! - **Source.** Latin-1 bytes, LF or CRLF. [`Program::parse_and_check`] reports every error it
//!   finds, each as a [`Diagnostic`] that renders with its source line. KAREL that is legal but
//!   not run yet is an error that says so, never ignored.
//! - **Memory.** A row of cells, one for each scalar; arrays, structures and positions are the
//!   cells of their parts. Each cell knows whether it is uninitialized, and reading such a cell
//!   ends the task with INTP-311.
//! - **Tasks.** [`Machine::run`] executes a task for a number of instructions. A statement that
//!   must wait suspends the task with a [`Wait`]; its state is plain data, there is no thread and
//!   no recursion. Status codes and error texts are the controller's ([`Status`],
//!   [`RuntimeError`]).
//! - **Several programs.** Routines of other programs are linked by name when programs are loaded;
//!   `%INCLUDE` takes files of the caller ([`Includes`]); programs start and end each other's tasks.
//! - **Memory without power.** [`Machine::export_cmos`] and [`Machine::import_cmos`] carry variables
//!   `IN CMOS` and [`Registers`] over a power cycle.
//! - **Units.** Positions are `f32` millimeters and degrees, W, P, R about the fixed X, Y, Z axes,
//!   as KAREL has them.
//!
//! Rules that are guessed and not documented are marked `ASSUMPTION:` in the source, and their
//! tests start with `assumed`.
//!
//! # Example
//!
//! ```
//! use karel::{Limits, Machine, Program, Run};
//! # use karel::*;
//! # use std::time::Duration;
//! # #[derive(Default)]
//! # struct Screen { text: String }
//! # impl Host for Screen {
//! #     fn now(&self) -> Duration { Duration::ZERO }
//! #     fn msg_connect(&mut self, _: TaskId, _: &str) -> Progress<Status> { Progress::Ready(Status::HOST_TAG) }
//! #     fn msg_disco(&mut self, _: TaskId, _: &str) -> Status { Status::OK }
//! #     fn open_file(&mut self, _: TaskId, _: OpenMode, _: &str) -> Result<FileId, Status> { Err(Status::INTP_OPEN_FAILED) }
//! #     fn close_file(&mut self, _: FileId) -> Status { Status::OK }
//! #     fn cancel_file(&mut self, _: FileId) -> Status { Status::OK }
//! #     fn input(&self, _: FileId) -> Input<'_> { Input { bytes: &[], end: InputEnd::Open } }
//! #     fn consume(&mut self, _: FileId, _: usize) {}
//! #     fn output(&mut self, _: FileId, _: &[u8]) -> Progress<Status> { Progress::Ready(Status::OK) }
//! #     fn display(&mut self, _: TaskId, text: &[u8]) { self.text.push_str(&String::from_utf8_lossy(text)); }
//! #     fn system_variable(&self, _: TaskId, _: &SysPath) -> Result<Value, Status> { Err(Status::VARS_UNKNOWN) }
//! #     fn set_system_variable(&mut self, _: TaskId, _: &SysPath, _: SysValue) -> Result<(), Status> { Ok(()) }
//! #     fn current_position(&mut self, _: TaskId, _: i32) -> Result<XyzwprExt, Status> { Ok(XyzwprExt::default()) }
//! #     fn check_position(&mut self, _: TaskId, _: &XyzwprExt, _: &Position, _: &Position, _: i32) -> Status { Status::OK }
//! #     fn start_motion(&mut self, _: TaskId, _: MotionRequest) -> Progress<Result<MotionId, Status>> { Progress::Ready(Ok(MotionId(1))) }
//! #     fn motion_ended(&mut self, _: MotionId) -> Progress<Status> { Progress::Ready(Status::OK) }
//! #     fn post_alarm(&mut self, _: TaskId, _: &RuntimeError) {}
//! # }
//! // `Screen` is a host that keeps what the program writes; see [`Host`] for what it implements.
//! let mut host = Screen::default();
//!
//! let source = b"PROGRAM hello\nBEGIN\n  WRITE ('2 + 2 =', 2 + 2)\nEND hello\n";
//! let program = Program::parse_and_check(source, "hello.kl").expect("no errors");
//!
//! let mut machine = Machine::new(Limits::default());
//! machine.load(program)?;
//! let task = machine.start("hello")?;
//! assert_eq!(machine.run(task, 1_000, &mut host).run, Run::Ended);
//! assert_eq!(host.text, "2 + 2 = 4");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod ast;
mod binary;
mod builtins;
mod check;
mod cmos;
mod diagnostic;
mod error;
mod frame;
mod generation;
#[cfg(test)]
mod golden_coverage;
mod headers;
mod host;
mod include;
mod ir;
mod lexer;
mod lower;
mod machine;
mod parser;
mod port;
mod position;
mod program;
mod registers;
mod run;
mod sexpr;
mod span;
mod status;
mod syspath;
mod sysvars;
mod text_reader;
mod text_writer;
mod token;
mod tp;
mod typed;
mod types;
mod value;
mod vendor_file;

pub use cmos::{Cmos, PathNodes, Scalar};
pub use diagnostic::{Diagnostic, Severity, render};
pub use error::{CallSite, RuntimeError};
pub use generation::Generation;
pub use host::{
    AlarmSeverity, AlarmView, FileId, FileOperation, HandAction, Host, Input, InputEnd,
    Interpolation, MotionId, MotionPath, MotionRequest, MoveEnd, OpenMode, ProgramAlarm, Progress,
    TaskId, TpMotion, TpSpeed, TpTarget, Wait,
};
pub use include::{IncludeFile, IncludeFiles, Includes};
pub use machine::{LoadError, Machine, StartError, VariableView};
pub use port::{Port, PortValue};
pub use position::{Config, Elbow, Front, JointPosition, Position, Wrist, Xyzwpr, XyzwprExt};
pub use program::{Interruption, Program, syntax_tree};
pub use registers::{Number, PositionRegister, RegisterCounts, Registers};
pub use run::{ByteOrder, Limits, Run, Slice, TaskState, TaskView};
pub use status::Status;
pub use syspath::{Step, SysPath, SysPathError};
pub use value::{SysValue, Text, Value};
