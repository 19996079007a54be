use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{Evidence, FaultName, LoadLocation, PoseBody, ProblemCode, Role};

/// Something only a person can decide: what is known, what is not, and what may be answered.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Intervention {
    /// Its id. That of a motion in doubt is the motion's.
    pub id: Uuid,
    /// What it is about. The list grows: a client shows what it does not know by `question` and `allowed`.
    pub kind: InterventionKind,
    /// Whether it still waits for its answer.
    pub state: InterventionState,
    /// The cell.
    pub cell: String,
    /// The robot concerned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// The motion concerned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub motion: Option<Uuid>,
    /// The job concerned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<Uuid>,
    /// The hand-over session concerned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub session: Option<Uuid>,
    /// The load concerned.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub load: Option<String>,
    /// The fault behind it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<FaultName>,
    /// Since when.
    pub opened_at: Timestamp,
    /// What is asked, in a sentence.
    pub question: String,
    /// What is known.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub known: Vec<String>,
    /// What is not known: what to look at before answering.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unknown: Vec<String>,
    /// What went wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub code: Option<ProblemCode>,
    /// Where the arm was to go.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub target: Option<PoseBody>,
    /// The controller's words, if it said anything.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub controller_text: Option<String>,
    /// What the controller reported afterwards; absent where it reports nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub evidence: Option<Evidence>,
    /// What may be answered, and what follows from it.
    pub allowed: Vec<AllowedAnswer>,
    /// What was answered.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub decision: Option<InterventionDecision>,
    /// Why nobody has to answer any more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub withdrawn: Option<String>,
}

/// What a person decided, once and for good.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct InterventionDecision {
    /// The answer.
    pub answer: String,
    /// Who.
    pub principal: String,
    /// Why.
    pub reason: String,
    /// When; absent where only the job's events tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<Timestamp>,
}

/// What an intervention is about.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum InterventionKind {
    /// A motion that may have been executed, in whole, in part, or not at all.
    MotionInDoubt,
    /// A job or a hand-over that cannot go on by itself.
    Job,
}

/// Whether an intervention waits for its answer.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum InterventionState {
    /// It waits.
    Open,
    /// It was answered.
    Answered,
    /// Its cause went away, so that nobody has to answer.
    Withdrawn,
}

/// An answer that may be given.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct AllowedAnswer {
    /// The word to answer with.
    pub answer: String,
    /// What follows from it.
    pub consequence: String,
    /// Who may give it; absent: an operator.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<Role>,
    /// What has to be said with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub needs: Option<AnswerNeeds>,
}

/// What has to be said with an answer, as a key of the body.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AnswerNeeds {
    /// Which mobile robot.
    MobileRobot,
    /// Which place.
    Place,
    /// Where the load is, and the load's id once more.
    Custody,
}

/// The interventions that wait for an answer, the oldest first.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct InterventionList {
    /// They.
    pub interventions: Vec<Intervention>,
}

/// An answer to an intervention.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"answer": "did_not_happen", "reason": "the arm stands where it stood"}))]
pub struct RespondBody {
    /// One of the allowed answers.
    pub answer: String,
    /// Why, for the record: 1 to 500 characters.
    #[schema(min_length = 1, max_length = 500)]
    pub reason: String,
    /// The mobile robot, for answers that need one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mobile_robot: Option<String>,
    /// The place, for answers that need one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// Where the load is, for answers that need it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub custody: Option<CustodyAnswer>,
}

/// Where a load is, said with an answer.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct CustodyAnswer {
    /// The load the question is about, once more.
    pub confirm: String,
    /// Where it is.
    pub location: LoadLocation,
}
