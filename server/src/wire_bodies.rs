//! Between the API's bodies and the types inside.

use api::{FloorPoseBody, JointsBody, LegacyPoint, SingularityBody};
use kinematics::{PendantJoints, Singularity, Xyzwpr};
use units::{Degrees, Millimeters};

pub(crate) use robotics::{point_of, pose_body, shown};

/// Joint values as [`joints_body`] shows them: what is told about them then holds for the numbers a caller sees.
pub(crate) fn as_shown(joints: &PendantJoints) -> PendantJoints {
    PendantJoints::from_degrees(joints.degrees().map(shown))
}

pub(crate) fn joints_body(joints: &PendantJoints) -> JointsBody {
    joints.degrees().map(shown).into()
}

/// A pose on the floor as a body, numbers as people read them.
pub(crate) fn floor_pose(pose: workflow::BasePose) -> FloorPoseBody {
    FloorPoseBody {
        x_mm: shown(pose.x_mm),
        y_mm: shown(pose.y_mm),
        heading_deg: shown(pose.heading_deg),
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
