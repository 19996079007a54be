//! Built-in routines: one table of names, signatures and code.

pub(crate) mod absent;
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
    host::{FileOperation, Host, InputEnd, OpenMode, Progress, TaskId, Wait},
    ir::BuiltinSite,
    machine::{
        Loaded, Names, Tasks,
        cell::{Address, Cell, Memory},
        created::Created,
        dictionaries::Dictionaries,
        fault::Fault,
        paths::Paths,
        semaphore::Semaphores,
        task::{Argument, Caller, Pending},
        teaching::Teaching,
    },
    port::{Comments, PortSetup},
    position::{JointPosition, XyzwprExt},
    program::Program,
    registers::Registers,
    run::Limits,
    status::Status,
    types::{PositionKind, Type},
    value::Text,
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

impl Context<'_> {
    /// What finds a variable by its name.
    fn names(&self) -> Names<'_> {
        Names {
            programs: self.programs,
            paths: self.paths,
            created: self.created,
            globals: self.memory.globals,
        }
    }

    /// Says why something that is correct has another effect than many expect.
    fn explain(&mut self, why: &dyn Fn() -> String) {
        let place = (self.program.name(), self.running.line);
        self.host.explain(self.task, place, why);
    }

    fn arg(&self, number: usize) -> &Cell {
        let index = number + usize::from(self.site.result_in_memory);
        self.operands
            .get(index)
            .expect("the checker counts arguments")
    }

    fn has_arg(&self, number: usize) -> bool {
        number < self.site.types.len()
    }

    fn ty(&self, number: usize) -> &Type {
        self.site
            .types
            .get(number)
            .expect("the checker counts arguments")
    }

    fn integer(&self, number: usize) -> i32 {
        self.arg(number).expect_integer()
    }

    fn real(&self, number: usize) -> f32 {
        self.arg(number).expect_real()
    }

    fn text(&self, number: usize) -> Text {
        self.arg(number).expect_text()
    }

    fn boolean(&self, number: usize) -> bool {
        *self.arg(number) == Cell::Boolean(true)
    }

    /// The value of an argument that is read and written.
    fn in_out(&self, number: usize) -> &Cell {
        self.memory.get(self.variable(number))
    }

    /// The address of a variable, `None` if a constant stands in its place.
    fn address(&self, number: usize) -> Option<Address> {
        let arg = self.arg(number);
        (*arg != Cell::Uninit).then(|| arg.expect_address())
    }

    /// The address of a variable that the checker insists on.
    fn variable(&self, number: usize) -> Address {
        self.address(number)
            .expect("the checker insists on a variable")
    }

    /// Where a result of several cells goes.
    fn result(&self) -> Address {
        self.operands
            .first()
            .expect("lowering pushes the result's address")
            .expect_address()
    }

    fn joints(&self, number: usize) -> Result<JointPosition, Fault> {
        let Type::Joints(kind) = self.ty(number) else {
            unreachable!("the checker insists on a JOINTPOS")
        };
        self.memory.joints(self.variable(number), *kind)
    }

    fn position(&self, number: usize, kind: PositionKind) -> Result<XyzwprExt, Fault> {
        self.memory.position(self.variable(number), kind)
    }

    fn put(&mut self, number: usize, value: Cell) {
        if let Some(address) = self.address(number) {
            self.memory.set(address, value);
        }
    }

    fn put_status(&mut self, number: usize, status: Status) {
        self.put(number, Cell::Integer(status.0));
    }

    /// The elements of an array of strings.
    fn texts(&self, number: usize) -> Vec<Option<String>> {
        let at = self.variable(number);
        let length = variable::array_length(self.ty(number), at.extra);
        let cells = (0..length).map(|offset| self.memory.get(at.plus(offset)));
        let texts = cells.map(|cell| {
            let has_value = *cell != Cell::Uninit;
            has_value.then(|| cell.expect_text().to_string_lossless())
        });
        texts.collect()
    }

    /// Stores texts into an array of strings from its first element on, as many as fit, cut to the
    /// length of its strings. How many those were.
    fn put_texts(&mut self, number: usize, texts: impl Iterator<Item = Text>) -> i32 {
        let at = self.variable(number);
        let room = variable::array_length(self.ty(number), at.extra);
        let mut longest = crate::types::split_text_array(at.extra).1;
        if let Type::Array(array) = self.ty(number) {
            longest = array.element.length().unwrap_or(longest);
        }
        let mut count = 0;
        for (mut text, offset) in texts.zip(0..room) {
            text.truncate(longest as usize);
            self.memory.set(at.plus(offset), Cell::Text(text));
            count += 1;
        }
        count
    }

    /// The bytes of a file that can be read at once.
    fn read_file(&mut self, name: &str) -> Result<Vec<u8>, Status> {
        let file = self.host.open_file(self.task, OpenMode::ReadOnly, name)?;
        let input = self.host.input(file);
        let bytes = match input.end {
            InputEnd::Closed(_) => Ok(input.bytes.to_vec()),
            // A connection or a pipe.
            InputEnd::Open => Err(Status::FILE_ILLEGAL_PARAMETER),
        };
        let _closed = self.host.close_file(file);
        bytes
    }

    /// Replaces a file.
    fn write_file(&mut self, name: &str, bytes: &[u8]) -> Result<(), Status> {
        let _none = self
            .host
            .file_operation(self.task, FileOperation::Delete(name));
        let file = self.host.open_file(self.task, OpenMode::ReadWrite, name)?;
        let written = self.host.output(file, bytes);
        let closed = self.host.close_file(file);
        match written {
            Progress::Ready(status) if !status.is_ok() => Err(status),
            Progress::Ready(_) if !closed.is_ok() => Err(closed),
            Progress::Ready(_) => Ok(()),
            Progress::Pending(_) => Err(Status::INTP_WRITE_FAILED),
        }
    }

    /// Stores a string, cut to the variable's length.
    fn put_text(&mut self, number: usize, mut text: Text) {
        if let Some(address) = self.address(number) {
            let length = self.ty(number).length().unwrap_or(address.extra);
            text.truncate(length as usize);
            self.memory.set(address, Cell::Text(text));
        }
    }
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
