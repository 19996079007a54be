//! Motions and what else is in the journal beside the decisions of the state machines.

use journal::{AuditResult, End, Intent, MotionId, Record, Subject};
use serde_json::{Map, Value, json};

/// What such a record is as an event.
pub(super) struct Noted {
    pub(super) kind: &'static str,
    pub(super) text: String,
    pub(super) subject: Option<String>,
    pub(super) more: Map<String, Value>,
}

/// The motion whose cell has to be known to tell of a record.
pub(super) fn motion_of(record: &Record) -> Option<MotionId> {
    match record {
        Record::Accepted(accepted) => Some(accepted.motion),
        Record::Outcome(outcome) => Some(outcome.motion),
        Record::Decision(decision) => match decision.subject {
            Subject::Motion(motion) => Some(motion),
            Subject::Job(_) => None,
        },
        Record::Intent(_)
        | Record::ServerStarted(_)
        | Record::JobCreated(_)
        | Record::JobStep(_)
        | Record::JobEnded(_)
        | Record::SignalReceived(_)
        | Record::Audit(_)
        | Record::CellDecided(_)
        | Record::SnapshotTaken(_)
        | Record::Pruned(_) => None,
    }
}

/// The event a record is. `intent` is the beginning of its motion, where it has one.
pub(super) fn of_record(record: &Record, intent: Option<&Intent>) -> Option<Noted> {
    let robot = intent.map_or("", |intent| &*intent.robot);
    let noted = match record {
        Record::Intent(intent) => motion(
            "robocell.motion.intended",
            intent.motion,
            format!("a motion of {} is about to be sent", intent.robot),
        ),
        Record::Accepted(accepted) => motion(
            "robocell.motion.accepted",
            accepted.motion,
            format!("{robot} took its motion: {}", accepted.text),
        ),
        Record::Outcome(outcome) => {
            let (kind, text) = outcome_in_words(robot, &outcome.end);
            motion(kind, outcome.motion, text)
        }
        Record::Decision(decision) => {
            let Subject::Motion(id) = decision.subject else {
                return None;
            };
            let text = format!(
                "{} decided about a motion of {robot} in doubt: {}, because \"{}\"",
                decision.principal,
                crate::words::word(&decision.answer),
                decision.reason
            );
            motion("robocell.motion.decided", id, text)
        }
        Record::Audit(audit) => {
            let result = match audit.result {
                AuditResult::Done => "",
                AuditResult::Denied => ", which was denied",
                AuditResult::Failed => ", which failed",
            };
            Noted {
                kind: "robocell.audit",
                text: format!(
                    "{}: {} of {}{result}",
                    audit.principal, audit.action, audit.object
                ),
                subject: None,
                more: object(json!({
                    "principal": audit.principal, "action": audit.action, "object": audit.object,
                })),
            }
        }
        Record::ServerStarted(started) => Noted {
            kind: "robocell.server.started",
            text: format!("{} was started", started.program),
            subject: None,
            more: object(json!({ "epoch": started.epoch })),
        },
        // Of the state machines; or of none of the parts that write journals now.
        Record::CellDecided(_)
        | Record::SnapshotTaken(_)
        | Record::Pruned(_)
        | Record::JobCreated(_)
        | Record::JobStep(_)
        | Record::JobEnded(_)
        | Record::SignalReceived(_) => return None,
    };
    let mut noted = noted;
    if let Some(intent) = intent {
        let _none = noted.more.insert("robot".to_owned(), json!(intent.robot));
        let _none = noted
            .more
            .insert("request_id".to_owned(), json!(intent.request_id));
    }
    Some(noted)
}

fn motion(kind: &'static str, motion: MotionId, text: String) -> Noted {
    Noted {
        kind,
        text,
        subject: Some(format!("motions/{motion}")),
        more: object(json!({ "motion": motion })),
    }
}

fn outcome_in_words(robot: &str, end: &End) -> (&'static str, String) {
    match end {
        End::Done { .. } => ("robocell.motion.done", format!("{robot} is at its target")),
        End::Rejected { text } => (
            "robocell.motion.rejected",
            format!("{robot} refused its motion: {text}"),
        ),
        End::NotExecuted { .. } => (
            "robocell.motion.not-executed",
            format!("the motion of {robot} was not executed"),
        ),
        End::InDoubt { code, .. } => (
            "robocell.motion.in-doubt",
            format!("nobody knows what became of a motion of {robot}: {code}"),
        ),
        End::Interrupted { reason, .. } => (
            "robocell.motion.interrupted",
            format!("the motion of {robot} was interrupted: {reason}"),
        ),
    }
}

fn object(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(map) => map,
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) | Value::Array(_) => {
            Map::new()
        }
    }
}
