//! The queue: by priority, then deadline, then age; a job starts when everything it needs is free at once.

use std::cmp::Reverse;

use crate::claims::{Holder, Resource};
use crate::definition::Definition;
use crate::fact::Fact;
use crate::job::plan::plan;
use crate::job::{Job, JobState, StepState, Why};
use crate::matching::Match;
use crate::work::Work;

impl Work<'_> {
    pub(crate) fn run_queue(&mut self) {
        if !self.cell.live.jobs_may_act {
            return;
        }
        let mut queue: Vec<_> = self
            .cell
            .book
            .jobs
            .values()
            .filter(|j| j.state == JobState::Idle)
            .map(|j| {
                let deadline = j.spec.deadline.unwrap_or(u64::MAX);
                ((Reverse(j.spec.priority), deadline, j.number), j.clone())
            })
            .collect();
        queue.sort_by_key(|(key, _)| *key);
        for (_, job) in queue {
            if let Ok(found) = self.cell.match_job(&job) {
                self.start(&job, found);
                return;
            }
        }
    }

    /// A1, B1: the claims, the session and the plan, in one decision.
    fn start(&mut self, job: &Job, found: Match) {
        let Match {
            arm,
            mobile_robot,
            resources,
        } = found;
        let session = self.ids.next_id();
        let (held, shared): (Vec<_>, Vec<_>) = resources
            .into_iter()
            .partition(|r| matches!(r, Resource::Point(_) | Resource::MobileRobot(_)));
        self.emit(Fact::Claimed {
            by: Holder::Session(session),
            resources: held,
        });
        self.emit(Fact::Claimed {
            by: Holder::Job(job.id),
            resources: shared,
        });
        self.emit(Fact::JobAssigned {
            job: job.id,
            arm: arm.clone(),
            mobile_robot: mobile_robot.clone(),
        });
        self.emit(Fact::SessionOpened {
            session,
            point: job.spec.point.clone(),
            job: job.id,
            mobile_robot,
        });
        self.emit(Fact::Planned {
            job: job.id,
            steps: plan(&job.spec, &job.items),
            drop: Vec::new(),
            definition: Some(Definition::of(job.spec.workflow)),
        });
        self.go(job.id, JobState::Starting, Why::Course, "");
        if let Some(job) = self.job(job.id) {
            self.step_to(&job, 0, StepState::Running, "");
        }
        if let Some(job) = self.job(job.id) {
            self.step_to(&job, 0, StepState::Succeeded, "claimed");
        }
    }
}
