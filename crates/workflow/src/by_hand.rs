//! C10: a human has the arm between two steps of a job, at the pendant. Nothing goes on by itself afterwards, and never
//! with a straight line from where the hand left it.

use crate::fact::Fact;
use crate::faults::Fault;
use crate::intervention::Answer;
use crate::job::phase::Phase;
use crate::job::{Job, JobState, StepState};
use crate::react::Reaction;
use crate::work::{Ask, Work};

impl Work<'_> {
    /// Looks whether a human has, or had, the arm of a job that stands between two motions. True if something was
    /// done about it.
    pub(crate) fn supervise_hand(&mut self, job: &Job, arm: &str) -> bool {
        let busy = self.cell.book.ops.values().any(|op| op.arm == *arm);
        let Some(seen) = self.cell.arm_seen(arm) else {
            return false;
        };
        let (manual, displaced) = (seen.manual, seen.displaced && self.cell.arm_still(arm));
        if busy || !job.is_between_motions() {
            return false;
        }
        let news = match job.by_hand {
            None => manual || displaced,
            // It stands where the question found it until the way out begins; the pendant in between asks anew.
            Some(by) => (displaced && !by.displaced) || (manual && by.decided),
        };
        if news {
            self.emit(Fact::ArmByHand {
                job: job.id,
                displaced,
            });
        }
        let Some(job) = self.job(job.id).filter(|j| j.waits_for_hand()) else {
            return news;
        };
        // Another question is answered first: this one comes as soon as that one is decided.
        if self.cell.book.question_of(job.id).is_some() {
            return news;
        }
        let moved = job.is_displaced();
        let text = if moved {
            format!("arm {arm} was moved by hand")
        } else {
            format!("the pendant of arm {arm} was enabled, or its mode changed")
        };
        let mut known = self.known_of(&job);
        known.push(if moved {
            "after replan it turns to its safe pose at reduced speed, joint by joint and not along a line, and the \
             step begins anew"
                .to_owned()
        } else {
            "it stands where the job left it".to_owned()
        });
        let mut answers = vec![Answer::Replan, Answer::Cancel, Answer::Abort];
        if job.state == JobState::Stopping {
            // It is canceled already.
            answers.retain(|answer| *answer != Answer::Cancel);
        }
        let ask = Ask {
            question: format!("{text}. Is its way free, and should the job go on?"),
            known,
            unknown: vec!["what else was changed by hand".into()],
            answers,
            ..Ask::default()
        };
        self.react(
            &job,
            Reaction {
                fault: Fault::ControlLost,
                text,
                state: Some(JobState::Holding),
                ask: Some(ask),
                ..Reaction::default()
            },
        );
        true
    }

    /// A human said how to go on.
    pub(crate) fn decided_by_hand(&mut self, job: &Job) {
        self.emit(Fact::ArmByHandDecided { job: job.id });
    }

    /// The arm drives out before anything else, unless it is about to.
    pub(crate) fn leave_first(&mut self, job: &Job) {
        let leaves = job
            .steps
            .iter()
            .any(|s| s.plan.phase == Phase::BackOut && s.state == StepState::Running);
        if !leaves {
            self.add_back_out(job);
        }
    }
}
