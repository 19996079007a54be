//! Questions about arm models, and paths on a floor. `robotics` answers them; nothing here knows how.

mod paths;
mod planning;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use api::arms::{
    ArmCalibrationBody, ArmCalibrationResult, ArmDescription, ArmForwardBody, ArmForwardResult,
    ArmInverseBody, ArmInverseDynamicsBody, ArmInverseDynamicsResult, ArmInverseResult,
    ArmJacobianBody, ArmJacobianResult, ArmList, ArmRatesBody, ArmRatesResult,
};
use api::{ProblemCode, Violation};
use axum::Json;
use axum::extract::{FromRequestParts, State};
use axum::http::request::Parts;
use robotics::{Refusal, RefusalKind, Wanted};
use tokio::time::Instant;
use utoipa::IntoParams;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::params::{param, path_params};
use super::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use crate::compute::compute;
use crate::extract::ListJson;
use crate::problem::Problem;
use crate::state::App;

/// Their routes.
pub(super) fn documented() -> OpenApiRouter<Arc<App>> {
    OpenApiRouter::new()
        .routes(routes!(list_arms))
        .routes(routes!(describe_arm))
        .routes(routes!(arm_forward))
        .routes(routes!(arm_inverse))
        .routes(routes!(arm_jacobian))
        .routes(routes!(arm_rates))
        .routes(routes!(arm_inverse_dynamics))
        .routes(routes!(arm_calibrate_tool))
        .routes(routes!(planning::arm_velocity_motion))
        .routes(routes!(planning::arm_reachability))
        .routes(routes!(planning::arm_trajectory))
        .routes(routes!(planning::arm_tool_path))
        .routes(routes!(planning::arm_transfer))
        .routes(routes!(planning::robot_reachability))
        .routes(routes!(planning::robot_jacobian))
        .routes(routes!(paths::plan_route))
        .routes(routes!(paths::plan_mobile_robot_route))
}

/// The arm model in a path, for the OpenAPI document.
#[derive(IntoParams)]
#[into_params(parameter_in = Path)]
#[expect(dead_code, reason = "the field exists for its description only")]
struct ArmPath {
    /// The model's name.
    #[param(example = "fanuc-m20ia")]
    model: String,
}

/// The name of the arm model in a path.
struct ModelName(String);

impl FromRequestParts<Arc<App>> for ModelName {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        let params = path_params(parts).await?;
        param(&params, "model").map(|model| Self(model.to_owned()))
    }
}

/// Why a question was not answered, as a problem.
pub(super) fn refused(refusal: Refusal) -> Problem {
    let code = match refusal.kind {
        RefusalKind::UnknownModel => ProblemCode::NotFound,
        RefusalKind::Invalid => ProblemCode::Validation,
        RefusalKind::OutOfReach => ProblemCode::OutOfWorkspace,
        RefusalKind::JointLimit => ProblemCode::JointLimitExceeded,
        RefusalKind::Singular => ProblemCode::Singularity,
        RefusalKind::NoWay => ProblemCode::NoWay,
        RefusalKind::BrokenOff => ProblemCode::RequestTimeout,
    };
    let problem = Problem::new(code, refusal.to_string());
    if refusal.kind == RefusalKind::BrokenOff {
        let detail = format!(
            "the question was given up after {} s; one that asks for less (samples, steps, poses, a coarser resolution) may be answered",
            LONGEST.as_secs()
        );
        return Problem::new(code, detail);
    }
    if refusal.path.is_empty() {
        return problem;
    }
    problem.violations(vec![Violation {
        item: refusal.path,
        message: refusal.detail,
        value: refusal.value.filter(|value| value.is_finite()),
        min: refusal.min.filter(|value| value.is_finite()),
        max: refusal.max.filter(|value| value.is_finite()),
    }])
}

fn answered<T>(answer: Result<T, Refusal>) -> Result<Json<T>, Problem> {
    answer.map(Json).map_err(refused)
}

/// The longest that one question may keep the place for computing from all others.
const LONGEST: Duration = Duration::from_secs(30);

/// Whether the answer is still wanted.
fn goes_on(given_up: &AtomicBool, until: Instant) -> bool {
    !given_up.load(Ordering::Relaxed) && Instant::now() < until
}

/// Answers a question that takes long, in the place for it.
///
/// A search that looks at what it is given ends soon after the caller went away, or after [`LONGEST`].
async fn computed<T: Send + 'static>(
    app: &App,
    question: impl FnOnce(Wanted<'_>) -> Result<T, Refusal> + Send + 'static,
) -> Result<Json<T>, Problem> {
    let work = move |given_up: &AtomicBool| {
        let until = Instant::now() + LONGEST;
        let still = || goes_on(given_up, until);
        question(Wanted::while_true(&still)).map_err(refused)
    };
    compute(app, work).await.map(Json)
}

/// Lists the arm models that are known.
#[utoipa::path(
    get, path = "/api/v1/arms", tag = "arms",
    responses((status = 200, description = "Them.", body = ArmList), AnyProblem),
)]
async fn list_arms() -> Json<ArmList> {
    Json(robotics::models())
}

/// Shows an arm model: its table, ranges, speeds, shape, and how its inverse kinematics are solved.
#[utoipa::path(
    get, path = "/api/v1/arms/{model}", tag = "arms",
    params(ArmPath),
    responses((status = 200, description = "It.", body = ArmDescription), NotFound, AnyProblem),
)]
async fn describe_arm(ModelName(model): ModelName) -> Result<Json<ArmDescription>, Problem> {
    answered(robotics::describe(&model))
}

/// Computes where the tool of an arm model is, and every link on the way to it.
#[utoipa::path(
    post, path = "/api/v1/arms/{model}/forward", tag = "arms",
    params(ArmPath),
    request_body = ArmForwardBody,
    responses(
        (status = 200, description = "The poses, in the user frame.", body = ArmForwardResult),
        (status = 422, description = "`validation`: an item is out of its range.", body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
async fn arm_forward(
    ModelName(model): ModelName,
    ListJson(body): ListJson<ArmForwardBody>,
) -> Result<Json<ArmForwardResult>, Problem> {
    answered(robotics::forward(&model, &body))
}

/// Computes every joint set of an arm model that reaches a pose.
///
/// The method is the model's own, or one of its `solvers`. Joint sets outside the ranges are told too; with none inside,
/// `reason` says why.
#[utoipa::path(
    post, path = "/api/v1/arms/{model}/inverse", tag = "arms",
    params(ArmPath),
    request_body = ArmInverseBody,
    responses(
        (status = 200, description = "The joint sets.", body = ArmInverseResult),
        (status = 422, description = "`validation`: an item is out of its range. `out-of-workspace`: no joint set reaches the pose.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
async fn arm_inverse(
    State(app): State<Arc<App>>,
    ModelName(model): ModelName,
    ListJson(body): ListJson<ArmInverseBody>,
) -> Result<Json<ArmInverseResult>, Problem> {
    if robotics::is_search(&model, &body).map_err(refused)? {
        return computed(&app, move |_| robotics::inverse(&model, &body)).await;
    }
    answered(robotics::inverse(&model, &body))
}

/// Computes the Jacobians of an arm model: geometric, analytic, rank, manipulability, what is lost.
#[utoipa::path(
    post, path = "/api/v1/arms/{model}/jacobian", tag = "arms",
    params(ArmPath),
    request_body = ArmJacobianBody,
    responses(
        (status = 200, description = "Them.", body = ArmJacobianResult),
        (status = 422, description = "`validation`: an item is out of its range.", body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
async fn arm_jacobian(
    ModelName(model): ModelName,
    ListJson(body): ListJson<ArmJacobianBody>,
) -> Result<Json<ArmJacobianResult>, Problem> {
    answered(robotics::jacobian(&model, &body))
}

/// Computes the joint rates that give the tool of an arm model a velocity.
#[utoipa::path(
    post, path = "/api/v1/arms/{model}/rates", tag = "arms",
    params(ArmPath),
    request_body = ArmRatesBody,
    responses(
        (status = 200, description = "The rates.", body = ArmRatesResult),
        (status = 422, description = "`validation`: an item is out of its range. `singularity`: part of the velocity cannot be made here.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
async fn arm_rates(
    ModelName(model): ModelName,
    ListJson(body): ListJson<ArmRatesBody>,
) -> Result<Json<ArmRatesResult>, Problem> {
    answered(robotics::rates(&model, &body))
}

/// Computes the torques of an arm model's joints for a motion: recursive Newton-Euler.
///
/// The links weigh what the model says, or what the question says in `links`.
#[utoipa::path(
    post, path = "/api/v1/arms/{model}/inverse-dynamics", tag = "arms",
    params(ArmPath),
    request_body = ArmInverseDynamicsBody,
    responses(
        (status = 200, description = "The torques.", body = ArmInverseDynamicsResult),
        (status = 422, description = "`validation`: an item is out of its range; of `links`: the model does not say what they weigh.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
async fn arm_inverse_dynamics(
    ModelName(model): ModelName,
    ListJson(body): ListJson<ArmInverseDynamicsBody>,
) -> Result<Json<ArmInverseDynamicsResult>, Problem> {
    answered(robotics::inverse_dynamics(&model, &body))
}

/// Computes a tool out of taught points: three-point or six-point method.
#[utoipa::path(
    post, path = "/api/v1/arms/{model}/calibrate-tool", tag = "arms",
    params(ArmPath),
    request_body = ArmCalibrationBody,
    responses(
        (status = 200, description = "The tool, and how well the points agree.", body = ArmCalibrationResult),
        (status = 422, description = "`validation`: an item is out of its range, or the points do not give a tool.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
async fn arm_calibrate_tool(
    ModelName(model): ModelName,
    ListJson(body): ListJson<ArmCalibrationBody>,
) -> Result<Json<ArmCalibrationResult>, Problem> {
    answered(robotics::calibrate(&model, &body))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_wanted_until_its_time_is_up_or_nobody_waits() {
        let (waits, now) = (AtomicBool::new(false), Instant::now());
        assert!(goes_on(&waits, now + LONGEST));
        assert!(!goes_on(&waits, now));
        waits.store(true, Ordering::Relaxed);
        assert!(!goes_on(&waits, now + LONGEST));
    }
}
