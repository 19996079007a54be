//! Condition handlers: looking at conditions between slices, and running actions as interruptions.
//!
//! Time passes only between slices, so looking at the start of each is exact. What conditions ask
//! for and what only lasts a moment (events, errors, aborts) is kept as numbered signals.

use std::time::Duration;

use super::{
    cell::Cell,
    exec::{Exec, Flow, Stop, row_of},
    fault::Fault,
    runtime_error,
    task::{Caller, Ending, Handler, HandlerKind, Pending, Signal, Trigger},
};
use crate::{
    ast::TaskVerb,
    host::{Progress, Wait},
    ir::{Op, Outward},
    status::Status,
};

/// Instructions of one condition, which has no loops.
const MAX_STEPS: u32 = 100_000;

/// Alarms that one look turns into signals; older ones are missed.
const MAX_ALARMS: i32 = 32;

impl Exec<'_> {
    /// Executes at most `fuel` instructions, with condition handlers. What was used is more than `fuel` if the conditions
    /// cost more.
    pub(super) fn slice(&mut self, fuel: u32) -> (Stop, u32) {
        if fuel == 0 {
            return (Stop::OutOfFuel, 0);
        }
        let mut used = 0_u32;
        loop {
            let looked = if self.task.looks() {
                self.look()
            } else {
                Ok(())
            };
            used = used.saturating_add(std::mem::take(&mut self.looked));
            if let Err(fault) = looked {
                if let Some(stop) = self.fail(fault) {
                    return (stop, used);
                }
                // The task stays inside of the condition that failed: only handlers that see its end go on.
                if used >= fuel {
                    return (Stop::OutOfFuel, used);
                }
                continue;
            }
            if !self.task.interrupted {
                if let Some(stop) = self.end_if_it_must() {
                    return (stop, used);
                }
                if self.task.paused {
                    return (Stop::Blocked(Wait::Continue), used);
                }
            }
            // Conditions cost what they cost, even more than there is: time must not depend on how a share is cut.
            // The task itself always gets on.
            let (stop, more) = self.run(fuel.saturating_sub(used).max(1));
            used = used.saturating_add(more);
            match stop {
                Stop::Failed(fault) => {
                    if let Some(stop) = self.fail(fault) {
                        return (stop, used);
                    }
                }
                Stop::Yield => {}
                Stop::OutOfFuel | Stop::Blocked(_) | Stop::Ended | Stop::Aborted(_) => {
                    return (stop, used);
                }
            }
            if used >= fuel {
                return (Stop::OutOfFuel, used);
            }
        }
    }

    /// The end that was put off until the handlers have seen it.
    fn end_if_it_must(&mut self) -> Option<Stop> {
        if self.task.scan_now || !self.task.triggered.is_empty() {
            return None;
        }
        match std::mem::take(&mut self.task.ending) {
            Ending::No => None,
            Ending::Requested | Ending::Own => {
                self.close_locals(0);
                Some(Stop::Ended)
            }
            Ending::Failed(error) => Some(Stop::Aborted(*error)),
        }
    }

    /// Posts an error. The task ends, at once or when its handlers have seen that.
    ///
    /// ASSUMPTION: a run-time error cannot be taken back by NOABORT: the statement is not done.
    fn fail(&mut self, fault: Fault) -> Option<Stop> {
        let error = runtime_error(fault, self.task, self.programs);
        self.host.post_alarm(self.id, &error);
        // Of a motion that is over by now, they do not see it any more.
        self.drop_local_ones();
        if self.task.sees_its_end() {
            self.task.ending = Ending::Failed(Box::new(error));
            self.task.scan_now = true;
            self.task.signal(Signal::Task(TaskVerb::Abort, self.id));
            return None;
        }
        if let Ending::Failed(first) = std::mem::take(&mut self.task.ending) {
            return Some(Stop::Aborted(*first));
        }
        Some(Stop::Aborted(error))
    }

    /// Looks at the conditions that are due, and begins the actions of one that holds.
    ///
    /// ASSUMPTION: while actions run no conditions are looked at.
    fn look(&mut self) -> Result<(), Fault> {
        if self.task.interrupted {
            return Ok(());
        }
        let now = self.host.now();
        let everything = std::mem::take(&mut self.task.scan_now);
        self.drop_local_ones();
        if self.task.triggered.is_empty() {
            let due = |handler: &Handler| handler.enabled && (everything || handler.next <= now);
            if self.task.handlers.iter().any(due) {
                self.hear_alarms();
            }
            for index in 0..self.task.handlers.len() {
                if self.task.handlers.get(index).is_some_and(due) {
                    self.look_at(index, now)?;
                }
            }
        }
        if self.task.triggered.is_empty() {
            self.look_at_monitors(now)?;
        }
        if self.task.triggered.is_empty() && !self.task.paused {
            self.look_beside(now)?;
        }
        match self.task.triggered.pop_front() {
            Some(trigger) => self.interrupt(trigger),
            None => Ok(()),
        }
    }

    /// Local conditions end with their motion; a MOVE that waits for it ends them itself.
    fn drop_local_ones(&mut self) {
        let host = &mut *self.host;
        let awaited = match self.task.pending {
            Pending::Motion(motion) => Some(motion),
            Pending::Along => self.task.along.last().and_then(|along| along.motion),
            Pending::None
            | Pending::Until(_)
            | Pending::Read { .. }
            | Pending::Skipped(_)
            | Pending::Deadline(_)
            | Pending::Paused
            | Pending::GivesUp => None,
        };
        self.task.handlers.retain(|handler| match handler.kind {
            HandlerKind::Local(Some(motion)) if Some(motion) != awaited => {
                matches!(host.motion_ended(motion), Progress::Pending(_))
            }
            HandlerKind::Global(_) | HandlerKind::Local(_) => true,
        });
    }

    /// ASSUMPTION: a handler of which one WHEN holds is disabled as a whole; of a MOVE, each WHEN
    /// acts once.
    fn look_at(&mut self, index: usize, now: Duration) -> Result<(), Fault> {
        let Some(handler) = self.task.handlers.get_mut(index) else {
            return Ok(());
        };
        handler.next = now.saturating_add(handler.period);
        let (program, mark, kind) = (handler.program, handler.mark, handler.kind);
        let mut whens = std::mem::take(&mut handler.whens);
        let before = std::mem::replace(&mut self.task.mark, mark);
        let mut result = Ok(());
        let mut fires = false;
        for when in whens.iter_mut().filter(|when| !when.fired) {
            std::mem::swap(&mut self.task.edges, &mut when.edges);
            let holds = self.holds(program, when.condition);
            std::mem::swap(&mut self.task.edges, &mut when.edges);
            match holds {
                Ok(true) => {
                    fires = true;
                    when.fired = matches!(kind, HandlerKind::Local(_));
                    let actions = Trigger::Actions(program, when.actions);
                    self.task.triggered.push_back(actions);
                }
                Ok(false) => {}
                Err(fault) => {
                    result = Err(fault);
                    break;
                }
            }
        }
        self.task.mark = before;
        let seen = self.task.signals.now();
        if let Some(handler) = self.task.handlers.get_mut(index) {
            handler.whens = whens;
            handler.mark = seen;
            if result.is_err() || (fires && matches!(kind, HandlerKind::Global(_))) {
                handler.enabled = false;
            }
        }
        result
    }

    /// Executes the code of a condition beside what the task does. After an error the task stays
    /// there, so that the error has the place of the condition.
    fn holds(&mut self, program: usize, routine: u32) -> Result<bool, Fault> {
        let here = (
            self.task.program,
            self.task.routine,
            self.task.pc,
            self.task.base,
        );
        let operands = self.task.operands.len();
        let frames = self.task.frames.len();
        let pending = std::mem::take(&mut self.task.pending);
        self.switch_program(program);
        let code = row_of(&self.program.code.routines, routine);
        let cells = frames + code.frame_cells as usize;
        if cells > self.limits.stack_cells {
            return Err(Fault::new(Status::INTP_STACK_OVERFLOW, "Stack overflow"));
        }
        self.task.routine = routine;
        self.task.pc = code.entry as usize;
        self.task.frames.resize(cells, Cell::Uninit);
        self.task.base = frames;
        let result = self.condition_value()?;
        self.task.operands.truncate(operands);
        self.task.frames.truncate(frames);
        self.task.pending = pending;
        let (program, routine, pc, base) = here;
        self.switch_program(program);
        self.task.routine = routine;
        self.task.pc = pc;
        self.task.base = base;
        Ok(result)
    }

    fn condition_value(&mut self) -> Result<bool, Fault> {
        for _ in 0..MAX_STEPS {
            self.looked = self.looked.saturating_add(1);
            let op = *row_of(&self.program.code.ops, pc_row(self.task.pc));
            if op == Op::Outward(Outward::ConditionEnd) {
                return Ok(self.pop_boolean());
            }
            match self.single(op)? {
                Flow::Next => self.task.pc += 1,
                Flow::Jumped => {}
                // What has to wait does not hold now.
                Flow::Blocked(_) | Flow::Yield | Flow::Ended => return Ok(false),
            }
        }
        Ok(false)
    }

    /// Begins actions; the task goes on with the same instruction when they end.
    fn interrupt(&mut self, trigger: Trigger) -> Result<(), Fault> {
        let (program, routine, arguments) = match trigger {
            Trigger::Actions(program, routine) => (program, routine, None),
            Trigger::Call(program, arguments) => (program, 0, Some(arguments)),
        };
        let loaded = self.programs.get(program);
        let loaded = loaded.expect("programs are never unloaded");
        let code = row_of(&loaded.program.code.routines, routine);
        let base = self.task.frames.len();
        let cells = base + code.frame_cells as usize;
        if self.task.callers.len() >= self.limits.call_depth || cells > self.limits.stack_cells {
            return Err(Fault::new(Status::INTP_STACK_OVERFLOW, "Stack overflow"));
        }
        self.task.callers.push(Caller {
            program: self.task.program,
            routine: self.task.routine,
            pc: self.task.pc,
            base: self.task.base,
            interrupted: Some(Box::new(std::mem::take(&mut self.task.pending))),
        });
        self.task.frames.resize(cells, Cell::Uninit);
        self.task.base = base;
        self.task.routine = routine;
        self.task.pc = code.entry as usize;
        self.task.interrupted = true;
        self.switch_program(program);
        if let Some(arguments) = arguments {
            let depth = self.task.callers.len();
            self.task.tp.arguments.push((depth, arguments));
        }
        Ok(())
    }

    /// Alarms that are new since the last look become signals.
    pub(super) fn hear_alarms(&mut self) {
        if !self.task.listens && self.task.handlers.is_empty() {
            return;
        }
        let Some(newest) = self.host.alarm(i32::MAX).map(|alarm| alarm.seq) else {
            return;
        };
        let first = self.task.last_alarm.saturating_add(1);
        for seq in first.max(newest.saturating_sub(MAX_ALARMS - 1))..=newest {
            if let Some(alarm) = self.host.alarm(seq)
                && alarm.seq == seq
            {
                self.task.signal(Signal::Error(alarm.code));
            }
        }
        self.task.last_alarm = newest.max(self.task.last_alarm);
    }

    pub(super) fn forget_alarms(&mut self) {
        let newest = self.host.alarm(i32::MAX).map_or(0, |alarm| alarm.seq);
        self.task.last_alarm = newest.max(self.task.last_alarm);
    }
}

fn pc_row(pc: usize) -> u32 {
    u32::try_from(pc).unwrap_or(u32::MAX)
}
