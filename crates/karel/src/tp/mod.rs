//! TP programs, the pendant's own language, as their `.ls` listings.
//!
//! The part that programs of the field use most: motion, registers, I/O, jumps, blocks, calls with
//! arguments, waits, frames. Each line
//! becomes one [`Instruction`] of the same machine that runs KAREL. What is TP and not run yet is
//! an error that says so.

mod absent;
mod expression;
mod instruction;
mod listing;
mod motion;
mod position;
mod resolve;
mod scan;
mod simple;

use std::{collections::BTreeMap, sync::Arc};

use crate::{
    ast::Relation,
    host::{Interpolation, TpTarget},
    port::Port,
    syspath::SysPath,
};

pub(crate) use listing::parse;

/// What a line of a TP program does.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Instruction {
    /// A remark, a label, or nothing.
    Nothing,
    /// To an instruction of the same program.
    Jump(u32),
    Goto(Goal),
    Assign {
        target: Place,
        value: Expr,
    },
    If {
        condition: Expr,
        then: Branch,
    },
    /// `IF .. THEN`: to an instruction if the condition does not hold.
    Unless {
        condition: Expr,
        to: u32,
    },
    /// A case of a SELECT; a program that is called comes back behind the whole SELECT.
    Case {
        condition: Option<Expr>,
        then: Branch,
        behind: u32,
    },
    /// `FOR`: to the instruction behind its ENDFOR if there is nothing to do.
    For {
        head: ForHead,
        behind: u32,
    },
    /// `ENDFOR`: to the instruction behind its FOR if there is more to do.
    EndFor {
        head: ForHead,
        again: u32,
    },
    WaitSeconds(Operand),
    WaitFor {
        condition: Expr,
        /// Where to when it takes longer than `$WAITTMOUT`.
        timeout: Option<Goal>,
    },
    Call(Call),
    /// An instruction by words of its own, which a table of the controller explains.
    Macro(Call),
    /// `CALL ...`: nobody has entered the program.
    Unfinished,
    Run(Arc<str>),
    Move(Box<Motion>),
    /// Without a time it is that of `$DEFPULSE`.
    Pulse(Port, Index, Option<Operand>),
    Timer(Index, TimerAction),
    /// `UALM[1]`.
    UserAlarm(Index),
    /// `MONITOR` and `MONITOR END`: whether a program of conditions is looked at.
    Monitor(Arc<str>, bool),
    /// A condition of such a program.
    When(Expr, Call),
    Message(Arc<str>),
    SkipCondition(Expr),
    /// `OFFSET CONDITION`, or `TOOL_OFFSET CONDITION`.
    OffsetCondition {
        tool: bool,
        register: Index,
    },
    Override(Operand),
    /// `RSR[1]=ENABLE`, `DISABLE`: whether that signal starts its program.
    EnableRequest(Index, bool),
    /// Of an option that is not there.
    Absent(Absent),
    End,
    Abort,
    Pause,
}

/// `FOR R[1]=1 TO 5`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ForHead {
    pub(crate) counter: Index,
    pub(crate) from: Operand,
    pub(crate) to: Operand,
    pub(crate) down: bool,
}

/// Something of an option that this controller does not have.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Absent {
    /// The words of the line.
    pub(crate) what: Arc<str>,
    pub(crate) needs: &'static str,
}

/// A program and its arguments.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Call {
    pub(crate) program: Arc<str>,
    pub(crate) arguments: Vec<Operand>,
}

/// What follows a condition that holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Branch {
    Jump(Goal),
    Call(Call),
    /// An assignment, of mixed logic.
    Assign(Place, Expr),
    /// As [`Instruction::Pulse`].
    Pulse(Port, Index, Option<Operand>),
}

/// A label.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Goal {
    /// It is this instruction.
    At(u32),
    /// It is not there, which only who goes there finds out.
    Missing(i32),
    /// Its number is in a register.
    By(Index, Arc<Labels>),
}

/// The labels of a program.
pub(crate) type Labels = BTreeMap<i32, u32>;

/// What can be assigned.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Place {
    Number(Index),
    Text(Index),
    Position(Index),
    /// `P[1]`.
    Taught(Index),
    /// `PR[1,2]`.
    Component(Index, Index),
    Port(Port, Index),
    /// `UFRAME[1]` and `UTOOL[1]`.
    Frame(FrameKind, Index),
    /// `UFRAME_NUM` and `UTOOL_NUM`.
    FrameNumber(FrameKind),
    System(SysPath),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FrameKind {
    User,
    Tool,
}

impl FrameKind {
    /// The system variable with the frames, and that with the number of the one in use.
    pub(crate) fn variables(self) -> (&'static str, &'static str) {
        match self {
            FrameKind::User => ("$MNUFRAME", "$MNUFRAMENUM"),
            FrameKind::Tool => ("$MNUTOOL", "$MNUTOOLNUM"),
        }
    }
}

/// The number of a register or port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Index {
    Fixed(i32),
    /// The number is in this `R[]`.
    Register(i32),
    /// The number is this argument of the program, `AR[]`.
    Argument(i32),
    /// `...`: nobody has entered it.
    Unset,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Operand {
    /// `Constant` or `...`: nobody has entered it.
    Unset,
    /// `VR[1].OFFSET`.
    Absent(Absent),
    Integer(i32),
    Real(f32),
    Switch(bool),
    Literal(Arc<str>),
    Number(Index),
    Text(Index),
    Argument(Index),
    Position(Index),
    /// `P[1]`.
    Taught(Index),
    Component(Index, Index),
    Port(Port, Index),
    Frame(FrameKind, Index),
    FrameNumber(FrameKind),
    /// `TIMER[1]`: seconds.
    Timer(Index),
    /// Where the arm is: the tool in the user frame, or the joints.
    LinearPosition,
    JointPosition,
    System(SysPath),
    /// `ERR_NUM`: the number of the alarm that was raised since the condition is looked at, 0 if there was none.
    ErrorNumber,
    /// `STRLEN SR[1]`, `ABS[R[1]]`.
    Function(Function, Arc<[Operand]>),
}

/// What is calculated of values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Function {
    Length,
    Part,
    Find,
    Abs,
    Sqrt,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Atan2,
    Ln,
    Exp,
    Round,
    Trunc,
}

/// A value or a condition; its depth is bounded by the scanner.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Expr {
    Operand(Operand),
    /// What was written in parentheses.
    Group(Box<Expr>),
    Not(Box<Expr>),
    /// `DI[1]=ON+` and `DI[1]=OFF-`: the port went on, or off, while the condition was looked at.
    Edge {
        port: Port,
        index: Index,
        rising: bool,
    },
    Binary(Operator, Box<Expr>, Box<Expr>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Operator {
    Arithmetic(Arithmetic),
    Relation(Relation),
    And,
    Or,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Arithmetic {
    Add,
    Subtract,
    Multiply,
    Divide,
    Div,
    Mod,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    pub(crate) interpolation: Interpolation,
    /// Of a `C`: a position on the arc. Of an `A`: one on the rest of its circle.
    pub(crate) via: Option<MotionTarget>,
    pub(crate) target: MotionTarget,
    pub(crate) speed: Speed,
    /// `CNT`; `None` is FINE.
    pub(crate) rounding: Option<Operand>,
    /// `ACC`.
    pub(crate) acceleration: Option<Operand>,
    pub(crate) offset: Shift,
    pub(crate) tool_offset: Shift,
    /// `INC`: the target counts from where the motion starts.
    pub(crate) incremental: bool,
    pub(crate) wrist: Wrist,
    /// `Skip`: where to when the motion ends without its SKIP CONDITION.
    pub(crate) skip: Option<Goal>,
    /// `SkipJump`: where to when it ends with it.
    pub(crate) skip_jumps: bool,
    /// `Skip,LBL[1],PR[2]=LPOS`: the register that keeps where the arm was when the condition held.
    pub(crate) skip_keeps: Option<(Index, Operand)>,
    /// `TA`, `TB`, `DB`.
    pub(crate) beside: Option<Beside>,
}

/// What an option says of the wrist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Wrist {
    /// Nothing.
    AsTaught,
    /// `Wjnt`: it turns as in a joint motion.
    AsJoints,
    /// `MROT`: it turns as little as possible.
    LeastRotation,
}

/// What a motion does besides.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Beside {
    pub(crate) when: BesideWhen,
    /// A call, an assignment or a pulse.
    pub(crate) action: Branch,
}

/// Seconds and millimeters, neither below 0.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum BesideWhen {
    /// `TA .30sec`.
    After(Operand),
    /// `TB .70sec`.
    Before(Operand),
    /// `DB 10.0mm`.
    Near(Operand),
}

/// `Offset`, `Tool_Offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Shift {
    No,
    /// By the register of the OFFSET CONDITION.
    Condition,
    Register(Index),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum MotionTarget {
    Register(Index),
    Taught(Arc<Taught>),
    /// `P[R[1]]`.
    TaughtBy(Index, Arc<Positions>),
}

/// The `/POS` section by number.
pub(crate) type Positions = BTreeMap<i32, Arc<Taught>>;

/// A position of the `/POS` section; frame and tool as numbers, `None` for whatever is active.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Taught {
    pub(crate) number: i32,
    pub(crate) frame: Option<i32>,
    pub(crate) tool: Option<i32>,
    pub(crate) target: TpTarget,
}

/// How fast a motion is.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Speed {
    /// `max_speed`: as fast as the arm can.
    Greatest,
    Of(Operand, SpeedUnit),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SpeedUnit {
    Percent,
    MmPerSec,
    CmPerMin,
    InchPerMin,
    DegPerSec,
    Seconds,
    Milliseconds,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TimerAction {
    Start,
    Stop,
    Reset,
}
