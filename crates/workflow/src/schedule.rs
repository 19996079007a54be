//! Which waits there have to be, derived from the state: no code can forget to arm or to disarm a timer (I9).

use crate::book::{OpState, Wait};
use crate::cell::Cell;
use crate::effect::{Action, Target};
use crate::ids::Millis;
use crate::job::{Job, JobState, StepState, Why};
use crate::session::SessionState;
use crate::timers::{Running, TimerKey};

/// A wait that has to run.
pub(crate) struct Needed {
    pub key: TimerKey,
    pub total_ms: Millis,
    /// An absolute end instead.
    pub at: Option<Millis>,
    pub stamp: u64,
}

impl Cell {
    /// Arms what is missing, drops what has no meaning any more, begins anew what changed its stamp.
    pub(crate) fn schedule(&mut self, now: Millis) {
        if !self.live.recovered {
            return;
        }
        let needed = self.needed();
        let mut timers = std::collections::BTreeMap::new();
        for Needed {
            key,
            total_ms,
            at,
            stamp,
        } in needed
        {
            let wait = match self.live.timers.get(&key) {
                Some(old) if old.stamp == stamp => *old,
                Some(_) | None => {
                    let at = at.unwrap_or_else(|| now.saturating_add(total_ms));
                    Wait {
                        running: Running { at, total_ms },
                        stamp,
                        fired: false,
                    }
                }
            };
            let _same = timers.insert(key, wait);
        }
        self.live.timers = timers;
    }

    /// Every wait of the present state.
    #[expect(clippy::too_many_lines, reason = "one list: every kind of wait")]
    pub(crate) fn needed(&self) -> Vec<Needed> {
        let t = &self.setup.timers;
        let mut all = Vec::new();
        let mut need = |key, total_ms: Millis, stamp: u64| {
            all.push(Needed {
                key,
                total_ms: total_ms.max(1),
                at: None,
                stamp,
            });
        };
        for job in self.book.jobs.values().filter(|j| !j.state.is_final()) {
            self.needed_by(job, &mut need);
        }
        for (id, op) in &self.book.ops {
            let limit = match (&op.action, op.state) {
                (_, OpState::Doubt | OpState::Reconciling) => t.recover_ms,
                (Action::Precheck { .. }, OpState::Running) => t.precheck_ms,
                (Action::Grip { .. }, OpState::Running) => t.grip_ms,
                (Action::Move { .. }, OpState::Running) => {
                    self.live
                        .planned
                        .get(id)
                        .map_or(t.motion_unplanned_ms, |planned| {
                            planned
                                .saturating_add(planned / 2)
                                .saturating_add(t.motion_margin_ms)
                        })
                }
            };
            let planned = u64::from(self.live.planned.contains_key(id));
            need(
                TimerKey::Operation { op: *id },
                limit,
                op.state as u64 * 2 + planned,
            );
        }
        for (arm, stamp) in &self.live.safe {
            need(TimerKey::Safe { arm: arm.clone() }, t.safe_ms, *stamp);
        }
        for (arm, live) in self.live.arms.iter().filter(|(_, a)| a.seen.link) {
            need(
                TimerKey::ArmSeen { arm: arm.clone() },
                t.arm_silence_ms,
                live.count,
            );
        }
        for session in self.book.sessions.values().filter(|s| !s.state.is_closed()) {
            let asked = self.book.question_of_session(session.id).is_some();
            let on_its_own =
                session.state == SessionState::Faulted && !self.book.is_live(session.job);
            let stamp = session.state as u64 * 1000
                + u64::from(session.resends) * 2
                + u64::from(session.left);
            let limit = match session.state {
                SessionState::ExitGranted if session.left => Some(t.clear_ms),
                SessionState::TransferDone | SessionState::ExitGranted => Some(t.exit_ms),
                SessionState::Canceling => Some(t.clear_ms),
                SessionState::Reserved
                | SessionState::AccessPending
                | SessionState::AccessGranted
                | SessionState::Positioned
                | SessionState::Docked
                | SessionState::TransferReady
                | SessionState::Transferring
                | SessionState::Exited
                | SessionState::Released
                | SessionState::Faulted
                | SessionState::Canceled => on_its_own.then_some(t.clear_ms),
            };
            if let Some(limit) = limit
                && !asked
            {
                need(
                    TimerKey::Session {
                        session: session.id,
                    },
                    limit,
                    stamp,
                );
            }
            if session.state.is_docked() {
                let mobile_robot = session.mobile_robot.clone();
                let count = self.live.mobiles.get(&mobile_robot).map_or(0, |m| m.count);
                if self.live.mobiles.get(&mobile_robot).is_none_or(|m| !m.lost) {
                    need(TimerKey::Heartbeat { mobile_robot }, t.heartbeat_ms, count);
                }
            }
        }
        for (id, mobile) in &self.book.mobiles {
            if let Some(parked) = &mobile.parked {
                need(
                    TimerKey::Parked {
                        mobile_robot: id.clone(),
                    },
                    t.park_ms,
                    parked.seq,
                );
            }
        }
        for (id, question) in self.book.interventions.iter().filter(|(_, i)| i.is_open()) {
            let stamp = u64::from(question.reminders);
            need(TimerKey::Question { intervention: *id }, t.remind_ms, stamp);
        }
        for job in self
            .book
            .jobs
            .values()
            .filter(|j| j.state == JobState::Idle)
        {
            if let Some(at) = job.spec.deadline {
                let key = TimerKey::Deadline { job: job.id };
                all.push(Needed {
                    key,
                    total_ms: 0,
                    at: Some(at),
                    stamp: at,
                });
            }
        }
        all
    }

    fn needed_by(&self, job: &Job, need: &mut impl FnMut(TimerKey, Millis, u64)) {
        let t = &self.setup.timers;
        let id = job.id;
        let state = job.state as u64;
        let running = job.steps.iter().any(|s| s.state == StepState::Running);
        if job.state == JobState::Idle {
            need(TimerKey::Queue { job: id }, t.reserve_ms, 0);
        } else if matches!(job.state, JobState::Held | JobState::Aborted) {
            // Waiting for a human who knows: looked at again from time to time.
            need(TimerKey::State { job: id }, t.remind_ms, state);
        } else if job.state == JobState::Suspended && job.why != Why::Awaiting {
            need(TimerKey::State { job: id }, t.recover_ms, state);
        } else if job.state == JobState::Stopping && !running {
            need(
                TimerKey::State { job: id },
                t.still_ms,
                state + job.compensation as u64 * 100,
            );
        } else if job.state.is_acting() && job.state != JobState::Stopping {
            need(TimerKey::State { job: id }, t.still_ms, state);
        }
        if !job.runs() && !job.state.is_acting() {
            return;
        }
        for (index, step) in job.steps.iter().enumerate() {
            if step.state != StepState::Running || step.op.is_some() {
                continue;
            }
            let stamp = u64::from(step.attempt) * 10_000
                + u64::from(step.resends) * 100
                + step.done_ops as u64;
            let limit = if step.plan.phase.is_arm_work() {
                t.motion_unplanned_ms
            } else {
                step.plan.phase.limit(t, &job.spec)
            };
            need(
                TimerKey::Step {
                    job: id,
                    step: index,
                },
                limit,
                stamp,
            );
        }
        if self.is_prefetched(job) {
            need(TimerKey::Prefetch { job: id }, t.prefetch_hold_ms, 0);
        }
    }

    /// A load waits in the gripper for a mobile robot that has not docked yet.
    pub(crate) fn is_prefetched(&self, job: &Job) -> bool {
        let Some(arm) = &job.arm else { return false };
        job.spec.prefetch
            && job.state != JobState::Stopping
            && self.book.custody.in_gripper(arm).is_some()
            && !job.is_done(crate::Phase::Dock)
            && job.steps.iter().all(|s| !s.plan.undo || s.state.is_done())
    }

    /// Arm work of a job that leaves a place.
    pub(crate) fn is_leaving(action: &Action) -> bool {
        matches!(
            action,
            Action::Move {
                target: Target::LiftOf { .. } | Target::Safe,
                ..
            }
        )
    }
}
