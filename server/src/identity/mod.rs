//! Who may call: bearer tokens, their roles, and the one table of what each role may.
//!
//! ```text
//! edge ── admit ── table: method + route -> least role (a route without an entry is closed)
//!            ├──── tokens: `cell_<id>_<secret>` -> principal; BLAKE3 of the secret, compared in constant time
//!            └──── scope: the cell, the mobile robot
//! ```
//!
//! The file holds no secrets and is its owner's alone. The first start makes one admin token and shows it once; an
//! admin moves nothing, so its first act is to make an operator's token. In demo mode nobody is asked.

mod access;
mod audit;
mod principal;
mod refusals;
mod rules;
mod store;
mod table;
mod throttle;
mod token;
mod tokens;

use std::fmt;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError};

use api::{NewToken, ProblemCode, RotateBody, TokenBody, TokenInfo};
use axum::http::{HeaderMap, Method, header};
use jiff::Timestamp;
use tokio::sync::watch;
use tokio::time::Instant;

pub(crate) use access::Access;
pub(crate) use audit::entry;
pub use audit::{AuditSink, NotRecorded, Recorded, TracingAudit};
pub(crate) use principal::Principal;
pub(crate) use refusals::Refusals;
pub use store::StoreError;
pub(crate) use table::{Rule, access as least_role, methods};
pub use token::RandomError;
pub(crate) use token::TokenId;

use crate::clock::WallClock;
use crate::problem::{Problem, outcome_of_nothing_sent};
use crate::state::shown;
use table::Place;
use tokens::Tokens;

/// Knows who callers are. Cheap to clone.
#[derive(Clone)]
pub struct Identity(Arc<Kind>);

enum Kind {
    Demo,
    Tokens(Tokens),
}

/// A request, as far as the question goes who may send it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Asked<'a> {
    pub(crate) method: &'a Method,
    /// The template of the route, where one matched.
    pub(crate) route: Option<&'a str>,
    pub(crate) path: &'a str,
    pub(crate) headers: &'a HeaderMap,
    pub(crate) peer: Option<IpAddr>,
    pub(crate) request_id: &'a str,
}

/// A request that may not go on.
#[derive(Debug)]
pub(crate) struct NotAdmitted {
    pub(crate) problem: Problem,
    /// Who tried, where the record of who did what is to know of it: a token that is not valid, or one that may not do
    /// this. A browser's first request without any token is neither, and what comes too fast is in the log alone.
    pub(crate) worth_noting: Option<Principal>,
}

impl From<Problem> for NotAdmitted {
    fn from(problem: Problem) -> Self {
        Self {
            problem,
            worth_noting: None,
        }
    }
}

impl Identity {
    /// Everybody may do everything. Only for a server that nobody else's machine reaches.
    #[must_use]
    pub fn demo() -> Self {
        Self(Arc::new(Kind::Demo))
    }

    /// Opens the file of tokens, or begins it. Where no admin token is valid, as at the first start, one is made and
    /// handed out: this once.
    ///
    /// # Errors
    /// The file cannot be read or written, others may read it, or it is no such file.
    pub fn open(path: PathBuf, now: Timestamp) -> Result<(Self, Option<NewToken>), StoreError> {
        let (tokens, first) = Tokens::open(path, now, false)?;
        Ok((Self(Arc::new(Kind::Tokens(tokens))), first))
    }

    /// As [`Identity::open`], and makes a new admin token in any case: for whoever has the machine but no token.
    ///
    /// # Errors
    /// As [`Identity::open`].
    pub fn open_with_new_admin(
        path: PathBuf,
        now: Timestamp,
    ) -> Result<(Self, Option<NewToken>), StoreError> {
        let (tokens, first) = Tokens::open(path, now, true)?;
        Ok((Self(Arc::new(Kind::Tokens(tokens))), first))
    }

    /// Reads the file of tokens and changes nothing. That there is none yet is no error.
    ///
    /// # Errors
    /// The file cannot be read, others may read it, or it is no such file.
    pub fn check(path: &Path) -> Result<(), StoreError> {
        store::load(path).map(drop)
    }

    /// Whether everybody may do everything.
    #[must_use]
    pub fn is_demo(&self) -> bool {
        matches!(*self.0, Kind::Demo)
    }

    /// Decides whether a request may go on, and as whom.
    ///
    /// # Errors
    /// 401 without a valid token, 403 where role or scope do not allow it, 404 where the scope does not see the cell,
    /// 429 after too many tokens that were not valid.
    pub(crate) fn admit(
        &self,
        asked: &Asked<'_>,
        clock: &dyn WallClock,
    ) -> Result<Principal, NotAdmitted> {
        // Where no route matched, or no method of it, the router has an answer that says nothing of the cell.
        let Some(route) = asked.route else {
            return Ok(Principal::nobody());
        };
        let (access, place) = match table::rule(asked.method, route) {
            Rule::Needs { access, place } => (access, place),
            Rule::NoSuchMethod => return Ok(Principal::nobody()),
            Rule::Missing => {
                let detail = "the route has no entry in the table of who may call it";
                return Err(refused(asked, ProblemCode::Forbidden, detail).into());
            }
        };
        if access == Access::Open {
            return Ok(Principal::nobody());
        }
        let principal = self.authenticate(asked, access, clock)?;
        match allow(asked, &principal, access, place) {
            Ok(()) => Ok(principal),
            Err(problem) => Err(NotAdmitted {
                problem,
                worth_noting: Some(principal),
            }),
        }
    }

    fn authenticate(
        &self,
        asked: &Asked<'_>,
        access: Access,
        clock: &dyn WallClock,
    ) -> Result<Principal, NotAdmitted> {
        let tokens = match &*self.0 {
            Kind::Demo => return Ok(Principal::demo()),
            Kind::Tokens(tokens) => tokens,
        };
        let text = bearer(asked.headers).map_err(|missing| {
            refused(asked, ProblemCode::Unauthorized, missing)
                .hint("Send `Authorization: Bearer cell_…`; `cellctl login` keeps a token for you")
        })?;
        let invalid = match tokens.principal(text, clock.now()) {
            Ok(principal) => return Ok(principal),
            Err(invalid) => invalid,
        };
        let counted = {
            let mut throttle = tokens
                .throttle
                .lock()
                .unwrap_or_else(PoisonError::into_inner);
            throttle.failed(Instant::now(), asked.peer)
        };
        // Whoever tries to stop a robot is told what is wrong, and never to wait.
        if let Err(wait) = counted
            && access != Access::Anyone
        {
            let detail =
                "too many tokens from this address were not valid; a valid one is not kept waiting";
            let problem = refused(asked, ProblemCode::RateLimited, detail).retry_after(wait);
            return Err(problem.into());
        }
        if counted.is_ok() {
            tracing::warn!(
                request_id = asked.request_id,
                address = asked.peer.map(tracing::field::display),
                reason = %invalid,
                "a token was refused"
            );
        }
        Err(NotAdmitted {
            problem: refused(asked, ProblemCode::Unauthorized, &invalid.to_string()),
            worth_noting: counted.is_ok().then(Principal::nobody),
        })
    }

    fn tokens(&self) -> Result<&Tokens, Problem> {
        match &*self.0 {
            Kind::Demo => {
                let detail =
                    "in demo mode there are no tokens: everybody on this machine may do everything";
                Err(Problem::not_sent(ProblemCode::DemoMode, detail)
                    .hint("Start robocell with an [identity] section and without --demo"))
            }
            Kind::Tokens(tokens) => Ok(tokens),
        }
    }

    pub(crate) fn list(&self, now: Timestamp) -> Result<Vec<TokenInfo>, Problem> {
        Ok(self.tokens()?.list(now))
    }

    pub(crate) async fn create(
        &self,
        body: TokenBody,
        by: &Principal,
        now: Timestamp,
    ) -> Result<NewToken, Problem> {
        self.tokens()?.create(body, by, now).await
    }

    pub(crate) async fn revoke(&self, id: &TokenId, now: Timestamp) -> Result<TokenInfo, Problem> {
        self.tokens()?.revoke(id, now).await
    }

    pub(crate) async fn rotate(
        &self,
        id: &TokenId,
        body: RotateBody,
        by: &Principal,
        now: Timestamp,
    ) -> Result<NewToken, Problem> {
        self.tokens()?.rotate(id, body.overlap_s, by, now).await
    }

    /// Whether somebody of this name can act at all.
    pub(crate) fn knows(&self, name: &str, now: Timestamp) -> bool {
        match &*self.0 {
            Kind::Demo => name == "demo",
            Kind::Tokens(tokens) => tokens.has_name(name, now),
        }
    }

    /// Whether a principal may still act: for what lasts longer than a request, such as a stream of events.
    #[cfg_attr(not(test), expect(dead_code, reason = "for the streams of events"))]
    pub(crate) fn is_valid(&self, principal: &Principal, now: Timestamp) -> bool {
        match (&*self.0, principal.token()) {
            (Kind::Demo, _) => principal.is_demo(),
            (Kind::Tokens(tokens), Some(id)) => tokens.is_valid(id, now),
            (Kind::Tokens(_), None) => false,
        }
    }

    /// Tells of every change of the tokens; `None` in demo mode, where nothing changes.
    pub(crate) fn changes(&self) -> Option<watch::Receiver<u64>> {
        match &*self.0 {
            Kind::Demo => None,
            Kind::Tokens(tokens) => Some(tokens.changes()),
        }
    }
}

/// Says which kind it is and nothing of what it knows.
impl fmt::Debug for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match &*self.0 {
            Kind::Demo => "Identity(demo)",
            Kind::Tokens(_) => "Identity(tokens)",
        })
    }
}

/// The token of a request: one `Authorization` header with one bearer token.
fn bearer(headers: &HeaderMap) -> Result<&str, &'static str> {
    let mut values = headers.get_all(header::AUTHORIZATION).iter();
    let value = match (values.next(), values.next()) {
        (Some(value), None) => value.to_str().unwrap_or_default(),
        (None, _) => return Err("the request has no bearer token"),
        (Some(_), Some(_)) => return Err("the request has more than one Authorization header"),
    };
    match value.split_once(' ') {
        Some((scheme, token)) if scheme.eq_ignore_ascii_case("bearer") => Ok(token.trim()),
        Some(_) | None => Err("the Authorization header holds no bearer token"),
    }
}

/// Compares a principal with what the route asks.
fn allow(
    asked: &Asked<'_>,
    principal: &Principal,
    access: Access,
    place: Place,
) -> Result<(), Problem> {
    let role = api::Role::ALL
        .into_iter()
        .find(|role| principal.has(*role) && access.allows(*role));
    let forbidden = |detail: String| {
        tracing::info!(
            request_id = asked.request_id,
            principal = principal.name(),
            method = %asked.method,
            route = asked.route,
            "the request was refused: its role or scope does not allow it"
        );
        refused(asked, ProblemCode::Forbidden, &detail)
    };
    if role.is_none() {
        return Err(forbidden(format!(
            "`{}` may not do this; it needs: {access}",
            principal.name()
        )));
    }
    let segment = |index: Option<usize>| index.and_then(|index| asked.path.split('/').nth(index));
    // The names are compared as they stand in the path: an encoded one is refused, never mistaken for another.
    if let Some(cell) = segment(place.cell)
        && !principal.sees_cell(cell)
    {
        // The same answer as for a cell there is not.
        let detail = format!("there is no cell `{}`", shown(cell));
        return Err(refused(asked, ProblemCode::NotFound, &detail));
    }
    if role == Some(api::Role::MobileRobot)
        && let Some(robot) = segment(place.mobile_robot)
        && principal.scope().mobile_robot.as_deref() != Some(robot)
    {
        return Err(forbidden(format!(
            "`{}` is another mobile robot",
            principal.name()
        )));
    }
    Ok(())
}

fn refused(asked: &Asked<'_>, code: ProblemCode, detail: &str) -> Problem {
    Problem::new(code, detail).outcome(outcome_of_nothing_sent(asked.method))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn what_lasts_longer_than_a_request_ends_with_its_token() {
        let folder = tempfile::tempdir().unwrap();
        let now = Timestamp::now();
        let (identity, admin) = Identity::open(folder.path().join("t"), now).unwrap();
        let admin = admin.unwrap();
        let body = TokenBody {
            name: "alice".to_owned(),
            role: api::Role::Viewer,
            scope: api::TokenScope::default(),
            expires_in_days: Some(1),
        };
        let tokens = identity.tokens().unwrap();
        let by = tokens.principal(admin.token.reveal(), now).unwrap();
        let alice = identity.create(body, &by, now).await.unwrap();
        let principal = tokens.principal(alice.token.reveal(), now).unwrap();
        let mut changes = identity.changes().unwrap();
        assert!(identity.is_valid(&principal, now) && identity.knows("alice", now));
        assert!(!identity.is_valid(&principal, alice.info.expires_at));
        assert!(!identity.is_valid(&Principal::demo(), now));
        let id = TokenId::parse(&alice.info.id).unwrap();
        let _revoked = identity.revoke(&id, now).await.unwrap();
        assert!(changes.has_changed().unwrap());
        changes.mark_unchanged();
        assert!(!identity.is_valid(&principal, now) && !identity.knows("alice", now));
        assert!(Identity::demo().is_valid(&Principal::demo(), now));
    }

    /// T1, T2.
    #[test]
    fn t1_a_clock_that_was_set_back_revives_no_token() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t");
        let year = jiff::SignedDuration::from_hours(366 * 24);
        let now = Timestamp::now();
        let (_, old) = Identity::open(path.clone(), now - year).unwrap();
        let (identity, _) = Identity::open(path, now).unwrap();
        let old = old.unwrap();
        let tokens = identity.tokens().unwrap();
        assert!(tokens.principal(old.token.reveal(), now - year).is_err());
        assert!(
            tokens
                .principal(old.token.reveal(), Timestamp::UNIX_EPOCH)
                .is_err()
        );
    }
}
