use std::time::Duration;

use kinematics::{ArmModel, Frames};

use crate::config::{FrameNumbers, RobotPlan, Tolerance};
use crate::link::ControllerAddress;
use crate::metrics::ControllerMetrics;

use protocol::v2::StatusLine;

use super::readiness::{NotReady, implausible};

/// Between two polls while all is well: five a second.
const POLL: Duration = Duration::from_millis(200);
/// Where the controller's clock is faster, polls come faster, but not without limit.
const SHORTEST_POLL: Duration = Duration::from_millis(5);
/// An answer later than this is late.
pub(super) const LATE: Duration = Duration::from_millis(250);
/// A controller without an answer for this long is lost: with the poll before it, less than a second.
pub(super) const LOST: Duration = Duration::from_millis(700);
/// How long a verdict must hold that a later status could change, by the controller's clock. As long as the
/// controller's dead-man: whatever was about to begin has begun or been stopped.
const SETTLE: Duration = Duration::from_secs(2);
/// How long after a fence a command may still be found to have been taken before it, by the controller's clock: twice
/// the life of a nonce.
const DRAIN: Duration = Duration::from_secs(1);
/// How long a motion in flight waits for a lost controller to come back.
pub(super) const GIVE_UP: Duration = Duration::from_secs(15);

/// What a link to a tier-2 controller runs on.
#[derive(Clone, Debug)]
pub(crate) struct CellServerPlan {
    pub(crate) cell: String,
    pub(crate) robot: String,
    pub(crate) command: ControllerAddress,
    pub(crate) status: ControllerAddress,
    pub(crate) queue_capacity: usize,
    pub(crate) connect_timeout: Duration,
    /// From the greeting asked for to the greeting, and from the command written to its answer.
    pub(crate) reply_timeout: Duration,
    pub(crate) tolerance: Tolerance,
    pub(crate) frame_numbers: FrameNumbers,
    /// Seconds of the controller's clock in a second. Intervals of its clock are divided by it; what the network
    /// needs is not.
    pub(crate) time_scale: f64,
    /// What the controller's reports are checked against.
    pub(crate) arm: Option<Arm>,
    pub(crate) metrics: ControllerMetrics,
}

/// The arm the controller is said to move.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arm {
    pub(crate) model: &'static ArmModel,
    pub(crate) frames: Frames,
}

impl CellServerPlan {
    /// The link of a robot of the configuration.
    pub(crate) fn of(robot: &RobotPlan, metrics: ControllerMetrics) -> Self {
        Self {
            cell: robot.cell.clone(),
            robot: robot.id.clone(),
            command: robot.controller.clone(),
            status: robot.status_controller.clone(),
            queue_capacity: robot.queue_capacity,
            connect_timeout: robot.connect_timeout,
            reply_timeout: robot.reply_timeout,
            tolerance: robot.tolerance,
            frame_numbers: robot.frame_numbers,
            time_scale: robot.time_scale,
            arm: Some(Arm {
                model: robot.model,
                frames: robot.frames,
            }),
            metrics,
        }
    }

    /// Why the arm, as it is reported, must not be moved.
    pub(super) fn implausible(&self, status: &StatusLine) -> Option<NotReady> {
        implausible(status, self.arm.as_ref()?)
    }

    pub(super) fn poll(&self) -> Duration {
        POLL.div_f64(self.time_scale).max(SHORTEST_POLL)
    }

    pub(super) fn settle(&self) -> Duration {
        SETTLE.div_f64(self.time_scale)
    }

    pub(super) fn drain(&self) -> Duration {
        DRAIN.div_f64(self.time_scale)
    }
}
