//! What a new token must be like.

use api::{ProblemCode, Role, TokenBody, TokenScope, Violation};
use jiff::SignedDuration;

use crate::problem::Problem;

const DEFAULT_DAYS: u32 = 90;
pub(super) const MAX_DAYS: u32 = 365;
pub(super) const MAX_OVERLAP_S: u32 = 86_400;
const MAX_NAME: usize = 64;
/// Names that mean something else in logs and records.
const RESERVED: [&str; 5] = ["demo", "jobs", "legacy", "nobody", "server"];

pub(super) fn days(days: u32) -> SignedDuration {
    SignedDuration::from_secs(i64::from(days) * 86_400)
}

/// Checks a new token's body; answers its lifetime.
pub(super) fn check(body: &TokenBody) -> Result<SignedDuration, Problem> {
    check_name(&body.name).map_err(|problem| validation("name", problem))?;
    if RESERVED.contains(&body.name.as_str()) {
        let names = RESERVED.join(", ");
        let message = format!("`{}` is one of the server's own names: {names}", body.name);
        return Err(validation("name", message));
    }
    if let Some(cell) = &body.scope.cell
        && cell.len() > MAX_NAME
    {
        return Err(validation("scope.cell", format!("longer than {MAX_NAME}")));
    }
    match (body.role, body.scope.mobile_robot.as_deref()) {
        (Role::MobileRobot, None | Some("")) => {
            let message = "missing; the role mobile_robot is for one of them";
            return Err(validation("scope.mobile_robot", message.to_owned()));
        }
        (Role::MobileRobot, Some(id)) if id.len() > MAX_NAME => {
            let message = format!("longer than {MAX_NAME}");
            return Err(validation("scope.mobile_robot", message));
        }
        (Role::Viewer | Role::Operator | Role::Integrator | Role::Admin, Some(_)) => {
            let message = "only for the role mobile_robot";
            return Err(validation("scope.mobile_robot", message.to_owned()));
        }
        (_, _) => {}
    }
    let moves = matches!(body.role, Role::Operator | Role::Integrator);
    if body.scope.local_station && !moves {
        let message = "only for the roles operator and integrator";
        return Err(validation("scope.local_station", message.to_owned()));
    }
    if body.role == Role::Admin && body.scope != TokenScope::default() {
        let message = "an admin token has no scope: it manages the tokens of every cell";
        return Err(validation("scope", message.to_owned()));
    }
    let asked = body.expires_in_days.unwrap_or(DEFAULT_DAYS);
    if !(1..=MAX_DAYS).contains(&asked) {
        return Err(out_of_range("expires_in_days", asked, 1, MAX_DAYS));
    }
    Ok(days(asked))
}

/// A name is safe in a log line, a table and a page.
pub(super) fn check_name(name: &str) -> Result<(), String> {
    let legal = |byte: u8| byte.is_ascii_alphanumeric() || b" ._@-".contains(&byte);
    let first = name.bytes().next();
    let begins = first.is_some_and(|byte| byte.is_ascii_alphanumeric());
    if begins && name.len() <= MAX_NAME && name.bytes().all(legal) {
        return Ok(());
    }
    let shown = crate::state::shown(name);
    Err(format!(
        "is `{shown}`; it must be 1 to {MAX_NAME} of `[A-Za-z0-9 ._@-]`, a letter or digit first"
    ))
}

fn validation(item: &str, message: String) -> Problem {
    Problem::not_sent(ProblemCode::Validation, format!("{item}: {message}")).violations(vec![
        Violation {
            item: item.to_owned(),
            message,
            ..Violation::default()
        },
    ])
}

pub(super) fn out_of_range(item: &str, value: u32, min: u32, max: u32) -> Problem {
    let message = format!("{value} is not from {min} to {max}");
    Problem::not_sent(ProblemCode::Validation, format!("{item}: {message}")).violations(vec![
        Violation {
            item: item.to_owned(),
            message,
            value: Some(f64::from(value)),
            min: Some(f64::from(min)),
            max: Some(f64::from(max)),
        },
    ])
}
