//! What TP programs leave in their task.

use std::{sync::Arc, time::Duration};

use crate::{
    host::MotionId,
    port::Port,
    registers::Number,
    tp::{Branch, Expr},
};

/// What TP programs leave in their task.
#[derive(Debug, Default)]
pub(crate) struct TpState {
    /// Arguments of programs that were called, and how many callers there were then.
    pub(crate) arguments: Vec<(usize, Vec<Argument>)>,
    pub(crate) skip: Option<Expr>,
    /// The registers of `OFFSET CONDITION` and `TOOL_OFFSET CONDITION`.
    pub(crate) offset: Option<i32>,
    pub(crate) tool_offset: Option<i32>,
    /// A motion whose corner may be rounded, so the program went on before its end.
    pub(crate) rounding: Option<MotionId>,
    /// What MONITOR looks at.
    pub(crate) monitors: Vec<Monitor>,
    /// What motions do besides, and have not done.
    pub(crate) beside: Vec<BesideMotion>,
    /// Whose condition is looked at.
    pub(crate) watch: Watch,
    /// Ports as conditions with edges saw them last.
    pub(crate) seen: Vec<Seen>,
    /// The newest alarm when a condition was looked at first.
    pub(crate) alarms: Vec<(Watch, i32)>,
}

/// Who looks at a condition again and again.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Watch {
    /// A WAIT, or a line that looks once.
    #[default]
    Line,
    /// The SKIP CONDITION.
    Skip,
    /// The MONITOR of this program, an index of the machine.
    Monitor(usize),
}

/// A port as a condition saw it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) watch: Watch,
    pub(crate) port: Port,
    pub(crate) number: i32,
    pub(crate) on: bool,
}

/// `TA`, `TB` and `DB` of a motion that was started.
#[derive(Clone, Debug)]
pub(crate) struct BesideMotion {
    pub(crate) motion: MotionId,
    pub(crate) moment: Moment,
    pub(crate) action: BesideAction,
    /// When it is looked at.
    pub(crate) next: Duration,
}

/// What a motion does besides.
#[derive(Clone, Debug)]
pub(crate) enum BesideAction {
    /// A program, and what it is given.
    Call(Arc<str>, Vec<Argument>),
    /// An assignment or a pulse.
    Do(Branch),
}

/// When something is done besides a motion.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Moment {
    /// So long after the motion, at this time once it has ended.
    After(Duration, Option<Duration>),
    /// So long before it ends.
    Before(Duration),
    /// So many millimeters from this place, in the user frame.
    Near(f32, [f32; 3]),
}

/// A program of conditions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Monitor {
    /// An index of the machine.
    pub(crate) program: usize,
    /// When it is looked at.
    pub(crate) next: Duration,
}

/// An argument of a CALL.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Argument {
    Number(Number),
    Text(String),
}
