use std::sync::Arc;

use api::ProblemCode;
use api::setup::{TeachBody, TeachResult};
use axum::Json;
use axum::extract::{Request, State};
use axum::http::HeaderMap;
use axum::response::Response;

use super::body::{based_on, part, tagged};
use super::parts::Named;
use super::problems::ChangeProblem;
use crate::problem::Problem;
use crate::routes::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use crate::setup::{Edit, Resource, parse_part, put};
use crate::state::App;

/// Teaches a pose: the arm's actual one as its controller reports it, or the one the request gives.
///
/// For a place on a mobile robot, `measured_dock` says where the robot stands meanwhile; what is kept is the pose at the
/// nominal dock. A controller that reports no position (tier 0) can only be taught with an explicit pose: the target it
/// last accepted is not where the arm is.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/setup/taught-poses/{arm}/{place}/teach", tag = "setup",
    params(
        ("cell" = String, Path, description = "The cell's id."),
        ("arm" = String, Path, description = "The arm's id."),
        ("place" = String, Path, description = "The place's id; a slash in it is written %2F."),
        ("if-match" = String, Header, description = "The entity tag the change is based on."),
    ),
    request_body = TeachBody,
    responses(
        (status = 200, description = "It is taught.", body = TeachResult,
            headers(("etag" = String, description = "Of the whole set-up now."))),
        ChangeProblem, CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn teach_pose(
    State(app): State<Arc<App>>,
    named: Named,
    headers: HeaderMap,
    request: Request,
) -> Result<Response, Problem> {
    let (arm, place) = (named.get("arm"), named.get("place"));
    let book = named.book(&app)?;
    let robot = app.robot(&named.get("cell"), &arm)?;
    let based_on = based_on(&headers)?;
    let text = part(request, &app.server).await?;
    let body: TeachBody = parse_part(&text)?;
    let actual = match body.at {
        Some(_) => None,
        None => Some(robot.actual_joints().map_err(|reason| {
            Problem::new(ProblemCode::NoActualPose, reason)
                .robot(&arm)
                .hint("read the pose from the pendant and give it in `at`")
        })?),
    };
    let kept = book.current();
    let taught = kept.setup.teach(&kept.file, &arm, &place, &body, actual)?;
    let resource = Resource::TaughtPose { arm, place };
    let part = taught.clone();
    let changing = book.change(based_on, resource, move |file| {
        put(file, part);
        Ok(Edit::Put)
    });
    let changed = changing.await?;
    let result = TeachResult {
        revision: changed.revision,
        etag: changed.etag.clone(),
        taught,
    };
    Ok(tagged(&changed.etag, Json(result)))
}
