use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::{JobParams, SignalName, WorkflowName};

/// A job that a mobile robot starts by its own signal: when it comes by itself, without an order of the cell.
///
/// One signal starts one job, however often it is sent, over restarts too. While a job of the trigger for a mobile robot
/// is open, further signals of that robot start none; the journal says so.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({
    "id": "unload-at-the-front",
    "on": {"signal": "MR_ARRIVED", "point": "handover/front"},
    "job": {
        "workflow": "delivery-and-placement",
        "params": {
            "point": "handover/front",
            "items": [{"type": "crate", "mr_slot": "left", "place": "rack/d"}]
        }
    }
}))]
pub struct TriggerBody {
    /// Its id; a job shows it as its `trigger`.
    pub id: String,
    /// Whether it starts jobs.
    #[serde(default = "yes")]
    pub enabled: bool,
    /// When.
    pub on: TriggerOn,
    /// What.
    pub job: TriggerJob,
}

const fn yes() -> bool {
    true
}

/// The signal that starts a job.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TriggerOn {
    /// `MR_ARRIVED`, `MR_DOCKED`, `MR_READY`, `MR_MODE` or `LOAD_CHANGED`: the others belong to an order, or are not kept.
    pub signal: SignalName,
    /// Only of this mobile robot; absent: of any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mobile_robot: Option<String>,
    /// Only at a point of this station. Not together with `point`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub station: Option<String>,
    /// Only at this point, `station/point`. Without it and without `station`: wherever the robot is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub point: Option<String>,
}

/// The job that a trigger starts.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TriggerJob {
    /// Which workflow.
    pub workflow: WorkflowName,
    /// Its parameters. Where they name no mobile robot, the job is for the one that signaled.
    pub params: JobParams,
    /// Higher first: -100 to 100; 0 where absent.
    #[serde(default)]
    #[schema(minimum = -100, maximum = 100)]
    pub priority: i32,
    /// How long after the signal the job has to have started, in seconds: one that has not is stopped.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 604_800)]
    pub deadline_s: Option<f64>,
}
