//! Where the base believes it is: dead reckoning from what the wheels say.

use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::SeedableRng;
use units::Radians;

use crate::base::MecanumBase;
use crate::pose::PlanarPose;
use crate::range::{OutOfRange, within};
use crate::wheels::WheelAngles;

/// The largest standard deviation after one radian of turning.
const MAX_NOISE: Radians = Radians(1.0);

/// The sum of the wheels' ways since a known pose.
///
/// Each increment is driven as one arc, so reckoning is exact for wheels that turn evenly between two
/// readings and do not slip. What slips is averaged over the wheels and never noticed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Odometry {
    base: MecanumBase,
    pose: PlanarPose,
}

impl Odometry {
    /// Reckons from `start`. `base` is what the controller believes of the base: its wheel radius may
    /// differ from the true one.
    #[must_use]
    pub fn new(base: MecanumBase, start: PlanarPose) -> Odometry {
        Odometry { base, pose: start }
    }

    /// The pose it has come to.
    #[must_use]
    pub fn pose(&self) -> PlanarPose {
        self.pose
    }

    /// Starts again from a pose that was measured otherwise.
    pub fn correct(&mut self, pose: PlanarPose) {
        self.pose = pose;
    }

    /// Adds what the wheels turned since the last reading.
    ///
    /// # Errors
    /// The new pose is out of range, or an angle is not a number; the pose then stays as it was.
    pub fn add(&mut self, increments: &WheelAngles) -> Result<PlanarPose, OutOfRange> {
        self.pose = self.pose.moved_by(&self.base.displacement(increments))?;
        Ok(self.pose)
    }
}

/// Encoders that misread: each reading has an error with a variance that grows with the angle turned.
///
/// The same seed gives the same errors, on every machine: the generator (PCG, 64 bits out of 128) is
/// one that promises to keep its sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct NoisyEncoders {
    deviation: f64,
    random: Pcg64Mcg,
}

impl NoisyEncoders {
    /// Encoders whose error has the standard deviation `after_one_radian` when a wheel has turned by
    /// one radian, and grows as the root of the angle: no error while it stands still.
    ///
    /// # Errors
    /// A deviation that is not from 0 to 1 radian.
    pub fn try_new(after_one_radian: Radians, seed: u64) -> Result<NoisyEncoders, OutOfRange> {
        let deviation = within(
            "noise of the encoders",
            after_one_radian,
            Radians(0.0),
            MAX_NOISE,
        )?;
        Ok(NoisyEncoders {
            deviation: deviation.0,
            random: Pcg64Mcg::seed_from_u64(seed),
        })
    }

    /// What the encoders say when the wheels have turned by `increments`.
    pub fn read(&mut self, increments: &WheelAngles) -> WheelAngles {
        WheelAngles(increments.0.map(|turned| {
            let error: f64 = StandardNormal.sample(&mut self.random);
            Radians(turned.0 + self.deviation * turned.0.abs().sqrt() * error)
        }))
    }
}
