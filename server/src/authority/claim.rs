//! On whose behalf a robot is moved: checked when a request arrives, when its intent is written, and right before the
//! first byte.

use std::sync::Arc;

use api::{ControlToken, ProblemCode, Violation};
use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use axum::http::{HeaderMap, HeaderName};

use super::control::CellControl;
use super::said::Refused;
use crate::identity::Principal;
use crate::problem::Problem;
use crate::state::App;

/// The header that carries a [`ControlToken`].
const CONTROL_TOKEN: HeaderName = HeaderName::from_static("control-token");

/// A right to move the robots of a cell, as long as it lasts. Cheap to clone.
#[derive(Clone, Debug)]
pub(crate) struct Claim {
    control: Arc<CellControl>,
    by: By,
}

#[derive(Clone, Debug)]
enum By {
    /// Whoever holds this lease.
    Lease {
        token: ControlToken,
        holder: Arc<str>,
    },
    /// The thesis's own routes, whose callers know of no lease: while nobody holds one.
    Legacy,
    /// The cell's jobs: while nobody holds control.
    Jobs,
}

impl Claim {
    pub(crate) fn of_legacy(control: Arc<CellControl>) -> Self {
        Self {
            control,
            by: By::Legacy,
        }
    }
    pub(crate) fn of_jobs(control: Arc<CellControl>) -> Self {
        Self {
            control,
            by: By::Jobs,
        }
    }

    pub(crate) fn of_lease(control: &Arc<CellControl>, token: ControlToken, holder: &str) -> Self {
        Self {
            control: Arc::clone(control),
            by: By::Lease {
                token,
                holder: holder.into(),
            },
        }
    }

    /// Reads the claim of a request from its header.
    pub(crate) fn of_request(
        control: &Arc<CellControl>,
        headers: &HeaderMap,
        principal: &Principal,
    ) -> Result<Self, Problem> {
        let Some(token) = token(headers)? else {
            return Err(control.required(principal.name()).into());
        };
        let claim = Self::of_lease(control, token, principal.name());
        claim.check()?;
        Ok(claim)
    }

    /// Whether it still holds.
    pub(crate) fn check(&self) -> Result<(), Refused> {
        match &self.by {
            By::Lease { token, holder } => self.control.check(*token, holder),
            By::Legacy | By::Jobs => self.control.check_free(),
        }
    }

    /// Who acts, for records.
    pub(crate) fn actor(&self) -> &str {
        match &self.by {
            By::Lease { holder, .. } => holder,
            By::Legacy => "legacy",
            By::Jobs => "jobs",
        }
    }
}

/// The token of a request, where it has one.
pub(crate) fn token(headers: &HeaderMap) -> Result<Option<ControlToken>, Problem> {
    let mut values = headers.get_all(CONTROL_TOKEN).iter();
    let value = match (values.next(), values.next()) {
        (None, _) => return Ok(None),
        (Some(value), None) => value.to_str().unwrap_or_default(),
        (Some(_), Some(_)) => return Err(invalid("it is given twice")),
    };
    match value.parse() {
        Ok(token) => Ok(Some(token)),
        Err(error) => Err(invalid(&format!("{error}"))),
    }
}

fn invalid(message: &str) -> Problem {
    Problem::not_sent(ProblemCode::Validation, format!("Control-Token: {message}")).violations(
        vec![Violation {
            item: "Control-Token".to_owned(),
            message: message.to_owned(),
            ..Violation::default()
        }],
    )
}

impl From<Refused> for Problem {
    fn from(refused: Refused) -> Self {
        let hint = if refused.code == ProblemCode::ControlHeld {
            "Wait until it is given back or ends; at the cell itself, LOCAL takes it at once"
        } else if refused.code == ProblemCode::ControlLost {
            "Look at the robot, then take control again"
        } else {
            "`cellctl` takes control for as long as a command needs it"
        };
        Self::not_sent(refused.code, refused.detail)
            .hint(hint)
            .control(refused.holder)
    }
}

/// The claim of a request to move the robot, or a robot of the cell, that its path names.
impl FromRequestParts<Arc<App>> for Claim {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, app: &Arc<App>) -> Result<Self, Problem> {
        let principal = Principal::from_request_parts(parts, app).await?;
        let cell = crate::routes::cell_of(parts, app).await?;
        Self::of_request(&cell.control, &parts.headers, &principal)
    }
}
