//! TP programs, the pendant's own language, as their `.ls` listings.
//!
//! The part that programs of the field and KAREL servers need to move the arm: motion to position
//! registers and taught positions, registers, flags, digital I/O, jumps, calls, waits. Each line
//! becomes one [`Instruction`] of the same machine that runs KAREL. What is TP and not run yet is
//! an error that says so.

mod instruction;
mod listing;
mod motion;
mod position;
mod scan;

use std::sync::Arc;

use crate::{
    ast::Relation,
    host::{Interpolation, TpTarget},
    port::Port,
};

pub(crate) use listing::parse;

/// What a line of a TP program does.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Instruction {
    /// A remark, a label, or nothing.
    Nothing,
    /// To an instruction of the same program.
    Jump(u32),
    Assign {
        target: Place,
        value: Expr,
    },
    If {
        condition: Condition,
        then: Branch,
    },
    WaitSeconds(Operand),
    WaitFor(Condition),
    Call(Arc<str>),
    Run(Arc<str>),
    Move(Motion),
    End,
    Abort,
}

/// What follows a condition that holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Branch {
    Jump(u32),
    Call(Arc<str>),
}

/// What can be assigned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Place {
    Number(Index),
    Position(Index),
    Port(Port, Index),
    UserFrame,
    Tool,
}

/// The number of a register or port.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Index {
    Fixed(i32),
    /// The number is in this `R[]`.
    Register(i32),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operand {
    Integer(i32),
    Real(f32),
    Switch(bool),
    Number(Index),
    Position(Index),
    Port(Port, Index),
}

/// One operand, or several with one kind of operator between them, from left to right.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Expr {
    pub(crate) negated: bool,
    pub(crate) first: Operand,
    pub(crate) rest: Vec<(Arithmetic, Operand)>,
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

/// Tests that all hold, or of which one holds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Condition {
    pub(crate) all: bool,
    pub(crate) tests: Vec<Test>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Test {
    pub(crate) negated: bool,
    pub(crate) left: Operand,
    /// Without it, the operand itself is on or off.
    pub(crate) right: Option<(Relation, Operand)>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Motion {
    pub(crate) interpolation: Interpolation,
    pub(crate) target: MotionTarget,
    pub(crate) speed: Operand,
    pub(crate) unit: SpeedUnit,
    /// `ACC`.
    pub(crate) acceleration: Option<Operand>,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum MotionTarget {
    Register(Index),
    Taught(Arc<Taught>),
}

/// A position of the `/POS` section; frame and tool as numbers, `None` for whatever is active.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Taught {
    pub(crate) number: i32,
    pub(crate) frame: Option<i32>,
    pub(crate) tool: Option<i32>,
    pub(crate) target: TpTarget,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SpeedUnit {
    Percent,
    MmPerSec,
    CmPerMin,
}
