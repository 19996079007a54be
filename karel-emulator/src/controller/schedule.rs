//! Tasks in turn: a slice for each that can run, and who can.

use std::time::Duration;

use karel::{Run, TaskId, Wait};

use super::Controller;
use super::steps::Place;

/// The period in which a task may spend its instructions.
const SHARE_PERIOD: Duration = Duration::from_millis(1);

#[derive(Debug)]
pub(super) struct Task {
    pub(super) id: TaskId,
    pub(super) phase: Phase,
    /// Instructions left in the present period.
    pub(super) share: u32,
    /// When the present period began.
    pub(super) period: Duration,
    /// When its condition handlers look again, whatever it waits for.
    pub(super) look: Option<Duration>,
    /// Pauses as soon as it is at another line than this one.
    pub(super) step_from: Option<Place>,
    /// The last line that was traced.
    pub(super) traced: Option<Place>,
}

#[derive(Debug)]
pub(super) enum Phase {
    Ready,
    Waiting(Wait),
    /// The share is spent.
    Resting,
    Over,
}

impl Controller {
    /// When something is due without any event from outside. In the past or now: at once.
    #[must_use]
    pub fn next_wake(&self) -> Option<Duration> {
        let frozen = self.faults.frozen;
        let tasks = self.tasks.iter().filter(|_| !frozen);
        let tasks = tasks.filter_map(|task| match &task.phase {
            Phase::Ready => Some(self.hardware.now),
            Phase::Waiting(Wait::Until(time) | Wait::ReadableUntil(_, time)) => Some(*time),
            Phase::Waiting(_) | Phase::Over => None,
            Phase::Resting => Some(task.period.saturating_add(SHARE_PERIOD)),
        });
        // Who rests looks when it goes on: counted here, a look in the past would keep time from passing.
        let waiting = self
            .tasks
            .iter()
            .filter(|task| matches!(task.phase, Phase::Waiting(_)));
        let looks = waiting.filter_map(|task| task.look);
        tasks
            .chain(looks)
            .chain(self.machine.next_due())
            .chain(self.hardware.executor.next_due())
            .chain(self.hardware.gripper_arrives())
            .chain(self.wire.next_due())
            .chain(self.faults.next_end())
            .chain(self.off_until)
            .min()
    }

    /// One slice for each task that can run. Whether there was any.
    pub(super) fn run_ready_tasks(&mut self) -> bool {
        if self.faults.frozen {
            return false;
        }
        let now = self.hardware.now;
        for task in &mut self.tasks {
            let due = match &task.phase {
                Phase::Waiting(Wait::Until(time) | Wait::ReadableUntil(_, time)) => *time <= now,
                Phase::Resting => task.period.saturating_add(SHARE_PERIOD) <= now,
                Phase::Ready | Phase::Waiting(_) | Phase::Over => false,
            };
            let looks = task.look.is_some_and(|look| look <= now);
            if due || (looks && matches!(task.phase, Phase::Waiting(_))) {
                task.phase = Phase::Ready;
            }
        }
        let mut worked = false;
        for index in 0..self.tasks.len() {
            worked |= self.run_slice(index);
        }
        worked
    }

    fn run_slice(&mut self, index: usize) -> bool {
        let now = self.hardware.now;
        let Some(task) = self.tasks.get_mut(index) else {
            return false;
        };
        if !matches!(task.phase, Phase::Ready) {
            return false;
        }
        if task.period.saturating_add(SHARE_PERIOD) <= now {
            task.period = now;
            task.share = self.limits.instructions_per_ms;
        }
        if task.share == 0 {
            task.phase = Phase::Resting;
            return true;
        }
        let (id, share) = (task.id, task.share);
        self.hardware.running = Some(id);
        let slice = if task.step_from.is_some() || self.trace.follows() {
            self.run_by_lines(index, id, share)
        } else {
            self.machine.run(id, share, &mut self.hardware)
        };
        self.hardware.running = None;
        let run = self.after_missing_call(id).unwrap_or(slice.run);
        let Some(task) = self.tasks.get_mut(index) else {
            return false;
        };
        // A slice costs something even if it only asks again, or two tasks could wake each other for ever.
        task.share = task.share.saturating_sub(slice.used.max(1));
        task.look = slice.wake_by;
        task.phase = match run {
            Run::OutOfFuel => Phase::Ready,
            Run::Blocked(wait) => Phase::Waiting(wait),
            Run::Ended => Phase::Over,
            Run::Aborted(error) => {
                self.hardware.stop_arm_of(id, &error.to_string());
                self.hardware.tell_clients(id, &error);
                Phase::Over
            }
        };
        let over = matches!(task.phase, Phase::Over);
        self.hardware.end_cancel(id);
        if over {
            task.look = None;
            tracing::info!(controller = %self.hardware.name, task = id.0, "A KAREL task is over.");
            self.hardware.release_ports(id);
        }
        self.follow_tasks();
        self.wake_tasks();
        true
    }

    /// Takes over tasks that programs have started, and drops those that programs have ended.
    pub(super) fn follow_tasks(&mut self) {
        if self.machine.task_changes() == self.task_changes {
            return;
        }
        self.task_changes = self.machine.task_changes();
        let ids: Vec<TaskId> = self.machine.tasks().collect();
        for task in &mut self.tasks {
            if !matches!(task.phase, Phase::Over) && !self.machine.is_alive(task.id) {
                tracing::info!(
                    controller = %self.hardware.name, task = task.id.0,
                    "A KAREL task was ended by another.",
                );
                self.hardware.release_ports(task.id);
                task.phase = Phase::Over;
                task.look = None;
            }
        }
        self.tasks.retain(|task| ids.contains(&task.id));
        self.hardware.forget_tasks(&ids);
        for task in &mut self.tasks {
            // Who was continued looks at once at what it waits for.
            if matches!(task.phase, Phase::Waiting(Wait::Continue))
                && !self.machine.is_paused(task.id)
            {
                task.phase = Phase::Ready;
            }
            // Its condition handlers have to see that somebody wants it to end.
            if matches!(task.phase, Phase::Waiting(_)) && self.machine.wants_to_run(task.id) {
                task.phase = Phase::Ready;
            }
        }
        for id in ids {
            if self.tasks.iter().all(|task| task.id != id) {
                self.tasks.push(Task {
                    id,
                    phase: Phase::Ready,
                    share: self.limits.instructions_per_ms,
                    period: self.hardware.now,
                    look: None,
                    step_from: None,
                    traced: None,
                });
                if self.single_step {
                    self.step_one_line(id);
                }
            }
        }
    }

    pub(super) fn wake_tasks(&mut self) {
        for wake in self.hardware.take_wakes() {
            for task in &mut self.tasks {
                if let Phase::Waiting(wait) = &task.phase
                    && wake.ends(wait)
                {
                    task.phase = Phase::Ready;
                    // Something happened that it did not do itself, so it is no endless loop.
                    task.share = self.limits.instructions_per_ms;
                }
            }
        }
    }
}
