//! Control authority: who may move the robots of a cell now.

use std::fmt;
use std::str::FromStr;

use jiff::Timestamp;
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use uuid::Uuid;

/// Where the holder of control stands.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Station {
    /// At the cell, in sight of the robots. May always take control.
    Local,
    /// Anywhere else. Waits until nobody holds control.
    Remote,
}

/// What happens to motions under way when control is lost without being given back.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum LossBehavior {
    /// The motion pauses, and goes on when somebody with control says so.
    Hold,
    /// The motion ends by a controlled stop.
    #[serde(rename = "STOP_1")]
    Stop1,
    /// The motion under way ends where it was going; nothing further is sent.
    CompleteStep,
}

/// A request for control.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(example = json!({"station": "REMOTE", "ttl_s": 60, "reason": "trying the API"}))]
pub struct AcquireBody {
    /// Where the caller stands. `LOCAL` needs a token made for the cell's own panel.
    pub station: Station,
    /// Control is lost this many seconds after the last heartbeat; 10 where absent, 2 for jogging.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 2, maximum = 60)]
    pub ttl_s: Option<u32>,
    /// What becomes of motions under way when control is lost; `STOP_1` where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss_behavior: Option<LossBehavior>,
    /// Why, for the holder this may be taken from and for the record: 1 to 200 characters.
    pub reason: String,
    /// Takes control away from whoever holds it. For admins.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub preempt: bool,
}

/// To whom control is handed over.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TransferBody {
    /// The name of the principal who has control from now on, under a new token.
    pub to: String,
    /// Why: 1 to 200 characters.
    pub reason: String,
}

/// What a client sends as `Control-Token` with everything that moves a robot: `<lease>.<epoch>`.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub struct ControlToken {
    /// The lease.
    pub lease: Uuid,
    /// Its epoch: a later lease has a greater one, so an old holder cannot act again.
    pub epoch: u64,
}

impl fmt::Display for ControlToken {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.lease, self.epoch)
    }
}

/// The text is no `<lease>.<epoch>`.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct ControlTokenError;

impl fmt::Display for ControlTokenError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("it is not `<lease>.<epoch>`, as control-authority answers it")
    }
}

impl std::error::Error for ControlTokenError {}

impl FromStr for ControlToken {
    type Err = ControlTokenError;

    fn from_str(text: &str) -> Result<Self, ControlTokenError> {
        let (lease, epoch) = text.split_once('.').ok_or(ControlTokenError)?;
        let digits = (1..=19).contains(&epoch.len()) && epoch.bytes().all(|b| b.is_ascii_digit());
        let hyphenated = lease.len() == 36;
        match (Uuid::parse_str(lease), epoch.parse()) {
            (Ok(lease), Ok(epoch)) if digits && hyphenated => Ok(Self { lease, epoch }),
            _ => Err(ControlTokenError),
        }
    }
}

impl Serialize for ControlToken {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for ControlToken {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}

/// Control that somebody holds.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ControlLease {
    /// What the holder sends as `Control-Token`. It is no secret: it serves its holder only.
    #[schema(value_type = String, example = "019302d4-7b3f-7c7e-8f3a-2f6f1b0c9d11.7")]
    pub token: ControlToken,
    /// The lease: the first half of the token.
    pub lease: Uuid,
    /// The epoch: the second half of the token.
    pub epoch: u64,
    /// The principal that holds control.
    pub holder: String,
    /// Where it stands.
    pub station: Station,
    /// Why.
    pub reason: String,
    /// Since when.
    pub since: Timestamp,
    /// When it is lost, unless a heartbeat comes before.
    pub expires: Timestamp,
    /// Seconds from a heartbeat to the loss. Send one every third of it.
    pub ttl_s: u32,
    /// What becomes of motions under way when it is lost.
    pub loss_behavior: LossBehavior,
}

/// How a lease ended.
#[derive(Clone, Copy, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum ControlEnd {
    /// Its holder gave it back.
    Released,
    /// No heartbeat came in time.
    Expired,
    /// Somebody at the cell, or an admin, took it.
    Preempted,
    /// Its holder handed it to somebody else.
    Transferred,
    /// Its holder's token was revoked.
    Revoked,
}

/// The last lease that ended.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct EndedLease {
    /// Its epoch.
    pub epoch: u64,
    /// Who held it.
    pub holder: String,
    /// How it ended.
    pub end: ControlEnd,
    /// When.
    pub at: Timestamp,
    /// Who ended it, where it was somebody else.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// Why, in that one's words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

/// Who has control of a cell.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize, ToSchema)]
pub struct ControlView {
    /// The cell.
    pub cell: String,
    /// The lease somebody holds; absent while control is free.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held: Option<ControlLease>,
    /// Whether jobs may move the robots: while nobody holds control.
    pub jobs_may_act: bool,
    /// The epoch of the latest lease; 0 before the first.
    pub epoch: u64,
    /// How the lease before ended.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub last: Option<EndedLease>,
}

/// Who holds control, in a problem that says so.
#[derive(Clone, Debug, Deserialize, Eq, PartialEq, Serialize, ToSchema)]
pub struct ControlHolder {
    /// The principal.
    pub holder: String,
    /// Where it stands.
    pub station: Station,
    /// Since when.
    pub since: Timestamp,
    /// When it ends, unless a heartbeat comes before.
    pub expires: Timestamp,
    /// Why.
    pub reason: String,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_control_token_is_read_as_it_is_written() {
        let token = ControlToken {
            lease: Uuid::from_u128(7),
            epoch: 12,
        };
        assert_eq!(token.to_string().parse(), Ok(token));
        let written = serde_json::to_string(&token).unwrap();
        assert_eq!(
            serde_json::from_str::<ControlToken>(&written).unwrap(),
            token
        );
    }

    #[test]
    fn what_is_no_control_token_is_refused() {
        let lease = Uuid::from_u128(7);
        for text in [
            String::new(),
            ".".to_owned(),
            format!("{lease}"),
            format!("{lease}."),
            format!("{lease}.+1"),
            format!("{lease}.1 "),
            format!("{lease}.99999999999999999999"),
            format!("{}.1", lease.simple()),
            "x.1".to_owned(),
        ] {
            assert!(text.parse::<ControlToken>().is_err(), "{text}");
        }
    }
}
