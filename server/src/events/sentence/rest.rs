//! All other facts, in words.

use uuid::Uuid;
use workflow::Fact;

use super::super::known::Known;
use super::{Said, said};
use crate::words::{because, word};

#[expect(
    clippy::wildcard_enum_match_arm,
    reason = "what none of the four tells of is no event"
)]
pub(super) fn of_rest(known: &Known, fact: &Fact) -> Option<Said> {
    Some(match fact {
        Fact::Recovered => said(
            "robocell.cell.recovered",
            None,
            "the cell was started; no permit is granted".to_owned(),
        ),
        Fact::SetupChanged { .. } => said(
            "robocell.cell.setup",
            None,
            "the workflows have a new set-up".to_owned(),
        ),
        Fact::OpDoubted { op, text } => said(
            "robocell.operation.in-doubt",
            known.job_of(op),
            format!("nobody knows what became of an operation{}", because(text)),
        ),
        Fact::OpReconciling { op } => said(
            "robocell.operation.reconciling",
            known.job_of(op),
            "the truth about an operation is being read".to_owned(),
        ),
        Fact::OpEnded { op, result } => said(
            "robocell.operation.ended",
            known.job_of(op),
            format!("the operation ended: {}", result_in_words(result)),
        ),
        Fact::LoadRegistered {
            load,
            kind,
            location,
        } => {
            let mut said = said(
                "robocell.load.registered",
                None,
                format!("load {load} of type {kind} is known now, at {location}"),
            );
            said.subject = Some(format!("loads/{load}"));
            said
        }
        Fact::CustodyMoved { load, to, by } => {
            let job = match by {
                workflow::Evidence::Gripper { op } => known.job_of(op),
                workflow::Evidence::Doubt { .. }
                | workflow::Evidence::MobileRobot { .. }
                | workflow::Evidence::Human { .. } => None,
            };
            let mut said = said(
                "robocell.load.moved",
                job,
                format!("load {load} is at {to}"),
            );
            said.subject = Some(format!("loads/{load}"));
            said
        }
        Fact::Asked { question } => {
            let job = question.job;
            let text = format!("{} {}", question.fault.code(), question.question);
            about_question("robocell.intervention.asked", job, question.id, text)
        }
        Fact::Answered {
            intervention,
            decided,
        } => about_question(
            "robocell.intervention.answered",
            known.job_of(intervention),
            *intervention,
            format!(
                "{} answered {}, because \"{}\"",
                decided.principal,
                word(&decided.answer),
                decided.reason
            ),
        ),
        Fact::Withdrawn { intervention, text } => about_question(
            "robocell.intervention.withdrawn",
            known.job_of(intervention),
            *intervention,
            format!("the question is no longer asked{}", because(text)),
        ),
        _ => return None,
    })
}

pub(super) fn about_question(
    kind: &'static str,
    job: Option<Uuid>,
    id: Uuid,
    text: String,
) -> Said {
    let mut said = said(kind, job, text);
    said.subject = Some(format!("interventions/{id}"));
    said
}

fn result_in_words(result: &workflow::OpResult) -> String {
    use workflow::OpResult;
    match result {
        OpResult::Arrived => "arrived".to_owned(),
        OpResult::Gripped {
            closed,
            open,
            part_present,
        } => {
            let fingers = match (closed, open) {
                (true, false) => "closed",
                (false, true) => "open",
                (false, false) | (true, true) => "between",
            };
            let part = if *part_present { "a part" } else { "no part" };
            format!("the gripper is {fingers}, with {part}")
        }
        OpResult::Prechecked { failures } => match failures.first() {
            None => "every pose can be reached".to_owned(),
            Some(first) => format!(
                "{} poses cannot be reached: {}",
                failures.len(),
                first.reason
            ),
        },
        OpResult::NotExecuted { text } => format!("not executed{}", because(text)),
        OpResult::Rejected { text } => format!("rejected{}", because(text)),
        OpResult::Interrupted { text } => format!("interrupted{}", because(text)),
        OpResult::InDoubt { text } => format!("in doubt{}", because(text)),
    }
}
