//! Refused requests in the record of who did what: each that a person would want to see, and no flood.

use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use api::ProblemCode;
use journal::{Audit, AuditResult};
use tokio::time::Instant;

use super::{Asked, AuditSink, Principal};
use crate::state::shown;

/// Entries within [`WINDOW`], of each kind of caller.
const MOST: u32 = 30;
const WINDOW: Duration = Duration::from_mins(1);

/// Counts refused requests. Those of callers nobody knows have their own measure, so that none of them can hide what
/// somebody with a token tries.
#[derive(Debug, Default)]
pub(crate) struct Refusals {
    unknown: Mutex<Window>,
    known: Mutex<Window>,
}

#[derive(Debug, Default)]
struct Window {
    began: Option<Instant>,
    noted: u32,
    /// Refused and not noted, until an entry tells of them.
    left_out: u64,
}

impl Window {
    /// How many were left out before this one; `None` to leave this one out, too.
    fn admit(&mut self, now: Instant) -> Option<u64> {
        let over = self
            .began
            .is_none_or(|began| now.duration_since(began) >= WINDOW);
        if over {
            self.began = Some(now);
            self.noted = 0;
        }
        if self.noted == MOST {
            self.left_out += 1;
            return None;
        }
        self.noted += 1;
        Some(std::mem::take(&mut self.left_out))
    }
}

impl Refusals {
    /// Notes a refused request.
    pub(crate) fn note(
        &self,
        audit: &dyn AuditSink,
        who: &Principal,
        asked: &Asked<'_>,
        code: ProblemCode,
    ) {
        let window = if who.token().is_some() {
            &self.known
        } else {
            &self.unknown
        };
        let admitted = {
            let mut window = window.lock().unwrap_or_else(PoisonError::into_inner);
            window.admit(Instant::now())
        };
        let Some(left_out) = admitted else { return };
        let code = code.as_str();
        audit.note(Audit {
            principal: who.name().to_owned(),
            action: "access.refused".to_owned(),
            object: format!("{} {}", asked.method, shown(asked.path)),
            result: AuditResult::Denied,
            request_id: Some(asked.request_id.to_owned()),
            cell: None,
            role: who.role().map(|role| role.as_str().to_owned()),
            source: asked.peer.map(|peer| peer.to_string()),
            lease: None,
            before: None,
            after: Some(if left_out == 0 {
                code.to_owned()
            } else {
                format!("{code}; {left_out} more were refused before it and have no entry")
            }),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn a_flood_has_a_few_entries_and_a_count() {
        let mut window = Window::default();
        for _ in 0..MOST {
            assert_eq!(window.admit(Instant::now()), Some(0));
        }
        for _ in 0..70 {
            assert_eq!(window.admit(Instant::now()), None);
        }
        tokio::time::advance(WINDOW).await;
        assert_eq!(window.admit(Instant::now()), Some(70));
        assert_eq!(window.admit(Instant::now()), Some(0));
    }
}
