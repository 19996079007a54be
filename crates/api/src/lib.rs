//! Request and response bodies of the HTTP API, and its problem codes.
//!
//! Everything here is at the edge: millimeters, degrees, the unit in the key. The bodies carry numbers as they
//! arrived; whoever reads them converts to the checked types of `units` and `kinematics` before using them.
//! Requests refuse unknown and duplicate keys; answers may grow, so clients ignore keys they do not know.

mod description;
mod health;
mod kinematics;
mod legacy;
mod mobile;
mod motion;
mod pose;
mod problem;
mod state;

pub use description::{CellSummary, JointDescription, RobotDescription, RobotSummary, Tier};
pub use health::{LinkReadiness, Liveness, Readiness};
pub use kinematics::{
    BranchBody, ForwardBody, ForwardResult, InverseBody, InverseResult, JointMargin,
    SingularityBody,
};
pub use legacy::{
    LegacyDelta, LegacyMoved, LegacyPoint, LegacyRefusal, LegacyValidation, LegacyValidationItem,
    LegacyVersion,
};
pub use mobile::{
    DockToleranceBody, FloorAreaBody, FloorPoseBody, MAX_MOBILE_ID, MAX_OUTBOX_WAIT_S,
    MAX_SIGNAL_ITEMS, MobileErrorBody, MobileErrorLevel, MobileMessage, MobileRobotState,
    MobileRobotSummary, OperatingMode, Outbox, OutboxMessage, OutboxQuery, RoutePointBody,
    SignalAnswer, SignalBody, SignalData, SignalName, SlotLoadBody, TransportOrderBody,
};
pub use motion::{Completion, Motion, MotionBody, MotionList, MotionState, MotionType, TargetBody};
pub use pose::{JointsBody, PoseBody};
pub use problem::{Outcome, Problem, ProblemCode, ProblemKind, Violation};
pub use state::{LinkState, LinkStatus, PoseSource, RobotState};
