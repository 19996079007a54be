//! A record as bytes, and back.
//!
//! The canonical bytes of a record are compact JSON with its fields in the order of the types. They are made once,
//! when the record is appended; whoever checks the chain hashes the bytes that were kept and never makes them again,
//! so a newer program cannot break an older journal by writing a field differently.

use std::time::Duration;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{Clocks, Epoch, Position, Record};

/// The version of the envelope this program writes.
pub const VERSION: u32 = 1;

/// Bytes of the longest record. A request's body has at most 64 KiB; a record keeps a part of it.
pub const MAX_BODY: usize = 64 * 1024;

/// Bytes that hold nearly every record: memory is asked for once.
const COMMON_BODY: usize = 1024;

/// A record with its place, epoch and time.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct Stored {
    /// Its place.
    pub position: Position,
    /// The epoch it was written in.
    pub epoch: Epoch,
    /// When, as its writer said.
    pub at: Clocks,
    /// What it says.
    pub record: Record,
}

/// The bytes are not a record this program can read.
#[derive(Debug, Error)]
pub enum DecodeError {
    /// Not JSON, or not of these fields.
    #[error("it is not a record of this version")]
    Json(#[source] serde_json::Error),
    /// Of another version.
    #[error("it has version {found}, this program reads version {VERSION}")]
    Version {
        /// Its version.
        found: u32,
    },
}

/// The record is longer than a record may be.
#[derive(Clone, Copy, Debug, Eq, Error, PartialEq)]
#[error("a record has at most {MAX_BODY} bytes, this one has {size}")]
pub struct TooLarge {
    /// Its size in bytes.
    pub size: usize,
}

#[derive(Serialize)]
struct EnvelopeOut<'a> {
    v: u32,
    position: Position,
    epoch: Epoch,
    wall: Timestamp,
    monotonic_ns: u64,
    record: &'a Record,
}

/// As [`Stored::encode`], of a record that is another's.
pub(crate) fn encode(
    position: Position,
    epoch: Epoch,
    at: Clocks,
    record: &Record,
) -> Result<String, TooLarge> {
    let envelope = EnvelopeOut {
        v: VERSION,
        position,
        epoch,
        wall: at.wall,
        monotonic_ns: u64::try_from(at.monotonic.as_nanos()).unwrap_or(u64::MAX),
        record,
    };
    let mut body = Vec::with_capacity(COMMON_BODY);
    serde_json::to_writer(&mut body, &envelope)
        .expect("records have string keys and no floating point");
    if body.len() > MAX_BODY {
        return Err(TooLarge { size: body.len() });
    }
    Ok(String::from_utf8(body).expect("JSON is UTF-8"))
}

#[derive(Deserialize)]
struct EnvelopeIn {
    v: u32,
    position: Position,
    epoch: Epoch,
    wall: Timestamp,
    monotonic_ns: u64,
    record: Record,
}

#[derive(Deserialize)]
struct VersionOnly {
    v: u32,
}

impl Stored {
    /// The canonical bytes.
    ///
    /// # Errors
    /// [`TooLarge`] if there are more than [`MAX_BODY`] of them.
    ///
    /// # Panics
    /// Never: every record is JSON.
    pub fn encode(&self) -> Result<String, TooLarge> {
        encode(self.position, self.epoch, self.at, &self.record)
    }

    /// The record in these bytes.
    ///
    /// # Errors
    /// [`DecodeError`] if they are none, or of another version.
    pub fn decode(body: &[u8]) -> Result<Self, DecodeError> {
        let envelope: EnvelopeIn = match serde_json::from_slice(body) {
            Ok(envelope) => envelope,
            // A newer version may differ in anything but its number.
            Err(error) => {
                return Err(match serde_json::from_slice::<VersionOnly>(body) {
                    Ok(VersionOnly { v }) if v != VERSION => DecodeError::Version { found: v },
                    Ok(_) | Err(_) => DecodeError::Json(error),
                });
            }
        };
        if envelope.v != VERSION {
            return Err(DecodeError::Version { found: envelope.v });
        }
        Ok(Self {
            position: envelope.position,
            epoch: envelope.epoch,
            at: Clocks {
                wall: envelope.wall,
                monotonic: Duration::from_nanos(envelope.monotonic_ns),
            },
            record: envelope.record,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_newer_version_is_named_and_not_guessed() {
        let error = Stored::decode(br#"{"v":2,"anything":[]}"#).unwrap_err();
        assert!(matches!(error, DecodeError::Version { found: 2 }));
        let error = Stored::decode(br#"{"v":1,"anything":[]}"#).unwrap_err();
        assert!(matches!(error, DecodeError::Json(_)));
    }
}
