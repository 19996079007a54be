//! How long a caller wants to wait for a motion's end: `Prefer: wait=20` (RFC 7240).

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::FromRequestParts;
use axum::http::request::Parts;

use crate::state::App;

/// The longest wait of one request, in seconds. A longer one is applied as this.
pub(super) const MAX_WAIT_S: u64 = 60;

/// What the `Prefer` headers of a request ask for.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub(super) struct Prefer {
    /// In seconds; zero for an answer at once.
    pub(super) wait_s: Option<u64>,
}

impl Prefer {
    pub(super) fn wait(self) -> Option<Duration> {
        self.wait_s.map(Duration::from_secs)
    }

    /// What `Preference-Applied` says.
    pub(super) fn applied(self) -> Option<String> {
        self.wait_s.map(|seconds| format!("wait={seconds}"))
    }

    /// A preference that is not understood is passed over: the header is no demand.
    fn of<'a>(values: impl Iterator<Item = &'a str>) -> Self {
        let mut prefer = Self::default();
        for preference in values.flat_map(|value| value.split(',')) {
            let token = preference.split(';').next().unwrap_or_default().trim();
            let (name, value) = token.split_once('=').unwrap_or((token, ""));
            let name = name.trim();
            if prefer.wait_s.is_some() {
                // The first one counts.
            } else if name.eq_ignore_ascii_case("wait") {
                let seconds: Option<u64> = value.trim().trim_matches('"').parse().ok();
                prefer.wait_s = seconds.map(|seconds| seconds.min(MAX_WAIT_S));
            } else if name.eq_ignore_ascii_case("respond-async") {
                prefer.wait_s = Some(0);
            }
        }
        prefer
    }
}

impl FromRequestParts<Arc<App>> for Prefer {
    type Rejection = Infallible;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Infallible> {
        let values = parts.headers.get_all("prefer").iter();
        Ok(Self::of(values.filter_map(|value| value.to_str().ok())))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wait_is_bounded_and_what_is_not_understood_is_passed_over() {
        let of = |values: &[&str]| Prefer::of(values.iter().copied()).wait_s;
        assert_eq!(of(&[]), None);
        assert_eq!(of(&["wait=20"]), Some(20));
        assert_eq!(of(&["respond-async, wait=20"]), Some(0));
        assert_eq!(of(&["handling=lenient", "Wait = \"7\"; x=y"]), Some(7));
        assert_eq!(of(&["wait=100000"]), Some(MAX_WAIT_S));
        assert_eq!(of(&["wait=-1", "wait=abc", "wait"]), None);
    }
}
