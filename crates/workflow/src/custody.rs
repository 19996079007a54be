//! Where each load is: exactly one place, changed only by confirmed grips, releases and human decisions.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The place of a load.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(tag = "at", rename_all = "SCREAMING_SNAKE_CASE", deny_unknown_fields)]
pub enum Location {
    /// A fixed or reject place.
    Fixed {
        /// Its id.
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
    /// A mobile robot took it to a destination: it left the cell.
    Delivered {
        /// Where to.
        destination: String,
    },
    /// Nobody knows. Automation of this load, and of the arm that had it, is blocked until a human says.
    Unknown {
        /// The arm that had it.
        arm: Option<String>,
    },
}

impl std::fmt::Display for Location {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Fixed { place } => f.write_str(place),
            Self::Gripper { arm } => write!(f, "the gripper of {arm}"),
            Self::MobileRobot { mobile_robot, slot } => write!(f, "{slot} of {mobile_robot}"),
            Self::Delivered { destination } => write!(f, "delivered to {destination}"),
            Self::Unknown { .. } => f.write_str("UNKNOWN"),
        }
    }
}

/// Why custody changed.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "by", rename_all = "snake_case")]
pub enum Evidence {
    /// A grip or release was confirmed by the gripper's inputs.
    Gripper {
        /// The operation.
        op: uuid::Uuid,
    },
    /// The truth of an operation could not be found, or a part was lost.
    Doubt {
        /// What was seen.
        text: String,
    },
    /// A mobile robot reported it.
    MobileRobot {
        /// Which one.
        mobile_robot: String,
    },
    /// A human decided.
    Human {
        /// Who.
        principal: String,
        /// Why.
        reason: String,
    },
}

/// One load.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Load {
    /// Its type.
    #[serde(rename = "type")]
    pub kind: String,
    /// Where it is.
    pub location: Location,
}

/// All loads. A map from load to place: a load cannot be in two places.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Custody(pub BTreeMap<String, Load>);

impl Custody {
    pub(crate) fn of(&self, load: &str) -> Option<&Location> {
        self.0.get(load).map(|l| &l.location)
    }

    /// The load at a location; the first by name where a bin holds several.
    pub(crate) fn at(&self, location: &Location) -> Option<&str> {
        self.0
            .iter()
            .find(|(_, l)| l.location == *location)
            .map(|(id, _)| id.as_str())
    }

    pub(crate) fn in_gripper(&self, arm: &str) -> Option<&str> {
        self.at(&Location::Gripper {
            arm: arm.to_owned(),
        })
    }

    /// A load of unknown place that this arm may still have.
    pub(crate) fn doubt_of(&self, arm: &str) -> Option<&str> {
        self.0
            .iter()
            .find(|(_, l)| matches!(&l.location, Location::Unknown { arm: Some(a) } if a == arm))
            .map(|(id, _)| id.as_str())
    }
}
