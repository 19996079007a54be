//! A token of text to a value: what is legal, and what may still become so.

use super::{ItemKind, ReadValue};

/// The value of a whole token, `None` if it is illegal.
pub(super) fn parse(token: &[u8], kind: ItemKind) -> Option<ReadValue> {
    match kind {
        ItemKind::Integer { base } => parse_integer(token, base).map(ReadValue::Integer),
        ItemKind::Real => parse_real(token).map(ReadValue::Real),
        ItemKind::Boolean if token.eq_ignore_ascii_case(b"TRUE") => Some(ReadValue::Boolean(true)),
        ItemKind::Boolean if token.eq_ignore_ascii_case(b"FALSE") => {
            Some(ReadValue::Boolean(false))
        }
        ItemKind::Boolean => None,
        ItemKind::Text { length } => Some(ReadValue::Text(
            token.get(..token.len().min(length))?.into(),
        )),
        ItemKind::LineEnd => Some(ReadValue::Nothing),
    }
}

/// Sign and digits, nothing else; a number beyond 32 bits is illegal.
pub(crate) fn parse_integer(token: &[u8], base: u32) -> Option<i32> {
    let text = std::str::from_utf8(token).ok()?;
    i32::from_str_radix(text, base).ok()
}

/// Sign, digits, point, exponent. Words that Rust reads as numbers are none, and neither is what
/// does not fit into 32 bits.
pub(crate) fn parse_real(token: &[u8]) -> Option<f32> {
    let text = std::str::from_utf8(token).ok()?;
    let plain = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | 'e' | 'E');
    if !text.chars().all(plain) {
        return None;
    }
    text.parse().ok().filter(|value: &f32| value.is_finite())
}

/// Whether more bytes can make a legal value of this beginning.
pub(super) fn can_become(token: &[u8], kind: ItemKind) -> bool {
    let digits = |token: &[u8], base: u32| {
        let unsigned = token
            .strip_prefix(b"-")
            .or_else(|| token.strip_prefix(b"+"));
        let digits = unsigned.unwrap_or(token);
        digits.iter().all(|byte| char::from(*byte).is_digit(base))
    };
    match kind {
        ItemKind::Integer { base } => digits(token, base),
        ItemKind::Real => {
            // `-`, `1.5e+` and `1.5e` want a digit.
            let completed = [token, b"0"].concat();
            parse_real(token).is_some() || parse_real(&completed).is_some()
        }
        ItemKind::Boolean => [&b"TRUE"[..], b"FALSE"].iter().any(|word| {
            word.get(..token.len())
                .is_some_and(|start| start.eq_ignore_ascii_case(token))
        }),
        ItemKind::Text { .. } | ItemKind::LineEnd => true,
    }
}
