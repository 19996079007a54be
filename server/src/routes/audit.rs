//! Who did what: read from the journal.

use std::sync::Arc;

use api::{AuditEntry, AuditList, AuditResult, ProblemCode};
use axum::Json;
use axum::extract::State;
use journal::{Audit, Position, Record, Stored};

use super::page::Page;
use super::params::{CellId, CellPath};
use super::responses::{AnyProblem, NotFound};
use crate::identity::Principal;
use crate::problem::Problem;
use crate::state::App;

/// Records of other cells that are passed over for one page.
const PASSED_OVER: usize = 1_000;

/// Tells who did what, the newest first: control taken, given back and lost, stops, tokens, refused requests.
///
/// It is what concerns the cell; and what concerns the whole server, tokens for example, for whoever's token is not
/// for one cell only. Each entry is a record of the journal, in its chain of hashes; `cellctl journal verify` and
/// `export` prove it from the file.
#[utoipa::path(
    get, path = "/api/v1/cells/{cell}/audit", tag = "identity",
    params(
        CellPath,
        ("limit" = Option<usize>, Query, minimum = 1, maximum = 200, description = "How many at most; 100 where absent."),
        ("cursor" = Option<String>, Query, description = "The `next_cursor` of the page before."),
    ),
    responses(
        (status = 200, description = "A page of entries.", body = AuditList),
        (status = 422, description = "`validation`: the query does not fit.", body = api::Problem, content_type = "application/problem+json"),
        (status = 503, description = "`journal-unavailable`: the journal cannot be read.", body = api::Problem, content_type = "application/problem+json"),
        NotFound, AnyProblem,
    ),
)]
pub(super) async fn list_audit(
    State(app): State<Arc<App>>,
    CellId(cell): CellId,
    principal: Principal,
    page: Page<Position>,
) -> Result<Json<AuditList>, Problem> {
    let cell = app.cell(&cell)?;
    let whole_server = principal.scope().cell.is_none();
    let mut before = page
        .cursor
        .unwrap_or_else(|| app.journal.head().position.next());
    let mut entries = Vec::new();
    let mut looked_at = 0;
    while entries.len() < page.limit && looked_at < PASSED_OVER {
        let found = app.journal.audits(before, page.limit).await;
        let found = found.map_err(|error| {
            Problem::new(ProblemCode::JournalUnavailable, error.to_string()).retry_after_a_second()
        })?;
        let Some(last) = found.last() else {
            return Ok(Json(AuditList {
                entries,
                next_cursor: None,
            }));
        };
        before = last.position;
        looked_at += found.len();
        for stored in &found {
            let Record::Audit(audit) = &stored.record else {
                continue;
            };
            let concerns = audit
                .cell
                .as_ref()
                .map_or(whole_server, |of| *of == cell.id);
            if concerns && entries.len() == page.limit {
                break;
            }
            before = stored.position;
            if concerns {
                entries.push(entry(stored, audit));
            }
        }
    }
    Ok(Json(AuditList {
        entries,
        next_cursor: Some(before.0.to_string()),
    }))
}

fn entry(stored: &Stored, audit: &Audit) -> AuditEntry {
    let audit = audit.clone();
    AuditEntry {
        id: format!("{}-{}", stored.epoch, stored.position),
        at: stored.at.wall,
        since_start_ms: u64::try_from(stored.at.monotonic.as_millis()).unwrap_or(u64::MAX),
        principal: audit.principal,
        role: audit.role,
        action: audit.action,
        object: audit.object,
        result: match audit.result {
            journal::AuditResult::Done => AuditResult::Done,
            journal::AuditResult::Denied => AuditResult::Denied,
            journal::AuditResult::Failed => AuditResult::Failed,
        },
        cell: audit.cell,
        lease: audit.lease,
        source: audit.source,
        request_id: audit.request_id,
        before: audit.before,
        after: audit.after,
    }
}
