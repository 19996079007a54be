//! Who may call: tokens, roles, and who the caller is.

use std::fmt;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// What a principal may do.
///
/// The roles are no ladder: an integrator does not manage tokens, and an admin does not move robots.
#[derive(Clone, Copy, Debug, Deserialize, Eq, Hash, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Role {
    /// Reads everything about cells and robots.
    Viewer,
    /// Moves robots, runs jobs, answers interventions; and what a viewer may.
    Operator,
    /// Sets cells up: limits, frames, stations, programs; and what an operator may.
    Integrator,
    /// Manages tokens, reads the audit, takes control away from somebody; and what a viewer may. Moves nothing.
    Admin,
    /// Is one mobile robot: posts its own signals and reads its own outbox, nothing else.
    MobileRobot,
}

impl Role {
    /// Every role.
    pub const ALL: [Self; 5] = [
        Self::Viewer,
        Self::Operator,
        Self::Integrator,
        Self::Admin,
        Self::MobileRobot,
    ];

    /// The role as it is written.
    #[must_use]
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Viewer => "viewer",
            Self::Operator => "operator",
            Self::Integrator => "integrator",
            Self::Admin => "admin",
            Self::MobileRobot => "mobile_robot",
        }
    }

    /// The role a text names.
    #[must_use]
    pub fn of_str(text: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|role| role.as_str() == text)
    }
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// What a token is limited to, besides its role.
#[derive(Clone, Debug, Default, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
#[schema(example = json!({"cell": "demo"}))]
pub struct TokenScope {
    /// The only cell it sees; every cell where absent. Other cells do not exist for it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cell: Option<String>,
    /// The mobile robot it is; needed for the role `mobile_robot`, and only there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mobile_robot: Option<String>,
    /// Whether its holder stands at the cell's own panel and may take control as `LOCAL`, from anybody.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub local_station: bool,
}

/// A new token.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"name": "alice", "role": "operator", "expires_in_days": 90}))]
pub struct TokenBody {
    /// Who will hold it, for the logs and the audit: 1 to 64 of `[A-Za-z0-9 ._@-]`, a letter or digit first. Not the
    /// name of another token that is valid.
    pub name: String,
    /// What its holder may do.
    pub role: Role,
    /// What it is limited to.
    #[serde(default)]
    pub scope: TokenScope,
    /// For how many days it is valid; 90 where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 365)]
    pub expires_in_days: Option<u32>,
}

/// A new secret for a token.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"overlap_s": 600}))]
pub struct RotateBody {
    /// For how many seconds the old token stays valid beside the new one; 0 where absent.
    #[serde(default)]
    #[schema(minimum = 0, maximum = 86_400)]
    pub overlap_s: u32,
}

/// Whether a token opens anything now.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum TokenState {
    /// It does.
    Active,
    /// Its time is over.
    Expired,
    /// It was revoked.
    Revoked,
}

/// A token, without its secret: the server does not know it.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct TokenInfo {
    /// Its public id.
    pub id: String,
    /// Who holds it.
    pub name: String,
    /// What its holder may do.
    pub role: Role,
    /// What it is limited to.
    pub scope: TokenScope,
    /// Whether it opens anything now.
    pub state: TokenState,
    /// When it was made.
    pub created_at: Timestamp,
    /// Who made it.
    pub created_by: String,
    /// When it ends.
    pub expires_at: Timestamp,
    /// When it was revoked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub revoked_at: Option<Timestamp>,
}

/// Every token, the newest first.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct TokenList {
    /// The tokens; those that ended more than 30 days ago are forgotten.
    pub tokens: Vec<TokenInfo>,
}

/// A token that was just made. This is the only time its secret is shown.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct NewToken {
    /// The token itself: for `Authorization: Bearer …`.
    pub token: TokenSecret,
    /// Everything else about it.
    pub info: TokenInfo,
}

/// A token's text, `cell_<id>_<secret>`. It never shows itself in a log.
#[derive(Clone, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(transparent)]
#[schema(value_type = String)]
pub struct TokenSecret(String);

impl TokenSecret {
    /// Takes a token's text.
    #[must_use]
    pub fn new(text: String) -> Self {
        Self(text)
    }

    /// The text: for an `Authorization` header, or for the one person it is meant for.
    #[must_use]
    pub fn reveal(&self) -> &str {
        &self.0
    }
}

impl fmt::Debug for TokenSecret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("TokenSecret(redacted)")
    }
}

/// Who is asking.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct Me {
    /// The principal's name.
    pub name: String,
    /// Its roles: one, except in demo mode.
    pub roles: Vec<Role>,
    /// What it is limited to.
    pub scope: TokenScope,
    /// Whether the server runs in demo mode, where everybody on this machine may do everything.
    pub demo: bool,
    /// The token's public id.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub token: Option<String>,
    /// When the token ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expires_at: Option<Timestamp>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_role_is_written_as_its_text() {
        for role in Role::ALL {
            let written = serde_json::to_string(&role).unwrap();
            assert_eq!(written, format!("\"{role}\""));
            assert_eq!(Role::of_str(role.as_str()), Some(role));
        }
    }

    #[test]
    fn a_secret_does_not_show_itself() {
        let secret = TokenSecret::new("cell_canary_canary".to_owned());
        assert!(!format!("{secret:?}").contains("canary"));
    }
}
