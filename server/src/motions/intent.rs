//! Between a motion here and its records in the journal.

use std::borrow::Cow;
use std::sync::Arc;

use api::{DecisionBody, DoubtAnswer, MotionType, ProblemCode};
use journal::{
    Answer, Arrival, Claim, Completion, Decision, Intent, MotionId, MotionStory, NoMotion, Outcome,
    Record as Entry, Repeatability, Stored,
};
use kinematics::PendantJoints;
use uuid::Uuid;

use super::record::{Asked, End, Progress, Record, Speed, target_of, thousandths_of};
use super::{Door, Motions, book};
use crate::request_id::RequestId;

impl Motions {
    pub(super) fn intent(
        &self,
        id: Uuid,
        entry: &book::Entry,
        door: &Door,
        claim: Option<Claim>,
    ) -> Intent {
        let asked = &entry.asked;
        let (speed_um_s, speed_percent) = match asked.speed {
            Speed::MmPerSec(speed) => (u32::from(speed) * 1_000, None),
            Speed::Percent(percent) => (0, Some(percent)),
        };
        Intent {
            motion: MotionId(id),
            cell: self.plan.cell.clone(),
            robot: self.plan.id.clone(),
            epoch: self.journal.epoch(),
            seq: door.number,
            target: target_of(asked.point),
            speed_um_s,
            // Every motion of the API is to an absolute pose; a relative one was resolved before it came here.
            class: match asked.output {
                Some(_) => Repeatability::LevelIo,
                None => Repeatability::AbsoluteFree,
            },
            request_id: entry.request_id.to_string(),
            claim,
            job: None,
            reason: entry.reason.clone(),
            asked: Some(Box::new(journal::Asked {
                motion_type: type_name(asked.motion_type).to_owned(),
                principal: entry.principal.to_string(),
                joints_mdeg: asked.joints.degrees().map(mdeg),
                speed_percent,
                not_after: entry.not_after,
                wire_epoch: door.wire_epoch,
                boot: door.boot,
                to_joints: asked.to_joints,
                output: asked.output,
                from: asked.from.map(target_of),
            })),
        }
    }
}

/// The record of an acceptance whose end will be known.
pub(super) fn taken(id: Uuid) -> Entry {
    Entry::Accepted(journal::Accepted {
        motion: MotionId(id),
        text: "ACK".to_owned(),
        completion: Completion::Observable,
    })
}

/// The record of an end.
pub(super) fn ended(id: Uuid, end: &End) -> Entry {
    let end = match end {
        // The acceptance is the last word.
        End::Accepted => {
            return Entry::Accepted(journal::Accepted {
                motion: MotionId(id),
                text: protocol::Reply::Accepted.text().to_owned(),
                completion: Completion::NotObservable,
            });
        }
        End::Succeeded { seen: Some(seen) } => journal::End::Done {
            evidence: Arrival::Observed((**seen).clone()),
        },
        // There is no success without evidence: this one comes from a decision, which writes its own record.
        End::Succeeded { seen: None } => journal::End::InDoubt {
            code: ProblemCode::Internal.as_str().to_owned(),
            text: None,
            seen: None,
        },
        End::Rejected { text, .. } => journal::End::Rejected {
            text: text.to_string(),
        },
        End::NotExecuted { code, .. } => journal::End::NotExecuted {
            evidence: NoMotion::NotSent {
                code: code.as_str().to_owned(),
            },
        },
        End::Interrupted { code, seen } => journal::End::Interrupted {
            reason: code.as_str().to_owned(),
            seen: seen.as_deref().cloned(),
        },
        End::InDoubt {
            code, text, seen, ..
        } => journal::End::InDoubt {
            code: code.as_str().to_owned(),
            text: text.clone(),
            seen: seen.as_deref().cloned(),
        },
    };
    Entry::Outcome(Outcome {
        motion: MotionId(id),
        end,
    })
}

/// The motion a story is of, as far as this program can show it.
pub(super) fn restored(story: &MotionStory) -> Option<Record> {
    let Entry::Intent(intent) = &story.intent.record else {
        return None;
    };
    let more = intent.asked.as_deref()?;
    let asked = Asked {
        motion_type: type_of(&more.motion_type)?,
        point: thousandths_of(&intent.target),
        speed: match more.speed_percent {
            Some(percent) => Speed::Percent(percent),
            None => Speed::MmPerSec(u16::try_from(intent.speed_um_s / 1_000).ok()?),
        },
        joints: PendantJoints::from_degrees(more.joints_mdeg.map(degrees)),
        to_joints: more.to_joints,
        output: more.output,
        from: more.from.as_ref().map(thousandths_of),
    };
    Some(Record {
        id: intent.motion.0,
        asked,
        created_at: story.intent.at.wall,
        request_id: RequestId::recorded(&intent.request_id),
        principal: Arc::from(more.principal.as_str()),
        reason: intent.reason.clone(),
        not_after: more.not_after,
        progress: progress_of(story),
        decision: story.decision.as_ref().and_then(decision_of),
        in_journal: true,
    })
}

/// How far the journal knows a motion has come.
fn progress_of(story: &MotionStory) -> Progress {
    if let Some(Stored {
        record: Entry::Outcome(outcome),
        at,
        ..
    }) = &story.outcome
    {
        return Progress::Ended {
            at: at.wall,
            end: end_of(&outcome.end),
        };
    }
    match &story.accepted {
        Some(Stored {
            record: Entry::Accepted(accepted),
            at,
            ..
        }) => match accepted.completion {
            Completion::NotObservable => Progress::Ended {
                at: at.wall,
                end: End::Accepted,
            },
            Completion::Observable => Progress::Accepted,
        },
        // An intent and nothing else: it may have been sent.
        Some(_) | None => Progress::Dispatched,
    }
}

fn end_of(end: &journal::End) -> End {
    match end {
        journal::End::Done { evidence } => End::Succeeded {
            seen: match evidence {
                Arrival::Observed(seen) => Some(Arc::new(seen.clone())),
                Arrival::Decided { .. } => None,
            },
        },
        journal::End::Rejected { text } => End::Rejected {
            text: Cow::Owned(text.clone()),
            code: ProblemCode::ControllerRejected,
        },
        journal::End::NotExecuted { evidence } => End::NotExecuted {
            code: match evidence {
                NoMotion::NotSent { code } => code_of(code),
                NoMotion::Observed(_) | NoMotion::Decided { .. } => ProblemCode::ServerRestarted,
            },
            why: None,
        },
        journal::End::Interrupted { reason, seen } => End::Interrupted {
            code: code_of(reason),
            seen: seen.clone().map(Arc::new),
        },
        journal::End::InDoubt { code, text, seen } => End::InDoubt {
            code: code_of(code),
            text: text.clone(),
            why: None,
            seen: seen.clone().map(Arc::new),
        },
    }
}

/// A code of the journal; one this program does not know was written by a newer one.
fn code_of(text: &str) -> ProblemCode {
    ProblemCode::of_str(text).unwrap_or(ProblemCode::Internal)
}

pub(super) fn decision_of(stored: &Stored) -> Option<DecisionBody> {
    let Entry::Decision(Decision {
        answer,
        principal,
        reason,
        ..
    }) = &stored.record
    else {
        return None;
    };
    Some(DecisionBody {
        answer: match answer {
            Answer::Happened => DoubtAnswer::Happened,
            Answer::DidNotHappen => DoubtAnswer::DidNotHappen,
            Answer::AbortJob => DoubtAnswer::Abort,
        },
        principal: principal.clone(),
        reason: reason.clone(),
        at: stored.at.wall,
    })
}

const TYPES: [(MotionType, &str); 5] = [
    (MotionType::Joint, "JOINT"),
    (MotionType::Home, "HOME"),
    (MotionType::Linear, "LINEAR"),
    (MotionType::Relative, "RELATIVE"),
    (MotionType::Output, "OUTPUT"),
];

fn type_name(motion_type: MotionType) -> &'static str {
    match motion_type {
        MotionType::Joint => "JOINT",
        MotionType::Home => "HOME",
        MotionType::Linear => "LINEAR",
        MotionType::Relative => "RELATIVE",
        MotionType::Output => "OUTPUT",
    }
}

fn type_of(name: &str) -> Option<MotionType> {
    let known = TYPES.iter().find(|(_, known)| *known == name);
    known.map(|(motion_type, _)| *motion_type)
}

/// A joint value that passed the limits, in thousandths of a degree.
pub(super) fn mdeg(degrees: f64) -> i32 {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "joints within their limits are far inside; a cast saturates"
    )]
    let value = (degrees * 1000.0).round() as i32;
    value
}

pub(super) fn degrees(mdeg: i32) -> f64 {
    f64::from(mdeg) / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_of_motion_has_a_name_that_leads_back_to_it() {
        for (motion_type, name) in TYPES {
            assert_eq!(type_name(motion_type), name);
            assert_eq!(type_of(name), Some(motion_type));
            assert_eq!(
                serde_json::to_value(motion_type).unwrap(),
                serde_json::Value::from(name)
            );
        }
        assert_eq!(type_of("SPIRAL"), None);
    }
}
