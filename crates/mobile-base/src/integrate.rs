//! Fixed steps through time.

use std::time::Duration;

use units::{Millimeters, Radians};

use crate::pose::PlanarPose;
use crate::range::OutOfRange;
use crate::twist::BodyTwist;

impl PlanarPose {
    /// Where a base is after driving a constant twist for `time`: exact, whatever the time.
    ///
    /// This is what a sampled controller does, and the step to take for it.
    ///
    /// # Errors
    /// The new pose is out of range, or the twist is not a number.
    pub fn advanced(self, twist: &BodyTwist, time: Duration) -> Result<PlanarPose, OutOfRange> {
        self.moved_by(&twist.over(time))
    }
}

/// One step of the classical Runge-Kutta method, of order four: for a law that acts without pause,
/// not once in a step.
///
/// `law` gives the twist for a pose and the time since the beginning of the step.
///
/// # Errors
/// A pose on the way is out of range, or a twist is not a number.
pub fn runge_kutta(
    pose: PlanarPose,
    step: Duration,
    mut law: impl FnMut(PlanarPose, Duration) -> BodyTwist,
) -> Result<PlanarPose, OutOfRange> {
    let h = step.as_secs_f64();
    let mut slope = |pose: PlanarPose, time: Duration| {
        let twist = pose.world_twist(law(pose, time));
        [twist.x.0, twist.y.0, twist.turn.0]
    };
    let along = |[x, y, turn]: [f64; 3], time: f64| {
        let from = pose.position();
        PlanarPose::try_new(
            Millimeters(from.x().0 + time * x),
            Millimeters(from.y().0 + time * y),
            Radians(pose.heading().0 + time * turn),
        )
    };
    let k1 = slope(pose, Duration::ZERO);
    let k2 = slope(along(k1, 0.5 * h)?, step / 2);
    let k3 = slope(along(k2, 0.5 * h)?, step / 2);
    let k4 = slope(along(k3, h)?, step);
    let mean = |[a, b, c, d]: [f64; 4]| (a + 2.0 * (b + c) + d) / 6.0;
    along(
        [
            mean([k1[0], k2[0], k3[0], k4[0]]),
            mean([k1[1], k2[1], k3[1], k4[1]]),
            mean([k1[2], k2[2], k3[2], k4[2]]),
        ],
        h,
    )
}
