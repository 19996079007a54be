//! The state of a task: plain data, so that it can wait anywhere.

use std::{sync::Arc, time::Duration};

use super::cell::Cell;
use crate::{host::MotionId, run::TaskState};

#[derive(Debug)]
pub(crate) struct Task {
    pub(crate) name: Arc<str>,
    /// Program of the code that runs, an index of the machine.
    pub(crate) program: usize,
    /// Next instruction, or the one that waits.
    pub(crate) pc: usize,
    /// Where the frame of the running routine starts.
    pub(crate) base: usize,
    /// Routine that runs.
    pub(crate) routine: u32,
    /// Callers, outermost first.
    pub(crate) callers: Vec<Caller>,
    pub(crate) frames: Vec<Cell>,
    pub(crate) operands: Vec<Cell>,
    pub(crate) pending: Pending,
    pub(crate) state: TaskState,
    /// It has not executed anything.
    pub(crate) is_new: bool,
    /// It executes nothing until it is continued.
    pub(crate) paused: bool,
}

/// What a routine returns to.
#[derive(Debug)]
pub(crate) struct Caller {
    /// An index of the machine.
    pub(crate) program: usize,
    pub(crate) routine: u32,
    pub(crate) pc: usize,
    pub(crate) base: usize,
}

/// Progress of the instruction that waits.
#[derive(Debug, Default)]
pub(crate) enum Pending {
    #[default]
    None,
    /// A DELAY, or a pause that a built-in takes before it goes on.
    Until(Duration),
    /// Items of a READ that are done.
    Read {
        item: usize,
        operand: usize,
        /// When the READ gives up.
        until: Option<Duration>,
    },
    /// A motion that was started.
    Motion(MotionId),
    /// When a built-in, or a WAIT of a TP program, gives up.
    Deadline(Duration),
}
