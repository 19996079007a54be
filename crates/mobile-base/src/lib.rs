//! stub
#![expect(
    non_snake_case,
    reason = "frames are part of a name: X_WB is the base's frame B in the world W"
)]
mod approach;
mod base;
mod integrate;
mod odometry;
mod point_law;
mod polar;
mod pose;
mod range;
mod tracking;
mod twist;
mod wheels;

pub use approach::Approach;
pub use base::{Dimensions, MecanumBase, ScaledTwist, WheelTooFast};
pub use integrate::runge_kutta;
pub use odometry::{NoisyEncoders, Odometry};
pub use point_law::{HeadingReference, PointGains, PointLaw};
pub use polar::{Polar, PolarCommand, PolarRates};
pub use pose::{PlanarPose, Point};
pub use range::{OutOfRange, Quantity};
pub use tracking::{Deviation, Reference, TrackingLaw, Trajectory};
pub use twist::{BodyTwist, Displacement, WorldTwist};
pub use wheels::{Wheel, WheelAngles, WheelSpeeds};
