//! A tool out of taught points.

use api::arms::{
    ArmCalibrationBody, ArmCalibrationMethod, ArmCalibrationPoint, ArmCalibrationResult,
};
use kinematics::{Pose, calibrate_tip, calibrate_tool};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use units::Millimeters;

use crate::arm::Arm;
use crate::convert::{pose_at, shown, shown_pose};
use crate::refusal::{Refusal, length};

/// The tool by the three-point method (the tip), or by the six-point method (tip and directions).
///
/// The R and p behind A6 in the thesis's (12), by least squares over all points. `worst_mm` says how well they agree.
///
/// # Errors
/// No such model; too few points, orientations too alike, direction points too near, turned or in one line.
pub fn calibrate(model: &str, body: &ArmCalibrationBody) -> Result<ArmCalibrationResult, Refusal> {
    let arm = Arm::named(model)?;
    length("tip", body.tip.len(), [3, 1000], "points")?;
    let mut tips = Vec::new();
    for (index, point) in body.tip.iter().enumerate() {
        tips.push(flange(&arm, &format!("tip[{index}]"), point)?);
    }
    let refused = |error| Refusal::invalid("tip", error);
    let directions = [
        ("orient_origin", &body.orient_origin),
        ("along_x", &body.along_x),
        ("along_z", &body.along_z),
    ];
    let given = directions
        .iter()
        .filter(|(_, point)| point.is_some())
        .count();
    let (method, tool, tip) = match (&body.orient_origin, &body.along_x, &body.along_z) {
        (Some(origin), Some(x), Some(z)) => {
            let origin = flange(&arm, "orient_origin", origin)?;
            let x = flange(&arm, "along_x", x)?;
            let z = flange(&arm, "along_z", z)?;
            let (tool, tip) = calibrate_tool(&tips, &origin, &x, &z).map_err(refused)?;
            (ArmCalibrationMethod::SixPoint, tool, tip)
        }
        _ if given == 0 => {
            let tip = calibrate_tip(&tips).map_err(refused)?;
            let tool =
                Isometry3::from_parts(Translation3::from(tip.tip), UnitQuaternion::identity());
            let tool =
                Pose::try_from_isometry(tool).map_err(|error| Refusal::invalid("tip", error))?;
            (ArmCalibrationMethod::ThreePoint, tool, tip)
        }
        _ => {
            let missing = directions.iter().find(|(_, point)| point.is_none());
            let path = missing.map_or("", |(name, _)| name);
            let detail =
                "it is missing: the six-point method needs orient_origin, along_x and along_z";
            return Err(Refusal::invalid(path, detail));
        }
    };
    let shown_mm = |Millimeters(length)| shown(length);
    Ok(ArmCalibrationResult {
        method,
        tool: shown_pose(&tool),
        place_mm: [tip.place.x, tip.place.y, tip.place.z].map(shown),
        worst_mm: shown_mm(tip.worst),
        mean_mm: shown_mm(tip.mean),
    })
}

fn flange(arm: &Arm, path: &str, point: &ArmCalibrationPoint) -> Result<Pose, Refusal> {
    match (&point.joints_deg_mm, &point.flange) {
        (Some(joints), None) => {
            let path = format!("{path}.joints_deg_mm");
            let joints = arm.joints(&path, joints)?;
            arm.serial
                .forward(&joints)
                .map_err(|error| Refusal::invalid(path, error))
        }
        (None, Some(flange)) => pose_at(&format!("{path}.flange"), flange),
        (Some(_), Some(_)) | (None, None) => {
            let detail = "exactly one of joints_deg_mm and flange is needed";
            Err(Refusal::invalid(path, detail))
        }
    }
}
