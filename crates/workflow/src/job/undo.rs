//! Compensation: the undo column walked upwards, as a new plan that is part of the facts.

use crate::custody::Location;
use crate::fact::{Fact, Rewind};
use crate::faults::Fault;
use crate::intervention::Answer;
use crate::job::params::{OnCancel, Workflow};
use crate::job::phase::Phase;
use crate::job::plan::{Builder, slot_of};
use crate::job::{Compensation, Job, JobState, StepState, Why};
use crate::session::SessionState;
use crate::setup::PlaceRef;
use crate::signal::Message;
use crate::work::{Ask, Work};

/// What a human decided about loads that a canceled job left on the mobile robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Choice {
    Held(OnCancel),
    LeaveOnMobileRobot,
    Repick,
}

impl Work<'_> {
    /// Replaces what is left of the plan by its undoing; asks where only a human can choose.
    pub(crate) fn plan_undo(&mut self, job: &Job, choice: Option<Choice>) {
        let Some(arm) = job.arm.clone() else { return };
        let session = self.cell.session_of(job).cloned();
        let docked = session.as_ref().is_some_and(|s| {
            s.faulted.map_or(s.state, |(from, _)| from).is_docked() && s.docked.is_some()
        });
        let held = job.items.iter().enumerate().find(|(_, item)| {
            item.load.is_some() && item.load.as_deref() == self.cell.book.custody.in_gripper(&arm)
        });
        let mut b = Builder::after(job.steps.len(), true);
        if job.near.is_some() || job.is_displaced() {
            let _out = b.then(Phase::BackOut, None, None);
        }
        if let Some((index, item)) = held {
            let policy = match choice {
                Some(Choice::Held(policy)) => policy,
                _ => job.spec.on_cancel_with_load,
            };
            let slot = docked.then(|| slot_of(&job.spec, item));
            let fixed = Some(PlaceRef::fixed(item.place.clone()));
            let delivery = job.spec.workflow == Workflow::DeliveryAndPlacement;
            let to = match policy {
                OnCancel::Complete => {
                    if delivery {
                        fixed
                    } else {
                        slot
                    }
                }
                OnCancel::ReturnToMr => {
                    if delivery {
                        slot
                    } else {
                        fixed
                    }
                }
                OnCancel::RejectBin => job.spec.reject_slot.clone().map(PlaceRef::fixed),
                OnCancel::Hold => None,
            };
            let Some(to) = to else {
                self.ask_held(job, docked);
                return;
            };
            let _put = b.put(index, &to);
        }
        let on_mr = self.left_on_mobile_robot(job);
        if !on_mr.is_empty() && docked {
            match choice {
                Some(Choice::Repick) => {
                    for index in on_mr {
                        let Some(item) = job.items.get(index) else {
                            continue;
                        };
                        let _clear = b.pick(index, &slot_of(&job.spec, item));
                        let _put = b.put(index, &PlaceRef::fixed(item.place.clone()));
                    }
                }
                Some(Choice::LeaveOnMobileRobot) => {}
                Some(Choice::Held(_)) | None => {
                    self.ask_left(job);
                    return;
                }
            }
        }
        let _dismiss = b.then(Phase::Dismiss, None, None);
        let _close = b.then(Phase::Close, None, None);
        let drop = (0..job.steps.len())
            .filter(|i| job.step(*i).is_some_and(|s| !s.state.is_done()))
            .collect();
        self.emit(Fact::Planned {
            job: job.id,
            steps: b.steps(),
            drop,
            definition: None,
        });
        self.emit(Fact::CompensationMoved {
            job: job.id,
            to: Compensation::Running,
        });
        if let Some(session) = session
            && session.state == SessionState::Faulted
            && docked
            && self.may_resume(job).is_ok()
        {
            self.continue_session(&session);
        }
    }

    /// Loads of workflow B that passed Q1.
    fn left_on_mobile_robot(&self, job: &Job) -> Vec<usize> {
        if job.spec.workflow != Workflow::PickupAndDelivery {
            return Vec::new();
        }
        job.items
            .iter()
            .enumerate()
            .filter(|(_, item)| {
                item.load
                    .as_ref()
                    .and_then(|l| self.cell.book.custody.of(l))
                    .is_some_and(|at| {
                        matches!(at, Location::MobileRobot { mobile_robot, .. }
                        if Some(mobile_robot) == job.mobile_robot.as_ref())
                    })
            })
            .map(|(index, _)| index)
            .collect()
    }

    /// F17.
    fn ask_held(&mut self, job: &Job, docked: bool) {
        let delivery = job.spec.workflow == Workflow::DeliveryAndPlacement;
        let mut answers = Vec::new();
        if delivery || docked {
            answers.push(Answer::Complete);
        }
        if !delivery || docked {
            answers.push(Answer::PutBack);
        }
        if job.spec.reject_slot.is_some() {
            answers.push(Answer::RejectBin);
        }
        answers.push(Answer::SetCustody);
        self.note(
            job.id,
            Fault::CanceledWithLoad,
            "canceled with a load in the gripper",
        );
        self.emit(Fact::CompensationMoved {
            job: job.id,
            to: Compensation::Blocked,
        });
        let known = self.known_of(job);
        let load = job
            .arm
            .as_ref()
            .and_then(|a| self.cell.book.custody.in_gripper(a));
        let load = load.map(str::to_owned);
        self.ask(Ask {
            job: Some(job.id),
            load,
            fault: Fault::CanceledWithLoad,
            question: "The job was canceled with a load in the gripper. Where should it go?".into(),
            known,
            unknown: vec!["what you want with the load".into()],
            answers,
            ..Ask::default()
        });
    }

    fn ask_left(&mut self, job: &Job) {
        self.emit(Fact::CompensationMoved {
            job: job.id,
            to: Compensation::Blocked,
        });
        let known = self.known_of(job);
        self.ask(Ask {
            job: Some(job.id),
            fault: Fault::Canceled,
            question: "The job was canceled with loads on the mobile robot. What about them?"
                .into(),
            known,
            unknown: vec!["whether they should stay on it".into()],
            answers: vec![Answer::SendBack, Answer::Repick],
            ..Ask::default()
        });
    }

    /// Undo of A3 to A7: the mobile robot goes away, or its order is taken back.
    pub(crate) fn dismiss(&mut self, job: &Job, step: usize) {
        let Some(session) = self.cell.session_of(job).cloned() else {
            self.step_to(job, step, StepState::Succeeded, "");
            return;
        };
        if self.cell.book.question_of_session(session.id).is_some() {
            self.step_to(job, step, StepState::Succeeded, "the point stays occupied");
            return;
        }
        match session.state {
            SessionState::Reserved
            | SessionState::AccessPending
            | SessionState::AccessGranted
            | SessionState::Positioned => self.cancel_order(&session),
            SessionState::Docked | SessionState::TransferReady | SessionState::Transferring => {
                self.begin_exit(job, &session, Some("the job was canceled"));
            }
            SessionState::Faulted => match session.faulted {
                Some((from, _)) if from.is_docked() || from == SessionState::ExitGranted => {
                    self.begin_exit(job, &session, Some("the job was canceled"));
                }
                Some(_) | None => self.cancel_order(&session),
            },
            SessionState::TransferDone
            | SessionState::ExitGranted
            | SessionState::Exited
            | SessionState::Canceling
            | SessionState::Released
            | SessionState::Canceled => {}
        }
    }

    /// F2, F13: the same point, a new order. False if that would not help: the transfer has begun, or an arm may be
    /// in the zone.
    pub(crate) fn redispatch(&mut self, job: &Job) -> bool {
        let Some(session) = self.cell.session_of(job).cloned() else {
            return false;
        };
        let clear = self
            .cell
            .setup
            .point(&session.point)
            .is_some_and(|p| !self.cell.arm_may_be_in(p));
        let begun = session.state != SessionState::Reserved;
        if begun && !session.state.may_become(SessionState::Reserved) || !clear {
            return false;
        }
        if let Some(order) = session.order {
            self.tell(&session, Message::MovePermit { granted: false });
            self.tell(&session, Message::CancelOrder { order });
        }
        if session.state != SessionState::Reserved {
            self.move_session(&session, SessionState::Reserved);
        }
        self.emit(Fact::SessionRewound {
            session: session.id,
            to: Rewind::Order,
        });
        self.emit(Fact::Redispatched { job: job.id });
        let again = [
            Phase::Call,
            Phase::Await,
            Phase::Dock,
            Phase::VerifyLoad,
            Phase::VerifyEmpty,
            Phase::Permit,
        ];
        for phase in again {
            self.begin_anew(job, phase, "a new order", |s| s != StepState::Pending);
        }
        true
    }

    /// F13: when it is automatic again, but not where it was, it gets a new order.
    pub(crate) fn redispatch_if_automatic(&mut self, job: &Job) {
        let Some(session) = self.cell.session_of(job).cloned() else {
            return;
        };
        let Some(seen) = self.cell.mobile_seen(&session.mobile_robot).cloned() else {
            return;
        };
        let well = seen.mode.is_automatic() && !seen.errors.iter().any(|e| e.fatal);
        let gone = (session.echoes && seen.order.is_none())
            || session.docked.is_some_and(|d| {
                self.cell
                    .setup
                    .point(&session.point)
                    .is_some_and(|p| !seen.pose.within(&d, p.tolerance))
            });
        let clear = self
            .cell
            .setup
            .point(&session.point)
            .is_some_and(|p| !self.cell.arm_may_be_in(p));
        let ready = job.arm.as_ref().is_some_and(|a| self.cell.arm_ready(a));
        if well
            && gone
            && clear
            && ready
            && !seen.driving
            && job.redispatches < self.cell.setup.timers.redispatches
            && self.cell.ops_of(job.id).next().is_none()
        {
            if !self.redispatch(job) {
                return;
            }
            self.withdraw(job.id, "it gets a new order");
            let text = "the mobile robot is automatic again";
            self.go(
                job.id,
                JobState::Unsuspending,
                Why::Fault {
                    fault: Fault::ModeChanged,
                },
                text,
            );
        }
    }
}
