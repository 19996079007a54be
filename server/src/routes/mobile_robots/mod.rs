//! Mobile robots: the signals they send, and the messages the cell has for them.

mod instant;
mod outbox;
mod refused;
mod signal;
mod state;

use std::sync::Arc;

use api::{ProblemCode, SignalAnswer, SignalBody, Violation};
use axum::Json;
use axum::extract::{FromRequestParts, Request, State};
use axum::http::StatusCode;
use axum::http::request::Parts;
use utoipa::IntoParams;
use workflow::{Input, Reply};

pub(super) use instant::{__path_post_instant_action, post_instant_action};
pub(super) use outbox::{__path_get_outbox, get_outbox};
use refused::KeptProblem;
pub(super) use state::{
    __path_get_mobile_robot, __path_get_mobile_robot_state, __path_list_mobile_robots,
    get_mobile_robot, get_mobile_robot_state, list_mobile_robots,
};

use super::params::{param, path_params};
use super::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use crate::extract::{media_type, read_body};
use crate::problem::{Problem, outcome_of_nothing_sent};
use crate::setup::parse_part;
use crate::state::{App, shown};

/// The mobile robot in a path, for the OpenAPI document.
#[derive(IntoParams)]
#[into_params(parameter_in = Path)]
#[expect(dead_code, reason = "the fields exist for their descriptions only")]
pub(super) struct MobileRobotPath {
    /// The cell's id.
    #[param(example = "demo")]
    cell: String,
    /// The mobile robot's id.
    #[param(example = "mr1")]
    mobile_robot: String,
}

/// The mobile robot a path names: `…/cells/{cell}/mobile-robots/{mobile_robot}…`. It is one of the cell's set-up.
pub(super) struct MobileRobotOf {
    pub(super) cell: String,
    pub(super) id: String,
}

impl FromRequestParts<Arc<App>> for MobileRobotOf {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, Problem> {
        let params = path_params(parts).await?;
        let cell = param(&params, "cell")?;
        let id = param(&params, "mobile_robot")?;
        let outcome = outcome_of_nothing_sent(&parts.method);
        let found = app.cell(cell);
        let known = found.map_err(|problem| problem.outcome(outcome))?;
        if known.work.view().setup().mobile_robot(id).is_none() {
            let id = shown(id);
            let detail = format!("there is no mobile robot `{id}` in the set-up of cell `{cell}`");
            return Err(Problem::not_found(detail).outcome(outcome));
        }
        Ok(Self {
            cell: cell.to_owned(),
            id: id.to_owned(),
        })
    }
}

/// Takes a signal of a mobile robot.
///
/// Signals are counted from 1 in each `boot`. The same (boot, seq) again is answered as before and has no second
/// effect. A signal that comes before its predecessor is parked for a short while (202); one that comes still earlier,
/// or of an earlier boot, is refused and not counted: `violations` has `expected.seq`, and an `MR_HEARTBEAT` with
/// `resync` gives up what is lost for ever. One that does not fit the hand-over is counted and has no effect
/// (409), as is one of a hand-over that is over (410). What counts is the order of arrival, not the robot's clock.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/mobile-robots/{mobile_robot}/signals", tag = "mobile-robots",
    params(MobileRobotPath),
    request_body = SignalBody,
    responses(
        (status = 200, description = "It is recorded, now or before.", body = SignalAnswer),
        (status = 202, description = "It is parked: its predecessor has not come yet.", body = SignalAnswer),
        (status = 409, description = "`handover-conflict`: it is not legal now; `violations` says what would be.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 410, description = "`session-closed`: its hand-over is over, or unknown.",
            body = api::Problem, content_type = "application/problem+json"),
        (status = 422, description = "`validation`: a key is missing or unknown, or a value is out of its range.",
            body = api::Problem, content_type = "application/problem+json"),
        KeptProblem, CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn post_signal(
    State(app): State<Arc<App>>,
    MobileRobotOf { cell, id }: MobileRobotOf,
    request: Request,
) -> Result<(StatusCode, Json<SignalAnswer>), Problem> {
    let _json = media_type(request.headers(), &["application/json"])?;
    let text = read_body(request, &app.server, app.server.max_body_bytes).await?;
    let signal = signal::check(parse_part::<SignalBody>(&text)?, &id)?;
    let work = &app.cell(&cell)?.work;
    let asked = work.ask(Input::Signal(Box::new(signal)));
    match asked.await.map_err(refused::problem)? {
        Reply::Signal(answer) => {
            work.heard(&id, app.clock.now());
            answered(answer)
        }
        Reply::Done | Reply::Unchanged | Reply::Created(_) => Err(Problem::new(
            ProblemCode::Internal,
            "a signal was answered with something else",
        )),
    }
}

fn answered(answer: workflow::SignalAnswer) -> Result<(StatusCode, Json<SignalAnswer>), Problem> {
    let noted = |status, duplicate, parked, note: Option<&str>| {
        let answer = SignalAnswer {
            accepted: true,
            duplicate,
            parked,
            note: note.map(str::to_owned),
        };
        Ok((status, Json(answer)))
    };
    let taken = |status, duplicate, parked| noted(status, duplicate, parked, None);
    match answer {
        workflow::SignalAnswer::Accepted { duplicate } => taken(StatusCode::OK, duplicate, false),
        workflow::SignalAnswer::Late { duplicate } => noted(
            StatusCode::OK,
            duplicate,
            false,
            Some("its number was given up as lost: it is recorded and has no effect"),
        ),
        workflow::SignalAnswer::Gap {
            boot,
            expected,
            got,
        } => Err(gap(boot, expected, got)),
        workflow::SignalAnswer::Parked => taken(StatusCode::ACCEPTED, false, true),
        workflow::SignalAnswer::Conflict { expected, got, .. } => {
            let detail = format!("expected {expected}, got {got}");
            Err(
                Problem::new(ProblemCode::HandoverConflict, detail).violations(vec![
                    Violation {
                        item: "expected".to_owned(),
                        message: expected,
                        ..Violation::default()
                    },
                    Violation {
                        item: "got".to_owned(),
                        message: got,
                        ..Violation::default()
                    },
                ]),
            )
        }
        workflow::SignalAnswer::Closed { session, .. } => Err(Problem::new(
            ProblemCode::SessionClosed,
            format!("the hand-over session {session} is over, or was never begun"),
        )),
    }
}

/// More than one number before it is missing: `expected.seq` is the number to go on with.
fn gap(boot: u64, expected: u64, got: u64) -> Problem {
    let violation = |item: &str, message: String| Violation {
        item: item.to_owned(),
        message,
        ..Violation::default()
    };
    let (wanted, came) = (
        format!("boot {boot} seq {expected}"),
        format!("boot {boot} seq {got}"),
    );
    let detail = format!("expected {wanted}, got {came}; its number is not used up");
    Problem::new(ProblemCode::HandoverConflict, detail)
        .violations(vec![
            violation("expected", wanted),
            violation("got", came),
            violation("expected.seq", expected.to_string()),
        ])
        .hint("send the missing signals; if they are lost, send MR_HEARTBEAT with `resync` under the next number")
}
