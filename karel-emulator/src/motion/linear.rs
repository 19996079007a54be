//! A straight line or an arc of the tool center point, checked along the whole way before the arm moves.

use karel::Status;
use kinematics::{
    ArmModel, Axis, Configuration, Frames, IkError, PendantJoints, Pose, PoseError, Seed,
};

use super::arc::Arc;
use super::path::{INTERPOLATION_PERIOD_S, Path, SPEED_LIMIT};
use super::planner::{Refusal, ik_refusal};
use super::profile::Profile;
use super::wrist::WristJoint;

/// Acceleration of the tool center point, mm/s².
///
/// ASSUMPTION: this and the next two are of the size that arms of this class have; no document gives them.
pub(super) const ACCELERATION: f64 = 3000.0;
/// Greatest speed of a change of orientation, deg/s.
const ROTATION_SPEED: f64 = 180.0;
/// Acceleration of a change of orientation, deg/s².
const ROTATION_ACCELERATION: f64 = 720.0;

/// A smaller change of orientation is none, degrees.
const NO_ROTATION_DEG: f64 = 0.01;

/// Samples of a way: one each interpolation period, inside of these bounds.
const FEWEST_SAMPLES: f64 = 16.0;
const MOST_SAMPLES: f64 = 4000.0;

/// A larger change of orientation has no shortest rotation, within the rounding of a position.
pub(super) const MOST_ROTATION_DEG: f64 = 179.99;

/// MOTN-023: the way runs through a singularity.
///
/// ASSUMPTION: this number and the next two are from memory of error lists.
const MOTN_SINGULARITY: Status = Status::new(15, 23);
/// MOTN-063: a joint would have to be faster than it can.
const MOTN_JOINT_SPEED: Status = Status::new(15, 63);
/// MOTN-079: the target is in another configuration than the start.
const MOTN_CONFIGURATION: Status = Status::new(15, 79);

/// How fast the tool goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ToolSpeed {
    /// Of its center point.
    MmPerSec(f64),
    /// Of its orientation.
    DegPerSec(f64),
    /// From the start to the end.
    Seconds(f64),
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
    /// Rate and slope of progress on a way of `length` mm that turns by `angle` degrees.
    ///
    /// ASSUMPTION: a rotation of the tool is never faster than [`ROTATION_SPEED`], the center point never than
    /// `$SPEEDLIM`; a time or a rotation that would need more is refused.
    fn limits(&self, length: f64, angle: f64) -> Result<(f64, f64), Refusal> {
        let limit = |straight: f64, turning: f64| (straight / length).min(turning / angle);
        let most = limit(SPEED_LIMIT.0, ROTATION_SPEED);
        let slope = limit(
            ACCELERATION * self.acceleration,
            ROTATION_ACCELERATION * self.acceleration,
        );
        let refused = |text: String| Err(Refusal::new(INTP_SPEED, text));
        let rate = match self.speed {
            ToolSpeed::MmPerSec(speed) => limit(speed, self.rotation_deg_s.min(ROTATION_SPEED)),
            ToolSpeed::DegPerSec(_) if angle < NO_ROTATION_DEG => {
                return refused("A speed in deg/sec needs a change of orientation".to_owned());
            }
            ToolSpeed::DegPerSec(speed) => speed / angle,
            ToolSpeed::Seconds(seconds) => match Profile::rate_for(seconds, slope) {
                _ if !slope.is_finite() => f64::INFINITY,
                Some(rate) => rate,
                None => {
                    let shortest = 2.0 / slope.sqrt();
                    return refused(format!(
                        "The motion cannot take {seconds} s, {shortest:.3} s is the shortest"
                    ));
                }
            },
        };
        if rate.is_finite() && rate > most * (1.0 + 1e-9) {
            return refused(format!(
                "The tool would be faster than {} mm/s or {ROTATION_SPEED} deg/s",
                SPEED_LIMIT.0
            ));
        }
        Ok((rate, slope))
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
    let branch = model.configuration(&from);
    if target.wrist.is_none() {
        check_branch(branch, target)?;
    }
    let start = frames.tcp_in_user_frame(&model.forward(&from));
    let (length, angle) = start.distance_to(&target.tcp);
    let (length, angle) = (length.0, angle.0.to_degrees());
    if angle > MOST_ROTATION_DEG {
        let text = "the orientation changes by half a turn, so no rotation is the shortest";
        return Err(Refusal::new(Status::MOTN_UNREACHABLE, text));
    }
    let course = Course::Straight(start, target.tcp);
    let way = Way {
        model,
        frames,
        course,
        branch,
        wrist: target.wrist.map(|to| (from, to)),
    };
    way.travel(from, (length, angle), pace)
}

/// The way of the tool center point from `from` on the circle through `via` to `target`, otherwise as [`plan`].
///
/// # Errors
/// As [`plan`]; and positions through which no circle goes.
pub fn plan_arc(
    model: &ArmModel,
    frames: &Frames,
    from: PendantJoints,
    (via, target): (&Pose, &LinearTarget),
    pace: &Pace,
) -> Result<Path, Refusal> {
    let branch = model.configuration(&from);
    if target.wrist.is_none() {
        check_branch(branch, target)?;
    }
    let start = frames.tcp_in_user_frame(&model.forward(&from));
    let arc = Arc::through(&start, via, &target.tcp)?;
    let length = (arc.length(), arc.turning_deg());
    let mut pace = *pace;
    if let ToolSpeed::MmPerSec(speed) = pace.speed {
        pace.speed = ToolSpeed::MmPerSec(arc.possible_speed(speed, pace.acceleration));
    }
    let way = Way {
        model,
        frames,
        course: Course::Arc(arc),
        branch,
        wrist: target.wrist.map(|to| (from, to)),
    };
    way.travel(from, length, &pace)
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

/// The way of the tool center point in the user frame.
enum Course {
    Straight(Pose, Pose),
    Arc(Arc),
}

impl Course {
    fn at(&self, share: f64) -> Result<Pose, PoseError> {
        match self {
            Course::Straight(start, end) => {
                Pose::try_from_isometry(start.isometry().lerp_slerp(end.isometry(), share))
            }
            Course::Arc(arc) => arc.at(share),
        }
    }
}

struct Way<'a> {
    model: &'a ArmModel,
    frames: &'a Frames,
    course: Course,
    branch: Configuration,
    /// Joints at the start and at the end, if the wrist goes as in a joint motion between them.
    wrist: Option<(PendantJoints, PendantJoints)>,
}

impl Way<'_> {
    /// Samples the way, which is `length` mm long and turns by `angle` degrees, and checks each sample.
    fn travel(
        &self,
        from: PendantJoints,
        (length, angle): (f64, f64),
        pace: &Pace,
    ) -> Result<Path, Refusal> {
        let (rate, slope) = pace.limits(length, angle)?;
        if !rate.is_finite() || !slope.is_finite() {
            // Neither length nor angle: the arm is there.
            return Ok(Path::joint_at(self.model, from, from, 1.0, 1.0));
        }
        let steps = (1.0 / (rate * INTERPOLATION_PERIOD_S))
            .clamp(FEWEST_SAMPLES, MOST_SAMPLES)
            .ceil();
        let mut samples = vec![from];
        let mut before = from;
        let mut step = 1.0;
        while step <= steps {
            let joints = self.at(step / steps, &before)?;
            let middle = (step - 0.5) / steps;
            // What the profile allows here: less near the ends.
            let here = rate
                .min((2.0 * slope * middle).sqrt())
                .min((2.0 * slope * (1.0 - middle)).sqrt());
            check_speeds(self.model, &before, &joints, steps * here)?;
            samples.push(joints);
            before = joints;
            step += 1.0;
        }
        Path::of_tool(samples, (length, self.frames.tool), (rate, slope))
            .ok_or_else(|| Refusal::new(Status::MOTN_UNREACHABLE, "the way has no length"))
    }

    /// The joints at this share of the way, near those before it.
    fn at(&self, share: f64, before: &PendantJoints) -> Result<PendantJoints, Refusal> {
        let tcp = self
            .course
            .at(share)
            .map_err(|error| Refusal::new(Status::MOTN_UNREACHABLE, error.to_string()))?;
        if let Some(ends) = &self.wrist {
            let arm = WristJoint {
                model: self.model,
                frames: self.frames,
                ends,
            };
            return arm.at(&tcp, share, before);
        }
        let flange = self.frames.flange_in_world(&tcp);
        let solution = self
            .model
            .inverse(&flange, Seed::Near(*before))
            .map_err(|error| on_the_way(share, &error))?;
        let joints = solution.joints;
        self.model.check_limits(&joints).map_err(|violations| {
            let text = format!("Limit error at {} of the way: {violations}", percent(share));
            Refusal::new(Status::MOTN_LIMIT, text)
        })?;
        if !solution.configuration.same_branch(self.branch) {
            let (kind, _) = self.model.singularity(&joints).nearest();
            let text = format!(
                "Singularity ({kind}) at {} of the way: the configuration would change from {} to {}",
                percent(share),
                self.branch,
                solution.configuration
            );
            return Err(Refusal::new(MOTN_SINGULARITY, text));
        }
        Ok(joints)
    }
}

/// `per_second`: how many steps like this one the arm makes in a second.
fn check_speeds(
    model: &ArmModel,
    before: &PendantJoints,
    after: &PendantJoints,
    per_second: f64,
) -> Result<(), Refusal> {
    for axis in Axis::ALL {
        let speed = (after.of(axis).0 - before.of(axis).0).abs() * per_second;
        let limit = model.max_speed(axis).0;
        if speed > limit * (1.0 + 1e-6) {
            let (kind, measure) = model.singularity(after).nearest();
            let text = format!(
                "Joint speed: {axis} would turn with {speed:.1} deg/s, its limit is {limit:.1} deg/s \
                 (nearest singularity: {kind}, {measure:.3})"
            );
            return Err(Refusal::new(MOTN_JOINT_SPEED, text));
        }
    }
    Ok(())
}

fn on_the_way(share: f64, error: &IkError) -> Refusal {
    let Refusal { status, text } = ik_refusal(error);
    Refusal::new(status, format!("{text} (at {} of the way)", percent(share)))
}

fn percent(share: f64) -> String {
    format!("{:.1} %", share * 100.0)
}
