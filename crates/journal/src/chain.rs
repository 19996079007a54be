//! The chain of hashes: each record is hashed together with the hash of the record before it.
//!
//! ```text
//! hash(n) = BLAKE3-derive-key("robocell journal v1", hash(n - 1) ‖ n as 8 bytes, little endian ‖ body(n))
//! hash(0) = 32 zero bytes
//! ```
//! Whoever changes a record must change every later one, and the head that someone else has kept. The chain shows
//! changes and losses; it does not show who wrote it. A signature over a head does, and is not made here.

use std::sync::LazyLock;

use blake3::hazmat::{ContextKey, HasherExt as _, hash_derive_key_context};
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::{DecodeError, Digest, Position, Stored};

const CONTEXT: &str = "robocell journal v1";
/// What the context comes to; the same for every record.
static CONTEXT_KEY: LazyLock<ContextKey> = LazyLock::new(|| hash_derive_key_context(CONTEXT));

/// The last record of a journal, or of a part of it.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Head {
    /// Its place; zero before the first record.
    pub position: Position,
    /// Its hash.
    pub hash: Digest,
}

/// A record as it is kept: bytes and hashes.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct Row {
    /// Where it was found.
    pub position: Position,
    /// The hash of the record before it, as this record claims.
    pub previous: Digest,
    /// Its canonical bytes.
    pub body: Vec<u8>,
    /// Its hash, as it claims.
    pub hash: Digest,
}

/// The first place where a chain does not hold.
#[derive(Debug, Error)]
pub enum Broken {
    /// Records are missing.
    #[error("record {expected} is missing: record {found} follows record {}", expected.0.saturating_sub(1))]
    Missing {
        /// The first one missing.
        expected: Position,
        /// The one that stands there.
        found: Position,
    },
    /// A record stands there twice, or an older one comes after it.
    #[error("record {found} stands where record {expected} should: doubled or out of order")]
    Doubled {
        /// The one that should stand there.
        expected: Position,
        /// The one that stands there.
        found: Position,
    },
    /// The record does not belong behind the one before it.
    #[error("record {position} names another hash for the record before it")]
    WrongPrevious {
        /// The record.
        position: Position,
    },
    /// The record's bytes are not those that were hashed.
    #[error("record {position} is not what was written: its hash differs")]
    WrongHash {
        /// The record.
        position: Position,
    },
    /// The bytes are what was hashed, and cannot be read.
    #[error("reading record {position}")]
    Unreadable {
        /// The record.
        position: Position,
        /// Why.
        #[source]
        source: DecodeError,
    },
    /// The record says that it belongs elsewhere.
    #[error("record {position} says that it is record {says}")]
    Misplaced {
        /// Where it stands.
        position: Position,
        /// What it says.
        says: Position,
    },
    /// The end is missing.
    #[error("the journal ends at record {found}; record {expected} is known to have been written")]
    Truncated {
        /// The last record that is known.
        expected: Position,
        /// The last record that is there.
        found: Position,
    },
    /// There is more than the journal's own head says.
    #[error("record {found} stands behind the last one, which is {head}")]
    BehindHead {
        /// The last record, as the head says.
        head: Position,
        /// One behind it.
        found: Position,
    },
    /// The known record was replaced by another one.
    #[error("record {position} is not the one that is known to have been written")]
    Replaced {
        /// The record.
        position: Position,
    },
}

impl Broken {
    /// The first record that does not hold: missing, not what was written, or not where it belongs.
    #[must_use]
    pub fn position(&self) -> Position {
        match self {
            Self::Missing { expected, .. } => *expected,
            Self::Truncated { found, .. } => found.next(),
            Self::Doubled { found, .. } | Self::BehindHead { found, .. } => *found,
            Self::WrongPrevious { position }
            | Self::WrongHash { position }
            | Self::Unreadable { position, .. }
            | Self::Misplaced { position, .. }
            | Self::Replaced { position } => *position,
        }
    }
}

impl Head {
    /// The head of an empty journal.
    pub const EMPTY: Self = Self {
        position: Position::START,
        hash: Digest::ZERO,
    };

    /// The head after a record with this `body`.
    #[must_use]
    pub fn extend(&self, body: &[u8]) -> Self {
        let position = self.position.next();
        Self {
            position,
            hash: hash(&self.hash, position, body),
        }
    }
}

/// Walks along a chain, record by record.
#[derive(Clone, Debug)]
pub struct Walker {
    head: Head,
    known: Option<Head>,
}

impl Walker {
    /// Begins behind `after`: [`Head::EMPTY`] for a whole journal.
    #[must_use]
    pub fn new(after: Head) -> Self {
        Self {
            head: after,
            known: None,
        }
    }

    /// Also looks for a record that is known from elsewhere, for example from yesterday's backup.
    #[must_use]
    pub fn expecting(self, known: Head) -> Self {
        Self {
            known: Some(known),
            ..self
        }
    }

    /// The last record that holds.
    #[must_use]
    pub fn head(&self) -> Head {
        self.head
    }

    /// Checks the next record and returns what it says.
    ///
    /// # Errors
    /// [`Broken`] if the chain does not hold here. The walker stays where it was.
    pub fn step(&mut self, row: &Row) -> Result<Stored, Broken> {
        let expected = self.head.position.next();
        let found = row.position;
        if found < expected {
            return Err(Broken::Doubled { expected, found });
        }
        if found > expected {
            return Err(Broken::Missing { expected, found });
        }
        if row.previous != self.head.hash {
            return Err(Broken::WrongPrevious { position: found });
        }
        let next = self.head.extend(&row.body);
        if next.hash != row.hash {
            return Err(Broken::WrongHash { position: found });
        }
        let stored = Stored::decode(&row.body).map_err(|source| Broken::Unreadable {
            position: found,
            source,
        })?;
        if stored.position != found {
            return Err(Broken::Misplaced {
                position: found,
                says: stored.position,
            });
        }
        if self
            .known
            .is_some_and(|known| known.position == found && known.hash != row.hash)
        {
            return Err(Broken::Replaced { position: found });
        }
        self.head = next;
        Ok(stored)
    }

    /// Ends the walk.
    ///
    /// # Errors
    /// [`Broken::Truncated`] if the known record was not reached.
    pub fn finish(self) -> Result<Head, Broken> {
        match self.known {
            Some(known) if known.position > self.head.position => Err(Broken::Truncated {
                expected: known.position,
                found: self.head.position,
            }),
            Some(_) | None => Ok(self.head),
        }
    }
}

fn hash(previous: &Digest, position: Position, body: &[u8]) -> Digest {
    let mut hasher = blake3::Hasher::new_from_context_key(&CONTEXT_KEY);
    let _ = hasher
        .update(previous.as_bytes())
        .update(&position.0.to_le_bytes())
        .update(body);
    hasher.finalize().into()
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use jiff::Timestamp;

    use super::*;
    use crate::{Audit, AuditResult, Clocks, Epoch, Record};

    fn rows(count: u64) -> Vec<Row> {
        let mut head = Head::EMPTY;
        (1..=count)
            .map(|n| {
                let stored = Stored {
                    position: Position(n),
                    epoch: Epoch(1),
                    at: Clocks {
                        wall: Timestamp::UNIX_EPOCH,
                        monotonic: Duration::from_millis(n),
                    },
                    record: Record::Audit(Audit {
                        principal: "anna".into(),
                        action: "limits.update".into(),
                        object: format!("robot {n}"),
                        result: AuditResult::Done,
                        request_id: None,
                        cell: None,
                        role: None,
                        source: None,
                        lease: None,
                        before: None,
                        after: None,
                    }),
                };
                let body = stored.encode().unwrap().into_bytes();
                let previous = head.hash;
                head = head.extend(&body);
                Row {
                    position: head.position,
                    previous,
                    body,
                    hash: head.hash,
                }
            })
            .collect()
    }

    fn walk(rows: &[Row], known: Option<Head>) -> Result<Head, Broken> {
        let mut walker = Walker::new(Head::EMPTY);
        if let Some(known) = known {
            walker = walker.expecting(known);
        }
        for row in rows {
            let _stored = walker.step(row)?;
        }
        walker.finish()
    }

    #[test]
    fn a_missing_a_doubled_and_a_moved_record_are_named() {
        let good = rows(5);
        let mut missing = good.clone();
        drop(missing.remove(2));
        let broken = walk(&missing, None).unwrap_err();
        assert_eq!(
            broken.to_string(),
            "record 3 is missing: record 4 follows record 2"
        );
        let mut doubled = good.clone();
        doubled.insert(2, good[1].clone());
        assert!(matches!(
            walk(&doubled, None).unwrap_err(),
            Broken::Doubled {
                expected: Position(3),
                found: Position(2)
            }
        ));
        let mut renumbered = missing;
        for (row, n) in renumbered.iter_mut().zip(1..) {
            row.position = Position(n);
        }
        assert!(matches!(
            walk(&renumbered, None).unwrap_err(),
            Broken::WrongPrevious {
                position: Position(3)
            }
        ));
    }

    #[test]
    fn a_record_that_was_hashed_again_does_not_fit_the_next_one() {
        let mut rows = rows(5);
        let before = Head {
            position: Position(2),
            hash: rows[1].hash,
        };
        let text = String::from_utf8(rows[2].body.clone()).unwrap();
        rows[2].body = text.replace("anna", "otto").into_bytes();
        rows[2].hash = before.extend(&rows[2].body).hash;
        assert!(walk(&rows[..3], None).is_ok());
        assert!(matches!(
            walk(&rows, None).unwrap_err(),
            Broken::WrongPrevious {
                position: Position(4)
            }
        ));
    }

    #[test]
    fn a_known_head_shows_a_cut_or_replaced_end() {
        let good = rows(5);
        let known = walk(&good, None).unwrap();
        assert!(walk(&good, Some(known)).is_ok());
        assert!(matches!(
            walk(&good[..4], Some(known)).unwrap_err(),
            Broken::Truncated {
                expected: Position(5),
                found: Position(4)
            }
        ));
        let other = Head {
            hash: Digest::ZERO,
            ..known
        };
        assert!(matches!(
            walk(&good, Some(other)).unwrap_err(),
            Broken::Replaced {
                position: Position(5)
            }
        ));
    }

    #[test]
    fn the_hash_is_the_one_of_the_first_version() {
        // Do not change: every journal in the field depends on it.
        assert_eq!(
            Head::EMPTY.extend(b"{}").hash.to_string(),
            "5b4e3e97da5a1db38227a9c4846bd149172f0db590cbe3153cdccb6c3b7342cc"
        );
    }
}
