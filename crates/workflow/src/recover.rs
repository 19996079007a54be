//! F21: after a start nothing moves until it is known what became of everything. Doing it twice is doing it once (P13).

use crate::book::OpState;
use crate::definition::Definition;
use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::Reply;
use crate::intervention::Answer;
use crate::job::{Job, JobState, Why};
use crate::react::Reaction;
use crate::work::{Ask, Work};

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
            if self.other_definition(&job) {
                continue;
            }
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

    /// P15: what another program planned may mean something else here. True if a person is asked.
    fn other_definition(&mut self, job: &Job) -> bool {
        let now = Definition::of(job.spec.workflow);
        let Some(then) = job.definition.clone().filter(|then| *then != now) else {
            return false;
        };
        let goes_on = !matches!(
            job.state,
            JobState::Stopping | JobState::Aborting | JobState::Aborted | JobState::Clearing
        );
        if !goes_on || self.cell.book.question_of(job.id).is_some() {
            return false;
        }
        let text = format!("the job was planned by {then} of its workflow, this program has {now}");
        let mut known = self.known_of(job);
        known.push(text.clone());
        let ask = Ask {
            question: format!("{text}. How should the job go on?"),
            known,
            unknown: vec!["whether its steps mean the same in both".into()],
            answers: vec![Answer::Resume, Answer::Cancel, Answer::Abort],
            ..Ask::default()
        };
        self.react(
            job,
            Reaction {
                fault: Fault::Restarted,
                text: text.clone(),
                ask: Some(ask),
                ..Reaction::default()
            },
        );
        if !matches!(job.state, JobState::Held | JobState::Holding) {
            let fault = Fault::Restarted;
            self.go(job.id, JobState::Holding, Why::Fault { fault }, text);
        }
        true
    }

    /// P15: a person lets it go on as this program understands it.
    pub(crate) fn accept_definition(&mut self, job: &Job) {
        let now = Definition::of(job.spec.workflow);
        if job.definition.as_ref().is_some_and(|then| *then != now) {
            self.emit(Fact::Planned {
                job: job.id,
                steps: Vec::new(),
                drop: Vec::new(),
                definition: Some(now),
            });
        }
    }

    fn fault_session_at_boot(&mut self, session: &crate::session::Session) {
        let had_permit = crate::Permit::of(session.state) != crate::Permit::None;
        if had_permit || session.state.is_docked() {
            self.fault_session(session, Fault::Restarted);
        }
    }
}
