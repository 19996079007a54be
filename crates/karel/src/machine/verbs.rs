//! Statements that act on tasks, motion, hands and ports, most of them actions of condition handlers.

use std::time::Duration;

use super::{
    exec::{Exec, Flow},
    fault::Fault,
    pulse::Pulses,
    task::{Ending, Pending, Signal},
};
use crate::{
    ast::{Action, HandVerb, MotionVerb, Signaled, TaskVerb, Waits},
    host::{HandAction, TaskId, Wait},
    port::{Port, PortValue},
    status::Status,
};

impl Exec<'_> {
    pub(super) fn action(&mut self, action: Action) -> Flow {
        match action {
            Action::NoAbort => {
                if matches!(self.task.ending, Ending::Requested) {
                    self.task.ending = Ending::No;
                    self.give_up_waiting();
                }
            }
            Action::NoPause => self.task.paused = false,
            Action::Unpause => self.task.unpaused = true,
            // ASSUMPTION: messages and what was stopped are the operator's; both change nothing.
            Action::NoMessage | Action::Restore => {}
        }
        Flow::Next
    }

    /// The task goes on, and must not wait for ever for a client that may never come.
    fn give_up_waiting(&mut self) {
        let mut callers = self.task.callers.iter_mut().rev();
        if let Some(pending) = callers.find_map(|caller| caller.interrupted.as_deref_mut())
            && matches!(pending, Pending::None)
        {
            *pending = Pending::GivesUp;
        }
    }

    pub(super) fn action_gate(&mut self) -> Flow {
        if self.task.paused && !self.task.unpaused {
            return Flow::Blocked(Wait::Continue);
        }
        Flow::Next
    }

    pub(super) fn signal(&mut self, what: Signaled) -> Result<Flow, Fault> {
        let number = self.pop_integer();
        match what {
            Signaled::Event => {
                let signal = Signal::Event(number);
                self.others.broadcast(signal);
                self.task.signal(signal);
                self.task.scan_now = !self.task.handlers.is_empty();
            }
            Signaled::Semaphore => {
                let Some(count) = self.semaphores.count(number) else {
                    return Err(Fault::argument(format!("There is no semaphore {number}")));
                };
                *count = count.saturating_add(1);
            }
        }
        self.task.pc += 1;
        Ok(Flow::Yield)
    }

    /// A task's number, or 0 for the own one. A task that is not there is left alone.
    pub(super) fn task_verb(&mut self, verb: TaskVerb) -> Flow {
        let number = self.operand(0).expect_integer();
        let other = TaskId(u32::try_from(number).unwrap_or(u32::MAX));
        if number != 0 && other != self.id {
            self.drop_operands(1);
            match verb {
                TaskVerb::Abort => {
                    let _was_alive = self.others.request_end(other, self.host);
                }
                TaskVerb::Pause => {
                    let _changed = self.others.pause(other);
                }
                TaskVerb::Continue => {
                    if self.others.resume(other) {
                        self.host.continue_motions(other);
                    }
                }
            }
            self.hear_own_deeds();
            return Flow::Next;
        }
        match verb {
            TaskVerb::Abort => self.end_task(),
            TaskVerb::Continue => {
                self.drop_operands(1);
                self.task.paused = false;
                Flow::Next
            }
            TaskVerb::Pause if matches!(self.task.pending, Pending::Paused) => {
                self.task.pending = Pending::None;
                self.drop_operands(1);
                Flow::Next
            }
            // ASSUMPTION: what moves goes on.
            TaskVerb::Pause => {
                self.task.pending = Pending::Paused;
                self.task.paused = true;
                let signal = Signal::Task(TaskVerb::Pause, self.id);
                self.others.broadcast(signal);
                self.task.signal(signal);
                self.task.scan_now = !self.task.handlers.is_empty();
                Flow::Yield
            }
        }
    }

    /// ASSUMPTION: STOP and HOLD both hold what moves, RESUME and UNHOLD let it go on; there is one
    /// group and nobody else wants it, so ATTACH and RELEASE change nothing.
    pub(super) fn motion_verb(&mut self, verb: MotionVerb) -> Flow {
        match verb {
            MotionVerb::Cancel => self.host.cancel_arm(self.id),
            MotionVerb::Stop | MotionVerb::Hold => self.host.hold_arm(self.id),
            MotionVerb::Resume | MotionVerb::Unhold => self.host.resume_arm(self.id),
            MotionVerb::Attach | MotionVerb::Release => {}
        }
        Flow::Next
    }

    pub(super) fn hand(&mut self, verb: HandVerb) -> Result<Flow, Fault> {
        let number = self.pop_integer();
        let action = match verb {
            HandVerb::Open => HandAction::Open,
            HandVerb::Close => HandAction::Close,
            HandVerb::Relax => HandAction::Relax,
        };
        let done = self.host.hand(self.id, action, number);
        done.map_err(|status| Fault::new(status, format!("{} HAND {number} failed", verb.text())))?;
        Ok(Flow::Next)
    }

    /// ASSUMPTION: the port is inverted for that time, so a port that is on gives a pulse of OFF.
    pub(super) fn pulse(&mut self, port: Port, waits: Waits) -> Result<Flow, Fault> {
        if let Some(flow) = self.pause_is_over() {
            return Ok(flow);
        }
        let (milliseconds, number) = (self.pop_integer(), self.pop_integer());
        let Ok(milliseconds) = u64::try_from(milliseconds) else {
            let message = format!("PULSE of {milliseconds} ms, less than 0");
            return Err(Fault::argument(message));
        };
        let illegal = |status| super::ports::illegal(status, port, number);
        let before = self.host.port(port, number).map_err(illegal)?;
        let on = matches!(before, PortValue::Switch(true));
        let turned = PortValue::Switch(!on);
        self.host
            .set_port(self.id, port, number, turned)
            .map_err(illegal)?;
        let now = self.host.now();
        let until = now.saturating_add(Duration::from_millis(milliseconds));
        if !self.pulses.add(self.id, (port, number), before, until) {
            let message = format!("More than {} pulses at a time", Pulses::MOST);
            return Err(Fault::new(Status::INTP_LIMIT, message));
        }
        if waits == Waits::No {
            return Ok(Flow::Next);
        }
        self.task.pending = Pending::Until(until);
        Ok(Flow::Blocked(Wait::Until(until)))
    }
}
