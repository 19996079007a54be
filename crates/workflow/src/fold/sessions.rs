//! Hand-over sessions: the state each of them is in, and whose it is.

use uuid::Uuid;

use crate::cell::Cell;
use crate::fact::Rewind;
use crate::faults::Fault;
use crate::session::SessionState;

impl Cell {
    pub(super) fn fold_handed_on(&mut self, session: &Uuid, mobile_robot: &str) {
        let job = self.book.sessions.get(session).map(|s| s.job);
        self.session_mut(session, |s| {
            mobile_robot.clone_into(&mut s.mobile_robot);
            s.rewind(Rewind::Order);
        });
        if let Some(job) = job {
            self.job_mut(&job, |j| j.mobile_robot = Some(mobile_robot.to_owned()));
        }
    }

    pub(super) fn fold_rewound(&mut self, session: &Uuid, to: Rewind) {
        self.session_mut(session, |s| s.rewind(to));
        let robot = self.book.sessions.get(session);
        if let Some(robot) = robot.map(|s| s.mobile_robot.clone()) {
            self.forget_jump(&robot);
        }
    }

    pub(super) fn fold_session_moved(
        &mut self,
        session: &Uuid,
        to: SessionState,
        fault: Option<Fault>,
    ) {
        self.session_mut(session, |s| {
            if to == SessionState::Faulted {
                let from = s.faulted.map_or(s.state, |(from, _)| from);
                s.faulted = Some((from, fault.unwrap_or(Fault::NoAnswer)));
            } else {
                s.faulted = None;
            }
            (s.state, s.resends) = (to, 0);
        });
        if to.is_closed() {
            self.book.forget();
        }
    }
}
