//! Why a virtual mobile robot does not start, does not answer, or refuses.

use std::fmt::Display;
use std::io;
use std::net::{IpAddr, SocketAddr};

use mobile_base::OutOfRange;

/// A key of the configuration that does not fit.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("`{key}`: {reason}")]
pub struct ConfigError {
    /// The key's path, e.g. `docking.tolerance_mm`.
    pub key: String,
    /// The value and its limit.
    pub reason: String,
}

impl ConfigError {
    pub(crate) fn new(key: impl Into<String>, reason: impl Display) -> Self {
        Self {
            key: key.into(),
            reason: format!("{reason}"),
        }
    }

    /// For a section whose numbers the control laws refuse.
    pub(crate) fn in_section(section: &str) -> impl Fn(OutOfRange) -> Self {
        move |error| Self::new(section, error)
    }
}

/// The robot did not start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// A key of the configuration does not fit.
    #[error("the configuration of the mobile robot")]
    Config(#[from] ConfigError),
    /// The address is reachable from other machines.
    #[error(
        "{ip} is not a loopback address: anybody who reaches the view can change the robot, \
         and only `view.expose_to_network = true` opens it to other machines"
    )]
    NotLoopback {
        /// The address.
        ip: IpAddr,
    },
    /// The view's address cannot be opened.
    #[error("opening the view on {address}")]
    View {
        /// The address.
        address: SocketAddr,
        /// The system's answer.
        #[source]
        source: io::Error,
    },
}

/// The robot has stopped, so there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the virtual mobile robot has stopped")]
pub struct RobotStopped;

/// Something that cannot be asked of the robot. Nothing has changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// There is no such slot.
    #[error("there is no slot `{slot}`; there are: {known}")]
    UnknownSlot {
        /// As asked.
        slot: String,
        /// Those that are.
        known: String,
    },
    /// A slot holds one load.
    #[error("slot `{slot}` holds `{load}` already")]
    SlotTaken {
        /// The slot.
        slot: String,
        /// What lies in it.
        load: String,
    },
    /// There is nothing to take.
    #[error("slot `{slot}` is empty")]
    SlotEmpty {
        /// The slot.
        slot: String,
    },
    /// A load is in one place.
    #[error("load `{load}` lies in slot `{slot}` already")]
    LoadElsewhere {
        /// The load.
        load: String,
        /// Where it is.
        slot: String,
    },
    /// A value that does not fit.
    #[error("{item} is {value}; it must be {limit}")]
    Value {
        /// What the value is.
        item: &'static str,
        /// What was given.
        value: String,
        /// What is accepted.
        limit: String,
    },
    /// The message is not the next one; the robot asks for those before.
    #[error("message {got} is not the next one; that is {expected}")]
    Gap {
        /// The next one.
        expected: u64,
        /// What came.
        got: u64,
    },
    /// It does not drive there by itself.
    #[error("it does not drive to `{point}`: {reason}")]
    NoVisit {
        /// The point.
        point: String,
        /// Why.
        reason: String,
    },
    /// The robot has no power.
    #[error("the robot is down")]
    Down,
    /// The robot has stopped.
    #[error(transparent)]
    Stopped(#[from] RobotStopped),
}

/// `value` if it is a number from `min` to `max`.
pub(crate) fn number(
    item: &'static str,
    value: f64,
    (min, max): (f64, f64),
) -> Result<f64, Refusal> {
    if (min..=max).contains(&value) {
        return Ok(value);
    }
    Err(Refusal::Value {
        item,
        value: value.to_string(),
        limit: format!("from {min} to {max}"),
    })
}

/// `text` if it can be an id.
pub(crate) fn id<'a>(item: &'static str, text: &'a str) -> Result<&'a str, Refusal> {
    let legal = |byte: u8| byte.is_ascii_alphanumeric() || b"._-/".contains(&byte);
    if (1..=api::MAX_MOBILE_ID).contains(&text.len()) && text.bytes().all(legal) {
        return Ok(text);
    }
    let shown: String = text.chars().take(80).collect();
    Err(Refusal::Value {
        item,
        value: format!("{shown:?}"),
        limit: format!(
            "1 to {} of A-Z, a-z, 0-9, `.`, `_`, `-` and `/`",
            api::MAX_MOBILE_ID
        ),
    })
}
