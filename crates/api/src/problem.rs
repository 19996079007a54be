use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use utoipa::openapi::{ObjectBuilder, RefOr, Schema, schema::Type};
use utoipa::{PartialSchema, ToSchema};
use uuid::Uuid;

use crate::ControlHolder;

/// A problem in the form of RFC 9457, media type `application/problem+json`.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Problem {
    /// A URI reference that names the kind of problem: `/problems/` and the code.
    #[serde(rename = "type")]
    pub type_uri: String,
    /// The kind of problem in a few words; the same for every problem of one code.
    pub title: String,
    /// The HTTP status.
    pub status: u16,
    /// What happened this time: the item, the value, the limit.
    pub detail: String,
    /// The path of the request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instance: Option<String>,
    /// The stable code, for programs.
    pub code: ProblemCode,
    /// What is known of the command's effect on the robot.
    pub outcome: Outcome,
    /// Whether the same request may succeed later without a change.
    pub retryable: bool,
    /// The robot concerned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// The motion concerned, where one was recorded.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Uuid>,
    /// The controller's own words, as received.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller_text: Option<String>,
    /// The id of the request, as in the logs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub request_id: Option<String>,
    /// Each thing wrong, where there are several or a number belongs to it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub violations: Vec<Violation>,
    /// What to try.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
    /// Who has control of the cell, where that is the problem.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub control: Option<Box<ControlHolder>>,
}

/// A kind of problem: what a problem's `type` leads to.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ProblemKind {
    /// The stable code, for programs.
    pub code: ProblemCode,
    /// The kind of problem in a few words.
    pub title: String,
    /// The HTTP status that goes with it.
    pub status: u16,
}

/// One thing wrong: a field of the request, or a joint of the arm.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Violation {
    /// The field's path, e.g. `target.pose.x_mm`, or the joint, e.g. `J5`.
    pub item: String,
    /// What is wrong with it.
    pub message: String,
    /// The value, in the item's unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// The smallest legal value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min: Option<f64>,
    /// The largest legal value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max: Option<f64>,
}

/// What is known of a command's effect on the robot.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Outcome {
    /// Nothing reached the controller.
    NotSent,
    /// The controller refused it: not executed.
    Rejected,
    /// It may have been executed. Look at the robot before sending anything else.
    Unknown,
    /// The request was not a command.
    None,
}

macro_rules! problem_codes {
    ($($(#[$doc:meta])* $variant:ident, $text:literal, $status:literal, $title:literal;)*) => {
        /// The stable code of a problem. The list only grows.
        #[derive(Clone, Copy, Debug, Deserialize, Eq, Hash, PartialEq, Serialize)]
        pub enum ProblemCode {
            $($(#[$doc])* #[serde(rename = $text)] $variant,)*
        }

        impl ProblemCode {
            /// Every code, in the order they were added.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// The code as it is written in answers.
            #[must_use]
            pub fn as_str(self) -> &'static str {
                match self { $(Self::$variant => $text,)* }
            }

            /// The code a text names.
            #[must_use]
            pub fn of_str(text: &str) -> Option<Self> {
                Self::ALL.iter().copied().find(|code| code.as_str() == text)
            }

            /// The HTTP status that goes with the code.
            #[must_use]
            pub fn status(self) -> u16 {
                match self { $(Self::$variant => $status,)* }
            }

            /// The kind of problem in a few words.
            #[must_use]
            pub fn title(self) -> &'static str {
                match self { $(Self::$variant => $title,)* }
            }
        }
    };
}

problem_codes! {
    /// The body is not JSON.
    InvalidJson, "invalid-json", 400, "The body is not valid JSON";
    /// A key is missing, unknown, doubled, of the wrong type or out of range.
    Validation, "validation", 422, "The request does not fit";
    /// The content type is not JSON.
    UnsupportedMediaType, "unsupported-media-type", 415, "The content type is not supported";
    /// The body is larger than the server reads.
    PayloadTooLarge, "payload-too-large", 413, "The body is too large";
    /// No such path, cell, robot or motion.
    NotFound, "not-found", 404, "Not found";
    /// The path exists, the method does not.
    MethodNotAllowed, "method-not-allowed", 405, "The method is not allowed here";
    /// The request did not arrive, or was not answered, in time.
    RequestTimeout, "request-timeout", 408, "The request took too long";
    /// No joint values reach the pose.
    OutOfWorkspace, "out-of-workspace", 422, "The pose is out of reach";
    /// The pose is reached only outside the joint limits.
    JointLimitExceeded, "joint-limit-exceeded", 422, "A joint limit is exceeded";
    /// The pose is reached, but not in the configuration the controller keeps.
    NoSolutionInConfiguration, "no-solution-in-configuration", 422,
        "The pose is not reached in the controller's configuration";
    /// The pose is at a singularity.
    Singularity, "singularity", 422, "The pose is singular";
    /// The controller answered no.
    ControllerRejected, "controller-rejected", 409, "The controller refused the command";
    /// The robot's queue is full.
    ControllerBusy, "controller-busy", 503, "The robot's queue is full";
    /// No connection to the controller.
    ControllerDisconnected, "controller-disconnected", 503, "The controller cannot be reached";
    /// Sent, and no answer in time.
    ControllerTimeout, "controller-timeout", 504, "The controller did not answer in time";
    /// Sent, and the answer is not one of the protocol's.
    ControllerProtocol, "controller-protocol", 502, "The controller's answer is not understood";
    /// The deadline passed while the command waited in the queue.
    DeadlinePassed, "deadline-passed", 409, "The deadline passed before the command was sent";
    /// A relative move without an accepted target to count from.
    NoAcceptedTarget, "no-accepted-target", 409, "There is no accepted target to count from";
    /// The server is stopping.
    ShuttingDown, "shutting-down", 503, "The server is stopping";
    /// A defect of the server.
    Internal, "internal", 500, "Something went wrong in the server";
    /// A page of another site made a browser send the request.
    CrossSiteRequest, "cross-site-request", 403, "The request comes from another site";
    /// The Host header names a host the server does not answer for.
    HostNotAllowed, "host-not-allowed", 421, "The host is not one of this server's";
    /// No valid token.
    Unauthorized, "unauthorized", 401, "A valid token is needed";
    /// The token's role or scope does not allow it.
    Forbidden, "forbidden", 403, "The caller may not do this";
    /// Too many tokens that were not valid.
    RateLimited, "rate-limited", 429, "Too many failed attempts";
    /// Nobody moves a robot without control of its cell.
    ControlRequired, "control-required", 428, "Control of the cell is needed";
    /// Somebody else has control of the cell.
    ControlHeld, "control-held", 423, "Somebody else has control of the cell";
    /// The control that was used has ended.
    ControlLost, "control-lost", 409, "Control of the cell was lost";
    /// Without this token nobody could manage tokens any more.
    LastAdmin, "last-admin", 409, "This is the last admin token";
    /// Another valid token has this name.
    NameTaken, "name-taken", 409, "The name is taken";
    /// In demo mode there are no tokens.
    DemoMode, "demo-mode", 409, "The server runs in demo mode";
    /// What was asked could not be written down, so it was not done.
    NotRecorded, "not-recorded", 503, "The change could not be recorded";
    /// The server has as many event streams open as it may.
    ServerBusy, "server-busy", 503, "The server has no place for the request";
    /// An effectful POST without `Idempotency-Key`.
    IdempotencyMissing, "idempotency-missing", 400, "The idempotency key is missing";
    /// The `Idempotency-Key` was used with another request.
    IdempotencyMismatch, "idempotency-mismatch", 422, "The idempotency key was used for something else";
    /// The first request with this `Idempotency-Key` is still being answered.
    IdempotencyInFlight, "idempotency-in-flight", 409, "The first request with this idempotency key is under way";
    /// The journal cannot be written, and without it nothing moves.
    JournalUnavailable, "journal-unavailable", 503, "The journal cannot be written";
    /// The disk of the journal is full, and without it nothing moves.
    JournalFull, "journal-full", 507, "The disk of the journal is full";
    /// The plan of a preview is no longer kept, or was used.
    PlanExpired, "plan-expired", 409, "The plan has expired";
    /// What the caller expected does not hold any more.
    StaleState, "stale-state", 409, "The robot's state has changed";
    /// A relative motion has no fresh pose to count from.
    PoseStale, "pose-stale", 409, "The robot's pose is not known well enough";
    /// A motion of the robot is in doubt, and nobody has decided about it.
    InDoubt, "in-doubt", 409, "A motion of the robot is in doubt";
    /// The server restarted before the motion's end was known.
    ServerRestarted, "server-restarted", 409, "The server restarted before the end was known";
    /// The motion was taken back, or stopped.
    MotionCanceled, "motion-canceled", 409, "The motion was canceled";
    /// The motion began and did not get to its target.
    MotionInterrupted, "motion-interrupted", 409, "The motion was interrupted";
    /// The controller of the robot cannot do this.
    NotSupported, "not-supported", 409, "The robot's controller cannot do this";
    /// The state of the motion does not allow this.
    WrongMotionState, "wrong-motion-state", 409, "The motion's state does not allow this";
    /// Somebody has answered the intervention.
    AlreadyAnswered, "already-answered", 409, "The intervention was answered";
    /// Mode, pendant, hold, alarm, override, frames: the controller would not or should not take a motion now.
    ControllerNotReady, "controller-not-ready", 409, "The controller is not ready for motions";
    /// The command was numbered before the controller was fenced anew.
    StaleEpoch, "stale-epoch", 409, "The command belongs to an earlier time of the link";
    /// A stop came before the command was sent.
    StoppedBeforeSent, "stopped-before-sent", 409, "A stop came before the command was sent";
    /// The stop did not reach the controller, or the controller did not confirm it.
    StopUnconfirmed, "stop-unconfirmed", 503, "The controller has not confirmed the stop";
    /// The controller was started again while a motion was in flight.
    ControllerRestarted, "controller-restarted", 409, "The controller was started again";
    /// A motion was accepted, and stands still without having finished.
    MotionUnfinished, "motion-unfinished", 409, "The motion stands still without having finished";
    /// The controller says arrived, and stands elsewhere.
    PoseMismatch, "pose-mismatch", 409, "The arm does not stand where it should";
    /// The controller accepted a later command than the one asked about.
    MotionOvertaken, "motion-overtaken", 409, "Another command came after the motion";
    /// A change does not say which revision it is based on.
    PreconditionRequired, "precondition-required", 428, "If-Match is required";
    /// Somebody else has changed it meanwhile.
    PreconditionFailed, "precondition-failed", 412, "It was changed meanwhile";
    /// The body is not TOML.
    InvalidToml, "invalid-toml", 400, "The body is not valid TOML";
    /// Other parts of the set-up refer to what is to be deleted.
    StillReferenced, "still-referenced", 409, "Other parts refer to it";
    /// Running work uses what is to be changed.
    ResourceInUse, "resource-in-use", 409, "Running work uses it";
    /// The set-up could not be written where it is kept: nothing was changed.
    SetupNotKept, "setup-not-kept", 503, "The set-up could not be kept";
    /// The controller reports no pose that could be taught.
    NoActualPose, "no-actual-pose", 409, "The arm's actual pose is not known";
    /// The postures do not determine the tool, or do not agree.
    CalibrationRefused, "calibration-refused", 422, "The postures do not give a tool";
    /// A signal that is not legal now.
    HandoverConflict, "handover-conflict", 409, "The signal does not fit the hand-over";
    /// A signal for a hand-over that is over.
    SessionClosed, "session-closed", 410, "The hand-over session is closed";
    /// The state of the job does not allow this.
    WrongJobState, "wrong-job-state", 409, "The job's state does not allow this";
    /// As many jobs are open as a cell may have.
    QueueFull, "queue-full", 409, "The cell has as many jobs as it may";
    /// The cell is still finding out what became of its last run, or too much waits for it.
    CellNotReady, "cell-not-ready", 503, "The cell is not ready";
    /// The answer to an intervention is not possible now.
    AnswerNotPossible, "answer-not-possible", 409, "The answer is not possible now";
    /// Another load is there, or a job works with the load.
    CustodyConflict, "custody-conflict", 409, "The load cannot be booked there";
    /// It could bring an arm and a mobile robot together.
    InterlockViolation, "interlock-violation", 409, "An interlock does not allow it";
    /// This server was started without anything that simulates jobs.
    SimulatorMissing, "simulator-missing", 501, "This server has no simulator";
    /// A load of unknown place: there is no state that a simulation could begin in.
    CustodyUnknown, "custody-unknown", 409, "Nobody knows where a load is";
    /// Another simulation runs, and there is one at a time.
    SimulatorBusy, "simulator-busy", 503, "Another simulation runs";
    /// The simulation broke off. Nothing of the cell has changed.
    SimulationFailed, "simulation-failed", 500, "The simulation failed";
    /// There is no way from start to goal, or none was found within what was allowed.
    NoWay, "no-way", 422, "No way was found";
    /// The way enters a keep-out zone, or leaves the work area.
    ZoneViolation, "zone-violation", 422, "A zone of the cell is in the way";
}

// By hand: the derived schema does not see a name that a macro gives, and would list the variants.
impl PartialSchema for ProblemCode {
    fn schema() -> RefOr<Schema> {
        ObjectBuilder::new()
            .schema_type(Type::String)
            .description(Some("The stable code of a problem. The list only grows."))
            .enum_values(Some(Self::ALL.iter().map(|code| code.as_str())))
            .into()
    }
}

impl ToSchema for ProblemCode {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("ProblemCode")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_documented_codes_are_the_ones_that_are_written() {
        let schema = serde_json::to_value(ProblemCode::schema()).unwrap();
        let documented = schema["enum"].as_array().unwrap();
        assert_eq!(documented.len(), ProblemCode::ALL.len());
        for code in ProblemCode::ALL {
            assert!(documented.contains(&serde_json::to_value(code).unwrap()));
        }
    }

    #[test]
    fn a_code_is_written_as_its_text() {
        for code in ProblemCode::ALL {
            let written = serde_json::to_string(code).unwrap();
            assert_eq!(written, format!("\"{}\"", code.as_str()));
            assert_eq!(ProblemCode::of_str(code.as_str()), Some(*code));
            assert!((400..600).contains(&code.status()));
        }
    }
}
