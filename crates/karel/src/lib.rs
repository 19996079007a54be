//! KAREL, the language of FANUC controllers: lexer, parser, checker and machine.
//!
//! The shape towards a host (being built; signatures are settled):
//! `Program::parse_and_check(&[u8], file_name: &str) -> Result<Program, Vec<Diagnostic>>`,
//! `Program::warnings() -> &[Diagnostic]`, `Program::name() -> &str`,
//! `Machine::new(Limits)`, `Machine::load(Program) -> Result<(), LoadError>`,
//! `Machine::start(&str) -> Result<TaskId, StartError>`,
//! `Machine::run(TaskId, fuel: u32, &mut dyn Host) -> Slice { run: Run, used: u32 }`,
//! `Machine::task(TaskId) -> Option<TaskView>`, `Machine::abort(TaskId, &mut dyn Host)`.

mod error;
mod host;
mod position;
mod run;
mod status;
mod syspath;
mod value;

pub use error::{CallSite, RuntimeError};
pub use host::{
    FileId, Host, Input, InputEnd, MotionId, MotionRequest, MoveEnd, OpenMode, Progress, TaskId,
    Wait,
};
pub use position::{Config, Elbow, Front, Position, Wrist, Xyzwpr, XyzwprExt};
pub use run::{Limits, Run, Slice, TaskState, TaskView};
pub use status::Status;
pub use syspath::{Step, SysPath, SysPathError};
pub use value::{SysValue, Text, Value};
