//! Where the tool is.

use api::arms::{ArmForwardBody, ArmForwardResult, ArmPoint};
use kinematics::Frames;
use kinematics::serial::{FiveJoints, SerialError};
use nalgebra::Point3;
use units::Degrees;

use crate::arm::Arm;
use crate::convert::{frames_of, position_of, shown, shown_pose, zyz_body};
use crate::refusal::Refusal;
use crate::shape;

/// The tool's pose at given joints, and every frame of the table on the way to it.
///
/// The product of the links' transforms: textbook (1.22), thesis (12); the five-link arm's points A to F by the
/// paper's (1) and (2). Poses are in the user frame. Values outside the ranges have a pose too; `outside` names them.
///
/// # Errors
/// No such model, not as many values as it has joints, a value or a frame that is none.
pub fn forward(model: &str, body: &ArmForwardBody) -> Result<ArmForwardResult, Refusal> {
    let arm = Arm::named(model)?;
    let joints = arm.joints("joints_deg_mm", &body.joints_deg_mm)?;
    let frames = frames_of(&body.frames)?;
    let of_joints = |error: SerialError| Refusal::invalid("joints_deg_mm", error);
    // Without the tool the last frame is the flange.
    let to_user = Frames {
        tool: kinematics::Pose::identity(),
        ..frames
    };
    let in_user = arm.serial.with_frames(&to_user);
    let mut link_frames = in_user.frames(&joints).map_err(of_joints)?;
    let flange = in_user.forward(&joints).map_err(of_joints)?;
    let tcp = flange * frames.tool;
    let capsules = shape::placed(&shape::capsules(&arm), &link_frames);
    link_frames.push(tcp);
    Ok(ArmForwardResult {
        tcp: shown_pose(&tcp),
        tcp_zyz: zyz_body(&tcp),
        flange: shown_pose(&flange),
        points: points(&arm, &body.joints_deg_mm, &frames),
        capsules,
        configuration: arm.configuration(&body.joints_deg_mm),
        outside: arm.outside(&joints),
        link_frames: link_frames.iter().map(shown_pose).collect(),
    })
}

/// A to F of the five-link arm.
fn points(arm: &Arm, joints: &[f64], frames: &Frames) -> Vec<ArmPoint> {
    let joints: Result<[f64; 5], _> = joints.try_into();
    let (Some(five), Ok(joints)) = (arm.five_link(), joints) else {
        return Vec::new();
    };
    let joints: FiveJoints = joints.map(Degrees);
    let X_UW = frames.user_frame.inverse();
    five.points(&joints).map_or_else(
        |_| Vec::new(),
        |points| {
            let named = ["A", "B", "C", "D", "E", "F"].into_iter().zip(points);
            named
                .map(|(name, point)| {
                    let p = X_UW.isometry() * Point3::from(point);
                    ArmPoint {
                        name: name.to_owned(),
                        at_mm: [p.x, p.y, p.z].map(shown),
                    }
                })
                .collect()
        },
    )
}

/// The tool center point of an arm that already has its frames.
pub(crate) fn tcp(
    framed: &kinematics::serial::SerialArm,
    joints: &kinematics::serial::JointValues,
) -> [f64; 3] {
    framed
        .forward(joints)
        .map_or([0.0; 3], |pose| position_of(&pose))
}
