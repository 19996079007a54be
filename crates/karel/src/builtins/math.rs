//! Numbers.

use super::{Builtin, Context, Outcome, Param, Returns};
use crate::machine::{self, cell::Cell, fault::Fault};

#[rustfmt::skip]
pub(super) const TABLE: &[Builtin] = &[
    Builtin { name: "ABS", params: &[Param::Number], required: 1, returns: Returns::SameAsFirst, code: abs },
    Builtin { name: "ACOS", params: &[Param::Real], required: 1, returns: Returns::Real, code: |context| arc(context, "ACOS", f64::acos) },
    Builtin { name: "ASIN", params: &[Param::Real], required: 1, returns: Returns::Real, code: |context| arc(context, "ASIN", f64::asin) },
    Builtin { name: "ATAN2", params: &[Param::Real, Param::Real], required: 2, returns: Returns::Real, code: atan2 },
    Builtin { name: "COS", params: &[Param::Real], required: 1, returns: Returns::Real, code: |context| by_angle(context, f64::cos) },
    Builtin { name: "EXP", params: &[Param::Real], required: 1, returns: Returns::Real, code: exp },
    Builtin { name: "LN", params: &[Param::Real], required: 1, returns: Returns::Real, code: ln },
    Builtin { name: "ROUND", params: &[Param::Real], required: 1, returns: Returns::Integer, code: round },
    Builtin { name: "SIN", params: &[Param::Real], required: 1, returns: Returns::Real, code: |context| by_angle(context, f64::sin) },
    Builtin { name: "SQRT", params: &[Param::Real], required: 1, returns: Returns::Real, code: sqrt },
    Builtin { name: "TAN", params: &[Param::Real], required: 1, returns: Returns::Real, code: |context| by_angle(context, f64::tan) },
    Builtin { name: "TRUNC", params: &[Param::Real], required: 1, returns: Returns::Integer, code: trunc },
];

/// Computed with 64 bits, rounded once to a REAL.
fn real(value: f64) -> Result<Outcome, Fault> {
    machine::real(value).map(|value| Outcome::Value(Cell::Real(value)))
}

fn integer(value: f32) -> Result<Outcome, Fault> {
    machine::whole(value).map(|value| Outcome::Value(Cell::Integer(value)))
}

fn abs(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    if let Cell::Integer(value) = context.arg(0) {
        let value = value.checked_abs().ok_or_else(Fault::overflow)?;
        return Ok(Outcome::Value(Cell::Integer(value)));
    }
    Ok(Outcome::Value(Cell::Real(context.real(0).abs())))
}

/// ASSUMPTION: halves go away from zero.
fn round(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    integer(context.real(0).round())
}

fn trunc(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    integer(context.real(0).trunc())
}

/// Angles are degrees.
fn by_angle(context: &mut Context<'_>, function: fn(f64) -> f64) -> Result<Outcome, Fault> {
    real(function(f64::from(context.real(0)).to_radians()))
}

/// Of a ratio; degrees.
fn arc(context: &mut Context<'_>, name: &str, function: fn(f64) -> f64) -> Result<Outcome, Fault> {
    let ratio = context.real(0);
    if !(-1.0..=1.0).contains(&ratio) {
        return Err(Fault::argument(format!(
            "{name} of {ratio}, not in -1 to 1"
        )));
    }
    real(function(f64::from(ratio)).to_degrees())
}

/// `ATAN2(x, y)`: x first; degrees counterclockwise from the X axis.
fn atan2(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let (x, y) = (f64::from(context.real(0)), f64::from(context.real(1)));
    real(y.atan2(x).to_degrees())
}

fn sqrt(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let value = context.real(0);
    if value < 0.0 {
        return Err(Fault::argument(format!("SQRT of {value}, less than 0")));
    }
    real(f64::from(value).sqrt())
}

fn ln(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    let value = context.real(0);
    if value <= 0.0 {
        return Err(Fault::argument(format!("LN of {value}, not more than 0")));
    }
    real(f64::from(value).ln())
}

fn exp(context: &mut Context<'_>) -> Result<Outcome, Fault> {
    real(f64::from(context.real(0)).exp())
}
