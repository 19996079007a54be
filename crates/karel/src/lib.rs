//! KAREL, the language of FANUC controllers: lexer, parser, checker and machine.
//!
//! The shape towards a host (being built; signatures are settled):
//! `Program::parse_and_check(&[u8], file_name: &str) -> Result<Program, Vec<Diagnostic>>`,
//! `Program::warnings() -> &[Diagnostic]`, `Program::name() -> &str`,
//! `Machine::new(Limits)`, `Machine::load(Program) -> Result<(), LoadError>`,
//! `Machine::start(&str) -> Result<TaskId, StartError>`,
//! `Machine::run(TaskId, fuel: u32, &mut dyn Host) -> Slice { run: Run, used: u32 }`,
//! `Machine::task(TaskId) -> Option<TaskView>`, `Machine::abort(TaskId, &mut dyn Host)`.

mod ast;
mod builtins;
mod check;
mod diagnostic;
mod error;
mod host;
mod ir;
mod lexer;
mod lower;
mod machine;
mod parser;
mod position;
mod program;
mod run;
mod sexpr;
mod span;
mod status;
mod syspath;
mod sysvars;
mod text_reader;
mod text_writer;
mod token;
mod typed;
mod types;
mod value;

pub use diagnostic::{Diagnostic, Severity, render};
pub use error::{CallSite, RuntimeError};
pub use host::{
    FileId, Host, Input, InputEnd, MotionId, MotionRequest, MoveEnd, OpenMode, Progress, TaskId,
    Wait,
};
pub use machine::{LoadError, Machine, StartError};
pub use position::{Config, Elbow, Front, Position, Wrist, Xyzwpr, XyzwprExt};
pub use program::Program;
pub use run::{Limits, Run, Slice, TaskState, TaskView};
pub use status::Status;
pub use syspath::{Step, SysPath, SysPathError};
pub use value::{SysValue, Text, Value};

/// Parses `source` and writes its tree as S-expressions, one statement a line.
///
/// # Errors
/// What the lexer and the parser found.
pub fn syntax_tree(source: &[u8], file_name: &str) -> Result<String, Vec<Diagnostic>> {
    let source = span::Source::new(source, file_name);
    let mut reports = diagnostic::Reports::default();
    let program = parser::parse(&source, &mut reports);
    match program {
        Some(program) if !reports.has_errors() => Ok(sexpr::program(&program)),
        Some(_) | None => Err(reports.into_diagnostics(&source)),
    }
}
