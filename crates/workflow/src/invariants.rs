//! I1 to I10 as a check of the state. The driver runs it after each fact: a violation stops and aborts.

use std::collections::BTreeSet;

use serde::Serialize;

use crate::book::OpState;
use crate::cell::Cell;
use crate::effect::Action;
use crate::job::JobState;
use crate::permits::Permit;
use crate::timers::TimerKey;

/// A broken invariant.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Violation {
    /// `I1` to `I10`.
    pub invariant: &'static str,
    /// What was found.
    pub text: String,
}

impl Cell {
    /// Everything that is wrong with the state; nothing, if the crate has no bug.
    #[must_use]
    pub fn violations(&self) -> Vec<Violation> {
        let mut all = Vec::new();
        let mut say = |invariant, text: String| all.push(Violation { invariant, text });
        for point in &self.setup.points {
            let permits: Vec<_> = self
                .book
                .sessions
                .values()
                .filter(|s| s.point == point.id)
                .map(|s| self.permit_of(s))
                .filter(|p| *p != Permit::None)
                .collect();
            if permits.len() > 1 {
                say("I1", format!("{}: {permits:?}", point.id));
            }
            if permits.contains(&Permit::MrMove) && self.book.ops.values().any(|op| {
                op.state == OpState::Running
                    && point.arms.contains(&op.arm)
                    && matches!(&op.action, Action::Move { target, .. } if target.enters_zone()
                        && matches!(target.place(), Some(crate::PlaceRef::MobileRobot { point: p, .. }) if *p == point.id))
            }) {
                say("I2", format!("{}: an arm enters while the mobile robot may move", point.id));
            }
        }
        if !self.live.recovered {
            for session in self.book.sessions.values() {
                if self.permit_of(session) != Permit::None {
                    say(
                        "I7",
                        format!("session {} has a permit before recovery", session.id),
                    );
                }
            }
        }
        let mut taken = BTreeSet::new();
        for (load, found) in &self.book.custody.0 {
            if self.setup.is_single(&found.location) && !taken.insert(&found.location) {
                say(
                    "I4",
                    format!("{load} and another load are at {}", found.location),
                );
            }
        }
        let mut arms = BTreeSet::new();
        for (id, op) in &self.book.ops {
            if !arms.insert(&op.arm) {
                say(
                    "I6",
                    format!("{} has two operations, one of them {id}", op.arm),
                );
            }
            let known = self
                .book
                .jobs
                .get(&op.job)
                .and_then(|j| j.step(op.step))
                .and_then(|s| s.op);
            if known != Some(*id) {
                say("I5", format!("operation {id} belongs to no step"));
            }
        }
        if self.live.recovered && !self.live.unwritable {
            self.check_waits(&mut say);
        }
        all
    }

    /// I9: whatever is not over waits for something with a timer.
    fn check_waits(&self, say: &mut impl FnMut(&'static str, String)) {
        for job in self.book.jobs.values().filter(|j| !j.state.is_final()) {
            let waits = self.live.timers.iter().any(|(key, wait)| {
                let mine = match key {
                    TimerKey::Queue { job: id }
                    | TimerKey::Deadline { job: id }
                    | TimerKey::Step { job: id, .. }
                    | TimerKey::State { job: id }
                    | TimerKey::Prefetch { job: id } => *id == job.id,
                    TimerKey::Operation { op } => {
                        self.book.ops.get(op).is_some_and(|o| o.job == job.id)
                    }
                    TimerKey::Session { session } => job.session == Some(*session),
                    TimerKey::Question { intervention } => self
                        .book
                        .interventions
                        .get(intervention)
                        .is_some_and(|i| i.question.job == Some(job.id)),
                    TimerKey::Heartbeat { mobile_robot } => {
                        job.mobile_robot.as_ref() == Some(mobile_robot)
                    }
                    TimerKey::Safe { .. } | TimerKey::ArmSeen { .. } | TimerKey::Parked { .. } => {
                        false
                    }
                };
                mine && !wait.fired
            });
            let known = matches!(job.state, JobState::Held | JobState::Aborted);
            if !waits && !known {
                say(
                    "I9",
                    format!(
                        "job {} is {:?} and waits without a timer",
                        job.id, job.state
                    ),
                );
            }
        }
    }
}
