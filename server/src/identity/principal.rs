//! Who is behind a request.

use std::sync::Arc;

use api::{Me, ProblemCode, Role, TokenScope};
use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use jiff::Timestamp;

use super::token::TokenId;
use crate::problem::Problem;
use crate::state::App;

/// Who is behind a request. Cheap to clone.
#[derive(Clone, Debug, Eq, PartialEq)]
pub(crate) struct Principal(Arc<Inner>);

#[derive(Debug, Eq, PartialEq)]
struct Inner {
    name: String,
    credential: Credential,
    scope: TokenScope,
}

/// Why the principal is believed.
#[derive(Debug, Eq, PartialEq)]
enum Credential {
    /// It is not: the route is open to everybody.
    Nobody,
    /// The server runs in demo mode.
    Demo,
    Token {
        id: TokenId,
        role: Role,
        expires_at: Timestamp,
    },
}

impl Principal {
    /// Whoever calls an open route.
    pub(crate) fn nobody() -> Self {
        Self::new("nobody", Credential::Nobody, TokenScope::default())
    }

    /// Everybody, in demo mode.
    pub(crate) fn demo() -> Self {
        Self::new("demo", Credential::Demo, TokenScope::default())
    }

    pub(crate) fn of_token(
        name: &str,
        id: TokenId,
        role: Role,
        scope: TokenScope,
        expires_at: Timestamp,
    ) -> Self {
        let credential = Credential::Token {
            id,
            role,
            expires_at,
        };
        Self::new(name, credential, scope)
    }

    fn new(name: &str, credential: Credential, scope: TokenScope) -> Self {
        Self(Arc::new(Inner {
            name: name.to_owned(),
            credential,
            scope,
        }))
    }

    /// The name, as in logs and records: of letters, digits and ` ._@-` only.
    pub(crate) fn name(&self) -> &str {
        &self.0.name
    }

    pub(crate) fn scope(&self) -> &TokenScope {
        &self.0.scope
    }

    pub(crate) fn token(&self) -> Option<&TokenId> {
        match &self.0.credential {
            Credential::Nobody | Credential::Demo => None,
            Credential::Token { id, .. } => Some(id),
        }
    }

    /// Its role; in demo mode, where everybody has every role, none.
    pub(crate) fn role(&self) -> Option<Role> {
        match &self.0.credential {
            Credential::Nobody | Credential::Demo => None,
            Credential::Token { role, .. } => Some(*role),
        }
    }

    pub(crate) fn is_demo(&self) -> bool {
        self.0.credential == Credential::Demo
    }

    /// Whether it has this role; in demo mode everybody has every role.
    pub(crate) fn has(&self, wanted: Role) -> bool {
        match &self.0.credential {
            Credential::Nobody => false,
            Credential::Demo => true,
            Credential::Token { role, .. } => *role == wanted,
        }
    }

    /// Whether it may move robots, as far as its role goes.
    pub(crate) fn may_move(&self) -> bool {
        self.has(Role::Operator) || self.has(Role::Integrator)
    }

    /// Whether it may take control as `LOCAL`.
    pub(crate) fn may_be_local(&self) -> bool {
        self.is_demo() || (self.0.scope.local_station && self.may_move())
    }

    /// Whether this cell exists for it.
    pub(crate) fn sees_cell(&self, cell: &str) -> bool {
        let only = self.0.scope.cell.as_deref();
        only.is_none_or(|only| only == cell)
    }

    pub(crate) fn me(&self) -> Me {
        let (roles, token, expires_at) = match &self.0.credential {
            Credential::Nobody => (Vec::new(), None, None),
            Credential::Demo => (Role::ALL.to_vec(), None, None),
            Credential::Token {
                id,
                role,
                expires_at,
            } => (vec![*role], Some(id.to_string()), Some(*expires_at)),
        };
        Me {
            name: self.0.name.clone(),
            roles,
            scope: self.0.scope.clone(),
            demo: self.is_demo(),
            token,
            expires_at,
        }
    }
}

/// The principal, as the edge found it.
impl FromRequestParts<Arc<App>> for Principal {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &Arc<App>) -> Result<Self, Problem> {
        parts
            .extensions
            .get::<Self>()
            .cloned()
            .ok_or_else(|| Problem::new(ProblemCode::Internal, "the request passed no edge layer"))
    }
}
