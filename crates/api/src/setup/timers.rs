use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The timers of the workflows, in milliseconds. An absent one keeps its default.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TimersBody {
    /// How long a job waits for its claims at a time; 30 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub reserve_ms: Option<u64>,
    /// How long planning every pose may take; 5 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub precheck_ms: Option<u64>,
    /// How long a mobile robot may take to acknowledge an order, each time; 5 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub acknowledge_ms: Option<u64>,
    /// How long it may take to arrive; 300 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub arrive_ms: Option<u64>,
    /// How long docking may take; 60 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub dock_ms: Option<u64>,
    /// How long looking for the load may take; 10 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub verify_ms: Option<u64>,
    /// How long a docked mobile robot may take to say that it waits; 10 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub ready_ms: Option<u64>,
    /// How long a gripper may take; 3 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub grip_ms: Option<u64>,
    /// How long a mobile robot may take to begin to leave, each time; 10 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub exit_ms: Option<u64>,
    /// How long it may take to be out of the zone; 60 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub clear_ms: Option<u64>,
    /// How long a load may be held for a mobile robot that is late; 120 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub hold_ms: Option<u64>,
    /// How long an arm may take to a safe pose when the mobile robot falls silent; 3 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub safe_ms: Option<u64>,
    /// How long taking a load to its destination may take; 600 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub transport_ms: Option<u64>,
    /// After which silence a docked mobile robot counts as lost; 3 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub heartbeat_ms: Option<u64>,
    /// After which silence an arm counts as lost; 3 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub arm_silence_ms: Option<u64>,
    /// How much longer than one and a half times its plan a motion may take; 5 000.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub motion_margin_ms: Option<u64>,
}
