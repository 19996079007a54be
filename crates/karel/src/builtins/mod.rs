//! Built-in routines: one table of names, signatures and code.

mod convert;
mod file;
mod geometry;
mod joints;
mod math;
mod motion;
mod panel;
mod ports;
mod register;
mod semaphore;
mod string;
mod task;
mod time;
mod variable;

use std::time::Duration;

use crate::{
    host::{Host, TaskId, Wait},
    ir::BuiltinSite,
    machine::{
        Loaded, Tasks,
        cell::{Address, Cell, Memory},
        fault::Fault,
        semaphore::Semaphores,
        task::{Argument, Pending},
    },
    port::Comments,
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
        file::TABLE,
        geometry::TABLE,
        joints::TABLE,
        math::TABLE,
        motion::TABLE,
        panel::TABLE,
        ports::TABLE,
        register::TABLE,
        semaphore::TABLE,
        string::TABLE,
        task::TABLE,
        time::TABLE,
        variable::TABLE,
    ];
    tables.into_iter().flatten()
}

/// Built-ins that exist on a controller and not here: they deserve a better message than a typing
/// error.
const PLANNED: &[&str] = &[
    "ADD_DICT",
    "APPEND_NODE",
    "APPEND_QUEUE",
    "AVL_POS_NUM",
    "BYNAME",
    "CHECK_DICT",
    "CHECK_NAME",
    "CLOSE_TPE",
    "CLR_PORT_SIM",
    "CNC_DYN_DISB",
    "CNC_DYN_DISE",
    "CNC_DYN_DISI",
    "CNC_DYN_DISP",
    "CNC_DYN_DISR",
    "CNC_DYN_DISS",
    "CNCL_STP_MTN",
    "COPY_PATH",
    "COPY_QUEUE",
    "COPY_TPE",
    "CREATE_TPE",
    "CREATE_VAR",
    "DEL_INST_TPE",
    "DELETE_NODE",
    "DELETE_QUEUE",
    "DISCTRL_ALPH",
    "DISCTRL_FORM",
    "DISCTRL_LIST",
    "DISCTRL_PLMN",
    "DISCTRL_SBMN",
    "DISCTRL_TBL",
    "GET_ATTR_PRG",
    "GET_JPOS_TPE",
    "GET_PORT_ASG",
    "GET_PORT_MOD",
    "GET_PORT_SIM",
    "GET_POS_FRM",
    "GET_POS_TPE",
    "GET_POS_TYP",
    "GET_QUEUE",
    "GET_TPE_CMT",
    "INI_DYN_DISB",
    "INI_DYN_DISE",
    "INI_DYN_DISI",
    "INI_DYN_DISP",
    "INI_DYN_DISR",
    "INI_DYN_DISS",
    "INIT_QUEUE",
    "INIT_TBL",
    "INSERT_NODE",
    "INSERT_QUEUE",
    "LOAD",
    "MODIFY_QUEUE",
    "NODE_SIZE",
    "OPEN_TPE",
    "PATH_LEN",
    "POP_KEY_RD",
    "PRINT_FILE",
    "PURGE_DEV",
    "PUSH_KEY_RD",
    "READ_DICT",
    "READ_DICT_V",
    "READ_KB",
    "REMOVE_DICT",
    "RENAME_VAR",
    "RESET",
    "SAVE",
    "SEND_DATAPC",
    "SET_ATTR_PRG",
    "SET_JPOS_TPE",
    "SET_PORT_ASG",
    "SET_PORT_MOD",
    "SET_PORT_SIM",
    "SET_POS_TPE",
    "SET_TPE_CMT",
    "SET_TRNS_TPE",
    "TRANSLATE",
    "VAR_INFO",
    "VAR_LIST",
    "VOL_SPACE",
    "WRITE_DICT",
    "WRITE_DICT_V",
];

pub(crate) fn is_planned(name: &str) -> bool {
    PLANNED.contains(&name)
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
    pub(crate) running: Running<'a>,
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
            assert!(
                !is_planned(name),
                "{name} is there and announced as missing"
            );
        }
    }
}
