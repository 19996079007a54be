//! Request and response bodies of the HTTP API, and its problem codes.
//!
//! Everything here is at the edge: millimeters, degrees, the unit in the key. The bodies carry numbers as they
//! arrived; whoever reads them converts to the checked types of `units` and `kinematics` before using them.
//! Requests refuse unknown and duplicate keys; answers may grow, so clients ignore keys they do not know.

pub mod arms;
mod audit;
mod authority;
mod cell_state;
mod control;
mod description;
mod event;
mod health;
mod identity;
mod intervention;
mod job;
mod job_history;
mod kinematics;
mod legacy;
mod load;
mod mobile;
mod moment;
mod motion;
pub mod paths;
mod pose;
mod problem;
mod session;
pub mod setup;
mod simulation;
mod state;
pub mod trajectory;

pub use audit::{AuditEntry, AuditList, AuditResult};
pub use authority::{
    AcquireBody, ControlEnd, ControlHolder, ControlLease, ControlToken, ControlTokenError,
    ControlView, EndedLease, LossBehavior, Station, TransferBody,
};
pub use cell_state::{AlarmLevel, ArmState, CellAlarm, CellState, JobCount, SafetyState};
pub use control::{MotionPreview, SpeedOverride, StopBody, StopCategory, StopResult};
pub use description::{
    Capabilities, CellSummary, JointDescription, RobotDescription, RobotSummary, StopEffect, Tier,
};
pub use event::{
    CellEvent, CellEventData, CellStatus, EventGap, EventsQuery, GapReason, JobStatus, LoadStatus,
    PointStatus, TimerStatus,
};
pub use health::{JournalReadiness, LinkReadiness, Liveness, Readiness};
pub use identity::{
    Me, NewToken, Role, RotateBody, TokenBody, TokenInfo, TokenList, TokenScope, TokenSecret,
    TokenState,
};
pub use intervention::{
    AllowedAnswer, AnswerNeeds, CustodyAnswer, Intervention, InterventionDecision,
    InterventionKind, InterventionList, InterventionState, RespondBody,
};
pub use job::{
    ClaimBody, Compensation, CompleteOn, FaultName, Job, JobBody, JobCommand, JobCommandBody,
    JobFault, JobItem, JobItemBody, JobList, JobOperation, JobParams, JobReason, JobState, JobStep,
    JobSummary, OnCancelWithLoad, StepState, TimerBody, WorkflowName,
};
pub use job_history::{
    AttemptReport, DecisionReport, FaultReport, JobEvent, JobEventList, JobReport, PhaseKind,
    PhaseReport, StateTime,
};
pub use kinematics::{
    BranchBody, ForwardBody, ForwardResult, InverseBody, InverseResult, JointMargin,
    SingularityBody,
};
pub use legacy::{
    LegacyDelta, LegacyMoved, LegacyPoint, LegacyRefusal, LegacyValidation, LegacyValidationItem,
    LegacyVersion,
};
pub use load::{
    CustodyBody, CustodyEvent, CustodyEvidence, Load, LoadDetail, LoadList, LoadLocation,
};
pub use mobile::{
    DockToleranceBody, FloorAreaBody, FloorPoseBody, InstantActionAnswer, InstantActionBody,
    InstantActionName, MAX_MOBILE_ID, MAX_OUTBOX_WAIT_S, MAX_SIGNAL_ITEMS, MobileErrorBody,
    MobileErrorLevel, MobileMessage, MobileRobotState, MobileRobotSummary, OperatingMode, Outbox,
    OutboxMessage, OutboxQuery, RoutePointBody, SignalAnswer, SignalBody, SignalData, SignalName,
    SlotLoadBody, TransportOrderBody,
};
pub use motion::{
    Completion, DecisionBody, DoubtAnswer, Evidence, ExpectBody, Motion, MotionBody, MotionList,
    MotionState, MotionType, RelativeTo, TargetBody,
};
pub use pose::{JointsBody, PoseBody};
pub use problem::{Outcome, Problem, ProblemCode, ProblemKind, Violation};
pub use session::{PointPermits, Session, SessionList, SessionState};
pub use simulation::{
    JobSimulation, SimulatedCustody, SimulatedMotion, SimulatedPermit, SimulatedQuestion,
    SimulatedViolation, SimulationEnd,
};
pub use state::{ControllerState, LinkState, LinkStatus, OperationalMode, PoseSource, RobotState};
