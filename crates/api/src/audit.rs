//! Who did what, as the journal has it.

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// A page of who did what, the newest first.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct AuditList {
    /// The entries. A page may have fewer than were asked for, and more follow all the same.
    pub entries: Vec<AuditEntry>,
    /// Where the next page begins, where there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_cursor: Option<String>,
}

/// Somebody did, or tried to do, something.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct AuditEntry {
    /// The place of its record in the journal, `<epoch>-<position>`: `cellctl journal export` has it there, in the
    /// chain of hashes.
    #[schema(example = "3-1207")]
    pub id: String,
    /// When, by the wall clock, in UTC.
    pub at: Timestamp,
    /// When, by the monotonic clock: milliseconds since the start of the server in that epoch.
    pub since_start_ms: u64,
    /// Who; `nobody` where a token was not valid, `server` for the server itself.
    pub principal: String,
    /// In which role; absent in demo mode and where nobody is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// What, e.g. `control.acquire`. The list grows.
    pub action: String,
    /// To what.
    pub object: String,
    /// What became of it.
    pub result: AuditResult,
    /// The cell; absent where it is about the whole server.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<String>,
    /// The epoch of the lease of control.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lease: Option<u64>,
    /// The address it came from, where that was kept.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// The request behind it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub request_id: Option<String>,
    /// What it was before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub before: Option<String>,
    /// What it is now, or the reason given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after: Option<String>,
}

/// What became of it.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum AuditResult {
    /// It was done.
    Done,
    /// It was not allowed.
    Denied,
    /// It did not work.
    Failed,
}
