//! Between the API's bodies and the types inside.

use api::{JointsBody, LegacyPoint, PoseBody, SingularityBody};
use kinematics::{PendantJoints, Singularity, Xyzwpr};
use units::{Degrees, Millimeters};

/// A number as people read it: to a millionth of a thousandth, so that 500 does not come back as 500.00000000000006
/// from its way through radians.
pub(crate) fn shown(value: f64) -> f64 {
    let scaled = (value * 1e9).round();
    if scaled.is_finite() {
        // Adding zero makes a negative zero positive.
        scaled / 1e9 + 0.0
    } else {
        value
    }
}

/// Joint values as [`joints_body`] shows them: what is told about them then holds for the numbers a caller sees.
pub(crate) fn as_shown(joints: &PendantJoints) -> PendantJoints {
    PendantJoints::from_degrees(joints.degrees().map(shown))
}

pub(crate) fn joints_body(joints: &PendantJoints) -> JointsBody {
    joints.degrees().map(shown).into()
}

pub(crate) fn pose_body(point: &Xyzwpr) -> PoseBody {
    PoseBody {
        x_mm: shown(point.x.0),
        y_mm: shown(point.y.0),
        z_mm: shown(point.z.0),
        w_deg: shown(point.w.0),
        p_deg: shown(point.p.0),
        r_deg: shown(point.r.0),
    }
}

pub(crate) fn point_of(body: &PoseBody) -> Xyzwpr {
    Xyzwpr {
        x: Millimeters(body.x_mm),
        y: Millimeters(body.y_mm),
        z: Millimeters(body.z_mm),
        w: Degrees(body.w_deg),
        p: Degrees(body.p_deg),
        r: Degrees(body.r_deg),
    }
}

pub(crate) fn legacy_point(point: &Xyzwpr) -> LegacyPoint {
    LegacyPoint {
        x: point.x.0,
        y: point.y.0,
        z: point.z.0,
        w: point.w.0,
        p: point.p.0,
        r: point.r.0,
    }
}

pub(crate) fn point_of_legacy(body: &LegacyPoint) -> Xyzwpr {
    Xyzwpr {
        x: Millimeters(body.x),
        y: Millimeters(body.y),
        z: Millimeters(body.z),
        w: Degrees(body.w),
        p: Degrees(body.p),
        r: Degrees(body.r),
    }
}

pub(crate) fn singularity_body(singularity: &Singularity) -> SingularityBody {
    SingularityBody {
        wrist: singularity.wrist,
        shoulder: singularity.shoulder,
        elbow: singularity.elbow,
        singular: singularity.near().next().is_some(),
    }
}
