//! What the driver has to carry out. Effects of replayed facts are never returned.

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::setup::{BasePose, PlaceRef};
use crate::signal::OutMessage;

/// Where a motion goes, in words; the driver resolves it to a pose.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "target", rename_all = "snake_case")]
pub enum Target {
    /// Before the place, at the taught approach distance.
    ApproachOf {
        /// The place.
        place: PlaceRef,
    },
    /// At the place.
    At {
        /// The place.
        place: PlaceRef,
    },
    /// Above the place, where the arm can leave.
    LiftOf {
        /// The place.
        place: PlaceRef,
    },
    /// The arm's safe pose, outside every hand-over zone.
    Safe,
}

impl Target {
    /// The place it belongs to.
    #[must_use]
    pub const fn place(&self) -> Option<&PlaceRef> {
        match self {
            Self::ApproachOf { place } | Self::At { place } | Self::LiftOf { place } => Some(place),
            Self::Safe => None,
        }
    }

    /// Whether it takes the arm into a hand-over zone, rather than out of it.
    #[must_use]
    pub fn enters_zone(&self) -> bool {
        matches!(self, Self::ApproachOf { place } | Self::At { place } if place.in_zone())
    }
}

/// How the way is interpolated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Interpolation {
    /// In joint space.
    Joint,
    /// On a straight line.
    Linear,
}

/// How fast; the driver knows the figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Speed {
    /// In free space.
    Free,
    /// Near loads and in a zone.
    Reduced,
}

/// What a gripper does: levels, never pulses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum GripAction {
    /// Output 1.
    Close,
    /// Output 0.
    Open,
}

/// One operation of an arm, as it was intended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "do", rename_all = "snake_case")]
pub enum Action {
    /// A motion.
    Move {
        /// Where to.
        target: Target,
        /// How.
        interpolation: Interpolation,
        /// How fast.
        speed: Speed,
        /// Where the mobile robot really docked, if the place is on it; the driver corrects the taught pose by the
        /// difference to the point's nominal dock pose.
        docked: Option<BasePose>,
    },
    /// A gripper.
    Grip {
        /// Which way.
        action: GripAction,
    },
    /// Plan all of these without moving.
    Precheck {
        /// In the order in which they will be driven to.
        targets: Vec<Target>,
    },
}

/// What to do.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(tag = "effect", rename_all = "snake_case")]
pub enum Effect {
    /// Carry out an operation and send [`crate::Input::OperationEnded`].
    Operate {
        /// Its id: the key of its durable motion.
        op: Uuid,
        /// Which arm.
        arm: String,
        /// What.
        action: Action,
        /// The job.
        job: Uuid,
        /// The step's number.
        step: usize,
    },
    /// Find out what became of an operation (fence, read, decide) and send [`crate::Input::OperationEnded`].
    Reconcile {
        /// Which.
        op: Uuid,
        /// Of which arm.
        arm: String,
        /// What had been intended.
        action: Action,
    },
    /// Stop an arm by a controlled deceleration. Needs no journal.
    StopArm {
        /// Which.
        arm: String,
    },
    /// Tell a mobile robot; it is also in its outbox.
    Tell {
        /// Whom.
        mobile_robot: String,
        /// What.
        message: OutMessage,
    },
    /// A human is needed.
    Ask {
        /// The question.
        intervention: Uuid,
    },
    /// A human is still needed.
    Remind {
        /// The question.
        intervention: Uuid,
    },
}
