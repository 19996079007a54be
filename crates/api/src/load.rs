//! Loads: where each one is, and how that is known.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

/// Where a load is.
#[derive(Clone, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(tag = "at", rename_all = "SCREAMING_SNAKE_CASE", deny_unknown_fields)]
pub enum LoadLocation {
    /// At a fixed place, or in a reject bin.
    Fixed {
        /// The place.
        place: String,
    },
    /// In the gripper of an arm.
    Gripper {
        /// The arm.
        arm: String,
    },
    /// In a slot of a mobile robot.
    MobileRobot {
        /// The mobile robot.
        mobile_robot: String,
        /// Its slot.
        slot: String,
    },
    /// It was delivered, and has left the cell.
    Delivered {
        /// Where to.
        destination: String,
    },
    /// Nobody knows. Jobs do not touch it until a person says where it is.
    Unknown {
        /// The arm that had it last.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        arm: Option<String>,
    },
}

/// A load.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Load {
    /// Its id.
    pub id: String,
    /// Its type.
    #[serde(rename = "type")]
    pub load_type: String,
    /// Where it is.
    pub location: LoadLocation,
    /// The job that works with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub job: Option<Uuid>,
}

/// The loads of a cell, by id.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct LoadList {
    /// They.
    pub loads: Vec<Load>,
}

/// A load with how it came to where it is.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct LoadDetail {
    /// The load.
    #[serde(flatten)]
    pub load: Load,
    /// How it came there, the newest first: the last 100 moves the journal has.
    pub history: Vec<CustodyEvent>,
}

/// A load came to a place.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct CustodyEvent {
    /// When.
    pub at: Timestamp,
    /// Where it came to.
    pub to: LoadLocation,
    /// How that is known.
    pub evidence: CustodyEvidence,
    /// What was seen or said.
    pub text: String,
    /// The person who said so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub principal: Option<String>,
}

/// How it is known where a load is.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum CustodyEvidence {
    /// The operator's set-up says so.
    Setup,
    /// The gripper's inputs confirmed a grip or a release.
    Gripper,
    /// It was lost, or the end of an operation was not seen.
    Doubt,
    /// A mobile robot reported it.
    MobileRobot,
    /// A person said so.
    Person,
}

/// A person says where a load is.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"location": {"at": "FIXED", "place": "rack/a"}, "confirm": "load-1", "reason": "it stands there"}))]
pub struct CustodyBody {
    /// Where it is.
    pub location: LoadLocation,
    /// The load's id once more.
    pub confirm: String,
    /// Why, for the record: 1 to 500 characters.
    #[schema(min_length = 1, max_length = 500)]
    pub reason: String,
}
