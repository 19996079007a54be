//! Between the API's bodies and the types inside.

use api::PoseBody;
use api::arms::{ArmFrames, ArmOutside, ZyzBody};
use kinematics::serial::OutsideRange;
use kinematics::{Frames, Pose, PoseError, Xyzwpr, ZyzAngles, ZyzBranch};
use units::{Degrees, Millimeters};

use crate::refusal::Refusal;

pub use units::shown;

/// A pose as a body, numbers as people read them.
#[must_use]
pub fn pose_body(point: &Xyzwpr) -> PoseBody {
    let lengths = [point.x, point.y, point.z].map(|length| length.0);
    let angles = [point.w, point.p, point.r].map(|angle| angle.0);
    let ([x, y, z], [w, p, r]) = (lengths, angles);
    [x, y, z, w, p, r].map(shown).into()
}

/// The numbers of a body, not checked.
#[must_use]
pub fn point_of(body: &PoseBody) -> Xyzwpr {
    Xyzwpr {
        x: Millimeters(body.x_mm),
        y: Millimeters(body.y_mm),
        z: Millimeters(body.z_mm),
        w: Degrees(body.w_deg),
        p: Degrees(body.p_deg),
        r: Degrees(body.r_deg),
    }
}

pub(crate) fn shown_pose(pose: &Pose) -> PoseBody {
    pose_body(&pose.xyzwpr())
}

/// The pose that is at `path` of the question.
pub(crate) fn pose_at(path: &str, body: &PoseBody) -> Result<Pose, Refusal> {
    Pose::try_from_xyzwpr(&point_of(body)).map_err(|error| {
        let (key, value) = match error {
            PoseError::Coordinate { name, value } => (format!("{path}.{name}_mm"), value.0),
            PoseError::Angle { name, value } => (format!("{path}.{name}_deg"), value.0),
            PoseError::Rotation { norm } => (path.to_owned(), norm),
        };
        Refusal::invalid(key, error).with_value(value)
    })
}

pub(crate) fn frames_of(body: &ArmFrames) -> Result<Frames, Refusal> {
    let one = |path: &str, body: &Option<PoseBody>| match body {
        Some(body) => pose_at(path, body),
        None => Ok(Pose::identity()),
    };
    Ok(Frames {
        user_frame: one("frames.user_frame", &body.user_frame)?,
        tool: one("frames.tool", &body.tool)?,
    })
}

pub(crate) fn zyz_body(pose: &Pose) -> ZyzBody {
    let angles = pose.zyz(ZyzBranch::Positive);
    let zyz = angles.angles();
    let degrees = |angle: units::Radians| shown(angle.0.to_degrees());
    ZyzBody {
        phi_deg: degrees(zyz.phi),
        theta_deg: degrees(zyz.theta),
        psi_deg: degrees(zyz.psi),
        regular: matches!(angles, ZyzAngles::Regular(_)),
    }
}

pub(crate) fn outside_body(outside: &OutsideRange) -> ArmOutside {
    ArmOutside {
        joint: outside.joint.clone(),
        value_deg_mm: shown(outside.value),
        min_deg_mm: shown(outside.min),
        max_deg_mm: shown(outside.max),
    }
}

pub(crate) fn position_of(pose: &Pose) -> [f64; 3] {
    let p = pose.isometry().translation.vector;
    [p.x, p.y, p.z].map(shown)
}
