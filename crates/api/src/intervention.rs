use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

use crate::{DecisionBody, Evidence, PoseBody, ProblemCode};

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
    /// Since when.
    pub opened_at: Timestamp,
    /// What is asked, in a sentence.
    pub question: String,
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
    pub decision: Option<DecisionBody>,
}

/// What an intervention is about.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum InterventionKind {
    /// A motion that may have been executed, in whole, in part, or not at all.
    MotionInDoubt,
}

/// Whether an intervention waits for its answer.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum InterventionState {
    /// It waits.
    Open,
    /// It was answered.
    Answered,
}

/// An answer that may be given.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct AllowedAnswer {
    /// The word to answer with.
    pub answer: String,
    /// What follows from it.
    pub consequence: String,
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
}
