//! Jobs: the state each of them is in, and its plan.

use uuid::Uuid;

use crate::cell::Cell;
use crate::definition::Definition;
use crate::job::{Compensation, JobState, PlannedStep, Step, StepState, Why};

impl Cell {
    pub(super) fn fold_job_moved(&mut self, job: &Uuid, to: JobState, why: &Why, text: &str) {
        self.job_mut(job, |j| {
            j.state = to;
            j.why = why.clone();
            text.clone_into(&mut j.text);
            if to == JobState::Idle {
                (j.steps, j.near, j.session) = (Vec::new(), None, None);
                j.by_hand = None;
                (j.compensation, j.loads_accepted) = (Compensation::None, false);
                j.redispatches = 0;
            }
        });
        if to.is_final() {
            self.book.forget();
        }
    }

    pub(super) fn fold_planned(
        &mut self,
        job: &Uuid,
        steps: &[PlannedStep],
        drop: &[usize],
        definition: Option<&Definition>,
    ) {
        self.job_mut(job, |j| {
            if definition.is_some() {
                j.definition = definition.cloned();
            }
            for index in drop {
                if let Some(step) = j.steps.get_mut(*index) {
                    step.state = StepState::Dropped;
                }
            }
            j.steps.extend(steps.iter().cloned().map(Step::new));
        });
    }
}
