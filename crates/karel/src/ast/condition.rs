//! Condition handlers: what they look at, and what only they do.

use super::{Expr, Path, Stmt, TaskVerb};
use crate::span::Span;

/// Conditions of a WHEN, an UNTIL or a WAIT FOR.
#[derive(Debug)]
pub(crate) struct Conditions {
    pub(crate) terms: Vec<Condition>,
    /// Joined by `AND` or commas; else by `OR`.
    pub(crate) all: bool,
}

#[derive(Debug)]
pub(crate) enum Condition {
    /// A state.
    Expr(Expr),
    /// `ABORT`, `PAUSE PROGRAM[n]`.
    Task {
        verb: TaskVerb,
        task: Option<Expr>,
    },
    /// `ERROR[n]`; `ERROR[*]` is any.
    Error(Option<Expr>),
    /// `EVENT[n]`, `SEMAPHORE[n]`.
    Signaled {
        what: Signaled,
        number: Expr,
    },
    PowerUp,
    /// `DIN[n]+`, `DIN[n]-`.
    Edge {
        port: Path,
        edge: Edge,
    },
    /// `AT NODE[n]`; `AT NODE[*]` is any.
    AtNode {
        node: Option<Expr>,
        at: Span,
    },
    /// `TIME t BEFORE NODE[n]`, `TIME t AFTER NODE[n]`, in milliseconds.
    NodeTime {
        time: Expr,
        side: NodeSide,
        node: Expr,
        at: Span,
    },
}

/// Conditions and what is done when they hold.
#[derive(Debug)]
pub(crate) struct When {
    pub(crate) conditions: Conditions,
    pub(crate) actions: Vec<Stmt>,
    pub(crate) span: Span,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Edge {
    Rising,
    Falling,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NodeSide {
    Before,
    After,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signaled {
    Event,
    Semaphore,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ConditionVerb {
    Enable,
    Disable,
    Purge,
}

/// What stands only among the actions of a condition handler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Action {
    NoAbort,
    NoPause,
    Unpause,
    NoMessage,
    Restore,
}
