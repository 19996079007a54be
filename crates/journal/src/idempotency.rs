//! Keys under which a caller may ask for the same thing twice and get it once.

use std::sync::Arc;
use std::time::Duration;

use serde::{Deserialize, Serialize, Serializer};
use thiserror::Error;

use crate::Digest;

/// The caller's name for one request: 1 to 255 visible ASCII characters.
///
/// Whoever sees several callers puts the caller's name before the key, so that no one answers for another. Cheap to
/// clone: a journal has each in several orders.
#[derive(Clone, Debug, Eq, Hash, Ord, PartialEq, PartialOrd, Deserialize)]
#[serde(try_from = "String")]
pub struct IdempotencyKey(Arc<str>);

/// The text is not a key.
#[derive(Clone, Debug, Eq, Error, PartialEq)]
pub enum KeyError {
    /// Empty, or too long.
    #[error(
        "an idempotency key has 1 to {} characters, this one has {length}",
        IdempotencyKey::MAX
    )]
    Length {
        /// Its length in bytes.
        length: usize,
    },
    /// A character that does not belong into a key.
    #[error("an idempotency key has visible ASCII characters only, this one has {found:?}")]
    Character {
        /// The first such character.
        found: char,
    },
}

/// A key together with the body it was first used with.
#[derive(Clone, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// The caller's key.
    pub key: IdempotencyKey,
    /// The digest of the request's body (and of whatever else makes two requests different).
    pub body: Digest,
}

/// How long a key is remembered. Written into the journal at each opening, so that a reader forgets the same keys.
///
/// A key whose motion has neither an answer nor an outcome is never forgotten.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize, Deserialize)]
pub struct KeyRetention {
    /// By the callers' wall clocks, in seconds.
    pub max_age_s: u32,
    /// The newest so many.
    pub max_count: u32,
}

impl IdempotencyKey {
    /// Characters of the longest key.
    pub const MAX: usize = 255;

    /// A key of `text`.
    ///
    /// # Errors
    /// [`KeyError`] if it is empty, too long, or not visible ASCII.
    pub fn try_new(text: impl Into<Arc<str>>) -> Result<Self, KeyError> {
        let text = text.into();
        if text.is_empty() || text.len() > Self::MAX {
            return Err(KeyError::Length { length: text.len() });
        }
        match text.chars().find(|char| !char.is_ascii_graphic()) {
            Some(found) => Err(KeyError::Character { found }),
            None => Ok(Self(text)),
        }
    }

    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl TryFrom<String> for IdempotencyKey {
    type Error = KeyError;

    fn try_from(text: String) -> Result<Self, KeyError> {
        Self::try_new(text)
    }
}

impl Serialize for IdempotencyKey {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0)
    }
}

impl KeyRetention {
    /// The maximum age.
    #[must_use]
    pub fn max_age(self) -> Duration {
        Duration::from_secs(self.max_age_s.into())
    }

    /// Whether a key first used at `used_ms` is too old at `now_ms`, both in Unix milliseconds.
    pub(crate) fn is_expired(self, used_ms: i64, now_ms: i64) -> bool {
        used_ms <= self.expired_until(now_ms)
    }

    /// The youngest use that is too old at `now_ms`.
    pub(crate) fn expired_until(self, now_ms: i64) -> i64 {
        now_ms.saturating_sub(i64::from(self.max_age_s) * 1_000)
    }
}

impl Default for KeyRetention {
    /// Seven days, 20,000 keys.
    fn default() -> Self {
        Self {
            max_age_s: 7 * 24 * 60 * 60,
            max_count: 20_000,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_is_short_visible_ascii() {
        assert!(IdempotencyKey::try_new("a").is_ok());
        assert!(IdempotencyKey::try_new("x".repeat(255)).is_ok());
        assert_eq!(
            IdempotencyKey::try_new(""),
            Err(KeyError::Length { length: 0 })
        );
        assert_eq!(
            IdempotencyKey::try_new("x".repeat(256)),
            Err(KeyError::Length { length: 256 })
        );
        assert_eq!(
            IdempotencyKey::try_new("a b"),
            Err(KeyError::Character { found: ' ' })
        );
    }
}
