//! What a mobile robot is told in the course of a job: to come, that it may be entered, and to leave.

use crate::fact::Fact;
use crate::job::params::Workflow;
use crate::job::{Item, Job};
use crate::session::{Session, SessionState};
use crate::signal::Message;
use crate::work::Work;

impl Work<'_> {
    /// A3, B3: the order. Sending it again is sending the same one.
    pub(crate) fn send_order(&mut self, session: &Session) {
        let (order, update) = match session.order {
            Some(order) => (order, session.update),
            None => (self.ids.next_id(), 1),
        };
        self.emit(Fact::SessionOrdered {
            session: session.id,
            order,
            update,
        });
        let point = self.cell.setup.point(&session.point).cloned();
        let job = self.job(session.job);
        let then_to = job.as_ref().and_then(|j| j.spec.destination.clone());
        // What it brings is for the arm; it takes to the destination what the arm puts on it, and nothing else.
        let unload = job
            .filter(|_| then_to.is_some())
            .map(|j| j.items.iter().map(Item::in_slot).collect());
        self.tell(
            session,
            Message::TransportOrder {
                order,
                update,
                goal: session.point.clone(),
                dock: point.as_ref().map(|p| p.dock),
                route: point.map(|p| p.route).unwrap_or_default(),
                then_to,
                unload,
            },
        );
    }

    /// Whether the mobile robot says that an earlier order is not over.
    pub(crate) fn works_on_another(&self, session: &Session) -> bool {
        self.cell
            .mobile_seen(&session.mobile_robot)
            .is_some_and(|seen| seen.order.is_some() && seen.order != session.order)
    }

    /// A7, B8: everything the arm needs to enter.
    pub(crate) fn grant_entry(&mut self, session: &Session) {
        if session.state == SessionState::Docked
            && session.ready
            && self.cell.dock_evidence(session).is_ok()
        {
            self.move_session(session, SessionState::TransferReady);
            let Some(session) = self.session(session.id) else {
                return;
            };
            self.move_session(&session, SessionState::Transferring);
            self.tell(&session, Message::CellReady);
        }
    }

    /// A15, B13: the arm is out; the mobile robot may go, and in B it is told where to.
    pub(crate) fn begin_exit(&mut self, job: &Job, session: &Session, failed: Option<&str>) {
        self.move_session(session, SessionState::TransferDone);
        if let Some(reason) = failed {
            self.tell(
                session,
                Message::TransferFailed {
                    reason: reason.to_owned(),
                },
            );
            return;
        }
        self.tell(session, Message::TransferDone);
        if let (Workflow::PickupAndDelivery, Some(destination), Some(order)) =
            (job.spec.workflow, &job.spec.destination, session.order)
        {
            // The leaving edge was in the horizon until now; this update releases it.
            let update = session.update + 1;
            self.emit(Fact::SessionOrdered {
                session: session.id,
                order,
                update,
            });
            self.tell(
                session,
                Message::TransportOrder {
                    order,
                    update,
                    goal: destination.clone(),
                    dock: None,
                    route: Vec::new(),
                    then_to: None,
                    unload: Some(self.cell.to_unload(job, &session.mobile_robot)),
                },
            );
            self.emit(Fact::TransportBegun {
                mobile_robot: session.mobile_robot.clone(),
                job: job.id,
                order,
                destination: destination.clone(),
                session: Some(session.id),
                update,
            });
        }
    }
}
