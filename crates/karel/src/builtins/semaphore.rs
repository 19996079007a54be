//! Semaphores: one task waits for what another posts.

use std::time::Duration;

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    host::Wait,
    machine::{cell::Cell, fault::Fault, semaphore::Semaphores, task::Pending},
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "CLEAR_SEMA", params: &[Param::Integer], required: 1, returns: Returns::Nothing, code: clear },
    Builtin { name: "PEND_SEMA", params: &[Param::Integer, Param::Integer, Param::OutBoolean], required: 3, returns: Returns::Nothing, code: pend },
    Builtin { name: "SEMA_COUNT", params: &[Param::Integer], required: 1, returns: Returns::Integer, code: sema_count },
    Builtin { name: "POST_SEMA", params: &[Param::Integer], required: 1, returns: Returns::Nothing, code: post },
];

/// How often a task that waits looks again.
const LOOK: Duration = Duration::from_millis(2);

fn count<'a>(context: &'a mut Context<'_>) -> Result<&'a mut i32, Fault> {
    let n = context.integer(0);
    context.semaphores.count(n).ok_or_else(|| {
        let last = Semaphores::COUNT;
        Fault::argument(format!("There is no semaphore {n}, the last is {last}"))
    })
}

fn clear(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    *count(context)? = 0;
    Ok(Outcome::Done)
}

fn sema_count(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let count = *count(context)?;
    Ok(Outcome::Value(Cell::Integer(count)))
}

fn post(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let count = count(context)?;
    *count = count.saturating_add(1);
    Ok(Outcome::Done)
}

/// Takes one, or waits for it: for ever if the time is below 0.
fn pend(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let count = count(context)?;
    if *count > 0 {
        *count -= 1;
        *context.pending = Pending::None;
        context.put(2, Cell::Boolean(false));
        return Ok(Outcome::Done);
    }
    let now = context.host.now();
    let until = if let Pending::Deadline(until) = *context.pending {
        until
    } else {
        match u64::try_from(context.integer(1)) {
            Ok(milliseconds) => now.saturating_add(Duration::from_millis(milliseconds)),
            Err(_) => Duration::MAX,
        }
    };
    if until <= now {
        *context.pending = Pending::None;
        context.put(2, Cell::Boolean(true));
        return Ok(Outcome::Done);
    }
    *context.pending = Pending::Deadline(until);
    Ok(Outcome::Pending(Wait::Until(until.min(now + LOOK))))
}
