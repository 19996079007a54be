//! What happens when a wait ends without what was waited for. Late is late: a tick that comes after the time is a
//! timeout, whatever arrived in between.

use crate::book::OpState;
use crate::claims::{Holder, Resource};
use crate::effect::Action;
use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::OpResult;
use crate::intervention::Answer;
use crate::job::operations::describe;
use crate::job::phase::Phase;
use crate::job::{Job, JobState, StepState, Why};
use crate::react::Reaction;
use crate::signal::{Message, SignalKind};
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

    /// F1: another mobile robot if any will do, otherwise a human.
    pub(crate) fn not_acknowledged(&mut self, job: &Job, text: &str) {
        let Some(session) = self.cell.session_of(job).cloned() else {
            return;
        };
        let old = session.mobile_robot.clone();
        if let Some(other) = self.cell.choose_mobile_robot(job, Some(&old)) {
            self.note(
                job.id,
                Fault::NotAcknowledged,
                format!("{old}: {text}; {other} is called"),
            );
            self.hand_on(job, &other);
            return;
        }
        let ask = Ask {
            question: format!("{old}: {text}. Which mobile robot should come?"),
            known: self.known_of(job),
            unknown: vec![format!("whether {old} is in service")],
            answers: vec![Answer::Retry, Answer::ChooseMobileRobot, Answer::Cancel],
            ..Ask::default()
        };
        self.react(
            job,
            Reaction {
                fault: Fault::NotAcknowledged,
                text: format!("{old}: {text}"),
                state: Some(JobState::Suspending),
                ask: Some(ask),
                ..Reaction::default()
            },
        );
    }

    /// The session goes on with another mobile robot; the first one's order is taken back.
    pub(crate) fn hand_on(&mut self, job: &Job, other: &str) {
        let Some(session) = self.cell.session_of(job).cloned() else {
            return;
        };
        if let Some(order) = session.order {
            self.tell(&session, Message::CancelOrder { order });
        }
        let by = Holder::Session(session.id);
        let old = vec![Resource::MobileRobot(session.mobile_robot.clone())];
        self.emit(Fact::Released {
            by,
            resources: Some(old),
        });
        self.emit(Fact::Claimed {
            by,
            resources: vec![Resource::MobileRobot(other.to_owned())],
        });
        self.redispatch_steps(job);
        self.emit(Fact::SessionHandedOn {
            session: session.id,
            mobile_robot: other.to_owned(),
        });
    }

    pub(crate) fn redispatch_steps(&mut self, job: &Job) {
        for phase in [Phase::Call, Phase::Await] {
            if let Some(step) = job.find(phase)
                && job
                    .step(step)
                    .is_some_and(|s| s.state != StepState::Pending)
            {
                let to = StepState::Pending;
                let text = "another mobile robot".to_owned();
                self.emit(Fact::StepMoved {
                    job: job.id,
                    step,
                    to,
                    attempt: 0,
                    text,
                });
            }
        }
    }

    /// F2: once more if it is on its way, then a new order, then a human.
    fn arrival_late(&mut self, job: &Job, step: usize) {
        let Some(session) = self.cell.session_of(job).cloned() else {
            return;
        };
        let seen = self.cell.mobile_seen(&session.mobile_robot).cloned();
        let extended = job.step(step).is_some_and(|s| s.resends > 0);
        if !extended && seen.is_some_and(|s| s.driving) {
            self.note(job.id, Fault::ArrivalLate, "late, but on its way");
            self.emit(Fact::StepResent { job: job.id, step });
        } else if job.redispatches < self.cell.setup.timers.redispatches && self.redispatch(job) {
            self.note(job.id, Fault::ArrivalLate, "it gets a new order");
        } else {
            let mobile_robot = &session.mobile_robot;
            let mut known = self.known_of(job);
            let mut answers = vec![Answer::Redispatch, Answer::Cancel];
            let inside = |p| self.cell.arm_may_be_in(p);
            if self.cell.setup.point(&session.point).is_some_and(inside) {
                known.push("an arm is in the zone, so it has no permit to come in".into());
                answers.push(Answer::Retreat);
            }
            let ask = Ask {
                question: format!("{mobile_robot} does not arrive. How should the job go on?"),
                known,
                unknown: vec![format!("where {mobile_robot} is stuck")],
                answers,
                ..Ask::default()
            };
            self.react(
                job,
                Reaction {
                    fault: Fault::ArrivalLate,
                    text: format!("{mobile_robot} does not arrive"),
                    permits: true,
                    state: Some(JobState::Suspending),
                    ask: Some(ask),
                    ..Reaction::default()
                },
            );
        }
    }

    /// F20: never "unload remotely".
    pub(crate) fn transport_failed(&mut self, job: &Job, step: usize, text: &str) {
        let again = job.step(step).is_some_and(|s| s.resends == 0);
        let Some(mobile_robot) = job.mobile_robot.clone() else {
            return;
        };
        let Some(transport) = self.transport_of(&mobile_robot) else {
            return;
        };
        if again {
            self.note(
                job.id,
                Fault::TransportFailed,
                format!("{text}; the order is sent again"),
            );
            self.emit(Fact::StepResent { job: job.id, step });
            self.resend_transport(&mobile_robot, &transport);
            return;
        }
        let ask = Ask {
            question: format!(
                "{mobile_robot} does not deliver to {}: {text}.",
                transport.destination
            ),
            known: vec![format!("the loads are booked on {mobile_robot}")],
            unknown: vec![format!("where {mobile_robot} is")],
            answers: vec![
                Answer::Retry,
                Answer::SwapMobileRobot,
                Answer::MarkDelivered,
            ],
            ..Ask::default()
        };
        self.react(
            job,
            Reaction {
                fault: Fault::TransportFailed,
                text: format!("the transport did not end: {text}"),
                state: Some(JobState::Suspending),
                ask: Some(ask),
                ..Reaction::default()
            },
        );
    }

    pub(crate) fn resend_transport(
        &mut self,
        mobile_robot: &str,
        transport: &crate::book::Transport,
    ) {
        let unload = self
            .job(transport.job)
            .map(|job| self.cell.to_unload(&job, mobile_robot));
        self.emit(Fact::Told {
            mobile_robot: mobile_robot.to_owned(),
            // The mobile robot knows its order by this session, and answers with it.
            session: transport.session,
            message: Message::TransportOrder {
                order: transport.order,
                // Orders of earlier versions have none; theirs was the second.
                update: transport.update.max(1),
                goal: transport.destination.clone(),
                dock: None,
                route: Vec::new(),
                then_to: None,
                unload,
            },
        });
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
                words::capitals(job.state)
            ),
            known,
            unknown: vec![why_not],
            answers,
            ..Ask::default()
        });
    }

    /// Whether the mobile robot a job waits for says that it has no order, after it had one.
    pub(crate) fn has_dropped_its_order(&self, job: &Job) -> bool {
        let Some(session) = self.cell.session_of(job) else {
            return false;
        };
        let seen = self.cell.mobile_seen(&session.mobile_robot);
        session.echoes && seen.is_some_and(|seen| seen.order.is_none())
    }

    /// F2 in B: the prefetched load does not wait in the gripper for ever.
    fn put_prefetch_back(&mut self, job: &Job) {
        let Some(arm) = job.arm.clone() else { return };
        let held = job.items.iter().position(|item| {
            item.load.is_some() && item.load.as_deref() == self.cell.book.custody.in_gripper(&arm)
        });
        let Some((index, item)) = held.and_then(|i| job.items.get(i).map(|item| (i, item))) else {
            return;
        };
        self.note(
            job.id,
            Fault::ArrivalLate,
            "the prefetched load is put back",
        );
        let place = crate::PlaceRef::fixed(item.place.clone());
        let drop: Vec<_> = job
            .steps
            .iter()
            .enumerate()
            .filter(|(_, s)| {
                s.plan.item == Some(index)
                    && matches!(
                        s.plan.phase,
                        Phase::PlaceApproach | Phase::Release | Phase::Retreat
                    )
                    && s.state == StepState::Pending
            })
            .map(|(i, _)| i)
            .collect();
        // Back to its source now; after the permit it is picked again and put on the mobile robot.
        let mut b = crate::job::plan::Builder::after(job.steps.len(), false);
        let _back = b.put(index, &place);
        let back = job.steps.len() + 2;
        let _again = b.then(Phase::Approach, Some(index), Some(place.clone()));
        if let Some(permit) = job.find(Phase::Permit) {
            b.also(permit);
        }
        b.also(back);
        let _grip = b.then(Phase::Grip, Some(index), Some(place.clone()));
        let _lift = b.then(Phase::LiftClear, Some(index), Some(place));
        let last = b.put(index, &crate::job::plan::slot_of(&job.spec, item)) + 2;
        let steps = b.steps();
        self.emit(Fact::Planned {
            job: job.id,
            steps,
            drop,
            definition: None,
        });
        // What needed the old steps of this item needs the new ones.
        for phase in [Phase::Approach, Phase::VerifyOnMr] {
            let next = job.steps.iter().position(|s| {
                s.plan.phase == phase && s.state == StepState::Pending && s.plan.item != Some(index)
            });
            if let Some(step) = next {
                self.emit(Fact::StepNeeds {
                    job: job.id,
                    step,
                    need: last,
                });
            }
        }
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
