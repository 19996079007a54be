//! Motions in doubt, and what a person says about them: once, with a reason, for good.

use std::sync::Arc;

use api::{
    AllowedAnswer, DecisionBody, DoubtAnswer, Intervention, InterventionDecision, InterventionKind,
    InterventionState, ProblemCode,
};
use jiff::Timestamp;
use journal::{
    Answer, Arrival, Decision, DecisionId, Digest, MotionId, MotionStory, NoMotion, Outcome,
    ReadError, Record as Entry, Refusal, Subject,
};
use thiserror::Error;
use uuid::Uuid;

use super::record::{End, Progress, Record, evidence, point_of_thousandths};
use super::{Motions, RequestKey, intent};
use crate::config::RobotPlan;
use crate::journal::Trouble;
use crate::wire_bodies::pose_body;

/// A person's answer about a motion in doubt.
#[derive(Clone, Debug)]
pub(crate) struct Respond {
    pub(crate) motion: Uuid,
    pub(crate) answer: DoubtAnswer,
    pub(crate) principal: Arc<str>,
    pub(crate) reason: String,
    /// The same for the same request.
    pub(crate) decision: Uuid,
}

/// Whether an answer was taken now or before.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Responded {
    Now,
    Before,
}

/// Why an answer was not taken.
#[derive(Debug, Error)]
pub(crate) enum RespondError {
    #[error("the robot has no such motion")]
    NoSuchMotion,
    #[error("the motion is not in doubt")]
    NotInDoubt,
    #[error("somebody answered before")]
    Answered(Option<DecisionBody>),
    #[error(transparent)]
    Journal(Trouble),
    #[error(transparent)]
    Read(ReadError),
}

impl Respond {
    /// The name of a decision: the same request has the same name, so that it is taken once.
    pub(crate) fn name(
        key: &RequestKey,
        principal: &str,
        motion: Uuid,
        answer: DoubtAnswer,
        reason: &str,
    ) -> Uuid {
        let text = format!(
            "{principal}\0{}\0{motion}\0{answer:?}\0{reason}",
            key.as_str()
        );
        let mut bytes = [0; 16];
        for (byte, digest) in bytes.iter_mut().zip(Digest::of(text.as_bytes()).as_bytes()) {
            *byte = *digest;
        }
        uuid::Builder::from_custom_bytes(bytes).into_uuid()
    }
}

impl Motions {
    /// Takes a person's answer: the decision is durable before anything follows from it.
    ///
    /// It goes on where the caller goes away.
    pub(crate) async fn respond(
        self: &Arc<Self>,
        respond: Respond,
    ) -> Result<Responded, RespondError> {
        let this = Arc::clone(self);
        let task = self
            .tracker
            .spawn(async move { this.respond_alone(respond).await });
        task.await.unwrap_or_else(|_panicked| {
            let text = "the server failed while it kept the answer".to_owned();
            Err(RespondError::Journal(Trouble::Unavailable(text)))
        })
    }

    async fn respond_alone(&self, respond: Respond) -> Result<Responded, RespondError> {
        let Respond {
            motion,
            answer,
            principal,
            reason,
            decision,
        } = respond;
        let Some(record) = self.find(motion).await.map_err(RespondError::Read)? else {
            return Err(RespondError::NoSuchMotion);
        };
        if record.decision.is_none() && !record.progress.is_in_doubt() {
            return Err(RespondError::NotInDoubt);
        }
        let said = Decision {
            decision: DecisionId(decision),
            subject: Subject::Motion(MotionId(motion)),
            answer: match answer {
                DoubtAnswer::Happened => Answer::Happened,
                DoubtAnswer::DidNotHappen => Answer::DidNotHappen,
                DoubtAnswer::Abort => Answer::AbortJob,
            },
            principal: principal.to_string(),
            reason,
        };
        let now = self.clock.now();
        match self.journal.append(now, Entry::Decision(said)).await {
            Ok(_kept) => {}
            Err(Trouble::Refused(Refusal::MotionPhase { .. })) => {
                return self.answered_before(motion, decision).await;
            }
            Err(trouble) => return Err(RespondError::Journal(trouble)),
        }
        let story = self.journal.motion(MotionId(motion)).await;
        if let Some(story) = story.map_err(RespondError::Read)? {
            self.apply_decision(&record, &story).await;
        }
        Ok(Responded::Now)
    }

    /// Whether the decision that was taken is the one that is asked for again.
    async fn answered_before(
        &self,
        motion: Uuid,
        decision: Uuid,
    ) -> Result<Responded, RespondError> {
        let story = self.journal.motion(MotionId(motion)).await;
        let story = story.map_err(RespondError::Read)?;
        let Some(taken) = story.and_then(|story| story.decision) else {
            return Err(RespondError::NotInDoubt);
        };
        if let Entry::Decision(known) = &taken.record
            && known.decision.0 == decision
        {
            return Ok(Responded::Before);
        }
        Err(RespondError::Answered(intent::decision_of(&taken)))
    }

    /// Writes and shows the end that follows from a decision. Doing it twice changes nothing.
    pub(super) async fn apply_decision(&self, record: &Record, story: &MotionStory) {
        let Some(stored) = &story.decision else {
            return;
        };
        let (Entry::Decision(decision), Some(body)) = (&stored.record, intent::decision_of(stored))
        else {
            return;
        };
        let (kept, end) = end_after(decision, record);
        let outcome = Entry::Outcome(Outcome {
            motion: MotionId(record.id),
            end: kept,
        });
        if let Err(trouble) = self.journal.append(stored.at.wall, outcome).await {
            tracing::error!(
                motion = %record.id,
                error = %trouble,
                "the end that follows from a decision could not be kept; the next start does it"
            );
        }
        tracing::warn!(
            robot.id = self.plan.id,
            motion = %record.id,
            answer = ?body.answer,
            principal = body.principal,
            "a motion in doubt was decided"
        );
        let at = self.clock.now();
        self.book.amend(record.id, |record| {
            record.progress = Progress::Ended { at, end };
            record.decision = Some(body);
        });
    }
}

fn end_after(decision: &Decision, record: &Record) -> (journal::End, End) {
    let seen = record.progress.end().and_then(End::seen).cloned();
    let name = decision.decision;
    match decision.answer {
        Answer::Happened => (
            journal::End::Done {
                evidence: Arrival::Decided { decision: name },
            },
            End::Succeeded {
                seen: seen.map(Arc::new),
            },
        ),
        Answer::DidNotHappen => (
            journal::End::NotExecuted {
                evidence: NoMotion::Decided { decision: name },
            },
            End::NotExecuted {
                code: record
                    .progress
                    .end()
                    .and_then(End::code)
                    .unwrap_or(ProblemCode::InDoubt),
                why: Some("a person says that it was not executed".into()),
            },
        ),
        Answer::AbortJob => (
            journal::End::Interrupted {
                reason: ProblemCode::MotionInterrupted.as_str().to_owned(),
                seen: seen.clone(),
            },
            End::Interrupted {
                code: ProblemCode::MotionInterrupted,
                seen: seen.map(Arc::new),
            },
        ),
    }
}

/// A motion in doubt as something to decide.
pub(crate) fn intervention(plan: &RobotPlan, record: &Record) -> Option<Intervention> {
    let end = record.progress.end()?;
    if !record.progress.is_in_doubt() && record.decision.is_none() {
        return None;
    }
    let allowed = |answer: &str, consequence: &str| AllowedAnswer {
        answer: answer.to_owned(),
        consequence: consequence.to_owned(),
        role: None,
        needs: None,
    };
    Some(Intervention {
        id: record.id,
        kind: InterventionKind::MotionInDoubt,
        state: match record.decision {
            None => InterventionState::Open,
            Some(_) => InterventionState::Answered,
        },
        cell: plan.cell.clone(),
        robot: Some(plan.id.clone()),
        motion: Some(record.id),
        job: None,
        session: None,
        load: None,
        fault: None,
        opened_at: opened_at(record),
        question: "Did the arm move to the target? The server cannot tell. Look at the arm before answering; until \
                   then it takes no further motion of this robot."
            .to_owned(),
        known: Vec::new(),
        unknown: Vec::new(),
        code: end.code(),
        target: Some(pose_body(&point_of_thousandths(record.asked.point))),
        controller_text: end.controller_text().map(str::to_owned),
        evidence: end
            .seen()
            .and_then(|seen| evidence(seen, record.asked.point)),
        allowed: vec![
            allowed(
                "happened",
                "the motion ends `succeeded`: the arm was seen at the target, standing still",
            ),
            allowed(
                "did_not_happen",
                "the motion ends `not_executed`: the arm did not move. It is not sent again",
            ),
            allowed(
                "abort",
                "the motion ends `failed`: the arm is somewhere else. Where, has to be looked at before it moves",
            ),
        ],
        decision: record.decision.as_ref().map(|decision| InterventionDecision {
            answer: match decision.answer {
                DoubtAnswer::Happened => "happened",
                DoubtAnswer::DidNotHappen => "did_not_happen",
                DoubtAnswer::Abort => "abort",
            }
            .to_owned(),
            principal: decision.principal.clone(),
            reason: decision.reason.clone(),
            at: Some(decision.at),
        }),
        withdrawn: None,
    })
}

fn opened_at(record: &Record) -> Timestamp {
    if let Progress::Ended { at, .. } = &record.progress {
        *at
    } else {
        record.created_at
    }
}
