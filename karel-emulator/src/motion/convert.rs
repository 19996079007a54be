//! Positions, joints and configurations of KAREL as those of the arm, and back.

use karel::{Config, JointPosition, Position, Status, XyzwprExt};
use kinematics::{
    Configuration, Elbow, Flip, Frames, Front, PendantJoints, Pose, PoseError, Xyzwpr,
};
use units::{Degrees, Millimeters};

use super::planner::Refusal;
use crate::ledger::PoseMmDeg;

/// A pose as the ledger writes it.
#[must_use]
pub fn pose_mm_deg(pose: &Pose) -> PoseMmDeg {
    components(&pose.xyzwpr()).into()
}

/// KAREL's joints as the arm's.
///
/// # Errors
/// Not six axes, or an angle that is no number.
pub fn pendant_joints(joints: &JointPosition) -> Result<PendantJoints, Refusal> {
    let refused = |text: String| Refusal::new(Status::MOTN_LIMIT, text);
    let axes = <[f32; 6]>::try_from(joints.axes.as_slice()).map_err(|_| {
        refused(format!(
            "the joint position has {} axes, this arm has 6",
            joints.axes.len()
        ))
    })?;
    PendantJoints::try_from_degrees(axes.map(f64::from)).map_err(|error| refused(error.to_string()))
}

/// The arm's joints as KAREL's.
#[must_use]
pub fn joint_position(joints: &PendantJoints) -> JointPosition {
    JointPosition {
        axes: joints.degrees().map(to_f32).to_vec(),
    }
}

/// A position as the ledger writes it.
#[must_use]
pub fn pose_of_target(target: &XyzwprExt) -> PoseMmDeg {
    let XyzwprExt {
        x, y, z, w, p, r, ..
    } = *target;
    [x, y, z, w, p, r].map(f64::from).into()
}

pub(super) fn frames(
    user_frame: &Position,
    tool: &Position,
) -> Result<Frames, (&'static str, PoseError)> {
    Ok(Frames {
        user_frame: pose(user_frame).map_err(|error| ("$UFRAME", error))?,
        tool: pose(tool).map_err(|error| ("$UTOOL", error))?,
    })
}

pub(super) fn pose(position: &Position) -> Result<Pose, PoseError> {
    let Position {
        x, y, z, w, p, r, ..
    } = *position;
    let mm = |value: f32| Millimeters(f64::from(value));
    let deg = |value: f32| Degrees(f64::from(value));
    Pose::try_from_xyzwpr(&Xyzwpr {
        x: mm(x),
        y: mm(y),
        z: mm(z),
        w: deg(w),
        p: deg(p),
        r: deg(r),
    })
}

pub(super) fn components(pose: &Xyzwpr) -> [f64; 6] {
    [pose.x.0, pose.y.0, pose.z.0, pose.w.0, pose.p.0, pose.r.0]
}

#[expect(clippy::cast_possible_truncation, reason = "KAREL's REAL has 32 bits")]
pub(super) fn to_f32(value: f64) -> f32 {
    value as f32
}

pub(super) fn configuration(config: Config) -> Configuration {
    Configuration {
        flip: match config.wrist {
            karel::Wrist::Flip => Flip::Flip,
            karel::Wrist::NoFlip => Flip::NoFlip,
        },
        elbow: match config.elbow {
            karel::Elbow::Up => Elbow::Up,
            karel::Elbow::Down => Elbow::Down,
        },
        front: match config.front {
            karel::Front::Toward => Front::Toward,
            karel::Front::Back => Front::Back,
        },
        turns: config.turns,
    }
}

pub(super) fn karel_config(configuration: Configuration) -> Config {
    Config {
        wrist: match configuration.flip {
            Flip::Flip => karel::Wrist::Flip,
            Flip::NoFlip => karel::Wrist::NoFlip,
        },
        elbow: match configuration.elbow {
            Elbow::Up => karel::Elbow::Up,
            Elbow::Down => karel::Elbow::Down,
        },
        front: match configuration.front {
            Front::Toward => karel::Front::Toward,
            Front::Back => karel::Front::Back,
        },
        turns: configuration.turns,
    }
}
