//! f(rho): how the speed depends on the distance to the target, thesis after (5).

use units::{Millimeters, PerMillimeter};

use crate::range::{OutOfRange, within};

const MIN_STEEPNESS: PerMillimeter = PerMillimeter(1e-6);
const MAX_STEEPNESS: PerMillimeter = PerMillimeter(1e3);
const MIN_SCALE: Millimeters = Millimeters(1e-3);
const MAX_SCALE: Millimeters = Millimeters(1e6);

/// The share of the full speed at a distance from the target: zero at the target, positive
/// elsewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Approach {
    /// sign(rho): full speed up to the target, which is reached in a finite time.
    ///
    /// With a course fixed to the body the turn of (5) grows as 1 / rho: the base then winds around
    /// the target without end, unless it looks straight at it.
    Sign,
    /// (1 - e^(-k rho)) / (1 + e^(-k rho)), which is tanh(k rho / 2).
    Exponential {
        /// k: the larger, the later the base slows down.
        k: PerMillimeter,
    },
    /// tanh(rho / scale). The thesis writes th(rho), which needs a length to count rho in.
    Tanh {
        /// At this distance the speed is 76 % of the full one.
        scale: Millimeters,
    },
}

impl Approach {
    /// f at a distance: 0 at the target, rising to 1.
    #[must_use]
    pub fn share(&self, rho: Millimeters) -> f64 {
        match self {
            Approach::Sign if rho.0 > 0.0 => 1.0,
            Approach::Sign => 0.0,
            Approach::Exponential { k } => {
                // 1 - e^-x, without losing digits where e^-x is nearly 1.
                let rise = -(-k.0 * rho.0).exp_m1();
                rise / (2.0 - rise)
            }
            Approach::Tanh { scale } => (rho.0 / scale.0).tanh(),
        }
    }

    /// f / rho, which (5) multiplies with the angle: at the target its limit, except for
    /// [`Approach::Sign`], which has none; its law commands nothing there, so it is given as 0.
    #[must_use]
    pub fn share_per_distance(&self, rho: Millimeters) -> PerMillimeter {
        if rho.0 > 0.0 {
            PerMillimeter(self.share(rho) / rho.0)
        } else {
            self.slope().unwrap_or_default()
        }
    }

    /// The slope of f at the target: times the full speed it is the rate at which the last of the
    /// distance decays. Nothing for [`Approach::Sign`], which jumps there.
    #[must_use]
    pub fn slope(&self) -> Option<PerMillimeter> {
        match self {
            Approach::Sign => None,
            Approach::Exponential { k } => Some(*k * 0.5),
            Approach::Tanh { scale } => Some(PerMillimeter(1.0 / scale.0)),
        }
    }

    /// Refuses a parameter that makes no function of the distance.
    pub(crate) fn check(&self) -> Result<(), OutOfRange> {
        match self {
            Approach::Sign => Ok(()),
            Approach::Exponential { k } => {
                within("k of the approach", *k, MIN_STEEPNESS, MAX_STEEPNESS).map(drop)
            }
            Approach::Tanh { scale } => {
                within("scale of the approach", *scale, MIN_SCALE, MAX_SCALE).map(drop)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Approach; 3] = [
        Approach::Sign,
        Approach::Exponential {
            k: PerMillimeter(0.01),
        },
        Approach::Tanh {
            scale: Millimeters(200.0),
        },
    ];

    #[test]
    fn all_three_are_zero_at_the_target_and_rise_to_one() {
        for approach in ALL {
            assert!(approach.share(Millimeters(0.0)).abs() < f64::EPSILON);
            assert!((approach.share(Millimeters(1e5)) - 1.0).abs() < 1e-12);
            let mut last = 0.0;
            for distance in 1..1000 {
                let share = approach.share(Millimeters(f64::from(distance)));
                assert!(share > 0.0 && share >= last && share <= 1.0, "{approach:?}");
                last = share;
            }
        }
    }

    #[test]
    fn the_exponential_is_the_tangent_of_half_the_argument() {
        // At k rho = 2: (1 - e^-2) / (1 + e^-2) = 0.864665 / 1.135335 = 0.761594 = tanh 1.
        let [_, exponential, tanh] = ALL;
        for rho in [1e-9, 0.5, 200.0, 1e4].map(Millimeters) {
            let (a, b) = (exponential.share(rho), tanh.share(rho));
            assert!((a - b).abs() <= 1e-14 * b, "{rho}");
        }
        assert!((exponential.share(Millimeters(200.0)) - 0.761_594_155_955_765).abs() < 1e-14);
    }

    #[test]
    fn the_share_per_distance_has_the_slope_as_its_limit() {
        for approach in ALL.into_iter().skip(1) {
            let slope = approach.slope().unwrap().0;
            let near = approach.share_per_distance(Millimeters(1e-7)).0;
            assert!((near - slope).abs() < 1e-12 * slope);
            let at_target = approach.share_per_distance(Millimeters(0.0)).0;
            assert!((at_target - slope).abs() < f64::EPSILON);
        }
        assert_eq!(ALL[0].slope(), None);
    }
}
