//! What a caller asks for.

use serde::{Deserialize, Serialize};

use crate::ids::Millis;

/// The two group workflows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Workflow {
    /// A: a mobile robot brings loads, an arm unloads and places them.
    DeliveryAndPlacement,
    /// B: an arm loads a mobile robot, which takes the loads away.
    PickupAndDelivery,
}

/// What to do with a load in the gripper when the job is canceled.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum OnCancel {
    /// Place this load where it was going, then stop.
    Complete,
    /// Put it back where it came from: A: the mobile robot while it is docked; B: its source.
    ReturnToMr,
    /// Into the job's reject slot.
    RejectBin,
    /// Ask a human.
    #[default]
    Hold,
}

/// When workflow B is complete.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum CompleteOn {
    /// When the mobile robot has left with the loads.
    #[default]
    Departed,
    /// When it has delivered them.
    Delivered,
}

/// One load to move.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ItemParams {
    /// The load, if it is known by name.
    #[serde(default)]
    pub load_id: Option<String>,
    /// Its type.
    #[serde(rename = "type")]
    pub kind: String,
    /// The slot of the mobile robot: A from there, B to there.
    pub mr_slot: String,
    /// The fixed place: A to there, B from there.
    pub place: String,
    /// Other fixed places that do as well (A only).
    #[serde(default)]
    pub alternates: Vec<String>,
}

/// A new job.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NewJob {
    /// Which workflow.
    pub workflow: Workflow,
    /// `None`: any mobile robot that has the slots and is free.
    #[serde(default)]
    pub mobile_robot: Option<String>,
    /// `None`: any arm of the point that was taught all places.
    #[serde(default)]
    pub arm: Option<String>,
    /// `station/point`.
    pub point: String,
    /// In this order.
    pub items: Vec<ItemParams>,
    /// A: let the mobile robot go as soon as the last load was lifted.
    #[serde(default)]
    pub early_release: bool,
    /// B: pick the first load while the mobile robot is on its way.
    #[serde(default)]
    pub prefetch: bool,
    /// What to do with a load in the gripper.
    #[serde(default)]
    pub on_cancel_with_load: OnCancel,
    /// For [`OnCancel::RejectBin`] and for answers that name it.
    #[serde(default)]
    pub reject_slot: Option<String>,
    /// How often a grip is tried, 1 to 10.
    #[serde(default = "two")]
    pub max_attempts: u8,
    /// B: where to.
    #[serde(default)]
    pub destination: Option<String>,
    /// B: when it is complete.
    #[serde(default)]
    pub complete_on: CompleteOn,
    /// Higher first.
    #[serde(default)]
    pub priority: i32,
    /// Has to have started by then, on the driver's clock.
    #[serde(default)]
    pub deadline: Option<Millis>,
    /// Expected drive to the point: `T_arr` is 1.5 times this.
    #[serde(default)]
    pub expected_arrival_ms: Option<Millis>,
    /// Expected drive to the destination: its timer is twice this.
    #[serde(default)]
    pub expected_transport_ms: Option<Millis>,
}

const fn two() -> u8 {
    2
}
