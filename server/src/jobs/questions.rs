//! The workflows' questions to people, and the answers.

use api::{
    AllowedAnswer, AnswerNeeds, Intervention, InterventionDecision, InterventionKind,
    InterventionState, ProblemCode, RespondBody, Role, Violation,
};
use workflow::view::InterventionView;
use workflow::{Answer, Cell, Detail};

use super::body::location;
use super::shown::{created_at, fault_name};
use crate::problem::Problem;
use crate::words::word;

/// A question as the API shows it.
pub(crate) fn intervention(name: &str, cell: &Cell, view: &InterventionView) -> Intervention {
    let question = &view.question;
    let job = question.job.and_then(|job| cell.job(0, job));
    Intervention {
        id: question.id,
        kind: InterventionKind::Job,
        state: match (view.open, &view.decided) {
            (true, _) => InterventionState::Open,
            (false, Some(_)) => InterventionState::Answered,
            (false, None) => InterventionState::Withdrawn,
        },
        cell: name.to_owned(),
        robot: job.and_then(|job| job.arm),
        motion: None,
        job: question.job,
        session: question.session,
        load: question.load.clone(),
        fault: Some(fault_name(question.fault)),
        opened_at: created_at(question.id),
        question: question.question.clone(),
        known: question.known.clone(),
        unknown: question.unknown.clone(),
        code: None,
        target: None,
        controller_text: None,
        evidence: None,
        allowed: view
            .allowed
            .iter()
            .map(|allowed| AllowedAnswer {
                answer: word(&allowed.answer),
                consequence: allowed.consequence.to_owned(),
                role: match allowed.role {
                    workflow::Role::Integrator => Some(Role::Integrator),
                    workflow::Role::Admin => Some(Role::Admin),
                    workflow::Role::Viewer | workflow::Role::Operator => None,
                },
                needs: needs(allowed.answer),
            })
            .collect(),
        decision: view.decided.as_ref().map(|decided| InterventionDecision {
            answer: word(&decided.answer),
            principal: decided.principal.clone(),
            reason: decided.reason.clone(),
            at: None,
        }),
        withdrawn: view.withdrawn.clone(),
    }
}

fn needs(answer: Answer) -> Option<AnswerNeeds> {
    match answer {
        Answer::ChooseMobileRobot | Answer::SwapMobileRobot => Some(AnswerNeeds::MobileRobot),
        Answer::ChooseSlot => Some(AnswerNeeds::Place),
        Answer::SetCustody => Some(AnswerNeeds::Custody),
        Answer::Retry
        | Answer::Resume
        | Answer::Cancel
        | Answer::Abort
        | Answer::Redispatch
        | Answer::AcceptMeasured
        | Answer::Rescan
        | Answer::Accept
        | Answer::SendBack
        | Answer::Retreat
        | Answer::Replan
        | Answer::Happened
        | Answer::DidNotHappen
        | Answer::RejectBin
        | Answer::PutBack
        | Answer::Complete
        | Answer::Wait
        | Answer::OperatorMoved
        | Answer::CancelOrder
        | Answer::MarkDelivered
        | Answer::Repick
        | Answer::Hold
        | Answer::ConfirmStill => None,
    }
}

/// The answer in a body, with what it needs.
///
/// # Errors
/// `validation`: the answer is none of the allowed ones, or what it needs is missing, or something is said that it does
/// not need.
pub(crate) fn answer(
    view: &InterventionView,
    body: &RespondBody,
) -> Result<(Answer, Detail), Problem> {
    let all: Vec<_> = view.allowed.iter().map(|one| word(&one.answer)).collect();
    let found = view
        .allowed
        .iter()
        .find(|one| word(&one.answer) == body.answer);
    let Some(answer) = found.map(|one| one.answer) else {
        let said = crate::state::shown(&body.answer);
        return Err(wrong(
            "answer",
            format!("`{said}` is none of {}", all.join(", ")),
        ));
    };
    let needed = needs(answer);
    for (key, given, of) in [
        (
            "mobile_robot",
            body.mobile_robot.is_some(),
            AnswerNeeds::MobileRobot,
        ),
        ("place", body.place.is_some(), AnswerNeeds::Place),
        ("custody", body.custody.is_some(), AnswerNeeds::Custody),
    ] {
        let name = &body.answer;
        if given && needed != Some(of) {
            return Err(wrong(key, format!("`{name}` does not need it")));
        }
        if !given && needed == Some(of) {
            return Err(wrong(key, format!("missing; `{name}` needs it")));
        }
    }
    let detail = match (&body.mobile_robot, &body.place, &body.custody) {
        (Some(mobile_robot), _, _) => Detail::MobileRobot {
            mobile_robot: mobile_robot.clone(),
        },
        (None, Some(place), _) => Detail::Place {
            place: place.clone(),
        },
        (None, None, Some(custody)) => Detail::Custody {
            load: view.question.load.clone().unwrap_or_default(),
            confirm: custody.confirm.clone(),
            location: location(&custody.location),
        },
        (None, None, None) => Detail::None,
    };
    Ok((answer, detail))
}

fn wrong(item: &str, message: String) -> Problem {
    Problem::not_sent(ProblemCode::Validation, format!("{item}: {message}")).violations(vec![
        Violation {
            item: item.to_owned(),
            message,
            ..Violation::default()
        },
    ])
}
