//! F1, F2, F20: a mobile robot that does not answer, does not come, or does not deliver.

use crate::claims::{Holder, Resource};
use crate::fact::Fact;
use crate::faults::Fault;
use crate::intervention::Answer;
use crate::job::phase::Phase;
use crate::job::{Job, JobState, StepState};
use crate::react::Reaction;
use crate::signal::Message;
use crate::work::{Ask, Work};

impl Work<'_> {
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
        let begun = |state| state != StepState::Pending;
        for phase in [Phase::Call, Phase::Await] {
            self.begin_anew(job, phase, "another mobile robot", begun);
        }
        self.emit(Fact::SessionHandedOn {
            session: session.id,
            mobile_robot: other.to_owned(),
        });
    }

    /// F2: once more if it is on its way, then a new order, then a human.
    pub(super) fn arrival_late(&mut self, job: &Job, step: usize) {
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

    /// Whether the mobile robot a job waits for says that it has no order, after it had one.
    pub(crate) fn has_dropped_its_order(&self, job: &Job) -> bool {
        let Some(session) = self.cell.session_of(job) else {
            return false;
        };
        let seen = self.cell.mobile_seen(&session.mobile_robot);
        session.echoes && seen.is_some_and(|seen| seen.order.is_none())
    }
}
