//! F21: after a start nothing moves until it is known what became of everything. Doing it twice is doing it once (P13).

use crate::book::OpState;
use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::Reply;
use crate::job::{JobState, Why};
use crate::work::Work;

impl Work<'_> {
    pub(crate) fn recover(&mut self) -> Reply {
        self.emit(Fact::Recovered);
        for session in self.open_sessions() {
            // Whoever held a permit of the earlier process holds none now, and is told so.
            self.fault_session_at_boot(&session);
        }
        for id in self.jobs() {
            let Some(job) = self.job(id) else { continue };
            let running = matches!(
                job.state,
                JobState::Starting
                    | JobState::Execute
                    | JobState::Completing
                    | JobState::Unholding
                    | JobState::Unsuspending
            ) || matches!(job.state, JobState::Suspending | JobState::Suspended)
                && matches!(job.why, Why::Awaiting | Why::Course);
            if running {
                self.note(id, Fault::Restarted, "the server was restarted");
                let text = "every operation is being checked";
                self.go(id, JobState::Suspended, Why::Recovering, text);
            }
        }
        let open: Vec<_> = self
            .cell
            .book
            .ops
            .iter()
            .filter(|(id, op)| {
                let asked = self
                    .cell
                    .book
                    .interventions
                    .values()
                    .any(|i| i.is_open() && i.question.op == Some(**id));
                !asked || op.state != OpState::Doubt
            })
            .map(|(id, _)| *id)
            .collect();
        for op in open {
            self.emit(Fact::OpReconciling { op });
        }
        Reply::Done
    }

    fn fault_session_at_boot(&mut self, session: &crate::session::Session) {
        let had_permit = crate::Permit::of(session.state) != crate::Permit::None;
        if had_permit || session.state.is_docked() {
            self.fault_session(session, Fault::Restarted);
        }
    }
}
