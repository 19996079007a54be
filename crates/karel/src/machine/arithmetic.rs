//! Arithmetic of INTEGER and REAL, with the errors that KAREL raises.

use std::cmp::Ordering;

use super::fault::Fault;
use crate::ast::Relation;

pub(super) fn add(a: i32, b: i32) -> Result<i32, Fault> {
    a.checked_add(b).ok_or_else(Fault::overflow)
}

pub(super) fn subtract(a: i32, b: i32) -> Result<i32, Fault> {
    a.checked_sub(b).ok_or_else(Fault::overflow)
}

pub(super) fn multiply(a: i32, b: i32) -> Result<i32, Fault> {
    a.checked_mul(b).ok_or_else(Fault::overflow)
}

/// Truncates toward zero.
pub(super) fn div(a: i32, b: i32) -> Result<i32, Fault> {
    if b == 0 {
        return Err(Fault::divide_by_zero());
    }
    a.checked_div(b).ok_or_else(Fault::overflow)
}

/// The remainder of [`div`], with the sign of `a`.
pub(super) fn modulo(a: i32, b: i32) -> Result<i32, Fault> {
    if b == 0 {
        return Err(Fault::divide_by_zero());
    }
    Ok(a.wrapping_rem(b))
}

pub(super) fn divide(a: f32, b: f32) -> Result<f32, Fault> {
    if b == 0.0 {
        return Err(Fault::divide_by_zero());
    }
    finite(a / b)
}

/// A REAL that does not fit any more is an error; KAREL has no infinity.
pub(crate) fn finite(value: f32) -> Result<f32, Fault> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(Fault::overflow())
    }
}

/// A whole number as an INTEGER.
pub(crate) fn whole(value: f32) -> Result<i32, Fault> {
    let value = f64::from(value);
    if value < f64::from(i32::MIN) || value > f64::from(i32::MAX) {
        return Err(Fault::overflow());
    }
    #[expect(clippy::cast_possible_truncation, reason = "the range was checked")]
    let value = value as i32;
    Ok(value)
}

/// Rounds to a REAL.
pub(crate) fn real(value: f64) -> Result<f32, Fault> {
    #[expect(
        clippy::cast_possible_truncation,
        reason = "rounding to REAL is meant; range is checked"
    )]
    let rounded = value as f32;
    finite(rounded)
}

/// Order of two REALs, which are always finite; the two zeros are equal.
pub(super) fn order(a: f32, b: f32) -> Ordering {
    a.partial_cmp(&b).unwrap_or(Ordering::Equal)
}

pub(super) fn holds(relation: Relation, order: Ordering) -> bool {
    match relation {
        Relation::Equal => order.is_eq(),
        Relation::NotEqual => order.is_ne(),
        Relation::Less => order.is_lt(),
        Relation::Greater => order.is_gt(),
        Relation::LessEqual => order.is_le(),
        Relation::GreaterEqual => order.is_ge(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integer_division_truncates_toward_zero() {
        assert_eq!(div(-7, 2).unwrap(), -3);
        assert_eq!(modulo(-7, 2).unwrap(), -1);
        assert_eq!(modulo(i32::MIN, -1).unwrap(), 0);
    }

    /// Covers: K5.
    #[test]
    fn what_does_not_fit_is_an_overflow() {
        for result in [
            add(i32::MAX, 1),
            subtract(i32::MIN, 1),
            multiply(1 << 20, 1 << 20),
            div(i32::MIN, -1),
        ] {
            assert_eq!(result.unwrap_err().status.to_string(), "INTP-323");
        }
        assert_eq!(
            finite(f32::MAX * 2.0).unwrap_err().status.to_string(),
            "INTP-323"
        );
    }

    #[test]
    fn division_by_zero_has_its_own_number() {
        assert_eq!(div(1, 0).unwrap_err().status.to_string(), "INTP-307");
        assert_eq!(modulo(1, 0).unwrap_err().status.to_string(), "INTP-307");
        assert_eq!(divide(1.0, 0.0).unwrap_err().status.to_string(), "INTP-307");
    }
}
