//! A way of the tool center point, a straight line or an arc, checked along the whole way before the arm moves.

use karel::Status;
use kinematics::{ArmModel, Configuration, Frames, PendantJoints, Pose};
use planning::cartesian::{Demands, PathError, ToolError, ToolFollower, ToolPath};
use planning::jerk::{MotionLimits, Progress};

use super::path::{INTERPOLATION_PERIOD_S, Path, SPEED_LIMIT, along};
use super::planner::{Refusal, ik_refusal};

/// Acceleration of the tool center point, mm/s².
///
/// ASSUMPTION: this and the next two are of the size that arms of this class have; no document gives them.
pub(super) const ACCELERATION: f64 = 3000.0;
/// Greatest speed of a change of orientation, deg/s.
const ROTATION_SPEED: f64 = 180.0;
/// Acceleration of a change of orientation, deg/s².
const ROTATION_ACCELERATION: f64 = 720.0;
/// Jerk of both, for each unit of the acceleration, 1/s.
///
/// ASSUMPTION: the whole acceleration is there after a tenth of a second, as that of the joints is.
const JERK_PER_ACCELERATION: f64 = 10.0;

/// A smaller change of orientation is none, degrees.
const NO_ROTATION_DEG: f64 = 0.01;

/// Samples of a way: one each interpolation period, inside of these bounds.
const FEWEST_SAMPLES: f64 = 16.0;
const MOST_SAMPLES: f64 = 4000.0;

/// MOTN-023: the way runs through a singularity.
///
/// ASSUMPTION: this number and the next two are from memory of error lists.
const MOTN_SINGULARITY: Status = Status::new(15, 23);
/// MOTN-063: a joint would have to be faster than it can.
const MOTN_JOINT_SPEED: Status = Status::new(15, 63);
/// MOTN-079: the target is in another configuration than the start.
const MOTN_CONFIGURATION: Status = Status::new(15, 79);

/// MOTN-997: no circle goes through the three positions. A number of our own.
const MOTN_NO_CIRCLE: Status = Status::new(15, 997);

/// How fast the tool goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ToolSpeed {
    /// Of its center point.
    MmPerSec(f64),
    /// Of its orientation.
    DegPerSec(f64),
    /// From the start to the end.
    Seconds(f64),
    /// As fast as the tool and the joints can.
    Greatest,
}

/// Speed and acceleration of the tool.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// What the program says.
    pub speed: ToolSpeed,
    /// `$ROTSPEED`, deg/s: a change of orientation is not faster, unless the program says how fast it is.
    pub rotation_deg_s: f64,
    /// Part of the usual acceleration.
    pub acceleration: f64,
}

impl Pace {
    /// The progress along a way of `length` mm that turns by `angle` degrees, in millimeters or in degrees, whatever is
    /// more.
    ///
    /// ASSUMPTION: a rotation of the tool is never faster than [`ROTATION_SPEED`], the center point never than
    /// `$SPEEDLIM`; a time or a rotation that would need more is refused.
    fn progress(&self, length: f64, angle: f64) -> Result<Progress, Refusal> {
        let way = length.max(angle);
        let limit =
            |straight: f64, turning: f64| (straight * way / length).min(turning * way / angle);
        let most = limit(SPEED_LIMIT.0, ROTATION_SPEED);
        let acceleration = self.acceleration * limit(ACCELERATION, ROTATION_ACCELERATION);
        let refused = |text: String| Err(Refusal::new(INTP_SPEED, text));
        let velocity = match self.speed {
            ToolSpeed::MmPerSec(speed) => limit(speed, self.rotation_deg_s.min(ROTATION_SPEED)),
            ToolSpeed::DegPerSec(_) if angle < NO_ROTATION_DEG => {
                return refused("A speed in deg/sec needs a change of orientation".to_owned());
            }
            ToolSpeed::DegPerSec(speed) => speed * way / angle,
            ToolSpeed::Seconds(_) | ToolSpeed::Greatest => most,
        };
        if velocity > most * (1.0 + 1e-9) {
            return refused(format!(
                "The tool would be faster than {} mm/s or {ROTATION_SPEED} deg/s",
                SPEED_LIMIT.0
            ));
        }
        let limits = MotionLimits {
            velocity,
            acceleration,
            jerk: JERK_PER_ACCELERATION * acceleration,
        };
        let Some(progress) = Progress::try_new(way, limits) else {
            return refused(format!("{velocity} is no speed of a way of {way}"));
        };
        let ToolSpeed::Seconds(seconds) = self.speed else {
            return Ok(progress);
        };
        progress.lasting(seconds).or_else(|shortest| {
            refused(format!(
                "The motion cannot take {seconds} s, {shortest:.3} s is the shortest"
            ))
        })
    }
}

/// INTP-215: a speed that cannot be.
///
/// ASSUMPTION: the number is ours.
pub const INTP_SPEED: Status = Status::new(12, 215);

/// Where a straight line ends.
#[derive(Clone, Copy, Debug)]
pub struct LinearTarget {
    /// The tool center point in the user frame.
    pub tcp: Pose,
    /// The configuration that the target names; its turns do not matter.
    pub configuration: Configuration,
    /// The joints at the target, if the wrist goes to them as in a joint motion (`Wjnt`).
    pub wrist: Option<PendantJoints>,
}

/// The straight way of the tool center point from `from` to `target` at this pace; the orientation changes by the
/// one shortest rotation.
///
/// ASSUMPTION: a controller notices some of what is refused here only on the way; this one never starts.
///
/// # Errors
/// Another configuration at the target than at the start, a place on the way that is not reachable, beyond a joint
/// limit, or singular, or where a joint would have to be faster than it can.
pub fn plan(
    model: &ArmModel,
    frames: &Frames,
    from: PendantJoints,
    target: &LinearTarget,
    pace: &Pace,
) -> Result<Path, Refusal> {
    let start = frames.tcp_in_user_frame(&model.forward(&from));
    let course = ToolPath::line(&start, &target.tcp);
    travel(model, frames, from, (course, target), *pace)
}

/// Samples the way and checks each sample.
pub(super) fn travel(
    model: &ArmModel,
    frames: &Frames,
    from: PendantJoints,
    (course, target): (Result<ToolPath, PathError>, &LinearTarget),
    pace: Pace,
) -> Result<Path, Refusal> {
    let branch = model.configuration(&from);
    if target.wrist.is_none() {
        check_branch(branch, target)?;
    }
    let course = match course {
        Err(PathError::NoWay) => return Ok(Path::standing(from)),
        course => course.map_err(|error| no_path(&error))?,
    };
    let length = course.length().unwrap_or_default().0;
    let progress = pace.progress(length, course.turning().0.to_degrees())?;
    let mut follower = ToolFollower::new(model, frames, &course);
    if let Some(wrist) = &target.wrist {
        follower = follower.with_wrist(&from, wrist);
    }
    let steps = (progress.way() / (progress.peak() * INTERPOLATION_PERIOD_S))
        .clamp(FEWEST_SAMPLES, MOST_SAMPLES)
        .ceil();
    let mut samples = vec![from];
    let mut before = from;
    let mut step = 1.0;
    while step <= steps {
        let share = step / steps;
        let joints = follower
            .follow((step - 1.0) / steps, &before, share)
            .map_err(|error| on_the_way(&error))?;
        let configuration = model.configuration(&joints);
        if target.wrist.is_none() && !configuration.same_branch(branch) {
            let (kind, _) = model.singularity(&joints).nearest();
            let text = format!(
                "Singularity ({kind}) at {} of the way: the configuration would change from {branch} to \
                 {configuration}",
                percent(share),
            );
            return Err(Refusal::new(MOTN_SINGULARITY, text));
        }
        samples.push(joints);
        before = joints;
        step += 1.0;
    }
    let as_fast = pace.speed == ToolSpeed::Greatest;
    let progress = within_joints(model, &samples, (progress, as_fast))?;
    Path::of_tool(samples, (length, frames.tool), progress)
        .ok_or_else(|| Refusal::new(Status::MOTN_UNREACHABLE, "the way has no length"))
}

fn check_branch(branch: Configuration, target: &LinearTarget) -> Result<(), Refusal> {
    if branch.same_branch(target.configuration) {
        return Ok(());
    }
    let text = format!(
        "the target is in the configuration {}, the way of the tool keeps that of the start, {branch}",
        target.configuration
    );
    Err(Refusal::new(MOTN_CONFIGURATION, text))
}

/// The progress, slow enough for the accelerations of the joints; an alarm if one of them would be too fast, unless the
/// motion is to go `as_fast` as they can.
///
/// ASSUMPTION: where a joint would have to accelerate harder than it can, the whole way is traveled slower, and no alarm
/// is raised, also if the program says how long it shall take.
fn within_joints(
    model: &ArmModel,
    samples: &[PendantJoints],
    (progress, as_fast): (Progress, bool),
) -> Result<Progress, Refusal> {
    let Demands {
        speed,
        acceleration,
    } = Demands::of(model, samples, &progress);
    if speed.share > 1.0 + 1e-6 && !as_fast {
        let limit = model.max_speed(speed.joint).0;
        let there = along(samples, speed.parameter);
        let nearest = there.map(|joints| model.singularity(&joints).nearest());
        let nearest = nearest.map(|(kind, measure)| format!("{kind}, {measure:.3}"));
        let text = format!(
            "Joint speed: {} would turn with {:.1} deg/s, its limit is {limit:.1} deg/s \
             (nearest singularity: {})",
            speed.joint,
            speed.share * limit,
            nearest.unwrap_or_default(),
        );
        return Err(Refusal::new(MOTN_JOINT_SPEED, text));
    }
    let by = acceleration.share.sqrt().max(speed.share);
    let slower = (acceleration.share > 1.0 || as_fast && by > 1.0)
        .then(|| progress.stretched(by))
        .flatten();
    Ok(slower.unwrap_or(progress))
}

/// Why there is no such path.
fn no_path(error: &PathError) -> Refusal {
    match error {
        PathError::SamePoint { .. } => {
            let text = "No circle: two of start, position on the way and end are at the same place";
            Refusal::new(MOTN_NO_CIRCLE, text)
        }
        PathError::Straight { .. } => {
            let text = "No circle: start, position on the way and end are on one line";
            Refusal::new(MOTN_NO_CIRCLE, text)
        }
        PathError::HalfTurn { .. } => {
            let text = "the orientation changes by half a turn, so no rotation is the shortest";
            Refusal::new(Status::MOTN_UNREACHABLE, text)
        }
        PathError::NoWay | PathError::Points { .. } | PathError::Pose(_) => {
            Refusal::new(Status::MOTN_UNREACHABLE, error.to_string())
        }
    }
}

/// Why the arm cannot follow the path.
fn on_the_way(error: &ToolError) -> Refusal {
    match error {
        ToolError::Unreachable {
            parameter, source, ..
        } => {
            let Refusal { status, text } = ik_refusal(source);
            Refusal::new(
                status,
                format!("{text} (at {} of the way)", percent(*parameter)),
            )
        }
        ToolError::Jump {
            parameter,
            joint,
            from,
            to,
            ..
        } => {
            let text = format!(
                "Singularity at {} of the way: {joint} would jump from {from:.2} to {to:.2}",
                percent(*parameter),
            );
            Refusal::new(MOTN_SINGULARITY, text)
        }
        ToolError::Wrist { .. } => {
            let text =
                "Position not reachable: no place of the arm keeps the tool on its way (Wjnt)";
            Refusal::new(Status::MOTN_UNREACHABLE, text)
        }
        ToolError::WristLimits {
            parameter,
            violations,
        } => {
            let text = format!(
                "Limit error at {} of the way: {violations}",
                percent(*parameter)
            );
            Refusal::new(Status::MOTN_LIMIT, text)
        }
        ToolError::Path(error) => no_path(error),
        ToolError::Limit { .. }
        | ToolError::Period { .. }
        | ToolError::StartElsewhere { .. }
        | ToolError::TooSlow { .. }
        | ToolError::Profile(_)
        | ToolError::TooLong { .. } => Refusal::new(Status::MOTN_UNREACHABLE, error.to_string()),
    }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}

#[cfg(test)]
#[path = "linear_tests.rs"]
mod tests;
