//! What a person has a mobile robot do at once.

use std::sync::Arc;

use api::{InstantActionAnswer, InstantActionBody, InstantActionName, ProblemCode, Violation};
use axum::Json;
use axum::extract::State;
use axum::http::{HeaderMap, StatusCode};
use workflow::{Input, InstantAction};

use super::super::jobs::{Replayed, cell_to_change, replayed, understood};
use super::super::responses::{AnyProblem, BodyProblem, CrossSite, NotFound};
use super::refused::KeptProblem;
use super::{MobileRobotOf, MobileRobotPath};
use crate::extract::JsonBody;
use crate::identity::Principal;
use crate::jobs;
use crate::motions::RequestKey;
use crate::problem::Problem;
use crate::state::App;

/// Has a mobile robot do something at once, in the words of VDA 5050.
///
/// The message goes into the robot's outbox, and into the journal with who sent it. What a job has begun, the job ends:
/// a job's order is not canceled here, nor is its docking tried again or given up. A pause that keeps a robot away from
/// an arm is not ended here either. `START_PAUSE` and `STATE_REQUEST` are always possible.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}/instant-actions", tag = "mobile-robots",
    params(
        MobileRobotPath,
        ("idempotency-key" = String, Header, max_length = 128, description = "The caller's own word for this action, e.g. a UUID."),
    ),
    request_body = InstantActionBody,
    responses(
        (status = 202, description = "It is in the robot's outbox, now or since an earlier request with the key.", body = InstantActionAnswer,
            headers(("idempotency-replayed" = bool, description = "Present and `true` where it was asked for before."))),
        (status = 400, description = "`idempotency-missing`: the header is missing. `invalid-json`.", body = api::Problem, content_type = "application/problem+json"),
        (status = 409, description = "`handover-conflict`: it would interfere with a job; the detail says what to do instead. `interlock-violation`: an arm may be in the way.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: a key is missing or unknown. `idempotency-mismatch`: the key was used for something else.",
            body = api::Problem, content_type = "application/problem+json"),
        KeptProblem, CrossSite, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(crate) async fn post_instant_action(
    State(app): State<Arc<App>>,
    MobileRobotOf { cell, id }: MobileRobotOf,
    caller: Principal,
    headers: HeaderMap,
    JsonBody(body): JsonBody<InstantActionBody>,
) -> Result<(StatusCode, Replayed, Json<InstantActionAnswer>), Problem> {
    let cell = cell_to_change(&app, &cell)?;
    let key = RequestKey::of(&headers)?;
    let path = format!(
        "POST /api/v1/cells/{}/mobile-robots/{id}/instant-actions",
        cell.id
    );
    let claim = key.claim(caller.name(), &path, &understood(&body)?)?;
    if let Some(reason) = &body.reason {
        jobs::reason(reason)?;
    }
    let input = Input::InstantAction {
        mobile_robot: id.clone(),
        action: action(&body)?,
        principal: jobs::principal(&caller),
        reason: body.reason,
    };
    let told = cell.work.ask_with(input, claim).await;
    let told = jobs::told(told, ProblemCode::HandoverConflict, "")?;
    let answer = InstantActionAnswer {
        unacknowledged: cell.work.view().outbox(&id, 0).len(),
        mobile_robot: id,
        action: body.action,
    };
    Ok((StatusCode::ACCEPTED, replayed(told.replayed), Json(answer)))
}

fn action(body: &InstantActionBody) -> Result<InstantAction, Problem> {
    let action = match body.action {
        InstantActionName::StartPause => InstantAction::StartPause,
        InstantActionName::StopPause => InstantAction::StopPause,
        InstantActionName::CancelOrder => InstantAction::CancelOrder { order: body.order },
        InstantActionName::Retry => InstantAction::Retry,
        InstantActionName::SkipRetry => InstantAction::SkipRetry,
        InstantActionName::StateRequest => InstantAction::StateRequest,
    };
    if body.order.is_some() && body.action != InstantActionName::CancelOrder {
        let message = "only CANCEL_ORDER is about an order".to_owned();
        return Err(
            Problem::not_sent(ProblemCode::Validation, format!("order: {message}")).violations(
                vec![Violation {
                    item: "order".to_owned(),
                    message,
                    ..Violation::default()
                }],
            ),
        );
    }
    Ok(action)
}
