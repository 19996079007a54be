//! The state of a task: plain data, so that it can wait anywhere.

use std::{collections::VecDeque, sync::Arc, time::Duration};

mod tp;

use super::cell::Cell;
use crate::{
    ast::TaskVerb,
    error::RuntimeError,
    host::{MotionId, TaskId},
    run::TaskState,
};

pub(crate) use tp::{Argument, BesideAction, BesideMotion, Moment, Monitor, Seen, TpState, Watch};

#[derive(Debug)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each says one thing, and all of them can be true at once"
)]
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
    /// Condition handlers, in the order of their definition.
    pub(crate) handlers: Vec<Handler>,
    /// What happened that a condition may ask for.
    pub(crate) signals: Signals,
    /// Conditions see the signals from here on.
    pub(crate) mark: u64,
    /// States of ports that the conditions of a WAIT FOR have seen.
    pub(crate) edges: Vec<Option<bool>>,
    /// A WAIT FOR waits for a signal.
    pub(crate) listens: bool,
    /// The newest alarm that became a signal.
    pub(crate) last_alarm: i32,
    /// Conditions are to be looked at before anything else.
    pub(crate) scan_now: bool,
    /// Actions that are to be run.
    pub(crate) triggered: VecDeque<Trigger>,
    /// Actions run.
    pub(crate) interrupted: bool,
    /// UNPAUSE: the actions call routines although the task is paused.
    pub(crate) unpaused: bool,
    pub(crate) ending: Ending,
    /// Of TP programs.
    pub(crate) tp: TpState,
    /// MOVE ALONG statements that are under way, innermost last.
    pub(crate) along: Vec<Along>,
}

impl Task {
    pub(crate) fn new(name: Arc<str>, program: usize, entry: usize, cells: usize) -> Task {
        Task {
            name,
            program,
            pc: entry,
            base: 0,
            routine: 0,
            callers: Vec::new(),
            frames: vec![Cell::Uninit; cells],
            operands: Vec::with_capacity(16),
            pending: Pending::None,
            state: TaskState::Ready,
            is_new: true,
            paused: false,
            handlers: Vec::new(),
            signals: Signals::default(),
            mark: 0,
            edges: Vec::new(),
            listens: false,
            last_alarm: 0,
            scan_now: false,
            triggered: VecDeque::new(),
            interrupted: false,
            unpaused: false,
            ending: Ending::No,
            tp: TpState::default(),
            along: Vec::new(),
        }
    }

    pub(crate) fn has_enabled_handlers(&self) -> bool {
        self.handlers.iter().any(|handler| handler.enabled)
    }

    /// Whether there is anything to look at between two statements.
    pub(crate) fn looks(&self) -> bool {
        let tp = &self.tp;
        !(self.handlers.is_empty() && tp.monitors.is_empty() && tp.beside.is_empty())
    }

    /// Whether its end is put off until its handlers have seen it.
    pub(crate) fn sees_its_end(&self) -> bool {
        self.has_enabled_handlers() && !self.interrupted && matches!(self.ending, Ending::No)
    }

    /// Notes what happened, if it may be asked for.
    pub(crate) fn signal(&mut self, signal: Signal) {
        if self.listens || !self.handlers.is_empty() {
            self.signals.push(signal);
        }
    }

    /// When conditions are looked at next.
    pub(crate) fn next_scan(&self) -> Option<Duration> {
        if self.interrupted {
            return None;
        }
        let enabled = self.handlers.iter().filter(|handler| handler.enabled);
        let monitors = self.tp.monitors.iter().map(|monitor| monitor.next);
        let beside = self.tp.beside.iter().map(|beside| beside.next);
        let looks = enabled.map(|handler| handler.next);
        looks.chain(monitors).chain(beside).min()
    }
}

/// Progress of a MOVE ALONG.
#[derive(Debug)]
pub(crate) struct Along {
    /// The node that the arm moves to, or that is next.
    pub(crate) node: i32,
    pub(crate) last: i32,
    /// The motion to that node, once it was started.
    pub(crate) motion: Option<MotionId>,
    /// It was reached.
    pub(crate) passed: bool,
    /// Its conditions were enabled.
    pub(crate) watched: bool,
    /// Nodes that were reached, and when; 0 is the start.
    pub(crate) reached: Vec<(i32, Duration)>,
}

/// Actions that interrupt a task.
#[derive(Clone, Debug)]
pub(crate) enum Trigger {
    /// Of a condition handler: a routine of a program, which is an index of the machine.
    Actions(usize, u32),
    /// A whole program, and what it is given.
    Call(usize, Vec<Argument>),
}

/// A condition handler that was defined.
#[derive(Debug)]
pub(crate) struct Handler {
    pub(crate) kind: HandlerKind,
    /// The program whose code it is, an index of the machine.
    pub(crate) program: usize,
    pub(crate) enabled: bool,
    pub(crate) whens: Vec<WhenState>,
    /// Time between two looks.
    pub(crate) period: Duration,
    pub(crate) next: Duration,
    /// It sees the signals from here on.
    pub(crate) mark: u64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum HandlerKind {
    /// `CONDITION[n]`.
    Global(i32),
    /// Of a MOVE, until its motion ends; without a number before it started.
    Local(Option<MotionId>),
}

#[derive(Debug)]
pub(crate) struct WhenState {
    /// Routines of the program.
    pub(crate) condition: u32,
    pub(crate) actions: u32,
    /// States of ports that its conditions have seen.
    pub(crate) edges: Vec<Option<bool>>,
    /// A local one fires once.
    pub(crate) fired: bool,
}

/// Why a task is about to end, while its handlers may still act.
#[derive(Debug, Default)]
pub(crate) enum Ending {
    #[default]
    No,
    /// Another task or the operator wants it; `NOABORT` takes it back.
    Requested,
    /// Its own ABORT.
    Own,
    /// A run-time error.
    Failed(Box<RuntimeError>),
}

/// Something that happened at a moment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Signal {
    Event(i32),
    Error(i32),
    Task(TaskVerb, TaskId),
    /// A node of a MOVE ALONG was reached.
    Node(i32),
}

/// Signals, numbered; the oldest are forgotten.
#[derive(Debug, Default)]
pub(crate) struct Signals {
    recent: VecDeque<(u64, Signal)>,
    next: u64,
}

impl Signals {
    const MOST: usize = 64;

    pub(crate) fn push(&mut self, signal: Signal) {
        if self.recent.len() >= Signals::MOST {
            let _oldest = self.recent.pop_front();
        }
        self.recent.push_back((self.next, signal));
        self.next += 1;
    }

    /// The number of the next one.
    pub(crate) fn now(&self) -> u64 {
        self.next
    }

    pub(crate) fn since(&self, mark: u64) -> impl Iterator<Item = Signal> + '_ {
        let recent = self.recent.iter();
        let newer = recent.filter(move |(number, _)| *number >= mark);
        newer.map(|(_, signal)| *signal)
    }
}

/// What a routine returns to.
#[derive(Debug)]
pub(crate) struct Caller {
    /// An index of the machine.
    pub(crate) program: usize,
    pub(crate) routine: u32,
    pub(crate) pc: usize,
    pub(crate) base: usize,
    /// What the task waited for when the actions of a condition handler interrupted it; it goes on
    /// with the same instruction.
    pub(crate) interrupted: Option<Box<Pending>>,
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
        /// A condition handler of the task cancels the file: the READ fails when it goes on.
        cancelled: bool,
    },
    /// A motion that was started.
    Motion(MotionId),
    /// A MOVE ALONG, the innermost of the task.
    Along,
    /// A motion that its SKIP CONDITION ended.
    Skipped(MotionId),
    /// When a built-in, or a WAIT of a TP program, gives up.
    Deadline(Duration),
    /// A PAUSE that paused.
    Paused,
    /// NOABORT: what waits without a limit for the world outside gives up.
    GivesUp,
}
