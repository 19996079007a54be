//! What the body of a motion says, checked: which fields go together, their ranges, and what the arm can do.

use std::time::Duration;

use api::{MotionBody, MotionType, ProblemCode, TargetBody, Violation};
use jiff::{SignedDuration, Timestamp};
use tokio::time::Instant;
use units::MmPerSec;

use crate::config::{MAX_DEADLINE_MS, RobotPlan};
use crate::problem::Problem;
use crate::state::Robot;
use crate::target::{Paths, Prepared, Refusal};
use crate::wire_bodies::point_of;

const PATHS: Paths = Paths {
    speed: "speed_mm_s",
    point: [
        "target.pose.x_mm",
        "target.pose.y_mm",
        "target.pose.z_mm",
        "target.pose.w_deg",
        "target.pose.p_deg",
        "target.pose.r_deg",
    ],
    joints: "target.joints",
};
/// The longest reason, in characters.
const MAX_REASON: usize = 200;
/// When a motion must have begun where the caller does not say.
const NOT_AFTER: Duration = Duration::from_secs(5);
/// The farthest `not_after`: a command that waits longer was given for another situation.
const MAX_NOT_AFTER: SignedDuration = SignedDuration::from_mins(10);

/// When a motion must have begun, and when its answer must be here.
///
/// The wall clock is read once, here; from then on time is the monotonic clock's, which nobody sets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timing {
    pub(super) begin_by: Instant,
    pub(super) deadline: Instant,
    pub(super) not_after: Timestamp,
}

/// Checks what needs no arm: which fields go together, and their ranges.
pub(super) fn check(
    body: &MotionBody,
    plan: &RobotPlan,
    now: Timestamp,
) -> Result<Timing, Problem> {
    let mut violations = Vec::new();
    if body.plan_id.is_some() {
        check_of_plan(body, &mut violations);
    } else {
        check_target(body, &mut violations);
        check_speed(body, &mut violations);
    }
    check_expected(body, &mut violations);
    if let Some(deadline) = body.deadline_ms
        && !(1..=MAX_DEADLINE_MS).contains(&deadline)
    {
        #[expect(clippy::cast_precision_loss, reason = "only shown")]
        violations.push(Violation {
            value: Some(deadline as f64),
            min: Some(1.0),
            max: Some(MAX_DEADLINE_MS as f64),
            ..violation(
                "deadline_ms",
                &format!("{deadline} ms is not from 1 to {MAX_DEADLINE_MS} ms"),
            )
        });
    }
    if let Some(reason) = &body.reason {
        let length = reason.chars().count();
        if length > MAX_REASON {
            violations.push(violation(
                "reason",
                &format!("{length} characters; {MAX_REASON} at most"),
            ));
        }
    }
    let left = body.not_after.map(|at| at.duration_since(now));
    if left.is_some_and(|left| left > MAX_NOT_AFTER) {
        let message = format!(
            "more than {} minutes from now",
            MAX_NOT_AFTER.as_secs() / 60
        );
        violations.push(violation("not_after", &message));
    }
    if let Some(first) = violations.first() {
        let detail = format!("{}: {}", first.item, first.message);
        return Err(Problem::not_sent(ProblemCode::Validation, detail).violations(violations));
    }
    let within = body
        .deadline_ms
        .map_or(plan.deadline, Duration::from_millis);
    let begin_within = match left {
        None => NOT_AFTER,
        Some(left) => match Duration::try_from(left) {
            Ok(left) if !left.is_zero() => left,
            Ok(_) | Err(_) => {
                let detail = format!(
                    "not_after: {:.0} has passed: it is {now:.0}",
                    body.not_after.unwrap_or(now)
                );
                return Err(Problem::not_sent(ProblemCode::DeadlinePassed, detail));
            }
        },
    };
    let start = Instant::now();
    Ok(Timing {
        begin_by: start + begin_within.min(within),
        deadline: start + within,
        not_after: body
            .not_after
            .unwrap_or_else(|| later(now, begin_within.min(within))),
    })
}

fn later(now: Timestamp, by: Duration) -> Timestamp {
    SignedDuration::try_from(by)
        .ok()
        .and_then(|by| now.checked_add(by).ok())
        .unwrap_or(now)
}

/// A plan says where to and how fast.
fn check_of_plan(body: &MotionBody, violations: &mut Vec<Violation>) {
    for (item, given) in [
        ("target", body.target.is_some()),
        ("relative_to", body.relative_to.is_some()),
        ("speed_mm_s", body.speed_mm_s.is_some()),
        ("speed_percent", body.speed_percent.is_some()),
    ] {
        if given {
            violations.push(violation(item, "is the plan's, where there is a `plan_id`"));
        }
    }
}

fn check_expected(body: &MotionBody, violations: &mut Vec<Violation>) {
    let tolerance = body
        .expect
        .as_ref()
        .and_then(|expect| expect.start_tolerance_deg);
    if let Some(tolerance) = tolerance
        && !(0.0..=180.0).contains(&tolerance)
    {
        violations.push(Violation {
            value: tolerance.is_finite().then_some(tolerance),
            min: Some(0.0),
            max: Some(180.0),
            ..violation(
                "expect.start_tolerance_deg",
                &format!("{tolerance} is not from 0 to 180"),
            )
        });
    }
}

fn check_target(body: &MotionBody, violations: &mut Vec<Violation>) {
    match (body.motion_type, body.target.is_some()) {
        (MotionType::Joint, false) => violations.push(violation(
            "target",
            "missing; a JOINT motion needs `pose` or `joints`",
        )),
        (MotionType::Linear | MotionType::Relative, false) => {
            violations.push(violation("target", "missing; this motion needs a `pose`"));
        }
        (MotionType::Home, true) => {
            violations.push(violation("target", "a HOME motion has no target"));
        }
        (MotionType::Output, _) => {
            violations.push(violation(
                "type",
                "OUTPUT is no motion to ask for: only the cell's jobs set outputs",
            ));
        }
        (MotionType::Linear | MotionType::Relative, true)
            if matches!(body.target, Some(TargetBody::Joints(_))) =>
        {
            violations.push(violation("target.joints", "this motion needs a `pose`"));
        }
        (MotionType::Joint | MotionType::Linear | MotionType::Relative, true)
        | (MotionType::Home, false) => {}
    }
    match (body.motion_type, body.relative_to) {
        (MotionType::Relative, None) => violations.push(violation(
            "relative_to",
            "missing; a RELATIVE motion says what it counts from: `ACTUAL`",
        )),
        (
            MotionType::Joint | MotionType::Linear | MotionType::Home | MotionType::Output,
            Some(_),
        ) => {
            violations.push(violation(
                "relative_to",
                "only a RELATIVE motion counts from something",
            ));
        }
        (MotionType::Relative, Some(_))
        | (MotionType::Joint | MotionType::Linear | MotionType::Home | MotionType::Output, None) => {
        }
    }
}

fn check_speed(body: &MotionBody, violations: &mut Vec<Violation>) {
    match (body.speed_mm_s, body.speed_percent) {
        (None, None) => violations.push(violation("speed_mm_s", "missing")),
        (Some(_), Some(_)) => violations.push(violation(
            "speed_percent",
            "give the speed in mm/s or in percent, not both",
        )),
        (Some(_), None) | (None, Some(_)) => {}
    }
}

fn violation(item: &str, message: &str) -> Violation {
    Violation {
        item: item.to_owned(),
        message: message.to_owned(),
        ..Violation::default()
    }
}

/// What a controller of tier 0 is to be sent.
pub(super) fn prepare(robot: &Robot, body: &MotionBody) -> Result<Prepared, Problem> {
    let plan = &robot.plan;
    let Some(speed) = body.speed_mm_s else {
        let message = "the program on this controller takes a speed in mm/s only";
        let detail = format!("speed_percent: {message}");
        return Err(Problem::not_sent(ProblemCode::Validation, detail)
            .violations(vec![violation("speed_percent", message)]));
    };
    let speed = MmPerSec(speed);
    let prepared = match (body.motion_type, &body.target) {
        (MotionType::Linear, _) => {
            return Err(unsupported(
                "it moves the joints together and cannot keep a straight line",
            ));
        }
        (MotionType::Relative, _) => {
            return Err(unsupported(
                "it does not report where the arm is, so there is no actual pose to count from",
            ));
        }
        (MotionType::Joint, Some(TargetBody::Pose(pose))) => {
            plan.prepare_point(&point_of(pose), speed)
        }
        (MotionType::Joint, Some(TargetBody::Joints(joints))) => {
            plan.prepare_joints((*joints).into(), speed)
        }
        (MotionType::Output, _) => return Err(unsupported("it sets no outputs")),
        (MotionType::Home, _) | (MotionType::Joint, None) => plan.prepare_home(speed),
    };
    prepared.map_err(|refusal| refused(&refusal))
}

fn unsupported(why: &str) -> Problem {
    Problem::not_sent(
        ProblemCode::NotSupported,
        format!("the robot's controller runs the seed program: {why}"),
    )
}

pub(super) fn refused(refusal: &Refusal) -> Problem {
    Problem::not_sent(refusal.code(), refusal.to_string()).violations(refusal.violations(&PATHS))
}
