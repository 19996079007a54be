//! What a slice of execution ends with, and what can be seen of a task.

use std::{sync::Arc, time::Duration};

use crate::{
    error::{CallSite, RuntimeError},
    host::Wait,
    registers::RegisterCounts,
};

/// Bounds of a machine; every one of them ends in an error, never in a clamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Routine calls that may be open in one task; beyond it INTP-302.
    pub call_depth: usize,
    /// Cells of memory for the locals of one task; beyond it INTP-302.
    pub stack_cells: usize,
    /// Programs that may be loaded.
    pub programs: usize,
    /// Tasks that may exist, ended ones included.
    pub tasks: usize,
    /// Registers.
    pub registers: RegisterCounts,
}

impl Default for Limits {
    fn default() -> Limits {
        Limits {
            call_depth: 200,
            stack_cells: 1 << 18,
            programs: 64,
            tasks: 64,
            registers: RegisterCounts::default(),
        }
    }
}

/// The order of the bytes of a number in a binary file.
///
/// ASSUMPTION: controllers are big endian; the vendor's simulator on a PC is little endian.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ByteOrder {
    /// The highest byte first.
    #[default]
    Big,
    /// The lowest byte first.
    Little,
}

impl ByteOrder {
    /// The other one.
    #[must_use]
    pub fn reversed(self) -> ByteOrder {
        match self {
            ByteOrder::Big => ByteOrder::Little,
            ByteOrder::Little => ByteOrder::Big,
        }
    }
}

/// Why [`crate::Machine::run`] returned, and what it cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Slice {
    /// Why it returned.
    pub run: Run,
    /// Instructions that were executed, those of conditions included: at most the fuel given, or what the conditions cost and
    /// one more.
    pub used: u32,
    /// The task has condition handlers: run it again by this moment of the controller's clock,
    /// whatever it waits for.
    pub wake_by: Option<Duration>,
}

/// Why a task stopped executing.
#[derive(Clone, Debug, PartialEq)]
pub enum Run {
    /// The fuel is spent; run it again.
    OutOfFuel,
    /// The task waits; run it again when the wait may be over.
    Blocked(Wait),
    /// The program ended normally, or was aborted by its own ABORT statement or from outside.
    Ended,
    /// A run-time error ended the task; [`crate::Host::post_alarm`] was called with it.
    Aborted(RuntimeError),
}

/// The state of a task.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskState {
    /// It has instructions to execute.
    Ready,
    /// It waits.
    Blocked(Wait),
    /// It ended without an error.
    Ended,
    /// It ended with an error.
    Aborted(RuntimeError),
}

/// What can be seen of a task from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct TaskView {
    /// Name of the task: its root program, upper case.
    pub name: Arc<str>,
    /// Program of the routine that is executed, upper case.
    pub program: Arc<str>,
    /// Physical source line of the current statement, from 1; 0 before the first.
    pub line: u32,
    /// Its state.
    pub state: TaskState,
    /// The call stack, innermost first.
    pub calls: Vec<CallSite>,
}
