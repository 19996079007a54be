//! What happens when a wait ends without what was waited for. Late is late: a tick that comes after the time is a
//! timeout, whatever arrived in between.

use crate::book::OpState;
use crate::effect::Action;
use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::OpResult;
use crate::intervention::Answer;
use crate::job::operations::describe;
use crate::job::phase::Phase;
use crate::job::{Job, JobState, Why};
use crate::react::Reaction;
use crate::signal::SignalKind;
use crate::timers::TimerKey;
use crate::words;
use crate::work::{Ask, Work};

impl Work<'_> {
    /// Handles every wait that is over.
    pub(crate) fn expire(&mut self) {
        self.cell.schedule(self.now);
        let mut due: Vec<_> = self
            .cell
            .live
            .timers
            .iter()
            .filter(|(_, w)| !w.fired && w.running.at <= self.now)
            .map(|(key, w)| (w.running.at, key.clone()))
            .collect();
        due.sort();
        for (_, timer) in due {
            // An earlier reaction may have ended this wait.
            self.cell.schedule(self.now);
            let still = self
                .cell
                .live
                .timers
                .get(&timer)
                .is_some_and(|w| !w.fired && w.running.at <= self.now);
            if still {
                self.emit(Fact::TimerExpired {
                    timer: timer.clone(),
                });
                self.expired(timer);
                self.settle();
            }
        }
    }

    fn expired(&mut self, timer: TimerKey) {
        match timer {
            TimerKey::Queue { .. } | TimerKey::Question { .. } => {}
            TimerKey::Deadline { job } => {
                let text = "deadline-passed: it could not start in time";
                self.go(job, JobState::Stopped, Why::DeadlinePassed, text);
            }
            TimerKey::Step { job, step } => {
                if let Some(job) = self.job(job) {
                    self.step_late(&job, step);
                }
            }
            TimerKey::State { job } => {
                if let Some(job) = self.job(job) {
                    self.state_late(&job);
                }
            }
            TimerKey::Prefetch { job } => {
                if let Some(job) = self.job(job) {
                    self.put_prefetch_back(&job);
                }
            }
            TimerKey::Operation { op } => self.operation_late(op),
            TimerKey::Safe { arm } => {
                self.stop_arm(&arm, "it was not out of the zone within T_safe");
            }
            TimerKey::Session { session } => {
                if let Some(session) = self.session(session) {
                    self.session_late(&session);
                }
            }
            TimerKey::Heartbeat { mobile_robot } => {
                self.emit(Fact::MobileLost { mobile_robot });
            }
            TimerKey::ArmSeen { arm } => self.emit(Fact::ArmLost { arm }),
            TimerKey::Parked { mobile_robot } => self.park_expired(&mobile_robot),
        }
    }

    fn operation_late(&mut self, id: uuid::Uuid) {
        let Some(op) = self.cell.book.ops.get(&id).cloned() else {
            return;
        };
        let Some(job) = self.job(op.job) else { return };
        let text = format!("{} took too long", describe(&op.action));
        match (&op.action, op.state) {
            (Action::Precheck { .. }, _) => {
                self.emit(Fact::OpEnded {
                    op: id,
                    result: OpResult::NotExecuted { text: text.clone() },
                });
                let tries = job.step(op.step).map_or(0, |s| s.resends);
                if tries < self.cell.setup.timers.resends {
                    self.emit(Fact::StepResent {
                        job: job.id,
                        step: op.step,
                    });
                } else {
                    self.note(job.id, Fault::Unreachable, text.clone());
                    let why = Why::Fault {
                        fault: Fault::Unreachable,
                    };
                    self.go(job.id, JobState::Stopping, why, text);
                }
            }
            (Action::Move { .. }, OpState::Running) => {
                self.stop_arm(&op.arm, &text);
                self.op_in_doubt(&job, id, &op, &text);
            }
            (Action::Move { .. } | Action::Grip { .. }, _) => {
                self.op_in_doubt(&job, id, &op, &text);
            }
        }
    }

    /// The faults F1 to F5, F12, F19, F20 of the waits.
    fn step_late(&mut self, job: &Job, step: usize) {
        let Some(found) = job.step(step).cloned() else {
            return;
        };
        let phase = found.plan.phase;
        let asked = self.cell.book.question_of(job.id).is_some()
            || job
                .session
                .is_some_and(|s| self.cell.book.question_of_session(s).is_some());
        if asked {
            return;
        }
        let again = |work: &mut Self| work.emit(Fact::StepResent { job: job.id, step });
        let timers = self.cell.setup.timers.clone();
        match phase {
            Phase::Call => {
                let session = self.cell.session_of(job).cloned();
                if let Some(session) = session.filter(|_| found.resends < timers.resends) {
                    again(self);
                    self.send_order(&session);
                } else {
                    self.not_acknowledged(job, "it did not acknowledge its order");
                }
            }
            Phase::Await => self.arrival_late(job, step),
            Phase::Dock => {
                if let Some(session) = self.cell.session_of(job).cloned() {
                    self.dock_failed(&session, "it did not dock in time");
                }
            }
            Phase::VerifyEmpty if self.other_slots(job) => again(self),
            Phase::VerifyLoad | Phase::VerifyEmpty | Phase::VerifyOnMr => {
                if found.resends < timers.rescans {
                    again(self);
                } else {
                    let text = if phase == Phase::VerifyEmpty {
                        "a slot of the mobile robot is not reported free"
                    } else if phase == Phase::VerifyOnMr {
                        "the loads are not reported on the mobile robot"
                    } else {
                        "the loads do not match the job"
                    };
                    self.load_question(job, phase.row().late, text);
                }
            }
            Phase::Permit => self.wait_failed(
                job,
                Fault::HeartbeatLost,
                "it is not ready for the transfer",
            ),
            Phase::Transport => self.transport_failed(job, step, "it is late"),
            Phase::Exit | Phase::Dismiss => {
                if let Some(session) = self.cell.session_of(job).cloned() {
                    self.does_not_leave(&session, "it took too long");
                }
            }
            Phase::Reserve
            | Phase::Precheck
            | Phase::Approach
            | Phase::Grip
            | Phase::LiftClear
            | Phase::ReleaseMr
            | Phase::PlaceApproach
            | Phase::Release
            | Phase::Retreat
            | Phase::Close
            | Phase::BackOut => {
                self.wait_failed(job, phase.row().late, "the arm could not begin in time");
            }
        }
    }

    fn wait_failed(&mut self, job: &Job, fault: Fault, text: &str) {
        let ask = Ask {
            question: format!("{text}. How should the job go on?"),
            known: self.known_of(job),
            unknown: vec!["what it waits for".into()],
            answers: vec![Answer::Resume, Answer::Cancel, Answer::Abort],
            ..Ask::default()
        };
        let state = Some(JobState::Suspending);
        self.react(
            job,
            Reaction {
                fault,
                text: text.into(),
                permits: true,
                state,
                ask: Some(ask),
                ..Reaction::default()
            },
        );
    }

    /// An acting state that does not end, or a suspension that does not pass.
    fn state_late(&mut self, job: &Job) {
        if matches!(job.state, JobState::Held | JobState::Aborted)
            || self.cell.book.question_of(job.id).is_some()
        {
            return;
        }
        let fault = match &job.why {
            Why::Fault { fault } => *fault,
            Why::Recovering => Fault::Restarted,
            Why::Course | Why::Awaiting | Why::Human { .. } | Why::DeadlinePassed => {
                Fault::NoAnswer
            }
        };
        let why_not = self
            .may_resume(job)
            .err()
            .unwrap_or_else(|| "it is not seen to end".into());
        let mut known = self.known_of(job);
        let waits = matches!(
            job.state,
            JobState::Suspended | JobState::Unsuspending | JobState::Unholding
        );
        let mut answers = if waits && self.has_dropped_its_order(job) {
            // Nothing but a new order brings it back.
            vec![Answer::Redispatch, Answer::Cancel, Answer::Abort]
        } else if job.state != JobState::Suspended {
            vec![Answer::ConfirmStill, Answer::Abort]
        } else {
            vec![Answer::Resume, Answer::Cancel, Answer::Abort]
        };
        let inside = self
            .cell
            .session_of(job)
            .and_then(|session| self.cell.setup.point(&session.point))
            .is_some_and(|point| self.cell.arm_may_be_in(point));
        if answers.contains(&Answer::Redispatch) && inside {
            known.push("an arm is in the zone, so it has no permit to come in".into());
            answers.push(Answer::Retreat);
        }
        self.ask(Ask {
            job: Some(job.id),
            fault,
            question: format!(
                "The job stays {}: {why_not}. How should it go on?",
                words::word(&job.state)
            ),
            known,
            unknown: vec![why_not],
            answers,
            ..Ask::default()
        });
    }

    /// The predecessor of a parked signal is lost: it is not waited for any longer.
    fn park_expired(&mut self, mobile_robot: &str) {
        let parked = self
            .cell
            .book
            .mobiles
            .get(mobile_robot)
            .and_then(|m| m.parked.clone());
        if let Some(signal) = parked {
            debug_assert!(signal.kind != SignalKind::MrHeartbeat || signal.seq > 0);
            let _answer = self.act_on(signal);
        }
    }
}
