use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::LinkState;

/// The process answers.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Liveness {
    /// Always true: a process that does not live does not answer.
    pub alive: bool,
}

/// Whether the server takes commands. A controller that does not answer does not make the server unready.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Readiness {
    /// Whether every link takes commands.
    pub ready: bool,
    /// The links, one a robot.
    pub links: Vec<LinkReadiness>,
    /// The journal.
    pub journal: JournalReadiness,
}

/// Whether the journal takes records. Without it nothing moves.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct JournalReadiness {
    /// Whether it takes records.
    pub writable: bool,
    /// Whether it survives a restart.
    pub durable: bool,
    /// How often it was opened: a motion is sent in this epoch or not at all.
    pub epoch: u64,
    /// The number of its last record.
    pub last_record: u64,
    /// Whether the disk is full and only the reserve is left: what runs gets its end, and nothing new begins. It goes
    /// on by itself when there is room.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub on_reserve: bool,
    /// How many entries of the audit since the start are in the server's log and not in the journal, because the
    /// journal took none or too many waited.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub audit_lost: u64,
    /// What is wrong with it, in a sentence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde asks for a reference"
)]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

/// Whether a robot's link takes commands.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct LinkReadiness {
    /// The cell.
    pub cell: String,
    /// The robot.
    pub robot: String,
    /// Whether the link takes commands.
    pub running: bool,
    /// What is known of its controller.
    pub state: LinkState,
}
