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
