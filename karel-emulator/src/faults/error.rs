//! Why a fault was not injected.

use super::MAX_FAULTS;
use crate::error::ControllerStopped;

/// Why a fault was not injected; nothing has changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FaultError {
    /// A number beyond its limits.
    #[error("{item} is {value}, it must be {min} to {max}")]
    Range {
        /// The key.
        item: &'static str,
        /// What was given.
        value: String,
        /// The lowest.
        min: u64,
        /// The highest.
        max: u64,
    },
    /// No server tag.
    #[error("{item} is {value:?}, it must be S1 to S8")]
    Tag {
        /// The key.
        item: &'static str,
        /// What was given.
        value: String,
    },
    /// `times` or `scope` with a fault of the controller.
    #[error("{fault} is a fault of the controller, it takes neither scope nor times")]
    NotForDevices {
        /// The fault.
        fault: &'static str,
    },
    /// `times` or `for_ms` with a fault that ends by itself.
    #[error("{fault} ends by itself, it takes neither times nor for_ms")]
    NoEnd {
        /// The fault.
        fault: &'static str,
    },
    /// `times` with a stall.
    #[error("stall holds what comes, it takes for_ms and no times")]
    NoTimes,
    /// There are enough.
    #[error("{MAX_FAULTS} faults are active, which is the limit")]
    TooMany,
    /// The same fault of the controller is active already.
    #[error("{fault} is active already, as fault {id}")]
    Active {
        /// The fault.
        fault: &'static str,
        /// Its number.
        id: u64,
    },
    /// A frame that cannot be.
    #[error("the tool frame cannot be set: {reason}")]
    Frame {
        /// Why.
        reason: String,
    },
    /// No fault of this number.
    #[error("there is no active fault {id}")]
    NoSuchFault {
        /// The number.
        id: u64,
    },
    /// The controller stopped.
    #[error(transparent)]
    Stopped(#[from] ControllerStopped),
}
