//! An arm among obstacles.

use api::arms::{ArmCapsule, ArmObstacle, ArmTransferBody, ArmTransferResult};
use kinematics::serial::SerialError;
use kinematics::{ArmModel, PendantJoints, Pose};
use planning::Sampling;
use planning::arm::{self as planner, ArmError, ArmShape, Capsule, Obstacle, Scene};
use units::Millimeters;

use crate::arm::Arm;
use crate::convert::{pose_at, position_of, shown};
use crate::refusal::{Refusal, RefusalKind, count_or, length, within, within_or};
use crate::shape;

const MOST_OBSTACLES: usize = 100;
const MOST_CAPSULES: usize = 32;
/// Points of the flange that are told for each piece of the way.
const PARTS: u32 = 16;

/// A way from one joint set to another on which the arm's capsules touch no obstacle: a probabilistic roadmap in joint
/// space, textbook 2.2.3, distances by `parry3d`.
///
/// The joints move evenly between the points of the answer. The arm keeps from itself too: 20 mm, or the margin if that
/// is less, between capsules that are not on neighboring links and do not touch at home.
///
/// # Errors
/// No such model, or one that the closed form does not cover; joints outside their ranges; a start or goal that
/// touches an obstacle or the arm itself, with capsule, obstacle and distance; a size that is none; no way after all samples.
pub fn transfer(model: &str, body: &ArmTransferBody) -> Result<ArmTransferResult, Refusal> {
    let arm = Arm::named(model)?;
    let closed = covered(&arm)?;
    let start = pendant(&arm, "start_deg", &body.start_deg)?;
    let goal = pendant(&arm, "goal_deg", &body.goal_deg)?;
    let margin = within_or("margin_mm", body.margin_mm, 20.0, [5.0, 1000.0], "mm")?;
    let most = count_or("samples", body.samples, 5000, [1, 10_000])?;
    let capsules = capsules(&arm, body)?;
    let shape = capsules.iter().map(|capsule| Capsule {
        link: capsule.link,
        from: capsule.from_mm,
        to: capsule.to_mm,
        radius: capsule.radius_mm,
    });
    let shape = ArmShape::try_new(closed, shape.collect())
        .map_err(|error| Refusal::invalid("capsules", error))?;
    let scene = scene(body)?;
    let sampling = Sampling {
        seed: body.seed.unwrap_or(0),
        most,
        ..Sampling::default()
    };
    let path = planner::transfer(
        closed,
        &shape,
        &scene,
        &start,
        &goal,
        Millimeters(margin),
        &sampling,
    )
    .map_err(|error| refused(&error))?;
    let points = path.points();
    let mut placed = Vec::new();
    for point in points {
        let joints = arm.joints("", &point.degrees())?;
        let frames = arm
            .serial
            .frames(&joints)
            .map_err(|error: SerialError| Refusal::invalid("", error))?;
        placed.push(shape::placed(&capsules, &frames));
    }
    Ok(ArmTransferResult {
        points_deg: points
            .iter()
            .map(|point| point.degrees().map(shown).to_vec())
            .collect(),
        length_deg: shown(path.length_deg()),
        flange_mm: flange_way(closed, points),
        capsules: placed,
    })
}

/// The closed form's model, of an arm that has one.
pub(crate) fn covered(arm: &Arm) -> Result<&'static ArmModel, Refusal> {
    arm.closed.ok_or_else(|| {
        let names = ArmModel::builtin_names().join(", ");
        let detail = format!(
            "this is done for arms with a closed form only ({names}), not for {}",
            arm.name()
        );
        Refusal::invalid("", detail)
    })
}

pub(crate) fn pendant(arm: &Arm, path: &str, degrees: &[f64]) -> Result<PendantJoints, Refusal> {
    let _ = arm.joints_inside(path, degrees)?;
    Arm::pendant(degrees).ok_or_else(|| Refusal::invalid(path, "six joint values are needed"))
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
        | ArmError::NotFinite { .. }
        | ArmError::Limits { .. }
        | ArmError::Touches { .. }
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
fn refused(error: &ArmError) -> Refusal {
    match error {
        ArmError::Touches { end, touch } => Refusal {
            min: Some(touch.margin.0),
            ..Refusal::invalid(format!("{end}_deg"), error).with_value(touch.distance.0)
        },
        ArmError::Limits { end, .. } => {
            Refusal::new(RefusalKind::JointLimit, format!("{end}_deg"), error)
        }
        ArmError::NotFinite { end, .. } => Refusal::invalid(format!("{end}_deg"), error),
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

fn flange_way(arm: &ArmModel, points: &[PendantJoints]) -> Vec<[f64; 3]> {
    let at = |joints: &PendantJoints| position_of(&arm.forward(joints));
    let pairs = points.iter().zip(points.iter().skip(1));
    let inner = pairs.flat_map(|(a, b)| {
        (0..PARTS).map(move |part| {
            let share = f64::from(part) / f64::from(PARTS);
            let (from, to) = (a.degrees(), b.degrees());
            let mut joints = from;
            for (joint, to) in joints.iter_mut().zip(to) {
                *joint += share * (to - *joint);
            }
            at(&PendantJoints::from_degrees(joints))
        })
    });
    inner.chain(points.last().map(at)).collect()
}
