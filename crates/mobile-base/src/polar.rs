//! The base seen from its target: polar coordinates, thesis (4).

use std::f64::consts::PI;

use units::{Millimeters, MmPerSec, RadPerSec, Radians};

use crate::pose::{PlanarPose, Point, one_turn};
use crate::range::{OutOfRange, within};

/// Nearer than this, a nanometer, the direction to the target means nothing: the base is there.
pub(crate) const AT_TARGET: f64 = 1e-6;
const MAX_DISTANCE: Millimeters = Millimeters(1e8);

/// Distance and directions from the base to its target.
///
/// ```text
///            target            rho    from the base to the target
///            /                 theta  from X of the world to the target
///       rho /  . velocity      psi    from X of the world to the velocity of the base
///          / .                 alpha  psi - theta
///         B------- X
/// ```
/// At the target rho is zero and no direction leads there; theta is then psi and alpha zero, so that
/// every law commands rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polar {
    rho: f64,
    alpha: f64,
    theta: f64,
}

/// How [`Polar`] changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarRates {
    /// Of the distance.
    pub rho: MmPerSec,
    /// Of the angle between velocity and target.
    pub alpha: RadPerSec,
    /// Of the direction to the target.
    pub theta: RadPerSec,
}

/// What a law in polar coordinates commands: v and the turn of the velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PolarCommand {
    /// v, along the course; negative backs up.
    pub speed: MmPerSec,
    /// How fast the base, and with it the course, turns.
    pub turn: RadPerSec,
}

impl Polar {
    /// Coordinates of a base that drives along `course`, the angle from x of the base to its
    /// velocity (beta* of the thesis).
    #[must_use]
    pub fn of(pose: PlanarPose, target: Point, course: Radians) -> Polar {
        let psi = pose.heading().0 + course.0;
        let rho = pose.position().distance_to(target).0;
        if rho < AT_TARGET {
            return Polar {
                rho: 0.0,
                alpha: 0.0,
                theta: one_turn(psi),
            };
        }
        let (x, y) = pose.position().to(target);
        let theta = y.atan2(x);
        Polar {
            rho,
            alpha: one_turn(psi - theta),
            theta,
        }
    }

    /// Coordinates as they are given; at the target (rho below a nanometer) alpha becomes zero.
    ///
    /// # Errors
    /// A rho that is negative or beyond 100 km, an angle outside of -pi to pi.
    pub fn try_new(rho: Millimeters, alpha: Radians, theta: Radians) -> Result<Polar, OutOfRange> {
        let rho = within("rho", rho, Millimeters(0.0), MAX_DISTANCE)?.0;
        let alpha = within("alpha", alpha, Radians(-PI), Radians(PI))?.0;
        let theta = within("theta", theta, Radians(-PI), Radians(PI))?.0;
        if rho < AT_TARGET {
            return Ok(Polar {
                rho: 0.0,
                alpha: 0.0,
                theta: one_turn(theta + alpha),
            });
        }
        Ok(Polar { rho, alpha, theta })
    }

    /// The distance to the target.
    #[must_use]
    pub fn rho(&self) -> Millimeters {
        Millimeters(self.rho)
    }

    /// From the direction to the target to the velocity, from -pi to pi.
    #[must_use]
    pub fn alpha(&self) -> Radians {
        Radians(self.alpha)
    }

    /// From X of the world to the direction to the target, from -pi to pi.
    #[must_use]
    pub fn theta(&self) -> Radians {
        Radians(self.theta)
    }

    /// How the coordinates change under a command, thesis (4); with the law (5) this is (6).
    ///
    /// At the target the directions have no rate: alpha turns with the base, theta stays.
    #[must_use]
    pub fn rates(&self, command: &PolarCommand) -> PolarRates {
        let (sin, cos) = self.alpha.sin_cos();
        let around = if self.rho > 0.0 {
            command.speed.0 * sin / self.rho
        } else {
            0.0
        };
        PolarRates {
            rho: command.speed * -cos,
            alpha: RadPerSec(command.turn.0 + around),
            theta: RadPerSec(-around),
        }
    }
}
