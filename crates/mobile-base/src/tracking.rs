//! The law that follows a trajectory, thesis (11) and the formula after it.

use std::time::Duration;

use units::{Millimeters, MmPerSec, PerSecond, RadPerSec, Radians};

use crate::pose::{PlanarPose, one_turn};
use crate::range::{OutOfRange, within};
use crate::twist::{BodyTwist, WorldTwist};

const MIN_RATE: PerSecond = PerSecond(1e-3);
const MAX_RATE: PerSecond = PerSecond(1e3);

/// Where the base should be at one moment, and how it should move there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reference {
    /// `X_ref`, `Y_ref`, `phi_ref`.
    pub pose: PlanarPose,
    /// Their derivatives.
    pub velocity: WorldTwist,
}

impl Reference {
    /// The wanted velocity in the frame of a base that is at the wanted pose: the program control of
    /// the text before (11). Without feedback; it keeps what deviation there is.
    #[must_use]
    pub fn program_twist(&self) -> BodyTwist {
        self.pose.body_twist(self.velocity)
    }
}

/// A path in time, as smooth as its velocity is wanted: twice differentiable for wheels that do not
/// jerk.
pub trait Trajectory {
    /// Pose and velocity at `time` since the start.
    fn reference(&self, time: Duration) -> Reference;
}

/// How far the base is from its reference, along the axes of the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// X less `X_ref`.
    pub x: Millimeters,
    /// Y less `Y_ref`.
    pub y: Millimeters,
    /// phi less `phi_ref`, the short way round.
    pub heading: Radians,
}

impl Deviation {
    /// Of `pose` from `reference`.
    #[must_use]
    pub fn between(pose: PlanarPose, reference: PlanarPose) -> Deviation {
        let ((x, y), (x_ref, y_ref)) = (pose.position().xy(), reference.position().xy());
        Deviation {
            x: Millimeters(x - x_ref),
            y: Millimeters(y - y_ref),
            heading: Radians(one_turn(pose.heading().0 - reference.heading().0)),
        }
    }

    /// The distance between the two positions.
    #[must_use]
    pub fn distance(&self) -> Millimeters {
        Millimeters(self.x.0.hypot(self.y.0))
    }
}

/// The gains k1, k2, k3 of K in (11), checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackingLaw {
    gains: [PerSecond; 3],
}

impl TrackingLaw {
    /// A law under which the deviations in X, Y and heading decay as e^(-k t), each at its rate.
    ///
    /// # Errors
    /// A rate that is not from 0.001 to 1000 /s.
    pub fn try_new([x, y, heading]: [PerSecond; 3]) -> Result<TrackingLaw, OutOfRange> {
        Ok(TrackingLaw {
            gains: [
                within("k1 of the tracking law", x, MIN_RATE, MAX_RATE)?,
                within("k2 of the tracking law", y, MIN_RATE, MAX_RATE)?,
                within("k3 of the tracking law", heading, MIN_RATE, MAX_RATE)?,
            ],
        })
    }

    /// The rates it was made from.
    #[must_use]
    pub fn gains(&self) -> [PerSecond; 3] {
        self.gains
    }

    /// The twist to drive at `time` along `trajectory`; see [`TrackingLaw::command`].
    #[must_use]
    pub fn follow(
        &self,
        pose: PlanarPose,
        trajectory: &impl Trajectory,
        time: Duration,
    ) -> BodyTwist {
        self.command(pose, &trajectory.reference(time))
    }

    /// The twist to drive now, in the base's frame; the wheels of the thesis's last formula are
    /// [`MecanumBase::inverse`](crate::MecanumBase::inverse) of it.
    ///
    /// Not limited to what the wheels can do. It is turned into the base's frame with the measured
    /// heading, not the reference's.
    #[must_use]
    pub fn command(&self, pose: PlanarPose, reference: &Reference) -> BodyTwist {
        let Deviation { x, y, heading } = Deviation::between(pose, reference.pose);
        let [k1, k2, k3] = self.gains;
        let wanted = reference.velocity;
        pose.body_twist(WorldTwist {
            x: MmPerSec(wanted.x.0 - k1.0 * x.0),
            y: MmPerSec(wanted.y.0 - k2.0 * y.0),
            turn: RadPerSec(wanted.turn.0 - k3.0 * heading.0),
        })
    }
}
