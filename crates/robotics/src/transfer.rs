//! An arm among obstacles.

mod goals;

use api::arms::{ArmCapsule, ArmObstacle, ArmTransferBody, ArmTransferResult};
use kinematics::Pose;
use kinematics::serial::{JointKind, JointValues, SerialError};
use planning::arm::{ArmError, ArmPath, ArmShape, Capsule, Obstacle, Scene, Workplace};
use planning::{Sampling, Wanted};
use units::Millimeters;

use crate::arm::Arm;
use crate::convert::{pose_at, position_of, shown};
use crate::refusal::{Refusal, RefusalKind, count_or, length, within, within_or};
use crate::shape;
use goals::goals;

const MOST_OBSTACLES: usize = 100;
const MOST_CAPSULES: usize = 32;
/// Points of the flange that are told for each piece of the way.
const PARTS: u32 = 16;

/// A way from one joint set to another, or to a pose, on which the arm's capsules touch no obstacle: a probabilistic roadmap in joint
/// space, textbook 2.2.3, distances by `parry3d`.
///
/// The joints move evenly between the points of the answer. The arm keeps from itself too: 20 mm, or the margin if that
/// is less, between capsules that are not on neighboring links and do not touch at home.
///
/// # Errors
/// No such model; joints outside their ranges; a pose that is out of reach; a start or goal that touches an obstacle or
/// the arm itself, with capsule, obstacle and distance (of a pose, its nearest joint set); a size that is none; no way
/// after all samples.
pub fn transfer(model: &str, body: &ArmTransferBody) -> Result<ArmTransferResult, Refusal> {
    transfer_while(model, body, Wanted::ALWAYS)
}

/// As [`transfer`], as long as the answer is `wanted`.
///
/// # Errors
/// As [`transfer`]; [`RefusalKind::BrokenOff`].
pub fn transfer_while(
    model: &str,
    body: &ArmTransferBody,
    wanted: Wanted<'_>,
) -> Result<ArmTransferResult, Refusal> {
    let arm = Arm::named(model)?;
    let start = arm.joints_inside("start_deg_mm", &body.start_deg_mm)?;
    let (goal_key, goals) = goals(&arm, model, body)?;
    let margin = within_or("margin_mm", body.margin_mm, 20.0, [5.0, 1000.0], "mm")?;
    let most = count_or("samples", body.samples, 5000, [1, 10_000])?;
    let capsules = capsules(&arm, body)?;
    let shape = capsules.iter().map(|capsule| Capsule {
        link: capsule.link,
        from: capsule.from_mm,
        to: capsule.to_mm,
        radius: capsule.radius_mm,
    });
    let shape = ArmShape::try_new(arm.serial, shape.collect())
        .map_err(|error| Refusal::invalid("capsules", error))?;
    let scene = scene(body)?;
    let sampling = Sampling {
        seed: body.seed.unwrap_or(0),
        most,
        ..Sampling::default()
    };
    let workplace = Workplace {
        arm: arm.serial,
        shape: &shape,
        scene: &scene,
        margin: Millimeters(margin),
    };
    let path = nearest_way(&workplace, &start, &goals, &sampling, wanted);
    let path = path.map_err(|error| refused(&error, goal_key))?;
    let points = path.points();
    let mut placed = Vec::new();
    for joints in points {
        let frames = arm.serial.frames(joints).map_err(of_another_arm)?;
        placed.push(shape::placed(&capsules, &frames));
    }
    let joints = arm.serial.joint_list();
    let slides = joints
        .iter()
        .any(|joint| joint.kind == JointKind::Prismatic);
    Ok(ArmTransferResult {
        points_deg_mm: points.iter().map(|point| arm.shown(point)).collect(),
        length_deg: shown(path.length_deg()),
        length_mm: slides.then(|| shown(path.length_mm())),
        flange_mm: flange_way(&arm, points)?,
        capsules: placed,
    })
}

/// The way to the first goal that there is one to; why there is none to the first, if to none.
fn nearest_way(
    workplace: &Workplace<'_>,
    start: &JointValues,
    goals: &[JointValues],
    sampling: &Sampling,
    wanted: Wanted<'_>,
) -> Result<ArmPath, ArmError> {
    let mut first = None;
    for goal in goals {
        match workplace.transfer(start, goal, sampling, wanted) {
            // Another goal does not help.
            Err(error @ (ArmError::BrokenOff(_) | ArmError::Touches { end: "start", .. })) => {
                return Err(error);
            }
            Err(error) => first = first.or(Some(error)),
            Ok(path) => return Ok(path),
        }
    }
    Err(first.unwrap_or(ArmError::GaveUp { samples: 0 }))
}

fn of_another_arm(error: SerialError) -> Refusal {
    Refusal::invalid("", error)
}

fn capsules(arm: &Arm, body: &ArmTransferBody) -> Result<Vec<ArmCapsule>, Refusal> {
    let mut all = match &body.capsules {
        Some(capsules) => {
            length("capsules", capsules.len(), [1, MOST_CAPSULES], "capsules")?;
            capsules.clone()
        }
        None => shape::capsules(arm),
    };
    let own = all.len();
    length(
        "tool_capsules",
        body.tool_capsules.len(),
        [0, MOST_CAPSULES],
        "capsules",
    )?;
    all.extend(body.tool_capsules.iter().cloned());
    let links = arm.serial.degrees_of_freedom();
    for (index, capsule) in all.iter().enumerate() {
        let path = match index.checked_sub(own) {
            Some(index) => format!("tool_capsules[{index}]"),
            None => format!("capsules[{index}]"),
        };
        if capsule.link > links {
            let detail = format!("it is {}; links are 0 to {links}", capsule.link);
            return Err(Refusal::invalid(format!("{path}.link"), detail));
        }
        for (key, point) in [("from_mm", capsule.from_mm), ("to_mm", capsule.to_mm)] {
            for (axis, value) in point.into_iter().enumerate() {
                let _ = within(&format!("{path}.{key}[{axis}]"), value, [-1e5, 1e5], "mm")?;
            }
        }
        let _ = within(
            &format!("{path}.radius_mm"),
            capsule.radius_mm,
            [0.001, 1e5],
            "mm",
        )?;
    }
    Ok(all)
}

fn scene(body: &ArmTransferBody) -> Result<Scene, Refusal> {
    length(
        "obstacles",
        body.obstacles.len(),
        [0, MOST_OBSTACLES],
        "obstacles",
    )?;
    let mut obstacles = Vec::new();
    for (index, obstacle) in body.obstacles.iter().enumerate() {
        obstacles.push(obstacle_of(&format!("obstacles[{index}]"), obstacle)?);
    }
    Scene::try_new(&obstacles).map_err(|error| match &error {
        ArmError::Obstacle {
            obstacle, value, ..
        } => {
            let path = format!("obstacles[{}]", obstacle.saturating_sub(1));
            Refusal::invalid(path, &error).with_value(*value)
        }
        ArmError::Capsules { .. }
        | ArmError::Capsule { .. }
        | ArmError::Link { .. }
        | ArmError::Obstacles { .. }
        | ArmError::Margin { .. }
        | ArmError::Joints { .. }
        | ArmError::Limits { .. }
        | ArmError::Touches { .. }
        | ArmError::BrokenOff(_)
        | ArmError::GaveUp { .. } => Refusal::invalid("obstacles", &error),
    })
}

fn obstacle_of(path: &str, body: &ArmObstacle) -> Result<Obstacle, Refusal> {
    let placed = |pose| -> Result<Pose, Refusal> { pose_at(&format!("{path}.pose"), pose) };
    let size = |key: &str, value: f64| within(&format!("{path}.{key}"), value, [0.001, 1e5], "mm");
    match body {
        ArmObstacle::Box { pose, size_mm } => {
            for (axis, value) in size_mm.iter().enumerate() {
                let _ = size(&format!("size_mm[{axis}]"), *value)?;
            }
            Ok(Obstacle::Box {
                pose: placed(pose)?,
                size: size_mm.map(Millimeters),
            })
        }
        ArmObstacle::Cylinder {
            pose,
            radius_mm,
            height_mm,
        } => Ok(Obstacle::Cylinder {
            pose: placed(pose)?,
            radius: Millimeters(size("radius_mm", *radius_mm)?),
            height: Millimeters(size("height_mm", *height_mm)?),
        }),
        ArmObstacle::KeepOut { min_mm, max_mm } => {
            for (axis, (min, max)) in min_mm.iter().zip(max_mm).enumerate() {
                let _ = within(&format!("{path}.min_mm[{axis}]"), *min, [-1e5, 1e5], "mm")?;
                let least = min + 0.001;
                let _ = within(&format!("{path}.max_mm[{axis}]"), *max, [least, 1e5], "mm")?;
            }
            Ok(Obstacle::KeepOut {
                min: min_mm.map(Millimeters),
                max: max_mm.map(Millimeters),
            })
        }
    }
}

/// Capsules and obstacles count from 1 inside, from 0 in a path.
fn refused(error: &ArmError, goal_key: &str) -> Refusal {
    let key_of = |end: &str| {
        if end == "goal" {
            goal_key
        } else {
            "start_deg_mm"
        }
    };
    match error {
        ArmError::Touches { end, touch } => Refusal {
            min: Some(touch.margin.0),
            ..Refusal::invalid(key_of(end), error).with_value(touch.distance.0)
        },
        ArmError::Limits { end, .. } => Refusal::new(RefusalKind::JointLimit, key_of(end), error),
        ArmError::Joints { end, .. } => Refusal::invalid(key_of(end), error),
        ArmError::BrokenOff(error) => Refusal::broken_off(*error),
        ArmError::GaveUp { .. } => Refusal::new(RefusalKind::NoWay, "", error),
        ArmError::Margin { .. } => Refusal::invalid("margin_mm", error),
        ArmError::Capsules { .. } | ArmError::Capsule { .. } | ArmError::Link { .. } => {
            Refusal::invalid("capsules", error)
        }
        ArmError::Obstacles { .. } | ArmError::Obstacle { .. } => {
            Refusal::invalid("obstacles", error)
        }
    }
}

fn flange_way(arm: &Arm, points: &[JointValues]) -> Result<Vec<[f64; 3]>, Refusal> {
    let at = |joints: &JointValues| {
        let X_WF = arm.serial.forward(joints).map_err(of_another_arm)?;
        Ok(position_of(&X_WF))
    };
    let pairs = points.iter().zip(points.iter().skip(1));
    let inner = pairs.flat_map(|(a, b)| {
        let shares = (0..PARTS).map(|part| f64::from(part) / f64::from(PARTS));
        shares.map(move |share| at(&a.toward(b, share)))
    });
    inner.chain(points.last().map(at)).collect()
}
