//! The hook for the record of who did what.

use std::fmt;
use std::pin::Pin;

use journal::{Audit, AuditResult};

use super::Principal;
use crate::problem::Problem;

/// What becomes of an entry.
pub type Recorded<'a> = Pin<Box<dyn Future<Output = Result<(), NotRecorded>> + Send + 'a>>;

/// Keeps the record of who did what.
pub trait AuditSink: fmt::Debug + Send + Sync + 'static {
    /// Makes an entry durable before what it tells of is done. What cannot be recorded so is not done.
    fn record(&self, entry: Audit) -> Recorded<'_>;

    /// Takes an entry about what was done, or refused, already. It never waits; the entry becomes durable in its turn.
    fn note(&self, entry: Audit);
}

/// The entry could not be made durable.
#[derive(Clone, Debug, Eq, PartialEq, thiserror::Error)]
#[error("recording it: {reason}")]
pub struct NotRecorded {
    /// Why not.
    pub reason: String,
}

/// Writes the entries to the log: durable as far as the log is.
#[derive(Clone, Copy, Debug, Default)]
pub struct TracingAudit;

impl AuditSink for TracingAudit {
    fn record(&self, entry: Audit) -> Recorded<'_> {
        self.note(entry);
        Box::pin(std::future::ready(Ok(())))
    }

    fn note(&self, entry: Audit) {
        let Audit {
            principal,
            action,
            object,
            result,
            request_id,
            cell,
            role,
            source,
            lease,
            before,
            after,
        } = entry;
        tracing::info!(
            target: "server::audit",
            principal,
            action,
            object,
            ?result,
            request_id,
            cell,
            role,
            source,
            lease,
            before,
            after,
            "audit"
        );
    }
}

/// An entry about something that is being done.
pub(crate) fn entry(
    principal: &Principal,
    action: &str,
    object: impl Into<String>,
    request_id: &str,
) -> Audit {
    Audit {
        principal: principal.name().to_owned(),
        action: action.to_owned(),
        object: object.into(),
        result: AuditResult::Done,
        request_id: Some(request_id.to_owned()),
        cell: None,
        role: principal.role().map(|role| role.as_str().to_owned()),
        source: None,
        lease: None,
        before: None,
        after: None,
    }
}

impl From<NotRecorded> for Problem {
    fn from(error: NotRecorded) -> Self {
        tracing::error!(%error, "the audit could not be written; nothing was done");
        let detail = "the record of who did what cannot be written, so nothing was done";
        Self::not_sent(api::ProblemCode::NotRecorded, detail).retry_after_a_second()
    }
}
