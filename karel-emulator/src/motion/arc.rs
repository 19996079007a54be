//! Ways of the tool on a circle.

use kinematics::{ArmModel, Frames, PendantJoints, Pose};
use planning::cartesian::{Extent, ToolPath};

use super::linear::{ACCELERATION, LinearTarget, Pace, ToolSpeed, travel};
use super::{Path, Refusal};

/// Where the position of a circular motion is that is neither its start nor its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnCircle {
    /// Between them: `C`.
    OnTheWay,
    /// On the rest of the circle: `A`. On the way the orientation changes by the one shortest rotation.
    Elsewhere,
}

/// The way of the tool center point from `from` on the circle through `via` to `target`, otherwise as [`super::linear::plan`].
///
/// ASSUMPTION: the orientation changes evenly by the shortest rotation from the start to the position on the way, and
/// from there to the end; so that position is passed in its own orientation. A controller slows down on a small circle,
/// so that the acceleration toward the center is not more than that of the tool, and raises no alarm.
///
/// # Errors
/// As [`super::linear::plan`]; and positions through which no circle goes.
pub fn plan_arc(
    model: &ArmModel,
    frames: &Frames,
    from: PendantJoints,
    ((via, place), target): ((&Pose, OnCircle), &LinearTarget),
    pace: &Pace,
) -> Result<Path, Refusal> {
    let start = frames.tcp_in_user_frame(&model.forward(&from));
    let via = match place {
        OnCircle::OnTheWay => *via,
        OnCircle::Elsewhere => halfway(&start, via, &target.tcp),
    };
    let course = ToolPath::circle(&start, &via, &target.tcp, Extent::Arc);
    let mut pace = *pace;
    if let (ToolSpeed::MmPerSec(speed), Ok(course)) = (pace.speed, &course)
        && let Some(radius) = course.radius()
    {
        let most = (ACCELERATION * pace.acceleration * radius.0).sqrt();
        pace.speed = ToolSpeed::MmPerSec(speed.min(most));
    }
    travel(model, frames, from, (course, target), pace)
}

/// The middle of the arc from `start` to `goal` that does not pass `elsewhere`, of the circle through it. If there is no
/// such circle it is the middle of the line, through which there is none either.
fn halfway(start: &Pose, elsewhere: &Pose, goal: &Pose) -> Pose {
    let (from, to) = (start.isometry(), goal.isometry());
    let middle = (from.translation.vector + to.translation.vector) / 2.0;
    let chord = to.translation.vector - from.translation.vector;
    let other = elsewhere.isometry().translation.vector - middle;
    // Seen from the middle of the chord: `elsewhere` is `beside` of it, the center `center`, on the same axis.
    let along = chord.norm();
    let mut point = middle;
    if along > 0.0 {
        let on_chord = chord * (other.dot(&chord) / (along * along));
        let across = other - on_chord;
        let beside = across.norm();
        if beside > 0.0 {
            let half = along / 2.0;
            let center = (other.norm_squared() - half * half) / (2.0 * beside);
            let radius = center.hypot(half);
            point += across * ((center - radius) / beside);
        }
    }
    let mut isometry = *from;
    isometry.translation.vector = point;
    // Half a turn has no shortest way; planning says so.
    isometry.rotation = from
        .rotation
        .try_slerp(&to.rotation, 0.5, 1e-9)
        .unwrap_or(from.rotation);
    // The points were finite, so this one is.
    Pose::try_from_isometry(isometry).unwrap_or(*start)
}
