//! Tasks line by line: the trace of executed lines, and single steps.

use std::collections::VecDeque;
use std::sync::Arc;

use karel::{Run, Slice, TaskId, Wait};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Controller;
use crate::ledger::seconds;

/// Lines that the trace keeps; older ones are dropped and counted.
pub const TRACE_LINES: usize = 10_000;

/// A line of a source.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Place {
    program: Arc<str>,
    routine: Arc<str>,
    line: u32,
}

/// One executed line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct TraceEntry {
    /// Counts from 1, also over lines that are not kept any more.
    pub seq: u64,
    /// Controller time.
    pub time_s: f64,
    /// The task.
    pub task: String,
    /// The program that has the line.
    pub program: String,
    /// The routine.
    pub routine: String,
    /// The line of the source.
    pub line: u32,
}

/// Why the trace is not as it was asked for.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("there is no program {name} whose task could be traced; there are: {known}")]
pub struct TraceError {
    /// What was given.
    name: String,
    /// All programs.
    known: String,
}

/// The lines that were executed last.
#[derive(Debug, Default)]
pub(super) struct Trace {
    wanted: Wanted,
    lines: VecDeque<TraceEntry>,
    last: u64,
}

#[derive(Debug, Default, PartialEq)]
enum Wanted {
    #[default]
    Nothing,
    Everything,
    Task(String),
}

impl Trace {
    /// Whether any task is traced: it runs slower then, and nothing else is different.
    pub(super) fn follows(&self) -> bool {
        self.wanted != Wanted::Nothing
    }

    fn push(&mut self, time_s: f64, task: &str, place: &Place) {
        let wanted = match &self.wanted {
            Wanted::Nothing => false,
            Wanted::Everything => true,
            Wanted::Task(name) => name.eq_ignore_ascii_case(task),
        };
        if !wanted {
            return;
        }
        if self.lines.len() >= TRACE_LINES {
            let _oldest = self.lines.pop_front();
        }
        self.last += 1;
        self.lines.push_back(TraceEntry {
            seq: self.last,
            time_s,
            task: task.to_owned(),
            program: place.program.to_string(),
            routine: place.routine.to_string(),
            line: place.line,
        });
    }
}

impl Controller {
    /// Traces the lines of every task, of one, or of none. What was traced before stays.
    ///
    /// # Errors
    /// There is no such program.
    pub fn set_trace(&mut self, on: bool, task: Option<&str>) -> Result<(), TraceError> {
        let wanted = match task {
            _ if !on => Wanted::Nothing,
            None => Wanted::Everything,
            Some(name) => {
                let mut loaded = self.loaded.iter();
                if !loaded.any(|program| program.name.eq_ignore_ascii_case(name)) {
                    let known: Vec<&str> = self.loaded.iter().map(|p| p.name.as_str()).collect();
                    return Err(TraceError {
                        name: super::programs::shown(name),
                        known: known.join(", "),
                    });
                }
                Wanted::Task(name.to_owned())
            }
        };
        self.trace.wanted = wanted;
        for task in &mut self.tasks {
            task.traced = None;
        }
        Ok(())
    }

    /// Traces the lines of every task.
    pub(super) fn trace_everything(&mut self) {
        self.trace.wanted = Wanted::Everything;
    }

    /// Whether lines are traced.
    #[must_use]
    pub fn is_traced(&self) -> bool {
        self.trace.follows()
    }

    /// The lines above the number `after`, oldest first, at most `limit`; and how many are not kept any more.
    #[must_use]
    pub fn trace(&self, after: u64, limit: usize) -> (Vec<TraceEntry>, u64) {
        let Trace { lines, last, .. } = &self.trace;
        let kept = u64::try_from(lines.len()).unwrap_or(u64::MAX);
        let dropped = last.saturating_sub(kept);
        let skip = usize::try_from(after.saturating_sub(dropped)).unwrap_or(usize::MAX);
        let entries = lines.iter().skip(skip).take(limit).cloned();
        (entries.collect(), dropped)
    }

    /// The STEP key.
    pub(super) fn set_single_step(&mut self, on: bool) {
        self.single_step = on;
        let ids: Vec<TaskId> = self.tasks.iter().map(|task| task.id).collect();
        for id in ids {
            if on {
                self.step_one_line(id);
            } else if let Some(task) = self.tasks.iter_mut().find(|task| task.id == id) {
                task.step_from = None;
            }
        }
    }

    /// The task pauses as soon as it is at another line.
    pub(super) fn step_one_line(&mut self, id: TaskId) {
        let place = self.place(id);
        if let Some(task) = self.tasks.iter_mut().find(|task| task.id == id) {
            task.step_from = place;
        }
    }

    /// Executes a task instruction by instruction, and looks at its line before each.
    pub(super) fn run_by_lines(&mut self, index: usize, id: TaskId, share: u32) -> Slice {
        let mut used = 0;
        let mut wake_by = None;
        while used < share {
            let place = self.place(id);
            let time_s = seconds(self.hardware.now);
            if let (Some(place), Some(task)) = (place, self.tasks.get_mut(index)) {
                if task.step_from.as_ref().is_some_and(|from| *from != place) {
                    task.step_from = None;
                    let _was_running = self.machine.pause(id);
                    let run = Run::Blocked(Wait::Continue);
                    return Slice { run, used, wake_by };
                }
                if task.traced.as_ref() != Some(&place) {
                    if let Some(view) = self.machine.task(id) {
                        self.trace.push(time_s, &view.name, &place);
                    }
                    task.traced = Some(place);
                }
            }
            let slice = self.machine.run(id, 1, &mut self.hardware);
            used = used.saturating_add(slice.used);
            wake_by = slice.wake_by;
            if slice.run != Run::OutOfFuel || self.hardware.missing_call.is_some() {
                let run = slice.run;
                return Slice { run, used, wake_by };
            }
        }
        let run = Run::OutOfFuel;
        Slice { run, used, wake_by }
    }

    fn place(&self, id: TaskId) -> Option<Place> {
        let view = self.machine.task(id)?;
        let innermost = view.calls.into_iter().next()?;
        Some(Place {
            program: innermost.program,
            routine: innermost.routine,
            line: innermost.line,
        })
    }
}
