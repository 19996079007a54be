//! A journal as lines of JSON: one record a line, its bytes as they were hashed.
//!
//! Where old records were removed, the first line says behind what the others begin, and the last ones are the
//! snapshots, without which the rest is not understood:
//! ```text
//! {"base":{"position":1000,"hash":"..","epoch":3,"keys":{..}}}
//! {"previous":"..","hash":"..","body":{..}}
//! {"snapshot":{"cell":"c1","position":2040,"body":".."}}
//! ```

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use thiserror::Error;

use crate::index::Base;
use crate::{Broken, DecodeError, Digest, Position, Row, Stored};

/// A line is no record.
#[derive(Debug, Error)]
pub enum LineError {
    /// It is not an exported line.
    #[error("line {line} is not a line of an exported journal")]
    Json {
        /// Its number, from 1.
        line: u64,
        /// Why.
        #[source]
        source: serde_json::Error,
    },
    /// Its record cannot be read.
    #[error("reading the record in line {line}")]
    Record {
        /// Its number, from 1.
        line: u64,
        /// Why.
        #[source]
        source: DecodeError,
    },
    /// The chain does not hold there.
    #[error("the chain does not hold in line {line}")]
    Broken {
        /// Its number, from 1.
        line: u64,
        /// How.
        #[source]
        source: Broken,
    },
}

#[derive(Serialize)]
struct LineOut<'a> {
    previous: Digest,
    hash: Digest,
    body: &'a RawValue,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LineIn<'a> {
    previous: Digest,
    hash: Digest,
    // Borrowed: the bytes of the line are the bytes that were hashed.
    #[serde(borrow)]
    body: &'a RawValue,
}

/// A line of another kind.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Beside {
    /// What the records begin behind.
    Base(Base),
    /// The text of a snapshot.
    Snapshot {
        /// The cell.
        cell: String,
        /// The record that tells of it.
        position: Position,
        /// The text.
        body: String,
    },
}

/// Any line of an export.
pub(crate) enum Line {
    Row(Row),
    Beside(Beside),
}

/// Any line of an export. `number` counts from 1 and is for the error.
pub(crate) fn read_any(line: &[u8], number: u64) -> Result<Line, LineError> {
    if line.starts_with(b"{\"base\"") || line.starts_with(b"{\"snapshot\"") {
        return serde_json::from_slice(line)
            .map(Line::Beside)
            .map_err(|source| LineError::Json {
                line: number,
                source,
            });
    }
    read_line(line, number).map(Line::Row)
}

/// A row as a line, without its end.
///
/// # Errors
/// [`DecodeError`] if the row's bytes are not JSON: they were not written by this program.
pub fn write_line(row: &Row) -> Result<String, DecodeError> {
    let body: &RawValue = serde_json::from_slice(&row.body).map_err(DecodeError::Json)?;
    let line = LineOut {
        previous: row.previous,
        hash: row.hash,
        body,
    };
    serde_json::to_string(&line).map_err(DecodeError::Json)
}

/// The row in a line. `number` counts from 1 and is for the error.
///
/// # Errors
/// [`LineError`] if it is no line of an exported journal. Whether the chain holds is not checked here.
pub fn read_line(line: &[u8], number: u64) -> Result<Row, LineError> {
    let LineIn {
        previous,
        hash,
        body,
    } = serde_json::from_slice(line).map_err(|source| LineError::Json {
        line: number,
        source,
    })?;
    let body = body.get().as_bytes().to_vec();
    let stored = Stored::decode(&body).map_err(|source| LineError::Record {
        line: number,
        source,
    })?;
    Ok(Row {
        position: stored.position,
        previous,
        body,
        hash,
    })
}
