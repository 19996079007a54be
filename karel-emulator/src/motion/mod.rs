//! Motion of the virtual arm: closed forms of time, so nothing ticks while nothing changes.
//!
//! [`planning`] has the curves: the progress along a path in time, lines and circles, inverse kinematics along them. Here
//! [`path`] maps the progress to six joints, [`corner`] rounds what is between two paths, [`executor`] owns the motions
//! that run and the one that waits, and [`planner`] turns a Cartesian target into joints or into an alarm.

pub mod arc;
pub mod convert;
pub mod corner;
pub mod executor;
pub mod linear;
pub mod path;
pub mod planner;
mod tempo;

pub use arc::OnCircle;
pub use corner::Blend;
pub use executor::{Added, Brake, Executor, Happening, Motion, MotionEnd, Outcome};
pub use linear::{LinearTarget, Pace, ToolSpeed};
pub use path::Path;
pub use planner::{Planner, Refusal};

use std::time::Duration;

/// Seconds, rounded up to the clock's nanosecond, so that a motion is never reported ended too early.
#[must_use]
pub(crate) fn duration_from_secs_rounded_up(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds.max(0.0))
        .map_or(Duration::MAX, |d| d.saturating_add(Duration::from_nanos(1)))
}
