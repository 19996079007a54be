//! How a previewed motion would go: joints and tool in time.

use api::MotionType;
use api::arms::ArmFrames;
use api::trajectory::{
    JointStates, MotionProfile, ToolPathBody, ToolPathKind, TrajectoryBody, TrajectoryKind,
};
use kinematics::{Axis, PendantJoints};

use crate::config::RobotPlan;
use crate::motions::{Asked, Speed, point_of_thousandths};
use crate::wire_bodies::{pose_body, shown};

/// About so many samples are told.
const SAMPLES: f64 = 100.0;

/// The motion from the joints where the arm stands; nothing where its way or its speed is the controller's own affair.
pub(super) fn profile(
    plan: &RobotPlan,
    from: &PendantJoints,
    asked: &Asked,
) -> Option<MotionProfile> {
    match (asked.motion_type, asked.speed) {
        (MotionType::Linear, Speed::MmPerSec(speed)) => line(plan, from, asked, f64::from(speed)),
        (MotionType::Joint | MotionType::Home | MotionType::Relative, Speed::Percent(percent)) => {
            joints(plan, from, &asked.joints, f64::from(percent) / 100.0)
        }
        (MotionType::Output, _)
        | (MotionType::Linear, Speed::Percent(_))
        | (MotionType::Joint | MotionType::Home | MotionType::Relative, Speed::MmPerSec(_)) => None,
    }
}

fn frames(plan: &RobotPlan) -> ArmFrames {
    ArmFrames {
        user_frame: Some(pose_body(&plan.frames.user_frame.xyzwpr())),
        tool: Some(pose_body(&plan.frames.tool.xyzwpr())),
    }
}

fn joints(
    plan: &RobotPlan,
    from: &PendantJoints,
    to: &PendantJoints,
    share: f64,
) -> Option<MotionProfile> {
    let at = |joints: &PendantJoints| JointStates {
        position_deg_mm: joints.degrees().to_vec(),
        ..JointStates::default()
    };
    let speeds = Axis::ALL.map(|axis| share * plan.model.max_speed(axis).0);
    let question = TrajectoryBody {
        kind: TrajectoryKind::JerkLimited,
        start: at(from),
        goal: at(to),
        via_deg_mm: Vec::new(),
        durations_s: Vec::new(),
        max_velocity_deg_mm_s: Some(speeds.to_vec()),
        max_acceleration_deg_mm_s2: None,
        max_jerk_deg_mm_s3: None,
        period_s: None,
        frames: frames(plan),
    };
    let answer = robotics::trajectory(plan.model.name(), &question).ok()?;
    Some(MotionProfile {
        duration_s: shown(answer.duration_s),
        slowed: 1.0,
        limited_by: answer.slowest,
        samples: answer.samples,
        peaks: answer.peaks,
        failure: None,
    })
}

fn line(
    plan: &RobotPlan,
    from: &PendantJoints,
    asked: &Asked,
    speed_mm_s: f64,
) -> Option<MotionProfile> {
    let start = plan.point_at(from);
    let target = point_of_thousandths(asked.point);
    let begins = start.xyzwpr();
    let way = [
        target.x.0 - begins.x.0,
        target.y.0 - begins.y.0,
        target.z.0 - begins.z.0,
    ];
    let length = way.iter().map(|part| part * part).sum::<f64>().sqrt();
    let question = ToolPathBody {
        kind: ToolPathKind::Line,
        poses: vec![pose_body(&begins), pose_body(&target)],
        start_deg_mm: Some(from.degrees().to_vec()),
        task: None,
        speed_mm_s,
        acceleration_mm_s2: None,
        jerk_mm_s3: None,
        turning_deg_s: None,
        period_s: Some((length / speed_mm_s / SAMPLES).clamp(0.001, 1.0)),
        frames: frames(plan),
    };
    let answer = robotics::tool_path(plan.model.name(), &question).ok()?;
    Some(MotionProfile {
        duration_s: shown(answer.duration_s),
        slowed: answer.slowed,
        limited_by: answer.limited_by,
        samples: answer.samples,
        peaks: answer.peaks,
        failure: answer.failure,
    })
}
