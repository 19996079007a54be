use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use axum::http::{HeaderMap, HeaderName};
use jiff::Timestamp;
use uuid::{NoContext, Uuid};

pub(crate) const HEADER: HeaderName = HeaderName::from_static("x-request-id");

/// The longest request id taken from a caller.
const MAX_LEN: usize = 64;

/// The id that ties a request to its log lines, problem, motion and connection to the controller.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) struct RequestId(Arc<str>);

impl RequestId {
    /// The caller's own id where it is 1 to 64 of `[A-Za-z0-9._-]`, else a new one. Nothing else gets into the logs.
    pub(crate) fn of(headers: &HeaderMap, now: impl FnOnce() -> Timestamp) -> Self {
        let given = headers
            .get(HEADER)
            .and_then(|value| value.to_str().ok())
            .filter(|text| is_legal(text));
        match given {
            Some(text) => Self(text.into()),
            None => Self::new(now()),
        }
    }

    /// An id that was kept.
    pub(crate) fn recorded(text: &str) -> Self {
        Self(text.into())
    }

    fn new(now: Timestamp) -> Self {
        let seconds = u64::try_from(now.as_second()).unwrap_or(0);
        let nanos = u32::try_from(now.subsec_nanosecond()).unwrap_or(0);
        let id = Uuid::new_v7(uuid::Timestamp::from_unix(NoContext, seconds, nanos));
        let mut buffer = Uuid::encode_buffer();
        Self(Arc::from(&*id.hyphenated().encode_lower(&mut buffer)))
    }
}

fn is_legal(text: &str) -> bool {
    let legal = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_' | b'-');
    (1..=MAX_LEN).contains(&text.len()) && text.bytes().all(legal)
}

impl Deref for RequestId {
    type Target = str;

    fn deref(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for RequestId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderValue;

    use super::*;

    fn id_for(given: &'static [u8]) -> RequestId {
        let mut headers = HeaderMap::new();
        let _old = headers.insert(HEADER, HeaderValue::from_bytes(given).unwrap());
        RequestId::of(&headers, || Timestamp::UNIX_EPOCH)
    }

    #[test]
    fn a_callers_id_is_kept() {
        assert_eq!(&*id_for(b"Line-4.job_17"), "Line-4.job_17");
    }

    /// Covers: X10.
    #[test]
    fn an_id_that_could_forge_a_log_line_is_replaced() {
        let long = [b'a'; 65];
        for given in [b"".as_slice(), b"a b", b"a\tb", b"\xff", b"id;x=1", &long] {
            let given: &'static [u8] = Box::leak(given.into());
            let id = id_for(given);
            assert!(Uuid::parse_str(&id).is_ok(), "{id}");
        }
    }
}
