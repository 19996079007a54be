//! Feedback laws that drive the base to a point, thesis (5) to (10).

use units::{MmPerSec, PerSecond, RadPerSec, Radians};

use crate::approach::Approach;
use crate::polar::{AT_TARGET, Polar, PolarCommand};
use crate::pose::{PlanarPose, Point, one_turn};
use crate::range::{OutOfRange, within};
use crate::twist::BodyTwist;

const MIN_SPEED: MmPerSec = MmPerSec(1e-3);
const MAX_SPEED: MmPerSec = MmPerSec(1e5);
const MIN_RATE: PerSecond = PerSecond(1e-3);
const MAX_RATE: PerSecond = PerSecond(1e3);

/// The parameters of [`PointLaw`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointGains {
    /// `k_v`: the highest speed of the base.
    pub speed: MmPerSec,
    /// `k_phi`: the rate at which an angle decays, alpha in mode 1, the heading's error in mode 2.
    pub turn: PerSecond,
    /// f(rho).
    pub approach: Approach,
}

/// What the heading is to be in mode 2: beta and its derivative.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeadingReference {
    /// beta, in the world.
    pub angle: Radians,
    /// How fast beta changes.
    pub rate: RadPerSec,
}

/// The law (5), checked, for both modes of driving.
///
/// Along it alpha decays as e^(-`k_phi` t), and rho falls at `k_v` f(rho) cos^2(alpha). The commands
/// are not limited to what the wheels can do; see
/// [`MecanumBase::scale_to_limits`](crate::MecanumBase::scale_to_limits).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLaw {
    gains: PointGains,
}

impl PointLaw {
    /// A law with these gains.
    ///
    /// # Errors
    /// A speed that is not from 0.001 to 100,000 mm/s, a rate that is not from 0.001 to 1000 /s, or
    /// a parameter of the approach out of its range.
    pub fn try_new(gains: &PointGains) -> Result<PointLaw, OutOfRange> {
        let _ = within("speed of the law", gains.speed, MIN_SPEED, MAX_SPEED)?;
        let _ = within("turn rate of the law", gains.turn, MIN_RATE, MAX_RATE)?;
        gains.approach.check()?;
        Ok(PointLaw { gains: *gains })
    }

    /// The gains it was made from.
    #[must_use]
    pub fn gains(&self) -> &PointGains {
        &self.gains
    }

    /// The law in polar coordinates, thesis (5). At the target it commands rest.
    #[must_use]
    pub fn polar(&self, polar: &Polar) -> PolarCommand {
        let (rho, alpha) = (polar.rho(), polar.alpha().0);
        let k_v = self.gains.speed.0;
        let (sin, cos) = alpha.sin_cos();
        // One evaluation of f serves both lines; sin(2 alpha) / 2 = sin(alpha) cos(alpha).
        let (f, f_per_rho) = if rho.0 > 0.0 {
            let f = self.gains.approach.share(rho);
            (f, f / rho.0)
        } else {
            (0.0, 0.0)
        };
        PolarCommand {
            speed: MmPerSec(k_v * f * cos),
            turn: RadPerSec(-self.gains.turn.0 * alpha - k_v * f_per_rho * sin * cos),
        }
    }

    /// Mode 1, thesis (8): the velocity keeps the direction `course` in the base's frame (beta*,
    /// counterclockwise from x of the base), and the base turns until that direction is the target's.
    ///
    /// Away from the target's side (cos alpha < 0) the base backs up while it turns.
    #[must_use]
    pub fn fixed_course(&self, pose: PlanarPose, target: Point, course: Radians) -> BodyTwist {
        let command = self.polar(&Polar::of(pose, target, course));
        let (sin, cos) = course.0.sin_cos();
        BodyTwist {
            forward: command.speed * cos,
            left: command.speed * sin,
            turn: command.turn,
        }
    }

    /// Mode 2, thesis (10): the velocity points at the target whatever the heading is, and the
    /// heading follows `heading`.
    ///
    /// (10) turns the velocity into the base's frame with beta, which is right only while the heading
    /// is beta. Here the measured heading is used, and its error decays as e^(-`k_phi` t); with the
    /// heading equal to beta this is (10).
    #[must_use]
    pub fn free_heading(
        &self,
        pose: PlanarPose,
        target: Point,
        heading: &HeadingReference,
    ) -> BodyTwist {
        let phi = pose.heading().0;
        // Along the line to the target alpha is zero by choice of the course, and (5) is k_v f. The
        // direction theta is needed only by its sine and cosine, which are y / rho and x / rho.
        let rho = pose.position().distance_to(target);
        let (x, y) = pose.position().to(target);
        let speed_per_distance = if rho.0 < AT_TARGET {
            0.0
        } else {
            self.gains.speed.0 * self.gains.approach.share(rho) / rho.0
        };
        let (sin, cos) = phi.sin_cos();
        let error = one_turn(phi - heading.angle.0);
        BodyTwist {
            forward: MmPerSec(speed_per_distance * (cos * x + sin * y)),
            left: MmPerSec(speed_per_distance * (cos * y - sin * x)),
            turn: RadPerSec(heading.rate.0 - self.gains.turn.0 * error),
        }
    }
}
