//! Which request a caller means: the key it gives, and whether the first request with it is still under way.

use std::collections::HashSet;
use std::sync::{Arc, Mutex, PoisonError};

use api::{ProblemCode, Violation};
use axum::http::{HeaderMap, HeaderName};
use journal::{Claim, Digest, IdempotencyKey};

use crate::problem::Problem;
use crate::state::shown;

pub(crate) const HEADER: HeaderName = HeaderName::from_static("idempotency-key");
/// The longest key of a caller.
const MAX_KEY: usize = 128;

/// The key of one request: the caller's own word for it.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) struct RequestKey(String);

impl RequestKey {
    /// The key in the headers: 1 to 128 visible ASCII characters, bare or between quotes.
    ///
    /// # Errors
    /// `idempotency-missing` if there is none, `validation` if it is none or there are two.
    pub(crate) fn of(headers: &HeaderMap) -> Result<Self, Problem> {
        let mut values = headers.get_all(HEADER).iter();
        let Some(value) = values.next() else {
            return Err(Problem::not_sent(
                ProblemCode::IdempotencyMissing,
                "the header `Idempotency-Key` is missing",
            )
            .hint(
                "Give each motion a key of its own, for example a UUID, and the same key again only to ask for the \
                 same motion again.",
            ));
        };
        let text = value.to_str().unwrap_or("\u{fffd}");
        let bare = text
            .strip_prefix('"')
            .and_then(|rest| rest.strip_suffix('"'))
            .unwrap_or(text);
        let legal =
            (1..=MAX_KEY).contains(&bare.len()) && bare.bytes().all(|byte| byte.is_ascii_graphic());
        if legal && values.next().is_none() {
            Ok(Self(bare.to_owned()))
        } else {
            let message = format!(
                "`{}` is not one key of 1 to {MAX_KEY} visible ASCII characters",
                shown(text)
            );
            let detail = format!("Idempotency-Key: {message}");
            Err(
                Problem::not_sent(ProblemCode::Validation, detail).violations(vec![Violation {
                    item: "Idempotency-Key".to_owned(),
                    message,
                    ..Violation::default()
                }]),
            )
        }
    }

    /// What the journal keeps: the key among those of its principal, and a digest of the request.
    pub(crate) fn claim(&self, principal: &str, path: &str, body: &[u8]) -> Result<Claim, Problem> {
        // A name may have any characters; its digest has few.
        let scope: String = Digest::of(principal.as_bytes()).to_string();
        let scope = scope.get(..16).unwrap_or(&scope);
        let key = IdempotencyKey::try_new(format!("{scope}:{}", self.0))
            .map_err(|error| Problem::not_sent(ProblemCode::Internal, error.to_string()))?;
        let request = [path.as_bytes(), b"\0", body].concat();
        Ok(Claim {
            key,
            body: Digest::of(&request),
        })
    }

    /// The key, for what derives a name from it.
    pub(crate) fn as_str(&self) -> &str {
        &self.0
    }
}

/// The keys whose first request is being answered.
#[derive(Clone, Debug, Default)]
pub(crate) struct InFlight(Arc<Mutex<HashSet<IdempotencyKey>>>);

/// A key that is being answered, until the last one drops this.
#[derive(Clone, Debug)]
pub(crate) struct KeyGuard {
    _entry: Arc<Flying>,
}

#[derive(Debug)]
struct Flying {
    set: InFlight,
    key: IdempotencyKey,
}

impl InFlight {
    /// Takes a key, unless a request with it is being answered.
    pub(crate) fn enter(&self, key: &IdempotencyKey) -> Result<KeyGuard, Problem> {
        let new = self
            .0
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .insert(key.clone());
        if !new {
            return Err(Problem::not_sent(
                ProblemCode::IdempotencyInFlight,
                "the first request with this key is still being answered",
            )
            .retry_after_a_second());
        }
        Ok(KeyGuard {
            _entry: Arc::new(Flying {
                set: self.clone(),
                key: key.clone(),
            }),
        })
    }
}

impl Drop for Flying {
    fn drop(&mut self) {
        let mut keys = self.set.0.lock().unwrap_or_else(PoisonError::into_inner);
        let _was = keys.remove(&self.key);
    }
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;

    use super::*;

    fn key(values: &[&'static [u8]]) -> Result<RequestKey, ProblemCode> {
        let mut headers = HeaderMap::new();
        for value in values {
            let _more = headers.append(HEADER, HeaderValue::from_bytes(value).unwrap());
        }
        RequestKey::of(&headers).map_err(|problem| problem.code())
    }

    /// H8
    #[test]
    fn a_key_is_one_word_bare_or_quoted() {
        assert_eq!(key(&[]), Err(ProblemCode::IdempotencyMissing));
        assert_eq!(key(&[b"a-1"]).unwrap().as_str(), "a-1");
        assert_eq!(key(&[b"\"a-1\""]), key(&[b"a-1"]));
        let long = [b'x'; 129];
        let long: &'static [u8] = Box::leak(long.into());
        for wrong in [
            &[b"".as_slice()][..],
            &[b"a b"],
            &[b"\"\""],
            &[b"\xff"],
            &[long],
            &[b"a", b"b"],
        ] {
            assert_eq!(key(wrong), Err(ProblemCode::Validation), "{wrong:?}");
        }
    }

    /// X13: one principal's key is not another's.
    #[test]
    fn keys_of_two_principals_never_meet() {
        let key = key(&[b"k"]).unwrap();
        let anna = key.claim("anna", "/p", b"{}").unwrap();
        assert_ne!(anna.key, key.claim("otto", "/p", b"{}").unwrap().key);
        assert_eq!(anna, key.claim("anna", "/p", b"{}").unwrap());
        assert_ne!(anna.body, key.claim("anna", "/q", b"{}").unwrap().body);
    }

    /// H7
    #[test]
    fn a_key_is_taken_until_its_request_is_answered() {
        let keys = InFlight::default();
        let claim = key(&[b"k"]).unwrap().claim("a", "/", b"").unwrap();
        let first = keys.enter(&claim.key).unwrap();
        let with_the_task = first.clone();
        drop(first);
        assert!(keys.enter(&claim.key).is_err());
        drop(with_the_task);
        assert!(keys.enter(&claim.key).is_ok());
    }
}
