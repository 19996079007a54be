use std::fmt;

use super::error::DecodeError;
use super::fields::Fields;
use super::line::LineWriter;
use super::values::{MotionNumber, WirePose};

/// How a command finished.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum FinishStatus {
    /// At its target, standing still.
    Arrived,
    /// An alarm or an abort ended it.
    Alarm,
    /// A stop ended it.
    Stopped,
    /// No heartbeat came in time.
    DeadMan,
}

impl FinishStatus {
    /// Every status, in the order of the wire's numbers.
    pub const ALL: [Self; 4] = [Self::Arrived, Self::Alarm, Self::Stopped, Self::DeadMan];

    /// The number on the wire.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::Arrived => 0,
            Self::Alarm => 1,
            Self::Stopped => 2,
            Self::DeadMan => 3,
        }
    }

    pub(super) fn read(fields: &mut Fields<'_>) -> Result<Self, DecodeError> {
        Ok(match fields.in_range("the finish status", 0, 3)? {
            0 => Self::Arrived,
            1 => Self::Alarm,
            2 => Self::Stopped,
            _ => Self::DeadMan,
        })
    }
}

impl fmt::Display for FinishStatus {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Arrived => "arrived",
            Self::Alarm => "ended by an alarm or an abort",
            Self::Stopped => "stopped",
            Self::DeadMan => "stopped by the dead-man: no heartbeat came",
        })
    }
}

/// Why the controller refused a command: nothing was stored, nothing happens.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum ErrorCode {
    /// The line was malformed, or its checksum wrong.
    Malformed,
    /// The nonce was wrong, or too late.
    Nonce,
    /// The target is out of reach or of the limits.
    Unreachable,
    /// The speed.
    Speed,
    /// The dead-man is latched: a new epoch is needed.
    DeadMan,
    /// The pendant is enabled, the mode not AUTO, the arm held, or there is an alarm.
    NotReady,
    /// The number of the output.
    Output,
}

impl ErrorCode {
    /// Every code, in the order of the wire's numbers.
    pub const ALL: [Self; 7] = [
        Self::Malformed,
        Self::Nonce,
        Self::Unreachable,
        Self::Speed,
        Self::DeadMan,
        Self::NotReady,
        Self::Output,
    ];

    /// The number on the wire.
    #[must_use]
    pub fn code(self) -> u8 {
        match self {
            Self::Malformed => 1,
            Self::Nonce => 2,
            Self::Unreachable => 3,
            Self::Speed => 4,
            Self::DeadMan => 5,
            Self::NotReady => 6,
            Self::Output => 7,
        }
    }

    pub(super) fn read(fields: &mut Fields<'_>) -> Result<Self, DecodeError> {
        let code = fields.in_range("the error code", 1, 7)?;
        let known = Self::ALL
            .into_iter()
            .find(|known| i32::from(known.code()) == code);
        Ok(known.unwrap_or(Self::Malformed))
    }
}

impl fmt::Display for ErrorCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Malformed => "the line was malformed or its checksum wrong",
            Self::Nonce => "the nonce was wrong or came too late",
            Self::Unreachable => "the target is out of reach or outside the limits",
            Self::Speed => "the speed is out of range",
            Self::DeadMan => "the dead-man is latched until a new epoch",
            Self::NotReady => {
                "the controller is not ready: pendant enabled, mode not AUTO, held, or an alarm"
            }
            Self::Output => "there is no such output",
        })
    }
}

/// What the controller answers on its command port.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum Reply {
    /// The number is stored; what it stands for begins.
    Ack(MotionNumber),
    /// Standstill, and that is stored.
    Done {
        /// Of which command.
        number: MotionNumber,
        /// How it ended.
        finish: FinishStatus,
        /// Where the tool center point stands.
        pose: WirePose,
    },
    /// The number was accepted before.
    Dup {
        /// Which number.
        number: MotionNumber,
        /// Whether it has finished.
        finished: bool,
    },
    /// The epoch is below the highest seen.
    Stale {
        /// The highest seen.
        epoch_max: u32,
    },
    /// A motion of this number runs.
    Busy(MotionNumber),
    /// Refused.
    Err(ErrorCode),
}

impl Reply {
    /// The line, with its end.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        let start = |kind, number: MotionNumber| {
            let mut line = LineWriter::new(kind);
            number.write(&mut line);
            line
        };
        let mut line;
        match *self {
            Self::Ack(number) => line = start("ACK", number),
            Self::Busy(number) => line = start("BUSY", number),
            Self::Done {
                number,
                finish,
                pose,
            } => {
                line = start("DONE", number);
                let _line = line.integer(finish.code());
                pose.write(&mut line);
            }
            Self::Dup { number, finished } => {
                line = start("DUP", number);
                let _line = line.flag(finished);
            }
            Self::Stale { epoch_max } => {
                line = LineWriter::new("STALE");
                let _line = line.integer(epoch_max);
            }
            Self::Err(code) => {
                line = LineWriter::new("ERR");
                let _line = line.integer(code.code());
            }
        }
        line.finish()
    }

    /// Reads a line without its end.
    ///
    /// # Errors
    /// The line is not a reply in its canonical form.
    pub fn decode(line: &[u8]) -> Result<Self, DecodeError> {
        let (kind, mut fields) = Fields::open(line)?;
        let number =
            |fields: &mut Fields<'_>| MotionNumber::read(fields, "the epoch", "the number");
        let reply = match kind {
            b"ACK" => Self::Ack(number(&mut fields)?),
            b"BUSY" => Self::Busy(number(&mut fields)?),
            b"DONE" => Self::Done {
                number: number(&mut fields)?,
                finish: FinishStatus::read(&mut fields)?,
                pose: WirePose::read(&mut fields)?,
            },
            b"DUP" => Self::Dup {
                number: number(&mut fields)?,
                finished: fields.flag("whether it finished")?,
            },
            b"STALE" => Self::Stale {
                epoch_max: fields.count("the highest epoch")?,
            },
            b"ERR" => Self::Err(ErrorCode::read(&mut fields)?),
            _ => {
                return Err(DecodeError::Kind {
                    expected: "ACK, DONE, DUP, STALE, BUSY, ERR",
                });
            }
        };
        fields.end()?;
        Ok(reply)
    }
}
