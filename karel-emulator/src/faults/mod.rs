//! Faults that a test or a person injects: into the wire between clients and the program, and into the controller.
//!
//! A fault has a kind, a scope, and an end: a number of times, a duration in controller time, or whenever it is
//! cleared. Everything random in it comes from the seed of the configuration, so a run with faults can be repeated.

mod check;
mod dice;
mod error;
mod wire;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::ledger::PoseMmDeg;

pub use error::FaultError;

pub(crate) use wire::{Passed, Wire};

/// Faults that may be active at a time.
pub const MAX_FAULTS: usize = 64;
/// The longest time of a fault or a delay: a day.
pub const MAX_MS: u64 = 86_400_000;
/// Most times that a fault can strike.
pub const MAX_TIMES: u32 = 1_000_000;
/// Longest piece that a fault cuts bytes into, or lets through.
pub const MAX_BYTES: usize = 65_536;

/// What breaks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum FaultKind {
    /// Wire: bytes vanish. TCP does not lose bytes; a broken program or a middlebox does.
    Drop,
    /// Wire: bytes arrive later, in order.
    Delay {
        /// How much later, in milliseconds of controller time.
        ms: u64,
        /// Up to this much more, drawn anew for each piece.
        #[serde(default)]
        jitter_ms: u64,
    },
    /// Wire: bytes arrive in pieces.
    Split {
        /// The length of a piece.
        bytes: usize,
        /// Milliseconds of controller time between two pieces.
        #[serde(default = "one")]
        gap_ms: u64,
    },
    /// Wire: only the beginning of what was sent at once arrives.
    Truncate {
        /// How many bytes are left.
        keep: usize,
    },
    /// Wire: bytes arrive changed.
    Corrupt {
        /// How many bytes of each piece.
        #[serde(default = "one_byte")]
        bytes: usize,
    },
    /// Wire: nothing passes; what was held passes when the fault ends.
    Stall,
    /// Wire: the peer is gone and nobody says so: nothing of it arrives, nothing arrives there, and the connection
    /// looks open. A connection that was hit stays so until the fault ends.
    HalfOpen,
    /// Wire: the connections in the scope are reset now. Ends at once.
    Reset,
    /// The controller hangs: no task runs, the arm brakes, connections stay open and silent.
    Freeze,
    /// A server tag is wedged: `MSG_CONNECT` and `MSG_DISCO` answer HOST-144, and its connection stays open and silent,
    /// until the power is switched off and on.
    WedgeTag {
        /// `S1` to `S8`.
        tag: String,
    },
    /// The power is switched off, and on again after a time. Without the battery, variables in CMOS and registers
    /// are lost.
    PowerLoss {
        /// Whether the battery keeps the memory.
        memory: Memory,
        /// For how long the power is off, in milliseconds of controller time.
        #[serde(default)]
        off_ms: u64,
    },
    /// The servos have no power: the arm brakes, and no motion starts.
    ServoOff,
    /// A tool frame is wrong, as after somebody taught it anew: `$UTOOL` and `$MNUTOOL[1,n]`.
    WrongToolFrame {
        /// The number of the tool; the selected one if none is given.
        #[serde(default)]
        tool: Option<i32>,
        /// What it is instead.
        frame: PoseMmDeg,
    },
    /// The controller was delivered without an option. It is switched off and on for that, and again when the fault
    /// is cleared.
    OptionMissing {
        /// Which one.
        option: ControllerOption,
    },
    /// Somebody turned the general override down, and holds it there.
    SlowOverride {
        /// The highest override that is reached, 1 to 100.
        percent: i32,
    },
}

fn one() -> u64 {
    1
}

fn one_byte() -> usize {
    1
}

/// What is left of the memory that the battery keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Memory {
    /// All of it.
    Kept,
    /// Nothing.
    Lost,
}

/// Options that programs need, as they are ordered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, ToSchema)]
pub enum ControllerOption {
    /// KAREL: without it no KAREL program runs.
    R632,
    /// User Socket Messaging: without it `MSG_CONNECT` and `MSG_DISCO` end the task with INTP-320.
    R648,
}

impl std::fmt::Display for ControllerOption {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::R632 => "R632 (KAREL)",
            Self::R648 => "R648 (User Socket Messaging)",
        })
    }
}

/// Which bytes a wire fault hits. What is not given matches everything.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Scope {
    /// The port, as the program names it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub port: Option<u16>,
    /// The server tag, `S1` to `S8`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tag: Option<String>,
    /// The connection; they count from 1 in the order in which clients came.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub connection: Option<u64>,
    /// To the program, from it, or both.
    #[serde(default)]
    pub direction: Direction,
}

/// The way that bytes go.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// From the client to the program.
    In,
    /// From the program to the client.
    Out,
    /// Both ways.
    #[default]
    Both,
}

/// A fault to inject.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FaultBody {
    /// What breaks.
    pub fault: FaultKind,
    /// Which bytes, for a wire fault.
    #[serde(default)]
    pub scope: Scope,
    /// How often it strikes, for a wire fault: the next so many pieces of bytes. Without end if missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 1_000_000)]
    pub times: Option<u32>,
    /// How long it lasts, in milliseconds of controller time. Until it is cleared if missing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 86_400_000)]
    pub for_ms: Option<u64>,
}

impl FaultBody {
    /// A fault of this kind everywhere, until it is cleared.
    #[must_use]
    pub fn new(fault: FaultKind) -> Self {
        Self {
            fault,
            scope: Scope::default(),
            times: None,
            for_ms: None,
        }
    }

    /// Only so many times.
    #[must_use]
    pub fn times(mut self, times: u32) -> Self {
        self.times = Some(times);
        self
    }

    /// Only for so long.
    #[must_use]
    pub fn for_ms(mut self, ms: u64) -> Self {
        self.for_ms = Some(ms);
        self
    }

    /// Only in this scope.
    #[must_use]
    pub fn within(mut self, scope: Scope) -> Self {
        self.scope = scope;
        self
    }
}

impl FaultKind {
    /// Its name, as in JSON and on the command line.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Drop => "drop",
            Self::Delay { .. } => "delay",
            Self::Split { .. } => "split",
            Self::Truncate { .. } => "truncate",
            Self::Corrupt { .. } => "corrupt",
            Self::Stall => "stall",
            Self::HalfOpen => "half_open",
            Self::Reset => "reset",
            Self::Freeze => "freeze",
            Self::WedgeTag { .. } => "wedge_tag",
            Self::PowerLoss { .. } => "power_loss",
            Self::ServoOff => "servo_off",
            Self::WrongToolFrame { .. } => "wrong_tool_frame",
            Self::OptionMissing { .. } => "option_missing",
            Self::SlowOverride { .. } => "slow_override",
        }
    }

    /// Whether it is in the wire and not in the controller.
    pub(crate) fn is_wire(&self) -> bool {
        matches!(
            self,
            Self::Drop
                | Self::Delay { .. }
                | Self::Split { .. }
                | Self::Truncate { .. }
                | Self::Corrupt { .. }
                | Self::Stall
                | Self::HalfOpen
                | Self::Reset
        )
    }

    /// Whether it has an end of its own.
    fn is_momentary(&self) -> bool {
        matches!(self, Self::Reset | Self::PowerLoss { .. })
    }
}

/// A fault that is active.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FaultView {
    /// Counts from 1.
    pub id: u64,
    /// What breaks.
    pub fault: FaultKind,
    /// Which bytes, for a wire fault.
    pub scope: Scope,
    /// How often it still strikes.
    pub times_left: Option<u32>,
    /// When it ends, in controller time.
    pub until_s: Option<f64>,
    /// How often it has struck: pieces of bytes, or connections.
    pub struck: u64,
}

#[cfg(test)]
mod tests;
