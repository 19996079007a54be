//! What became of an operation, in the workflows' words.

use std::sync::Arc;

use api::{DoubtAnswer, ProblemCode};
use tokio::time::{Instant, timeout};
use uuid::Uuid;
use workflow::OpResult;

use super::super::arm::Operation;
use super::{CLOSE_OUTPUT, CLOSED_INPUT, FOREVER, GRIP, MotionArm, OPEN_INPUT, PART_INPUT};
use crate::motions::{End, Progress, Respond};
use crate::problem::Problem;

impl MotionArm {
    pub(super) async fn follow(&self, motion: Uuid) -> OpResult {
        let motions = &self.robot.motions;
        let limit = Instant::now() + FOREVER;
        let ended = motions
            .book
            .wait(motion, limit, |progress| progress.end().is_some())
            .await;
        let record = match ended {
            Some(record) => record,
            None => match motions.find(motion).await {
                Ok(Some(record)) => record,
                Ok(None) | Err(_) => {
                    return OpResult::InDoubt {
                        text: format!("what became of motion {motion} is not known"),
                    };
                }
            },
        };
        if let Progress::Ended { end, .. } = &record.progress {
            result_of(end)
        } else {
            OpResult::InDoubt {
                text: format!("motion {motion} has no end"),
            }
        }
    }

    /// The gripper's own inputs say what a level came to.
    pub(super) async fn gripped(&self, ended: OpResult) -> OpResult {
        if ended != OpResult::Arrived {
            return ended;
        }
        let mut views = self.link.watch();
        let limit = GRIP.div_f64(self.robot.plan.time_scale.max(0.01));
        let first = views.borrow().status.map(|seen| seen.count);
        let settled = async {
            loop {
                let line = views.borrow_and_update().status;
                if let Some(seen) = line {
                    let closing = seen.line.output(CLOSE_OUTPUT);
                    let input = if closing { CLOSED_INPUT } else { OPEN_INPUT };
                    // A line of before the level was set tells nothing.
                    if Some(seen.count) != first && seen.line.input(input) {
                        return;
                    }
                }
                if views.changed().await.is_err() {
                    return;
                }
            }
        };
        let _in_time = timeout(limit, settled).await;
        match self.link.view().status {
            Some(seen) => OpResult::Gripped {
                closed: seen.line.input(CLOSED_INPUT),
                open: seen.line.input(OPEN_INPUT),
                part_present: seen.line.input(PART_INPUT),
            },
            None => OpResult::InDoubt {
                text: "the gripper's inputs cannot be read".to_owned(),
            },
        }
    }

    /// The cell goes on, so what was in doubt has been decided there, by a person where one was needed.
    pub(super) async fn settle_doubt(&self, operation: &Operation) {
        let motions = &self.robot.motions;
        for doubt in motions.book.doubts() {
            if &*doubt.principal != self.control.actor() {
                continue;
            }
            let respond = Respond {
                motion: doubt.id,
                answer: DoubtAnswer::Abort,
                principal: Arc::from(self.control.actor()),
                reason: "decided by the job's own intervention or reconciliation".to_owned(),
                decision: operation.op,
            };
            if let Err(error) = motions.respond(respond).await {
                tracing::warn!(motion = %doubt.id, %error, "a doubt that was decided stays open");
            }
        }
    }
}

pub(super) fn result_of(end: &End) -> OpResult {
    let why = || match (end.why(), end.code()) {
        (Some(why), _) => why.to_owned(),
        (None, Some(code)) => code.title().to_owned(),
        (None, None) => String::new(),
    };
    match end {
        End::Succeeded { .. } => OpResult::Arrived,
        End::Rejected { text, .. } => OpResult::Rejected {
            text: text.to_string(),
        },
        End::NotExecuted { .. } => OpResult::NotExecuted { text: why() },
        End::Interrupted { .. } => OpResult::Interrupted { text: why() },
        End::Accepted | End::InDoubt { .. } => OpResult::InDoubt { text: why() },
    }
}

pub(super) fn not_now(problem: &Problem) -> OpResult {
    let text = problem.detail().to_owned();
    // The arm cannot do it, now or later.
    let never = matches!(
        problem.code(),
        ProblemCode::Validation
            | ProblemCode::JointLimitExceeded
            | ProblemCode::OutOfWorkspace
            | ProblemCode::Singularity
            | ProblemCode::NoSolutionInConfiguration
    );
    if never {
        OpResult::Rejected { text }
    } else {
        OpResult::NotExecuted { text }
    }
}
