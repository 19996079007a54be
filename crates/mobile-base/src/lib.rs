//! A mobile base on four mecanum wheels: kinematics, control laws, odometry, routes.
//!
//! [`MecanumBase`] turns wheel speeds into body velocity and back. [`PointLaw`] drives to a point and
//! [`TrackingLaw`] along a trajectory; both are feedback laws whose errors decay at a rate that is
//! promised and tested. [`Route`], [`Follower`] and [`Guard`] make a drive of them that slows down for
//! bends, wheel limits and obstacles; [`Robot`] is all of it, simulated.
//!
//! ```text
//!  Y                  x (forward)     W  world: X, Y on the floor
//!  ^      y (left)   /                B  base: in the middle of its four wheels
//!  |            \   /                 X_WB = (X, Y, phi): PlanarPose
//!  |             \ / phi              BodyTwist  velocity along x, y of B, and turn
//!  |              B - - -             WorldTwist the same along X, Y of W
//!  W-------> X                        turns are counterclockwise, seen from above
//! ```
//!
//! A robot that drives to a dock and turns to face it:
//!
//! ```
//! use std::time::Duration;
//! use mobile_base::*;
//! use units::*;
//!
//! let base = MecanumBase::try_new(&Dimensions {
//!     wheel_radius: Millimeters(100.0),
//!     wheelbase: Millimeters(600.0),
//!     track: Millimeters(400.0),
//!     max_wheel_speed: RadPerSec(20.0),
//! })?;
//! let follower = FollowerSettings {
//!     point_law: PointLaw::try_new(&PointGains {
//!         speed: MmPerSec(800.0),
//!         turn: PerSecond(2.0),
//!         approach: Approach::Tanh { scale: Millimeters(300.0) },
//!     })?,
//!     tracking_law: TrackingLaw::try_new([PerSecond(2.0); 3])?,
//!     acceleration: MmPerSec2(1000.0),
//!     heading_tolerance: Degrees(0.5).into(),
//!     max_deviation: Millimeters(200.0),
//! };
//! let settings = RobotSettings { base, follower, guard: None, localization: Localization::Exact };
//! let mut robot = Robot::try_new(settings, PlanarPose::default())?;
//!
//! robot.start(Route::try_new(vec![Leg::Waypoint(Waypoint {
//!     point: Point::try_new(Millimeters(2000.0), Millimeters(1000.0))?,
//!     tolerance: Millimeters(1.0),
//!     heading: WaypointHeading::Turn { to: Degrees(90.0).into() },
//! })])?)?;
//! let mut time = Duration::ZERO;
//! let step = Duration::from_millis(10);
//! while robot.step(step)? == Some(DriveState::Driving) {
//!     time += step;
//! }
//! let Some(DriveState::Arrived(docking)) = robot.state() else { return Err("stopped".into()) };
//! assert!(docking.distance < Millimeters(1.0) && time < Duration::from_secs(10));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Lengths are millimeters and angles radians. Nothing here does I/O or reads a clock, and nothing has
//! a mass. **This is not a safety function:** scanners and emergency stop stay hard-wired in the
//! robot.
#![expect(
    non_snake_case,
    reason = "frames are part of a name: X_WB is the base's frame B in the world W"
)]

mod approach;
mod base;
mod cubic;
mod follower;
mod guard;
mod integrate;
mod legs;
mod odometry;
mod point_law;
mod polar;
mod pose;
mod range;
mod robot;
mod route;
mod shapes;
mod speed_plan;
mod spline;
mod tracking;
mod twist;
mod wheels;

pub use approach::Approach;
pub use base::{Dimensions, MecanumBase, ScaledTwist, WheelTooFast};
pub use follower::{
    Docking, DriveCommand, DriveError, DriveState, Follower, FollowerSettings, Progress, StopReason,
};
pub use guard::{Blocked, Guard, GuardSettings, Passage};
pub use integrate::runge_kutta;
pub use odometry::{NoisyEncoders, Odometry};
pub use point_law::{HeadingReference, PointGains, PointLaw};
pub use polar::{Polar, PolarCommand, PolarRates};
pub use pose::{PlanarPose, Point};
pub use range::{OutOfRange, Quantity};
pub use robot::{Localization, Robot, RobotSettings};
pub use route::{Leg, Route, Waypoint, WaypointHeading};
pub use shapes::{Footprint, Obstacle};
pub use speed_plan::{PathError, PathHeading, PathLimits, PlannedPath};
pub use spline::{PathPoint, Spline, SplineEnds, SplineError};
pub use tracking::{Deviation, Reference, TrackingLaw, Trajectory};
pub use twist::{BodyTwist, Displacement, WorldTwist};
pub use wheels::{Wheel, WheelAngles, WheelSpeeds};
