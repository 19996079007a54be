//! A gripper and the work pieces that it takes: one output closes it, three inputs tell what it does.

use std::fmt;
use std::sync::Arc;
use std::time::Duration;

use kinematics::Pose;
use serde::{Deserialize, Serialize};

/// The gripper's wiring and speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GripperConfig {
    /// `DOUT` that closes it while on and opens it while off.
    pub close_output: u16,
    /// `DIN` that is on while it is closed.
    pub closed_input: u16,
    /// `DIN` that is on while it is open.
    pub open_input: u16,
    /// `DIN` that is on while a part is in it.
    pub part_input: u16,
    /// Time from open to closed and back.
    pub travel: Duration,
}

/// Closes on output 1, reports on inputs 1 (closed), 2 (open) and 3 (part), takes 300 ms.
impl Default for GripperConfig {
    fn default() -> Self {
        Self {
            close_output: 1,
            closed_input: 1,
            open_input: 2,
            part_input: 3,
            travel: Duration::from_millis(300),
        }
    }
}

/// The work pieces around the arms. Called by the controllers' tasks: it must answer at once.
pub trait Workpieces: Send + Sync {
    /// The gripper of a controller has closed with its tool center point at `tcp`, in the arm's world frame: the part
    /// that it holds now, if there is one.
    fn close_at(&self, controller: &str, tcp: &Pose) -> Option<String>;

    /// The gripper of a controller has opened there and lets the part go.
    fn open_at(&self, controller: &str, part: &str, tcp: &Pose);
}

/// [`Workpieces`] that somebody else owns, too.
#[derive(Clone)]
pub struct SharedWorkpieces(pub Arc<dyn Workpieces>);

impl fmt::Debug for SharedWorkpieces {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("SharedWorkpieces")
    }
}

/// What a gripper does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum GripperPosition {
    /// Open; its input is on.
    Open,
    /// On its way to closed.
    Closing,
    /// Closed, on a part or on nothing.
    Closed,
    /// On its way to open.
    Opening,
}

/// A gripper as people and tests see it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct GripperView {
    /// What it does.
    pub position: GripperPosition,
    /// Whether it cannot move.
    pub jammed: bool,
    /// The part in it.
    pub part: Option<String>,
}
