//! Instructions.

use super::SignalTest;
use crate::{
    ast::{Action, ConditionVerb, Edge, HandVerb, MotionVerb, Relation, Signaled, TaskVerb, Waits},
    port::Port,
    types::PositionKind,
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
