//! What people ask for and answer, and how the books are judged.

use uuid::Uuid;
use workflow::{
    Action, Answer, Command, Detail, Input, JobState, Location, NewJob, Refusal, Reply,
};

use super::{World, integrator, operator};

impl World {
    pub fn create(&mut self, job: NewJob) -> Uuid {
        match self.input(Input::CreateJob { job: Box::new(job) }) {
            Ok(Reply::Created(id)) => id,
            other => panic!("{other:?}"),
        }
    }

    pub fn state(&self, job: Uuid) -> JobState {
        self.cell.job(self.now, job).unwrap().state
    }

    pub fn command(&mut self, job: Uuid, command: Command) -> Result<Reply, Refusal> {
        self.input(Input::JobCommand {
            job,
            command,
            principal: operator(),
            reason: "test".into(),
        })
    }

    pub fn open_question(&self) -> Option<workflow::view::InterventionView> {
        self.cell.interventions().into_iter().find(|i| i.open)
    }

    pub fn answer(&mut self, answer: Answer, detail: Detail) -> Result<Reply, Refusal> {
        let open = self.open_question().expect("a question");
        self.input(Input::Respond {
            intervention: open.question.id,
            answer,
            detail,
            principal: integrator(),
            reason: "looked".into(),
        })
    }

    /// The books against the truth.
    pub fn judge_custody(&self) {
        for found in self.cell.custody() {
            if matches!(found.load.location, Location::Unknown { .. }) {
                continue;
            }
            let truth = &self.loads[&found.id];
            // A gripper that acts, or a part that fell a moment ago: the books cannot know yet.
            let acting = self
                .cell
                .jobs(self.now)
                .iter()
                .flat_map(|j| &j.steps)
                .any(|s| {
                    s.operation
                        .as_ref()
                        .is_some_and(|o| matches!(o.action, Action::Grip { .. }))
                });
            if acting || matches!(truth, Location::Unknown { .. }) {
                continue;
            }
            let delivered = matches!(truth, Location::Delivered { .. });
            assert!(
                *truth == found.load.location || delivered,
                "{} is at {truth}, booked at {}\n{}",
                found.id,
                found.load.location,
                self.story()
            );
        }
    }

    /// Runs a job to COMPLETE, or says why not.
    pub fn complete(&mut self, job: Uuid) {
        let ok = self.run(120_000, |w| w.state(job) == JobState::Complete);
        assert!(
            ok,
            "{:?} {:?}\n{}",
            self.state(job),
            self.open_question(),
            self.story()
        );
        self.judge_custody();
    }
}
