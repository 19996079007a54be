//! The tokens of a server: looking one up, and changing what there is.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError, RwLock};
use std::time::Duration;

use api::{NewToken, ProblemCode, Role, TokenBody, TokenInfo, TokenScope, TokenState};
use jiff::{SignedDuration, Timestamp};
use tokio::sync::watch;

use super::Principal;
use super::rules::{MAX_DAYS, MAX_OVERLAP_S, check, days, out_of_range};
use super::store::{self, Kept, StoreError};
use super::throttle::Throttle;
use super::token::{self, SecretHash, TokenId};
use crate::problem::Problem;

/// The most tokens kept, those that ended lately included.
pub(crate) const MAX_TOKENS: usize = 1_000;
/// For how long a token that ended is still listed.
const REMEMBERED: SignedDuration = SignedDuration::from_hours(30 * 24);
/// The tokens of a server.
pub(super) struct Tokens {
    path: PathBuf,
    table: RwLock<Arc<Table>>,
    /// Held while a change is being written, so that two changes do not overwrite one another.
    changing: tokio::sync::Mutex<()>,
    /// Counts changes.
    changed: watch::Sender<u64>,
    pub(super) throttle: Mutex<Throttle>,
}

struct Table {
    kept: Vec<Kept>,
    by_id: HashMap<TokenId, Entry>,
    /// The latest time written into the file: it cannot be earlier now, whatever the clock says.
    floor: Timestamp,
}

struct Entry {
    hash: SecretHash,
    principal: Principal,
    expires_at: Timestamp,
    revoked: bool,
}

/// Why a token opens nothing.
#[derive(Clone, Copy, Debug, Eq, PartialEq, thiserror::Error)]
pub(super) enum Invalid {
    #[error("the token is not one of this server's")]
    Unknown,
    #[error("the token expired at {0}")]
    Expired(Timestamp),
    #[error("the token was revoked")]
    Revoked,
}

impl Tokens {
    /// Reads the file, or begins it. Where no admin token is valid one is made.
    pub(super) fn open(
        path: PathBuf,
        now: Timestamp,
        replace_admin: bool,
    ) -> Result<(Self, Option<NewToken>), StoreError> {
        let mut kept = store::load(&path)?.unwrap_or_default();
        let now = now.max(floor(&kept));
        let mut first = None;
        if replace_admin || !kept.iter().any(|token| is_admin(token, now)) {
            let name = free_name("admin", &kept, now);
            let body = TokenBody {
                name,
                role: Role::Admin,
                scope: TokenScope::default(),
                expires_in_days: Some(MAX_DAYS),
            };
            let (new, made) = make(&body, "server", days(MAX_DAYS), now)?;
            kept.insert(0, new);
            store::save(&path, &kept)?;
            first = Some(made);
        }
        let tokens = Self {
            path,
            table: RwLock::new(Arc::new(Table::new(kept))),
            changing: tokio::sync::Mutex::default(),
            changed: watch::channel(0).0,
            throttle: Mutex::default(),
        };
        Ok((tokens, first))
    }

    fn table(&self) -> Arc<Table> {
        let table = self.table.read().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(&table)
    }

    /// Who a token's text belongs to.
    pub(super) fn principal(&self, text: &str, now: Timestamp) -> Result<Principal, Invalid> {
        let table = self.table();
        let (id, secret) = token::parse(text).ok_or(Invalid::Unknown)?;
        let entry = table.by_id.get(&id);
        // Compared in either case, so that the time does not tell which ids exist.
        let hash = entry.map_or(SecretHash::NOBODYS, |entry| entry.hash);
        let fits = secret.hash() == hash;
        let Some(entry) = entry.filter(|_| fits) else {
            return Err(Invalid::Unknown);
        };
        if entry.revoked {
            Err(Invalid::Revoked)
        } else if now.max(table.floor) >= entry.expires_at {
            Err(Invalid::Expired(entry.expires_at))
        } else {
            Ok(entry.principal.clone())
        }
    }

    /// Whether a principal's token is still valid.
    pub(super) fn is_valid(&self, id: &TokenId, now: Timestamp) -> bool {
        let table = self.table();
        let entry = table.by_id.get(id);
        entry.is_some_and(|entry| !entry.revoked && now.max(table.floor) < entry.expires_at)
    }

    /// Tells of every change of the tokens.
    pub(super) fn changes(&self) -> watch::Receiver<u64> {
        self.changed.subscribe()
    }

    pub(super) fn list(&self, now: Timestamp) -> Vec<TokenInfo> {
        let table = self.table();
        let now = now.max(table.floor);
        table.kept.iter().map(|token| token.info(now)).collect()
    }

    /// Whether a valid token has this name.
    pub(super) fn has_name(&self, name: &str, now: Timestamp) -> bool {
        is_taken(name, &self.table().kept, now)
    }

    pub(super) async fn create(
        &self,
        body: TokenBody,
        by: &Principal,
        now: Timestamp,
    ) -> Result<NewToken, Problem> {
        let days = check(&body)?;
        self.change(now, |kept, now| {
            if is_taken(&body.name, kept, now) {
                let detail = format!("a valid token is named `{}`", body.name);
                return Err(Problem::not_sent(ProblemCode::NameTaken, detail)
                    .hint("Choose another name, or rotate that token"));
            }
            let (new, made) =
                make(&body, by.name(), days, now).map_err(|error| unusable(&error))?;
            kept.insert(0, new);
            Ok(made)
        })
        .await
    }

    pub(super) async fn revoke(&self, id: &TokenId, now: Timestamp) -> Result<TokenInfo, Problem> {
        self.change(now, |kept, now| {
            let others = kept.iter().filter(|token| token.id != *id);
            let other_admin = others.into_iter().any(|token| is_admin(token, now));
            let token = find(kept, id)?;
            if is_admin(token, now) && !other_admin {
                let detail = format!("without token {id} nobody could manage tokens");
                return Err(Problem::not_sent(ProblemCode::LastAdmin, detail)
                    .hint("Create or rotate an admin token first"));
            }
            let _first = token.revoked_at.get_or_insert(now);
            Ok(token.info(now))
        })
        .await
    }

    pub(super) async fn rotate(
        &self,
        id: &TokenId,
        overlap_s: u32,
        by: &Principal,
        now: Timestamp,
    ) -> Result<NewToken, Problem> {
        if overlap_s > MAX_OVERLAP_S {
            return Err(out_of_range("overlap_s", overlap_s, 0, MAX_OVERLAP_S));
        }
        self.change(now, |kept, now| {
            let old = find(kept, id)?;
            if old.state(now) != TokenState::Active {
                let detail = format!("token {id} is not valid any more");
                return Err(Problem::not_found(detail).hint("Create a new one"));
            }
            let body = TokenBody {
                name: old.name.clone(),
                role: old.role,
                scope: old.scope.clone(),
                expires_in_days: None,
            };
            let lifetime = old.expires_at.duration_since(old.created_at);
            let end = now
                .checked_add(SignedDuration::from_secs(i64::from(overlap_s)))
                .unwrap_or(now);
            old.expires_at = old.expires_at.min(end);
            let (new, made) =
                make(&body, by.name(), lifetime, now).map_err(|error| unusable(&error))?;
            kept.insert(0, new);
            Ok(made)
        })
        .await
    }

    /// Changes a copy, writes it, and only then takes it for the truth.
    async fn change<T>(
        &self,
        now: Timestamp,
        change: impl FnOnce(&mut Vec<Kept>, Timestamp) -> Result<T, Problem>,
    ) -> Result<T, Problem> {
        let _one_at_a_time = self.changing.lock().await;
        let table = self.table();
        let now = now.max(table.floor);
        let mut kept = table.kept.clone();
        kept.retain(|token| {
            let ended = token
                .revoked_at
                .map_or(token.expires_at, |at| at.min(token.expires_at));
            now.duration_since(ended) < REMEMBERED
        });
        let changed = change(&mut kept, now)?;
        if kept.len() > MAX_TOKENS {
            let detail = format!("there are {MAX_TOKENS} tokens, and no more may be kept");
            return Err(Problem::not_sent(ProblemCode::Validation, detail)
                .hint("Tokens are forgotten 30 days after their end"));
        }
        let path = self.path.clone();
        let saved = tokio::task::spawn_blocking(move || store::save(&path, &kept).map(|()| kept));
        let kept = match saved.await {
            Ok(saved) => saved.map_err(|error| unusable(&error))?,
            Err(error) => return Err(Problem::new(ProblemCode::Internal, error.to_string())),
        };
        *self.table.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(Table::new(kept));
        self.changed.send_modify(|changes| *changes += 1);
        Ok(changed)
    }
}

impl Table {
    fn new(kept: Vec<Kept>) -> Self {
        let entry = |token: &Kept| {
            let principal = Principal::of_token(
                &token.name,
                token.id.clone(),
                token.role,
                token.scope.clone(),
                token.expires_at,
            );
            let entry = Entry {
                hash: token.hash,
                principal,
                expires_at: token.expires_at,
                revoked: token.revoked_at.is_some(),
            };
            (token.id.clone(), entry)
        };
        Self {
            by_id: kept.iter().map(entry).collect(),
            floor: floor(&kept),
            kept,
        }
    }
}

fn floor(kept: &[Kept]) -> Timestamp {
    let times = kept.iter().flat_map(|token| {
        let revoked = token.revoked_at.unwrap_or(token.created_at);
        [token.created_at, revoked]
    });
    times.max().unwrap_or(Timestamp::UNIX_EPOCH)
}

fn is_admin(token: &Kept, now: Timestamp) -> bool {
    token.role == Role::Admin && token.state(now) == TokenState::Active
}

fn is_taken(name: &str, kept: &[Kept], now: Timestamp) -> bool {
    kept.iter()
        .any(|token| token.name == name && token.state(now) == TokenState::Active)
}

fn free_name(name: &str, kept: &[Kept], now: Timestamp) -> String {
    let numbered = (2..).map(|number| format!("{name}-{number}"));
    let mut names = std::iter::once(name.to_owned()).chain(numbered);
    names
        .find(|name| !is_taken(name, kept, now))
        .unwrap_or_else(|| name.to_owned())
}

fn find<'a>(kept: &'a mut [Kept], id: &TokenId) -> Result<&'a mut Kept, Problem> {
    kept.iter_mut()
        .find(|token| token.id == *id)
        .ok_or_else(|| Problem::not_found(format!("there is no token {id}")))
}

fn make(
    body: &TokenBody,
    by: &str,
    lifetime: SignedDuration,
    now: Timestamp,
) -> Result<(Kept, NewToken), StoreError> {
    let (id, hash, text) = token::generate()?;
    let kept = Kept {
        id,
        name: body.name.clone(),
        role: body.role,
        scope: body.scope.clone(),
        hash,
        created_at: now,
        created_by: by.to_owned(),
        expires_at: now.checked_add(lifetime).unwrap_or(Timestamp::MAX),
        revoked_at: None,
    };
    let made = NewToken {
        token: text,
        info: kept.info(now),
    };
    Ok((kept, made))
}

/// The cause is the log's: it names files.
fn unusable(error: &StoreError) -> Problem {
    tracing::error!(
        error = error as &(dyn std::error::Error + 'static),
        "the tokens could not be changed"
    );
    let detail = "the file of tokens cannot be written, so nothing was changed";
    Problem::not_sent(ProblemCode::NotRecorded, detail).retry_after(Duration::from_secs(1))
}
