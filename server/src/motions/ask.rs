//! What a caller asks of a controller of tier 2, resolved: rounded, checked, and counted from where the arm is.

use std::time::Duration;

use api::{MotionBody, MotionType, PoseBody, ProblemCode, TargetBody, Tier, Violation};
use kinematics::{PendantJoints, Pose, Seed, Xyzwpr};

use units::MmPerSec;

use super::intent::mdeg;
use super::record::{apart, point_of_thousandths, rounded};
use super::{Asked, Speed};
use crate::config::RobotPlan;
use crate::link::cell_server::CellServerLink;
use crate::problem::Problem;
use crate::state::Robot;
use crate::target::{Refusal, joints_of};
use crate::wire_bodies::point_of;

/// The oldest report that still says where the arm is: polls come five a second.
const FRESH: Duration = Duration::from_millis(500);
/// Between two points of a line that are checked.
const STEP_MM: f64 = 10.0;
const STEP_DEG: f64 = 3.0;
/// The most points of a line that are checked.
const MAX_STEPS: u32 = 400;

/// Where the arm is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Actual {
    /// The tool center point in the user frame, in thousandths.
    pub(crate) point: [i32; 6],
    pub(crate) joints: PendantJoints,
}

/// Where the arm stands, by a fresh report.
///
/// # Errors
/// `pose-stale` if there is no fresh one, if the arm moves or is held, or if a motion is under way.
pub(crate) fn actual(robot: &Robot, link: &CellServerLink) -> Result<Actual, Problem> {
    let stale = |why: String| Err(Problem::not_sent(ProblemCode::PoseStale, why).retryable());
    if let Some(open) = robot.motions.book.open().first() {
        return stale(format!("motion {open} is under way"));
    }
    let view = link.view();
    let Some(seen) = view.status.filter(|_| view.is_connected()) else {
        return stale("the controller has not reported where the arm is".to_owned());
    };
    let age = seen.at.elapsed();
    if age > FRESH {
        let (age, fresh) = (age.as_millis(), FRESH.as_millis());
        return stale(format!(
            "the controller's last report is {age} ms old; {fresh} ms is the limit"
        ));
    }
    if seen.line.moving {
        return stale("the arm moves".to_owned());
    }
    if seen.line.held {
        return stale("a motion is on hold and may go on".to_owned());
    }
    Ok(Actual {
        point: seen.line.pose.thousandths(),
        joints: PendantJoints::from_degrees(seen.line.joints.degrees().map(|joint| joint.0)),
    })
}

/// The motion a body asks for. `refused` words what the kinematics say.
///
/// # Errors
/// A value that does not fit, a target the arm cannot reach, or a pose that is not known well enough.
pub(crate) fn resolve(
    robot: &Robot,
    link: &CellServerLink,
    body: &MotionBody,
    refused: fn(&Refusal) -> Problem,
) -> Result<Asked, Problem> {
    let plan = &robot.plan;
    if plan.tier == Tier::SeedStatus {
        return resolve_seed(robot, link, body, refused);
    }
    let speed = speed(body, plan)?;
    let to_point = |point: &Xyzwpr| -> Result<Asked, Problem> {
        let (point, solution) = plan.solve_point(point).map_err(|error| refused(&error))?;
        Ok(Asked {
            motion_type: body.motion_type,
            point,
            speed,
            joints: rounded(&solution.joints),
            to_joints: false,
            output: None,
            from: None,
        })
    };
    match (body.motion_type, &body.target) {
        (MotionType::Joint, Some(TargetBody::Pose(pose))) => to_point(&point_of(pose)),
        (MotionType::Joint, Some(TargetBody::Joints(joints))) => {
            to_joints(plan, body.motion_type, (*joints).into(), speed)
                .map_err(|error| refused(&error))
        }
        (MotionType::Home, _) => {
            let home = plan.model.home().degrees();
            to_joints(plan, body.motion_type, home, speed).map_err(|error| refused(&error))
        }
        (MotionType::Linear, Some(TargetBody::Pose(pose))) => {
            let asked = to_point(&point_of(pose))?;
            check_line(robot, link, &asked)?;
            Ok(asked)
        }
        (MotionType::Relative, Some(TargetBody::Pose(change))) => {
            let from = actual(robot, link)?.point;
            let asked = to_point(&moved(from, change))?;
            Ok(Asked {
                from: Some(from),
                ..asked
            })
        }
        (MotionType::Joint | MotionType::Linear | MotionType::Relative | MotionType::Output, _) => {
            Err(invalid("target", "this motion needs another target", None))
        }
    }
}

/// The motion a body asks for where the seed's pose server moves: poses at mm/s, the joints together.
fn resolve_seed(
    robot: &Robot,
    link: &CellServerLink,
    body: &MotionBody,
    refused: fn(&Refusal) -> Problem,
) -> Result<Asked, Problem> {
    let plan = &robot.plan;
    let speed = MmPerSec(body.speed_mm_s.ok_or_else(|| {
        invalid(
            "speed_percent",
            "the program on this controller takes a speed in mm/s only",
            body.speed_percent,
        )
    })?);
    let mut from = None;
    let prepared = match (body.motion_type, &body.target) {
        (MotionType::Joint, Some(TargetBody::Pose(pose))) => {
            plan.prepare_point(&point_of(pose), speed)
        }
        (MotionType::Joint, Some(TargetBody::Joints(joints))) => {
            plan.prepare_joints((*joints).into(), speed)
        }
        (MotionType::Home, _) => plan.prepare_home(speed),
        (MotionType::Relative, Some(TargetBody::Pose(change))) => {
            let start = actual(robot, link)?.point;
            from = Some(start);
            plan.prepare_point(&moved(start, change), speed)
        }
        (MotionType::Linear, _) => {
            return Err(Problem::not_sent(
                ProblemCode::NotSupported,
                "the robot's controller runs the seed program: it moves the joints together and cannot keep a straight line",
            ));
        }
        (MotionType::Joint | MotionType::Relative | MotionType::Output, _) => {
            return Err(invalid("target", "this motion needs another target", None));
        }
    };
    Ok(Asked {
        motion_type: body.motion_type,
        from,
        ..Asked::of(&prepared.map_err(|refusal| refused(&refusal))?)
    })
}

/// A pose, and what it is changed by.
fn moved(from: [i32; 6], change: &PoseBody) -> Xyzwpr {
    let (at, by) = (point_of_thousandths(from), point_of(change));
    Xyzwpr {
        x: at.x + by.x,
        y: at.y + by.y,
        z: at.z + by.z,
        w: at.w + by.w,
        p: at.p + by.p,
        r: at.r + by.r,
    }
}

fn to_joints(
    plan: &RobotPlan,
    motion_type: MotionType,
    asked: [f64; 6],
    speed: Speed,
) -> Result<Asked, Refusal> {
    let _legal = joints_of(asked)?;
    // What is checked is what the wire carries.
    let joints = rounded(&PendantJoints::from_degrees(asked));
    plan.model
        .check_limits(&joints)
        .map_err(Refusal::JointLimits)?;
    let point = plan.point_at(&joints).xyzwpr();
    Ok(Asked {
        motion_type,
        point: [
            point.x.0, point.y.0, point.z.0, point.w.0, point.p.0, point.r.0,
        ]
        .map(mdeg),
        speed,
        joints,
        to_joints: true,
        output: None,
        from: None,
    })
}

/// The speed in the unit the controller takes for this motion.
fn speed(body: &MotionBody, plan: &RobotPlan) -> Result<Speed, Problem> {
    let linear = body.motion_type == MotionType::Linear;
    match (linear, body.speed_mm_s, body.speed_percent) {
        (true, Some(speed), _) => whole("speed_mm_s", speed, plan.max_speed).map(Speed::MmPerSec),
        (false, _, Some(percent)) => {
            let percent = whole("speed_percent", percent, 100)?;
            Ok(Speed::Percent(u8::try_from(percent).unwrap_or(100)))
        }
        (true, None, _) => Err(invalid(
            "speed_percent",
            "the speed along a straight line is given in mm/s: `speed_mm_s`",
            body.speed_percent,
        )),
        (false, _, None) => Err(invalid(
            "speed_mm_s",
            "this controller takes the speed of a joint motion in percent: `speed_percent`",
            body.speed_mm_s,
        )),
    }
}

fn whole(item: &str, value: f64, max: u16) -> Result<u16, Problem> {
    if (1.0..=f64::from(max)).contains(&value) && value.fract() == 0.0 {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a whole number of 1 to u16::MAX was just checked"
        )]
        return Ok(value as u16);
    }
    let message = format!("{value} is not a whole number of 1 to {max}");
    let detail = format!("{item}: {message}");
    Err(
        Problem::not_sent(ProblemCode::Validation, detail).violations(vec![Violation {
            item: item.to_owned(),
            message,
            value: value.is_finite().then_some(value),
            min: Some(1.0),
            max: Some(f64::from(max)),
        }]),
    )
}

fn invalid(item: &str, message: &str, value: Option<f64>) -> Problem {
    let detail = format!("{item}: {message}");
    Problem::not_sent(ProblemCode::Validation, detail).violations(vec![Violation {
        item: item.to_owned(),
        message: message.to_owned(),
        value,
        ..Violation::default()
    }])
}

/// Checks the points of a straight line: reach, joint limits, singularities, and that no joint has to jump.
///
/// It begins where the motions before it end, or where the arm stands.
fn check_line(robot: &Robot, link: &CellServerLink, asked: &Asked) -> Result<(), Problem> {
    let plan = &robot.plan;
    let book = &robot.motions.book;
    let start = match book.open().last().and_then(|id| book.get(*id)) {
        Some(before) => Actual {
            point: before.asked.point,
            joints: before.asked.joints,
        },
        None => actual(robot, link)?,
    };
    let pose = |point| {
        Pose::try_from_xyzwpr(&point_of_thousandths(point))
            .map_err(|error| Problem::not_sent(ProblemCode::Validation, error.to_string()))
    };
    let (from, to) = (pose(start.point)?, pose(asked.point)?);
    let (distance_mm, angle_deg) = apart(start.point, asked.point).unwrap_or((0.0, 0.0));
    let steps = steps(distance_mm, angle_deg);
    let mut joints = start.joints;
    for step in 1..=steps {
        let share = f64::from(step) / f64::from(steps);
        let refuse = |code: ProblemCode, what: String| {
            let detail = format!("at {:.0} % of the straight line: {what}", share * 100.0);
            Err(Problem::not_sent(code, detail)
                .hint("Another target, a JOINT motion, or a point between may avoid it."))
        };
        let between = from
            .isometry()
            .try_lerp_slerp(to.isometry(), share, 1e-9)
            .and_then(|between| Pose::try_from_isometry(between).ok());
        let Some(between) = between else {
            return refuse(
                ProblemCode::Singularity,
                "the tool would turn by half a turn, and which way is not said".to_owned(),
            );
        };
        let solution = plan
            .model
            .inverse(&plan.frames.flange_in_world(&between), Seed::Near(joints));
        let solution = match solution {
            Ok(solution) => solution,
            Err(error) => {
                let refusal = Refusal::Kinematics(error);
                return refuse(refusal.code(), refusal.to_string());
            }
        };
        if solution.singularity.near().next().is_some() {
            let refusal = Refusal::Singular {
                singularity: solution.singularity,
            };
            return refuse(refusal.code(), refusal.to_string());
        }
        let jump = largest_change(&joints, &solution.joints);
        if jump > MAX_JUMP_DEG {
            return refuse(
                ProblemCode::NoSolutionInConfiguration,
                format!("a joint would have to turn by {jump:.1} degrees at once"),
            );
        }
        joints = solution.joints;
    }
    // The controller keeps the configuration of the line's end in mind, so both must be the same arm.
    let missed = largest_change(&joints, &asked.joints);
    if missed > MAX_JUMP_DEG {
        let detail = format!(
            "the straight line ends in another configuration than the controller's, {missed:.1} degrees away"
        );
        return Err(Problem::not_sent(
            ProblemCode::NoSolutionInConfiguration,
            detail,
        ));
    }
    Ok(())
}

/// The largest turn of a joint between two points that are checked.
const MAX_JUMP_DEG: f64 = 20.0;

fn steps(distance_mm: f64, angle_deg: f64) -> u32 {
    let steps = (distance_mm / STEP_MM).max(angle_deg / STEP_DEG).ceil();
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "clamped to a small range; a number of checks, not a value of the caller's"
    )]
    let steps = steps.clamp(1.0, f64::from(MAX_STEPS)) as u32;
    steps
}

fn largest_change(a: &PendantJoints, b: &PendantJoints) -> f64 {
    a.degrees()
        .into_iter()
        .zip(b.degrees())
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max)
}

/// How long a joint motion takes, in seconds: as a virtual controller moves, all joints together within the model's speeds,
/// accelerations and jerks.
pub(crate) fn joint_duration(
    plan: &RobotPlan,
    from: &PendantJoints,
    to: &PendantJoints,
    percent: u8,
) -> f64 {
    robotics::joint_seconds(plan.model, from, to, f64::from(percent) / 100.0)
}

/// About how long a straight line takes, in seconds: at its speed, without the ramps.
pub(crate) fn line_duration(from: [i32; 6], to: [i32; 6], speed_mm_s: u16) -> Option<f64> {
    let (distance_mm, _) = apart(from, to)?;
    Some(distance_mm / f64::from(speed_mm_s))
}
