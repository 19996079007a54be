//! What an event is about, where the record itself does not say: which job a session is of, what a step is.

use std::collections::BTreeMap;

use uuid::Uuid;
use workflow::{Cell, Fact, JobState, Phase, Workflow};

/// As many of each kind as the state machines remember, and room for those that are going on.
const MOST: usize = 512;

/// The story so far, as far as sentences need it.
#[derive(Clone, Debug, Default)]
pub(super) struct Known {
    jobs: BTreeMap<Uuid, Job>,
    sessions: BTreeMap<Uuid, Session>,
    /// Operations and questions: the jobs they belong to.
    parts: BTreeMap<Uuid, Uuid>,
}

#[derive(Clone, Debug)]
struct Job {
    number: u64,
    workflow: Workflow,
    phases: Vec<Phase>,
}

#[derive(Clone, Debug)]
pub(super) struct Session {
    pub(super) job: Uuid,
    pub(super) point: String,
    pub(super) mobile_robot: String,
}

impl Known {
    /// What a cell remembers now.
    pub(super) fn learn_from(&mut self, cell: &Cell) {
        for job in cell.jobs(0) {
            let known = Job {
                number: job.number,
                workflow: job.spec.workflow,
                phases: job.steps.iter().map(|step| step.phase).collect(),
            };
            insert(&mut self.jobs, job.id, known);
            for operation in job.steps.into_iter().filter_map(|step| step.operation) {
                insert(&mut self.parts, operation.op, job.id);
            }
        }
        for session in cell.sessions(0) {
            let known = Session {
                job: session.job,
                point: session.point,
                mobile_robot: session.mobile_robot,
            };
            insert(&mut self.sessions, session.id, known);
        }
        for question in cell.interventions() {
            if let Some(job) = question.question.job {
                insert(&mut self.parts, question.question.id, job);
            }
        }
    }

    /// What a fact adds.
    pub(super) fn learn(&mut self, fact: &Fact) {
        // Facts that add nothing are the most.
        if let Fact::JobCreated { job, spec, .. } = fact {
            let number = self.jobs.values().map(|job| job.number).max().unwrap_or(0) + 1;
            let known = Job {
                number,
                workflow: spec.workflow,
                phases: Vec::new(),
            };
            insert(&mut self.jobs, *job, known);
        } else if let Fact::Planned { job, steps, .. } = fact
            && let Some(job) = self.jobs.get_mut(job)
        {
            job.phases.extend(steps.iter().map(|step| step.phase));
        } else if let Fact::JobMoved {
            job,
            to: JobState::Idle,
            ..
        } = fact
            && let Some(job) = self.jobs.get_mut(job)
        {
            job.phases.clear();
        } else if let Fact::SessionOpened {
            session,
            point,
            job,
            mobile_robot,
        } = fact
        {
            let known = Session {
                job: *job,
                point: point.clone(),
                mobile_robot: mobile_robot.clone(),
            };
            insert(&mut self.sessions, *session, known);
        } else if let Fact::SessionHandedOn {
            session,
            mobile_robot,
        } = fact
            && let Some(session) = self.sessions.get_mut(session)
        {
            session.mobile_robot.clone_from(mobile_robot);
        } else if let Fact::OpStarted { op, job, .. } = fact {
            insert(&mut self.parts, *op, *job);
        } else if let Fact::Asked { question } = fact
            && let Some(job) = question.job
        {
            insert(&mut self.parts, question.id, job);
        }
    }

    pub(super) fn session(&self, id: &Uuid) -> Option<&Session> {
        self.sessions.get(id)
    }

    /// The job of an operation or a question.
    pub(super) fn job_of(&self, part: &Uuid) -> Option<Uuid> {
        self.parts.get(part).copied()
    }

    /// A step in words: `A8 APPROACH`.
    pub(super) fn step(&self, job: &Uuid, step: usize) -> String {
        let known = self.jobs.get(job);
        match known.and_then(|job| Some((job.phases.get(step)?, job.workflow))) {
            Some((phase, workflow)) => {
                format!("{} {}", phase.code(workflow), crate::words::word(phase))
            }
            None => format!("step {step}"),
        }
    }
}

/// Ids sort by creation, so the oldest one makes room.
fn insert<T>(all: &mut BTreeMap<Uuid, T>, id: Uuid, value: T) {
    let _before = all.insert(id, value);
    while all.len() > MOST {
        let _oldest = all.pop_first();
    }
}
