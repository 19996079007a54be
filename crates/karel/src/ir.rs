//! The instructions that the machine executes.
//!
//! A stack machine over typed cells. Operands are scalars or addresses; arrays, structures and
//! positions stay in memory and are named by the address of their first cell. Everything an
//! instruction needs beyond a number lies in a table of [`Code`].

mod op;

use std::{collections::BTreeMap, sync::Arc};

use crate::{
    ast::{NodeSide, TaskVerb},
    builtins::Builtin,
    syspath::SysPath,
    types::{PositionKind, Type},
    value::Text,
};

pub(crate) use op::{MoveKind, Op, Outward, Rare};

/// Where the position is in the nodes of a PATH.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct NodeShape {
    pub(crate) offset: u32,
    pub(crate) kind: PositionKind,
}

/// What a condition asks of the signals that a task has seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SignalTest {
    Event,
    Semaphore,
    /// An error of this code, or any.
    Error,
    AnyError,
    /// Of the task itself.
    Own(TaskVerb),
    /// Of the task with this number.
    Of(TaskVerb),
    /// A node of a MOVE ALONG was reached: this one, or any.
    Node,
    AnyNode,
    /// The time, in milliseconds, and a node.
    Time(NodeSide),
}

/// A condition handler: code for its conditions and its actions.
#[derive(Debug)]
pub(crate) struct HandlerShape {
    pub(crate) whens: Vec<WhenShape>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct WhenShape {
    /// Routines.
    pub(crate) condition: u32,
    pub(crate) actions: u32,
    /// Ports whose edges it looks for.
    pub(crate) edges: u32,
}

/// A lowered program.
#[derive(Debug, Default)]
pub(crate) struct Code {
    pub(crate) ops: Vec<Op>,
    /// Source line of each instruction.
    pub(crate) lines: Vec<u32>,
    pub(crate) texts: Vec<Text>,
    pub(crate) shapes: Vec<Shape>,
    pub(crate) systems: Vec<SystemRef>,
    pub(crate) builtins: Vec<BuiltinSite>,
    pub(crate) reads: Vec<ReadShape>,
    pub(crate) writes: Vec<WriteShape>,
    pub(crate) handlers: Vec<HandlerShape>,
    /// Types of what BYNAME finds.
    pub(crate) types: Vec<Type>,
    /// Nodes of the paths of MOVE ALONG.
    pub(crate) nodes: Vec<NodeShape>,
    /// Instructions of a TP program.
    pub(crate) tp: Vec<crate::tp::Instruction>,
    /// Positions of a TP program.
    pub(crate) positions: BTreeMap<i32, Arc<crate::tp::Taught>>,
    /// Routines of other programs that are called.
    pub(crate) externals: Vec<External>,
    /// The main body first.
    pub(crate) routines: Vec<RoutineCode>,
}

/// A variable that is another program's.
#[derive(Clone, Debug)]
pub(crate) struct SharedVariable {
    pub(crate) name: String,
    pub(crate) program: String,
    /// The cell among the own variables that holds its address.
    pub(crate) cell: u32,
    pub(crate) ty: Type,
}

/// What `%NOPAUSE`, `%NOABORT` and `%NOLOCKGROUP` say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Attributes {
    /// `%NOLOCKGROUP`: the program has no control of the motion group.
    pub(crate) free_of_group: bool,
    pub(crate) no_pause: Sources,
    pub(crate) no_abort: Sources,
}

/// Where an interruption comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Sources {
    pub(crate) error: bool,
    pub(crate) command: bool,
    pub(crate) pendant: bool,
}

impl Sources {
    /// `ERROR + COMMAND + TPENABLE`.
    pub(crate) fn parse(list: &str) -> Sources {
        let names = |wanted: &str| {
            list.split('+')
                .any(|name| name.trim().eq_ignore_ascii_case(wanted))
        };
        Sources {
            error: names("ERROR"),
            command: names("COMMAND"),
            pendant: names("TPENABLE"),
        }
    }
}

/// A routine of another program as its caller declares it.
#[derive(Clone, Debug)]
pub(crate) struct External {
    pub(crate) program: String,
    pub(crate) routine: String,
    pub(crate) signature: Signature,
}

/// Types of the parameters and of the result. Those of a caller and of the routine must be equal.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Signature {
    pub(crate) params: Vec<Type>,
    pub(crate) result: Option<Type>,
}

#[derive(Debug)]
pub(crate) struct RoutineCode {
    pub(crate) name: Arc<str>,
    pub(crate) signature: Signature,
    pub(crate) entry: u32,
    /// Arguments that the caller leaves on the stack.
    pub(crate) args: u32,
    pub(crate) frame_cells: u32,
    /// Frame cells of FILE variables.
    pub(crate) files: Vec<u32>,
    /// Frame cells of PATH variables, and the size of a node.
    pub(crate) paths: Vec<(u32, u32)>,
}

/// How subscripts become an offset.
#[derive(Debug, PartialEq)]
pub(crate) struct Shape {
    pub(crate) dims: Vec<u32>,
    pub(crate) element_cells: u32,
}

#[derive(Debug)]
pub(crate) struct SystemRef {
    pub(crate) steps: Vec<SystemPart>,
    /// The path, if it has no subscripts that are computed.
    pub(crate) fixed: Option<SysPath>,
    /// Subscripts on the stack.
    pub(crate) subscripts: u32,
    /// Cell of the component that is meant.
    pub(crate) component: Option<u32>,
    pub(crate) ty: Type,
}

#[derive(Debug)]
pub(crate) enum SystemPart {
    Name(String),
    /// As many subscripts as this.
    Index(u32),
}

#[derive(Debug)]
pub(crate) struct BuiltinSite {
    pub(crate) builtin: &'static Builtin,
    /// Types of the arguments as written.
    pub(crate) types: Vec<Type>,
    /// Operands: the arguments, and before them the address for a result of several cells.
    pub(crate) operands: u32,
    pub(crate) result_in_memory: bool,
}

#[derive(Debug)]
pub(crate) struct ReadShape {
    pub(crate) items: Vec<ReadPart>,
    pub(crate) operands: u32,
}

#[derive(Debug)]
pub(crate) enum ReadPart {
    /// A target address and format specifiers.
    Value {
        ty: ScalarType,
        formats: u32,
    },
    LineEnd,
}

impl ReadPart {
    pub(crate) fn is_config(&self) -> bool {
        let config = ScalarType::Config;
        matches!(self, ReadPart::Value { ty, .. } if *ty == config)
    }
}

#[derive(Debug)]
pub(crate) struct WriteShape {
    pub(crate) to_file: bool,
    pub(crate) items: Vec<WritePart>,
    pub(crate) operands: u32,
}

#[derive(Debug)]
pub(crate) enum WritePart {
    /// A value and format specifiers.
    Value {
        ty: ScalarType,
        formats: u32,
        /// A number behind others of a position or an array: a blank is before it.
        follows: bool,
    },
    LineEnd,
}

/// Types that READ and WRITE handle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ScalarType {
    Integer,
    Real,
    Boolean,
    Text,
    Config,
    /// Elements of arrays and fields; INTEGERs everywhere else.
    Short,
    Byte,
}
