//! Motions that programs ask for.

use std::sync::Arc;

use crate::position::{JointPosition, XyzwprExt};

/// Whether a MOVE waits for its end. The host needs it only for its records.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MoveEnd {
    /// The statement ends when the motion ends.
    Wait,
    /// `NOWAIT`: the statement ends when the motion is queued.
    NoWait,
}

/// A MOVE TO. Speed, motion type, frames and termination are the host's system variables
/// (`$SPEED`, `$MOTYPE`, `$UFRAME`, `$UTOOL`, `$TERMTYPE`) at the moment of the call.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionRequest {
    /// Where `$UTOOL` goes to in `$UFRAME`, millimeters and degrees.
    pub target: XyzwprExt,
    /// `VIA`: a position on the arc of a circular motion.
    pub via: Option<XyzwprExt>,
    /// `MOVE AXIS`: the joints that are meant, in place of the target, which is where the tool is.
    pub joints: Option<JointPosition>,
    /// How it gets there.
    pub path: MotionPath,
    /// Motion group, from 1.
    pub group: i32,
    /// Whether the statement waits.
    pub end: MoveEnd,
    /// Program of the statement, upper case.
    pub program: Arc<str>,
    /// Physical source line of the statement, from 1.
    pub line: u32,
}

/// How a motion of a KAREL program gets to its target.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MotionPath {
    /// As `$MOTYPE` says.
    #[default]
    AsSet,
    /// On a straight line, whatever `$MOTYPE` says: RELATIVE, AWAY, ABOUT.
    Straight,
}

/// How a motion of a TP program gets to its target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Interpolation {
    /// `J`: all axes start and stop together.
    Joint,
    /// `L`: the tool center point on a straight line.
    Linear,
    /// `C`: the tool center point on an arc through [`TpMotion::via`].
    Circular,
    /// `A`: the tool center point on the arc that does not pass [`TpMotion::via`], of the circle through it.
    CircleArc,
}

/// Where a motion of a TP program goes to.
#[derive(Clone, Debug, PartialEq)]
pub enum TpTarget {
    /// A pose of the active tool in the active user frame of the TP environment.
    Cartesian(XyzwprExt),
    /// Joints.
    Joints(JointPosition),
}

/// How fast a motion of a TP program is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TpSpeed {
    /// Of the speed of the axis that limits the motion.
    Percent(f32),
    /// Of the tool center point.
    MmPerSec(f32),
    /// Of the change of the tool's orientation.
    DegPerSec(f32),
    /// From the start to the end.
    Seconds(f32),
    /// As fast as the arm can.
    Greatest,
}

/// A motion instruction of a TP program.
#[derive(Clone, Debug, PartialEq)]
pub struct TpMotion {
    /// `J`, `L`, `C` or `A`.
    pub interpolation: Interpolation,
    /// Of a `C`: a position on the arc between the start and the target. Of an `A`: one on the rest of the circle.
    pub via: Option<TpTarget>,
    /// Where to.
    pub target: TpTarget,
    /// How fast.
    pub speed: TpSpeed,
    /// `CNT`: how much the corner at the target may be rounded, 0 to 100; `None` is `FINE`.
    pub rounding_percent: Option<f32>,
    /// `INC`: the target counts from where the motion starts, component by component.
    pub incremental: bool,
    /// `Wjnt`: the last three axes go as in a joint motion, the first three keep the tool on its way.
    pub wrist_joint: bool,
    /// `MROT` of a `J`: J4 and J6 go to the turn that is nearest, whatever the target's configuration says.
    pub least_rotation: bool,
    /// Of the usual acceleration; above 0.
    pub acceleration_percent: f32,
    /// Program of the instruction, upper case.
    pub program: Arc<str>,
    /// The instruction's line as the pendant numbers it, from 1.
    pub line: u32,
}
