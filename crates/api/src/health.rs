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
    /// Why it takes no records.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub problem: Option<String>,
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
