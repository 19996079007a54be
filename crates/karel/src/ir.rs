//! The instructions that the machine executes.
//!
//! A stack machine over typed cells. Operands are scalars or addresses; arrays, structures and
//! positions stay in memory and are named by the address of their first cell. Everything an
//! instruction needs beyond a number lies in a table of [`Code`].

use std::{collections::BTreeMap, sync::Arc};

use crate::{
    ast::{
        Action, ConditionVerb, Edge, HandVerb, MotionVerb, NodeSide, Relation, Signaled, TaskVerb,
        Waits,
    },
    builtins::Builtin,
    port::Port,
    syspath::SysPath,
    types::{PositionKind, Type},
    value::Text,
};

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Op {
    PushInteger(i32),
    PushReal(f32),
    PushBoolean(bool),
    /// From the table of texts.
    PushText(u32),
    /// In place of an output argument that is to be ignored.
    PushDiscard,

    /// Push the value of a cell; an uninitialized one is INTP-311.
    LoadGlobal(u32),
    LoadLocal(u32),
    /// Through the reference in a frame cell.
    LoadParam(u32),
    /// Through the address on the stack.
    LoadIndirect,

    AddressGlobal(u32),
    AddressLocal(u32),
    /// The reference in a frame cell.
    AddressParam(u32),
    /// Adds to the address on the stack.
    Offset(u32),
    /// Puts a length beside the address on the stack: of an array or of a string.
    Extra(u32),
    /// Subscripts above an address, by a row of the table of shapes.
    Index(u32),
    /// One subscript above the address of an open array; cells of an element.
    OpenIndex(u32),

    StoreGlobal(u32),
    StoreLocal(u32),
    StoreParam(u32),
    /// Cuts the string to the length beside the reference.
    StoreTextParam(u32),
    /// The value above an address.
    StoreIndirect,
    /// Cuts the string on the stack.
    Truncate(u32),

    IntegerToReal,
    AddInteger,
    SubtractInteger,
    MultiplyInteger,
    DivInteger,
    ModInteger,
    AndInteger,
    OrInteger,
    AddReal,
    SubtractReal,
    MultiplyReal,
    DivideReal,
    AndBoolean,
    OrBoolean,
    CompareInteger(Relation),
    CompareReal(Relation),

    Jump(u32),
    JumpIfFalse(u32),
    JumpIfTrue(u32),
    Call(u32),
    Return,

    /// Too seldom to make the hot loop larger.
    Rare(Rare),
    /// Ends something, waits, or asks the host.
    Outward(Outward),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Rare {
    /// Push the address of a variable of another program, from the cell that holds it.
    AddressShared(u32),
    NegateInteger,
    NegateReal,
    NotBoolean,
    NotInteger,
    Concatenate,
    CompareText(Relation),
    CompareBoolean(Relation),
    /// Copies cells: a source address above a target address.
    CopyCells(u32),
    /// Copies a position: a source address above a target address.
    CopyPosition {
        from: PositionKind,
        to: PositionKind,
        /// Without a value, the target gets none either; else that is INTP-311.
        may_lack: bool,
    },
    /// One subscript above the address of an open array of strings of any length.
    OpenTextIndex,
    /// A string above an address, cut to the length beside the address.
    StoreTextIndirect,
    /// Of the INTEGER on the stack, before it becomes a SHORT or a BYTE.
    CheckRange {
        least: i32,
        most: i32,
    },
    /// Subscripts above the address of an open array of so many dimensions.
    OpenGrid {
        dims: u8,
        element_cells: u32,
    },
    /// Push what is at an address, if it has no value, too.
    LoadAny,
    /// As `LoadAny`, of a configuration, which has a default value.
    LoadConfig,
    /// A subscript above the address of a PATH: the address of the node.
    Node,
    /// Copies joints: a source address above a target address, and their cells.
    CopyJoints {
        from: u32,
        to: u32,
    },
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outward {
    /// A routine of another program, by a row of the table of externals.
    CallExternal(u32),
    /// A function reached its END.
    MissingReturn,
    /// No CASE matched.
    NoCase,
    /// ABORT.
    EndTask,
    /// The END of the main body: back to whoever called the program, or the end of the task.
    EndProgram,
    /// By a row of the table of built-in calls.
    Builtin(u32),
    /// By a row of the table of system variables; subscripts on the stack. A value of several
    /// cells goes to the address below them.
    LoadSystem(u32),
    /// The value, or its address, below the subscripts.
    StoreSystem(u32),
    /// Loads for an output argument: an uninitialized variable is no error.
    FetchSystem(u32),
    /// Stores after an output argument was written, uninitialized or not.
    ReturnSystem(u32),
    /// The names of a program and of a variable become its address; by a row of the table of types.
    ByName(u32),
    /// Its number on the stack.
    LoadPort(Port),
    /// Its number above the value.
    StorePort(Port),
    /// Waits until conditions are looked at again.
    Scan,
    /// From here on a WAIT FOR sees what is signaled.
    WaitBegin,
    /// The end of the code of a condition, whose value is on the stack.
    ConditionEnd,
    /// A task's number, or that of an event or semaphore, or nothing on the stack.
    Signaled(SignalTest),
    /// The state of a port on the stack.
    Edge {
        slot: u32,
        edge: Edge,
    },
    /// By a row of the table of handlers; its number and `$SCAN_TIME`, or 0, on the stack.
    DefineCondition(u32),
    /// The handler of the MOVE that follows, by a row of the table of handlers.
    DefineLocal(u32),
    /// Its number on the stack.
    ConditionState(ConditionVerb),
    Action(Action),
    /// A call among the actions waits while the task is paused.
    ActionGate,
    /// Its number on the stack.
    Signal(Signaled),
    /// `ABORT` is `EndTask`. Its number, or 0 for the own one, on the stack.
    Task(TaskVerb),
    /// The time in milliseconds above the port's number.
    Pulse(Port, Waits),
    /// Its number on the stack.
    Hand(HandVerb),
    Motion(MotionVerb),
    OpenFile,
    CloseFile,
    CancelFile,
    Read(u32),
    Write(u32),
    Delay,
    /// The address of the variable.
    ConnectTimer,
    /// The address of the variable.
    DisconnectTimer,
    /// What it needs on the stack.
    Move(MoveKind, Waits),
    /// The address of a PATH, its first and last node or none; by a row of the table of nodes.
    MoveAlong(u32, Waits),
    /// An instruction of a TP program, by a row of its table.
    Tp(u32),
}

/// What a MOVE finds on the stack, the last one on top.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum MoveKind {
    /// A position.
    To,
    /// A position on the arc and a position.
    Via,
    /// A position and a distance.
    Near,
    /// A position on the arc, a position and a distance.
    NearVia,
    /// The number of a joint and a distance.
    Axis,
    /// A vector.
    Relative,
    /// A vector and an angle.
    About,
    /// A distance.
    Away,
}

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
