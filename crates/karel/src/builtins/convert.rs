//! Numbers to strings and back.

#![expect(
    clippy::unnecessary_wraps,
    reason = "all built-ins have the table's signature"
)]

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::{
    machine::{cell::Cell, fault::Fault},
    position::Config,
    status::Status,
    text_reader::{parse_integer, parse_real},
    text_writer::{MAX_WIDTH, fixed_point, integer_text, scientific},
    value::Text,
};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "CNV_INT_STR", params: &[Param::Integer, Param::Integer, Param::Integer, Param::OutText], required: 4, returns: Returns::Nothing, code: int_str },
    Builtin { name: "CNV_REAL_STR", params: &[Param::Real, Param::Integer, Param::Integer, Param::OutText], required: 4, returns: Returns::Nothing, code: real_str },
    Builtin { name: "CNV_CONF_STR", params: &[Param::Config, Param::OutText], required: 2, returns: Returns::Nothing, code: conf_str },
    Builtin { name: "CNV_STR_CONF", params: &[Param::Text, Param::OutConfig, Param::OutInteger], required: 3, returns: Returns::Nothing, code: str_conf },
    Builtin { name: "CNV_STR_INT", params: &[Param::Text, Param::OutInteger], required: 2, returns: Returns::Nothing, code: str_int },
    Builtin { name: "CNV_STR_REAL", params: &[Param::Text, Param::OutReal], required: 2, returns: Returns::Nothing, code: str_real },
];

/// Fills with blanks on the left; what is wider stays as it is.
fn right_justified(text: &str, width: i32) -> Result<Text, Fault> {
    let width = usize::try_from(width)
        .ok()
        .filter(|width| *width <= MAX_WIDTH);
    let width = width.ok_or_else(|| Fault::argument("Invalid length of a conversion"))?;
    Ok(Text::from(format!("{text:>width$}").as_str()))
}

/// One leading blank or minus sign, then digits; base 0 is 10.
fn int_str(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let base = match context.integer(2) {
        0 => 10,
        base => u32::try_from(base)
            .ok()
            .filter(|base| (2..=16).contains(base))
            .ok_or_else(|| {
                Fault::argument(format!("CNV_INT_STR with base {base}, not in 2 to 16"))
            })?,
    };
    let text = right_justified(&integer_text(context.integer(0), base), context.integer(1))?;
    context.put_text(3, text);
    Ok(Outcome::Done)
}

/// A configuration as the pendant shows it.
fn conf_str(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let Cell::Config(config) = *context.arg(0) else {
        return Err(Fault::uninit());
    };
    context.put_text(1, Text::from(config.to_string().as_str()));
    Ok(Outcome::Done)
}

/// A text that is no configuration leaves the variable without a value.
fn str_conf(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let (cell, status) = match Config::parse(&context.text(0).to_string_lossless()) {
        Some(config) => (Cell::Config(config), Status::OK),
        None => (Cell::Uninit, Status::INTP_ARGUMENT),
    };
    context.put(1, cell);
    context.put_status(2, status);
    Ok(Outcome::Done)
}

/// Fixed point with as many decimals as asked.
///
/// ASSUMPTION: a negative number of decimals means scientific notation.
fn real_str(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let text = match usize::try_from(context.integer(2)) {
        Ok(digits) if digits <= MAX_WIDTH => fixed_point(context.real(0), digits),
        Ok(_) => {
            return Err(Fault::argument(
                "Invalid number of decimals in CNV_REAL_STR",
            ));
        }
        Err(_) => scientific(context.real(0)),
    };
    let text = right_justified(&text, context.integer(1))?;
    context.put_text(3, text);
    Ok(Outcome::Done)
}

/// What is no number leaves the variable uninitialized, and that is no error.
fn str_int(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let value = parse_integer(context.text(0).as_bytes().trim_ascii(), 10);
    if value.is_none() {
        no_number(context, "CNV_STR_INT");
    }
    context.put(1, value.map_or(Cell::Uninit, Cell::Integer));
    Ok(Outcome::Done)
}

fn no_number(context: &mut Context<'_>, builtin: &str) {
    let text = context.text(0).to_string_lossless();
    context.explain(&|| {
        format!(
            "{builtin} finds no number in {text:?}: its variable has no value now, and using it ends the task with INTP-311"
        )
    });
}

fn str_real(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let value = parse_real(context.text(0).as_bytes().trim_ascii());
    if value.is_none() {
        no_number(context, "CNV_STR_REAL");
    }
    context.put(1, value.map_or(Cell::Uninit, Cell::Real));
    Ok(Outcome::Done)
}
