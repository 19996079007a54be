//! Built-in routines: one table of names, signatures and code.

pub(crate) mod absent;
mod clear;
mod context;
mod convert;
mod dictionary;
mod file;
mod geometry;
mod joints;
mod keyboard;
mod math;
mod motion;
mod panel;
mod path;
mod port_setup;
mod ports;
mod queue;
mod register;
mod semaphore;
mod string;
mod task;
mod teaching;
mod time;
mod variable;
mod variable_file;
mod variable_list;

use std::time::Duration;

use crate::{
    host::{Host, TaskId, Wait},
    ir::BuiltinSite,
    machine::{
        Loaded, Tasks,
        cell::{Cell, Memory},
        created::Created,
        dictionaries::Dictionaries,
        fault::Fault,
        paths::Paths,
        semaphore::Semaphores,
        task::{Argument, Caller, Pending},
        teaching::Teaching,
    },
    port::{Comments, PortSetup},
    program::Program,
    registers::Registers,
    run::Limits,
    types::PositionKind,
};

/// A row of the table.
#[derive(Debug)]
pub(crate) struct Builtin {
    pub(crate) name: &'static str,
    pub(crate) params: &'static [Param],
    /// Arguments that may not be left out.
    pub(crate) required: usize,
    pub(crate) returns: Returns,
    pub(crate) code: fn(&mut Context<'_>) -> Result<Outcome, Fault>,
}

/// What an argument may be. Inputs are values; outputs are variables or, ignored, constants.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Param {
    Integer,
    Real,
    /// INTEGER or REAL, not converted.
    Number,
    Text,
    Boolean,
    Position(PositionKind),
    Vector,
    OutInteger,
    OutReal,
    OutText,
    OutBoolean,
    Config,
    OutConfig,
    /// Any joint type.
    Joints,
    OutJoints,
    /// A variable of any cartesian type.
    OutPosition,
    /// A variable, ARRAY OF REAL.
    RealArray,
    /// A variable, ARRAY OF INTEGER.
    IntegerArray,
    /// A variable, ARRAY OF STRING.
    TextArray,
    /// Read, perhaps written: a variable, or a constant, which is only read.
    InOutInteger,
    InOutText,
    /// A variable of any type, also a system variable.
    OutAny,
    /// A FILE variable.
    File,
    /// A variable of any type, not read.
    AnyVariable,
    AnyArray,
    /// A PATH variable.
    Path,
    /// A `QUEUE_TYPE` variable.
    Queue,
    /// Any value; a variable may be uninitialized.
    AnyValue,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Returns {
    Nothing,
    Integer,
    Real,
    Boolean,
    Text,
    XyzwprExt,
    Position,
    Vector,
    Joints,
    SameAsFirst,
}

/// What a built-in did.
pub(crate) enum Outcome {
    Done,
    /// The result of a function, if it is a scalar.
    Value(Cell),
    /// It is called again with the same arguments.
    Pending(Wait),
    /// The task ends.
    EndTask,
    /// It is done, and the task pauses.
    PauseTask,
    /// A program runs in the same task, from a line on, 0 for the first.
    CallProgram {
        name: String,
        line: u32,
    },
    /// It is done, and the task rests a little: a loop around it must not starve the others.
    DoneThenPause(Duration),
}

/// Looks a built-in up by its upper-case name.
pub(crate) fn find(name: &str) -> Option<&'static Builtin> {
    tables().find(|builtin| builtin.name == name)
}

pub(crate) fn names() -> Vec<&'static str> {
    let names = tables().map(|builtin| builtin.name);
    names
        .filter(|name| name.starts_with(char::is_alphabetic))
        .collect()
}

fn tables() -> impl Iterator<Item = &'static Builtin> {
    let tables = [
        clear::TABLE,
        convert::TABLE,
        dictionary::TABLE,
        file::TABLE,
        geometry::TABLE,
        joints::TABLE,
        keyboard::TABLE,
        math::TABLE,
        motion::TABLE,
        panel::TABLE,
        path::TABLE,
        port_setup::TABLE,
        ports::TABLE,
        queue::TABLE,
        register::TABLE,
        semaphore::TABLE,
        string::TABLE,
        task::TABLE,
        teaching::TABLE,
        time::TABLE,
        variable::TABLE,
        variable_file::TABLE,
        variable_list::TABLE,
    ];
    tables.into_iter().flatten()
}

/// What the code of a built-in can reach.
pub(crate) struct Context<'a> {
    pub(crate) task: TaskId,
    pub(crate) program: &'a Program,
    pub(crate) programs: &'a [Loaded],
    /// All tasks but the one that runs.
    pub(crate) tasks: &'a mut Tasks,
    pub(crate) registers: &'a mut Registers,
    pub(crate) semaphores: &'a mut Semaphores,
    /// Progress of a built-in that waits.
    pub(crate) pending: &'a mut Pending,
    /// Arguments of the programs that were called, and how many callers there were.
    pub(crate) arguments: &'a [(usize, Vec<Argument>)],
    pub(crate) comments: &'a mut Comments,
    pub(crate) paths: &'a mut Paths,
    pub(crate) created: &'a mut Created,
    pub(crate) dictionaries: &'a mut Dictionaries,
    pub(crate) port_setup: &'a mut PortSetup,
    pub(crate) teaching: &'a mut Teaching,
    pub(crate) running: Running<'a>,
    /// Who called the program or routine that runs.
    pub(crate) callers: &'a [Caller],
    pub(crate) limits: &'a Limits,
    pub(crate) host: &'a mut dyn Host,
    pub(crate) memory: Memory<'a>,
    pub(crate) operands: &'a [Cell],
    pub(crate) site: &'a BuiltinSite,
}

/// The task that runs, as built-ins see it.
#[derive(Clone, Copy)]
pub(crate) struct Running<'a> {
    /// Its root program.
    pub(crate) name: &'a str,
    /// Source line of the statement.
    pub(crate) line: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_built_in_has_one_row_and_a_reachable_name() {
        let mut names = names();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
        // Operators have names that no program can write.
        for name in names
            .into_iter()
            .filter(|name| name.starts_with(char::is_alphabetic))
        {
            assert_eq!(name, name.to_ascii_uppercase());
        }
    }
}
