//! What is watched all the time, whatever step a job is at: arms, mobile robots, parts, doubts.

use std::sync::Arc;

use crate::book::OpState;
use crate::effect::{Action, GripAction};
use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::Safety;
use crate::intervention::Answer;
use crate::job::{Job, JobState, Why};
use crate::permits::Permit;
use crate::react::Reaction;
use crate::session::{Session, SessionState};
use crate::words;
use crate::work::{Ask, Work};

impl Work<'_> {
    /// Looks for the first thing that is wrong. Each reaction removes its own cause.
    pub(crate) fn supervise(&mut self) {
        let before = self.facts.len();
        for session in self.open_sessions() {
            self.supervise_session(&session);
            if self.facts.len() > before {
                return;
            }
        }
        for id in self.jobs() {
            let Some(job) = self.job(id) else { continue };
            self.supervise_job(&job);
            if self.facts.len() > before {
                return;
            }
        }
        self.supervise_doubts();
    }

    #[expect(
        clippy::too_many_lines,
        reason = "a list: what is looked at, the worst first"
    )]
    fn supervise_job(&mut self, job: &Arc<Job>) {
        let Some(arm) = job.arm.clone() else { return };
        let Some(live) = self.cell.live.arms.get(&arm).cloned() else {
            return;
        };
        let over = matches!(
            job.state,
            JobState::Aborting | JobState::Aborted | JobState::Clearing | JobState::Resetting
        );
        if over || job.steps.iter().all(|s| s.state.is_done()) {
            return;
        }
        let held = matches!(job.state, JobState::Held | JobState::Holding);
        let by = |fault: Fault| job.why == Why::Fault { fault };
        if live.seen.link && live.seen.safety == Safety::EmergencyStop {
            self.react(
                job,
                Reaction {
                    fault: Fault::EmergencyStop,
                    text: format!("emergency stop of {arm}"),
                    permits: true,
                    stop: true,
                    state: Some(JobState::Aborting),
                    ..Reaction::default()
                },
            );
            return;
        }
        if let Some(fault) = stopped_by(live.seen.safety)
            && live.seen.link
            && !(held && by(fault))
            && job.state != JobState::Stopping
        {
            self.react(
                job,
                Reaction {
                    fault,
                    text: format!("{arm} is in {}", words::word(&live.seen.safety)),
                    permits: true,
                    ..Reaction::default()
                },
            );
            self.go(
                job.id,
                JobState::Holding,
                Why::Fault { fault },
                "a human has to reset the arm and unhold the job",
            );
            return;
        }
        // Part sensor and custody have to agree while nothing is gripped or released.
        let gripping = self
            .cell
            .book
            .ops
            .values()
            .any(|op| op.arm == arm && matches!(op.action, Action::Grip { .. }));
        if live.seen.link
            && !gripping
            && live.seen.part_present == Some(false)
            && let Some(load) = self.cell.book.custody.in_gripper(&arm).map(str::to_owned)
        {
            self.part_lost(job, &load, "the part sensor says that the gripper is empty");
            return;
        }
        let suspended = matches!(job.state, JobState::Suspending | JobState::Suspended);
        let faulted = suspended && job.why != Why::Awaiting && job.why != Why::Course;
        if !live.seen.link && !held && !faulted && job.state != JobState::Stopping {
            self.react(
                job,
                Reaction {
                    fault: Fault::NoAnswer,
                    text: format!("the link to {arm} is lost"),
                    permits: true,
                    state: Some(JobState::Suspending),
                    ..Reaction::default()
                },
            );
            return;
        }
        if self.supervise_hand(job, &arm) {
            return;
        }
        if !self.cell.live.jobs_may_act
            && !held
            && job.state != JobState::Stopping
            && !job_waits(job)
        {
            let moving = self
                .cell
                .ops_of(job.id)
                .any(|(_, state)| state == OpState::Running);
            self.react(
                job,
                Reaction {
                    fault: Fault::ControlLost,
                    text: "somebody took control of the cell; `unhold` lets the job go on".into(),
                    stop: moving,
                    state: Some(JobState::Holding),
                    ..Reaction::default()
                },
            );
        }
    }

    fn supervise_session(&mut self, session: &Arc<Session>) {
        let Some(point) = self.cell.setup.point(&session.point).cloned() else {
            return;
        };
        let Some(job) = self.job(session.job) else {
            return;
        };
        let permit = self.cell.permit_of(session);
        let arm_inside = point
            .arms
            .iter()
            .any(|arm| self.cell.arm_in_zone(arm, &point.zone));
        let unheard = self.cell.unheard_at(&session.point).is_some();
        if permit == Permit::MrMove && arm_inside {
            self.interlock(
                &job,
                "an arm is in the zone while the mobile robot may move",
            );
            return;
        }
        if permit != Permit::None && unheard {
            self.fault_session(session, Fault::NoAnswer);
            self.react(
                &job,
                Reaction {
                    fault: Fault::NoAnswer,
                    text: format!("an arm of {} is not heard", session.point),
                    state: Some(JobState::Suspending),
                    ..Reaction::default()
                },
            );
            return;
        }
        let Some(live) = self.cell.live.mobiles.get(&session.mobile_robot).cloned() else {
            return;
        };
        let Some(seen) = live.state.clone() else {
            return;
        };
        let jumped = session
            .docked
            .is_some_and(|d| !seen.pose.within(&d, point.tolerance));
        // One that was told to give up may stop naming its order before it is out.
        let dropped = session.echoes && seen.order.is_none() && !session.backs_out;
        if session.state.is_docked() {
            let danger = permit == Permit::ArmEntry && self.cell.arm_may_be_in(&point);
            if danger && (seen.driving || jumped) {
                self.interlock(
                    &job,
                    if seen.driving {
                        "the mobile robot drives while the arm is in the zone"
                    } else {
                        "the pose of the mobile robot jumped while the arm is in the zone"
                    },
                );
                return;
            }
            if live.lost {
                self.mobile_fault(&job, Fault::HeartbeatLost, "its heartbeat is lost");
                return;
            }
            if seen.driving || jumped {
                self.mobile_fault(&job, Fault::ModeChanged, "it left its dock pose by itself");
                return;
            }
        }
        let served = session.state.is_docked()
            || matches!(
                session.state,
                SessionState::AccessPending
                    | SessionState::AccessGranted
                    | SessionState::Positioned
            );
        if served {
            if !seen.mode.is_automatic() {
                self.mobile_fault(
                    &job,
                    Fault::ModeChanged,
                    &format!("its mode is {}", words::word(&seen.mode)),
                );
            } else if seen.errors.iter().any(|e| e.fatal) {
                self.mobile_fault(&job, Fault::ModeChanged, "it reports a fatal error");
            } else if dropped {
                self.mobile_fault(&job, Fault::ModeChanged, "it dropped its order");
            }
        }
    }

    /// F11: the worst case. Nothing goes on without a human.
    fn interlock(&mut self, job: &Job, text: &str) {
        self.react(
            job,
            Reaction {
                fault: Fault::Interlock,
                text: format!("interlock-violation: {text}"),
                permits: true,
                stop: true,
                pause: true,
                state: Some(JobState::Aborting),
                ..Reaction::default()
            },
        );
    }

    /// F12, F13: the arm leaves the zone, then the job waits.
    pub(crate) fn mobile_fault(&mut self, job: &Job, fault: Fault, text: &str) {
        let mobile_robot = job.mobile_robot.clone().unwrap_or_default();
        let text = format!("{mobile_robot}: {text}");
        let running = self
            .cell
            .book
            .ops
            .values()
            .find(|op| op.job == job.id && op.state == OpState::Running);
        let in_zone = job.near.as_ref().is_some_and(crate::PlaceRef::in_zone);
        let moving = running.is_some_and(|op| matches!(op.action, Action::Move { .. }));
        let leaving = running.is_some_and(|op| crate::cell::Cell::is_leaving(&op.action));
        if let (true, true, Some(arm)) = (in_zone, leaving, job.arm.clone()) {
            self.emit(Fact::SafeDue { arm });
        }
        let again = if fault == Fault::HeartbeatLost {
            Answer::Resume
        } else {
            Answer::Redispatch
        };
        let ask = Ask {
            question: format!("{text}. How should the job go on?"),
            known: self.known_of(job),
            unknown: vec![format!("what {mobile_robot} does")],
            answers: vec![again, Answer::Cancel],
            ..Ask::default()
        };
        // A job that undoes itself waits for the answer to its own question, which no other may replace.
        let asked = job.state == JobState::Stopping && self.cell.book.question_of(job.id).is_some();
        self.react(
            job,
            Reaction {
                fault,
                text,
                permits: true,
                stop: moving && in_zone && !leaving,
                state: Some(JobState::Suspending),
                ask: (!asked).then_some(ask),
                ..Reaction::default()
            },
        );
    }

    /// Whatever is in doubt is looked up as soon as its arm answers again.
    fn supervise_doubts(&mut self) {
        let doubts: Vec<_> = self
            .cell
            .book
            .ops
            .iter()
            .filter(|(id, op)| {
                op.state == OpState::Doubt
                    && self.cell.arm_seen(&op.arm).is_some()
                    && !self
                        .cell
                        .book
                        .interventions
                        .values()
                        .any(|i| i.is_open() && i.question.op == Some(**id))
            })
            .map(|(id, _)| *id)
            .collect();
        for op in doubts {
            self.emit(Fact::OpReconciling { op });
        }
    }
}

/// The fault behind an arm that its controller has stopped, short of an emergency stop.
const fn stopped_by(safety: Safety) -> Option<Fault> {
    match safety {
        Safety::ProtectiveStop => Some(Fault::ProtectiveStop),
        Safety::Fault => Some(Fault::ControllerAlarm),
        Safety::Normal | Safety::Reduced | Safety::EmergencyStop | Safety::Unknown => None,
    }
}

/// A job that gives the arm nothing to do does not need control.
fn job_waits(job: &Job) -> bool {
    job.state == JobState::Suspended || job.state == JobState::Suspending
}

/// What a gripper was meant to do.
pub(crate) const fn grip_of(action: &Action) -> Option<GripAction> {
    match action {
        Action::Grip { action } => Some(*action),
        Action::Move { .. } | Action::Precheck { .. } => None,
    }
}
