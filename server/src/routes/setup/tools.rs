use std::sync::Arc;

use api::setup::{CalibrationBody, CalibrationPoint, CalibrationRecord, CalibrationResult};
use api::{PoseBody, ProblemCode};
use axum::Json;
use axum::extract::{Request, State};

use super::body::part;
use super::parts::Named;
use crate::problem::Problem;
use crate::routes::responses::{AnyProblem, BodyProblem, CrossSite, InvalidJson, NotFound};
use crate::setup::{
    Calibration, CalibrationError, Faults, MAX_RESIDUAL_MM, Resource, find, flange_of_body,
    four_point, parse_part,
};
use crate::state::App;
use crate::wire_bodies::shown;

/// Computes a tool center point by the four-point method. Nothing is kept: the answer goes into the tool with a PUT.
///
/// Each posture holds the tip at the same fixed point, with the flange turned differently. Postures that do not
/// determine the tip, or tips that do not agree, are refused with the posture or the direction named.
#[utoipa::path(
    post, path = "/api/v1/cells/{cell}/setup/tools/{arm}/{number}/calibrate", tag = "setup",
    params(
        ("cell" = String, Path, description = "The cell's id."),
        ("arm" = String, Path, description = "The arm's id."),
        ("number" = u8, Path, description = "The tool's number: its orientation is kept, where the set-up has it."),
    ),
    request_body = CalibrationBody,
    responses(
        (status = 200, description = "The tool center point.", body = CalibrationResult),
        (status = 422, description = "`validation`: the body does not fit. `calibration-refused`: the postures give no tool.",
            body = api::Problem, content_type = "application/problem+json"),
        CrossSite, InvalidJson, NotFound, BodyProblem, AnyProblem,
    ),
)]
pub(super) async fn calibrate_tool(
    State(app): State<Arc<App>>,
    named: Named,
    request: Request,
) -> Result<Json<CalibrationResult>, Problem> {
    let arm = named.get("arm");
    let robot = app.robot(&named.get("cell"), &arm)?;
    let kept = named.book(&app)?.current();
    let tool = Resource::Tool {
        arm,
        number: named.number("number"),
    };
    let orientation = find::<api::setup::ToolSetup>(&kept.file, &tool).map(|tool| tool.frame);
    let text = part(request, &app.server).await?;
    let body: CalibrationBody = parse_part(&text)?;
    let mut faults = Faults::default();
    let limit = body.max_residual_mm.unwrap_or(MAX_RESIDUAL_MM);
    let _limit = faults.number("max_residual_mm", limit, (0.001, 10.0));
    let mut flanges = Vec::with_capacity(body.points.len());
    for (index, CalibrationPoint { joints, flange }) in body.points.iter().enumerate() {
        let item = format!("points[{index}]");
        let model = robot.plan.model;
        flanges.extend(flange_of_body(&mut faults, &item, *joints, *flange, model));
    }
    if let Some(errors) = faults.into_errors() {
        return Err(errors.into());
    }
    let Calibration {
        tip,
        residuals,
        rms,
        max,
        uncertainty,
    } = four_point(&flanges, limit).map_err(|error| refused(&error))?;
    let turned = orientation.unwrap_or(PoseBody::from([0.0; 6]));
    Ok(Json(CalibrationResult {
        frame: PoseBody {
            x_mm: shown(tip.x),
            y_mm: shown(tip.y),
            z_mm: shown(tip.z),
            ..turned
        },
        calibration: CalibrationRecord {
            points: u32::try_from(flanges.len()).unwrap_or(u32::MAX),
            rms_mm: shown(rms),
            max_mm: shown(max),
            at: Some(app.clock.now()),
        },
        residuals_mm: residuals.into_iter().map(shown).collect(),
        uncertainty_mm: shown(uncertainty),
    }))
}

fn refused(error: &CalibrationError) -> Problem {
    Problem::new(ProblemCode::CalibrationRefused, error.to_string())
}
