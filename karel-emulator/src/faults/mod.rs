//! Faults that a test or a person injects: into the wire between clients and the program, and into the controller.
//!
//! A fault has a kind, a scope, and an end: a number of times, a duration in controller time, or whenever it is
//! cleared. Everything random in it comes from the seed of the configuration, so a run with faults can be repeated.

mod dice;
mod error;
mod wire;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::effects::Tag;
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

    /// Whether the fault can be injected at all.
    pub(crate) fn check(&self) -> Result<(), FaultError> {
        let within = |item: &'static str, value: u64, min: u64, max: u64| {
            if (min..=max).contains(&value) {
                Ok(())
            } else {
                Err(FaultError::Range {
                    item,
                    value: value.to_string(),
                    min,
                    max,
                })
            }
        };
        if let Some(times) = self.times {
            within("times", times.into(), 1, MAX_TIMES.into())?;
        }
        if let Some(ms) = self.for_ms {
            within("for_ms", ms, 1, MAX_MS)?;
        }
        check_tag("scope.tag", self.scope.tag.as_deref())?;
        let wire = self.fault.is_wire();
        if !wire && (self.times.is_some() || self.scope != Scope::default()) {
            return Err(FaultError::NotForDevices {
                fault: self.fault.name(),
            });
        }
        if self.fault.is_momentary() && (self.times.is_some() || self.for_ms.is_some()) {
            return Err(FaultError::NoEnd {
                fault: self.fault.name(),
            });
        }
        if self.fault == FaultKind::Stall && self.times.is_some() {
            return Err(FaultError::NoTimes);
        }
        let bytes = |value: usize| u64::try_from(value).unwrap_or(u64::MAX);
        match &self.fault {
            FaultKind::Delay { ms, jitter_ms } => {
                within("delay.ms", *ms, 0, MAX_MS)?;
                within("delay.jitter_ms", *jitter_ms, 0, MAX_MS)
            }
            FaultKind::Split { bytes: n, gap_ms } => {
                within("split.bytes", bytes(*n), 1, bytes(MAX_BYTES))?;
                within("split.gap_ms", *gap_ms, 0, MAX_MS)
            }
            FaultKind::Truncate { keep } => {
                within("truncate.keep", bytes(*keep), 0, bytes(MAX_BYTES))
            }
            FaultKind::Corrupt { bytes: n } => {
                within("corrupt.bytes", bytes(*n), 1, bytes(MAX_BYTES))
            }
            FaultKind::WedgeTag { tag } => check_tag("wedge_tag.tag", Some(tag)),
            FaultKind::PowerLoss { off_ms, .. } => within("power_loss.off_ms", *off_ms, 0, MAX_MS),
            FaultKind::SlowOverride { percent } => {
                if (1..=100).contains(percent) {
                    return Ok(());
                }
                Err(FaultError::Range {
                    item: "slow_override.percent",
                    value: percent.to_string(),
                    min: 1,
                    max: 100,
                })
            }
            FaultKind::Drop
            | FaultKind::Stall
            | FaultKind::HalfOpen
            | FaultKind::Reset
            | FaultKind::Freeze
            | FaultKind::ServoOff
            | FaultKind::WrongToolFrame { .. }
            | FaultKind::OptionMissing { .. } => Ok(()),
        }
    }
}

fn check_tag(item: &'static str, tag: Option<&str>) -> Result<(), FaultError> {
    match tag {
        Some(name) if Tag::parse(name).is_none() => Err(FaultError::Tag {
            item,
            value: name.chars().take(32).collect(),
        }),
        Some(_) | None => Ok(()),
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
mod tests {
    use super::dice::Dice;
    use super::*;

    #[test]
    fn a_fault_reads_as_the_documents_write_it() {
        let body: FaultBody = serde_json::from_str(
            r#"{"fault": {"delay": {"ms": 200}}, "scope": {"port": 59002, "direction": "in"}, "times": 3}"#,
        )
        .unwrap();
        assert_eq!(
            body.fault,
            FaultKind::Delay {
                ms: 200,
                jitter_ms: 0
            }
        );
        assert_eq!(body.scope.direction, Direction::In);
        assert_eq!(body.check(), Ok(()));
        let body: FaultBody = serde_json::from_str(r#"{"fault": "freeze"}"#).unwrap();
        assert_eq!(body.fault.name(), "freeze");
        for wrong in [
            r#"{"fault": "explode"}"#,
            r#"{"fault": {"delay": {"ms": 1, "s": 2}}}"#,
            r#"{"fault": "drop", "scope": {"prt": 1}}"#,
            r#"{"fault": "drop", "count": 1}"#,
        ] {
            assert!(serde_json::from_str::<FaultBody>(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn what_cannot_be_is_refused_with_item_value_and_limit() {
        let bodies = [
            (
                FaultBody::new(FaultKind::Drop).times(0),
                "times is 0, it must be 1 to 1000000",
            ),
            (FaultBody::new(FaultKind::Stall).for_ms(0), "for_ms is 0"),
            (
                FaultBody::new(FaultKind::Split {
                    bytes: 0,
                    gap_ms: 1,
                }),
                "split.bytes is 0, it must be 1 to 65536",
            ),
            (
                FaultBody::new(FaultKind::SlowOverride { percent: -3 }),
                "slow_override.percent is -3, it must be 1 to 100",
            ),
            (
                FaultBody::new(FaultKind::WedgeTag { tag: "S9".into() }),
                "S9",
            ),
            (
                FaultBody::new(FaultKind::Freeze).times(2),
                "neither scope nor times",
            ),
            (FaultBody::new(FaultKind::Reset).for_ms(5), "ends by itself"),
        ];
        for (body, words) in bodies {
            let text = body.check().unwrap_err().to_string();
            assert!(text.contains(words), "{text}");
        }
    }

    #[test]
    fn the_same_seed_gives_the_same_numbers_within_the_limit() {
        let draw = |seed| {
            let mut dice = Dice::new(seed);
            (0..50).map(|_| dice.up_to(9)).collect::<Vec<_>>()
        };
        assert_eq!(draw(7), draw(7));
        assert_ne!(draw(7), draw(8));
        assert!(draw(7).iter().all(|n| *n <= 9));
    }
}
