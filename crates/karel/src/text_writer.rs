//! WRITE of text: values to bytes.

use crate::types::MAX_STRING;

/// The end of a line that a `CR` item writes.
///
/// ASSUMPTION: not known for sockets; no program in the field writes CR to one in text mode.
pub(crate) const LINE_END: &[u8] = b"\r\n";

/// Widest field; more than a string can hold.
pub(crate) const MAX_WIDTH: usize = MAX_STRING;

/// INTEGER: one leading blank or the minus sign, then digits; `::w` fills on the left.
pub(crate) fn integer(out: &mut Vec<u8>, value: i32, width: Option<usize>) {
    right_justified(out, &integer_text(value, 10), width);
}

/// The leading blank stands where a minus sign would.
pub(crate) fn integer_text(value: i32, base: u32) -> String {
    let sign = if value < 0 { '-' } else { ' ' };
    let mut rest = value.unsigned_abs();
    let mut digits = Vec::new();
    loop {
        digits.push(
            char::from_digit(rest % base, base)
                .unwrap_or('?')
                .to_ascii_uppercase(),
        );
        rest /= base;
        if rest == 0 {
            break;
        }
    }
    std::iter::once(sign)
        .chain(digits.into_iter().rev())
        .collect()
}

/// REAL: scientific without a format, fixed point with `::w::d`.
pub(crate) fn real(out: &mut Vec<u8>, value: f32, width: Option<usize>, digits: Option<usize>) {
    let text = match digits {
        Some(digits) => format!(" {}", fixed_point(value, digits)),
        None => scientific(value),
    };
    match width {
        None => right_justified(out, &text, None),
        // Inside a width the leading blank is part of the padding.
        Some(_) => right_justified(out, text.trim_start(), width),
    }
}

/// ASSUMPTION: one digit before the point, six after it, two in the exponent, and a blank where a
/// minus sign would stand.
pub(crate) fn scientific(value: f32) -> String {
    let text = format!("{value:.6E}");
    let (mantissa, exponent) = text.split_once('E').unwrap_or((&text, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    let sign = if value < 0.0 { "" } else { " " };
    let exponent_sign = if exponent < 0 { '-' } else { '+' };
    format!(
        "{sign}{mantissa}E{exponent_sign}{:02}",
        exponent.unsigned_abs()
    )
}

/// Fixed point with this many decimals.
///
/// ASSUMPTION: a value below one has no zero before the point: `.500`, `-.250`.
pub(crate) fn fixed_point(value: f32, digits: usize) -> String {
    let text = format!("{value:.digits$}");
    if let Some(rest) = text.strip_prefix("0.") {
        return format!(".{rest}");
    }
    if let Some(rest) = text.strip_prefix("-0.") {
        // What rounds to zero has no sign either.
        let sign = if rest.bytes().all(|digit| digit == b'0') {
            ""
        } else {
            "-"
        };
        return format!("{sign}.{rest}");
    }
    text
}

/// BOOLEAN: the word.
pub(crate) fn boolean(out: &mut Vec<u8>, value: bool, width: Option<usize>) {
    left_justified(out, if value { b"TRUE" } else { b"FALSE" }, width);
}

/// STRING: as it is; `::w` fills on the right or cuts.
pub(crate) fn text(out: &mut Vec<u8>, value: &[u8], width: Option<usize>) {
    left_justified(out, value, width);
}

fn right_justified(out: &mut Vec<u8>, text: &str, width: Option<usize>) {
    let missing = width.unwrap_or(0).saturating_sub(text.len());
    out.extend(std::iter::repeat_n(b' ', missing));
    out.extend_from_slice(text.as_bytes());
}

fn left_justified(out: &mut Vec<u8>, text: &[u8], width: Option<usize>) {
    let width = width.unwrap_or(text.len());
    out.extend(
        text.iter()
            .copied()
            .chain(std::iter::repeat(b' '))
            .take(width),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(write: impl FnOnce(&mut Vec<u8>)) -> String {
        let mut out = Vec::new();
        write(&mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn an_integer_has_a_blank_where_its_sign_would_be() {
        assert_eq!(written(|out| integer(out, 5, None)), " 5");
        assert_eq!(written(|out| integer(out, -5, None)), "-5");
        assert_eq!(written(|out| integer(out, i32::MIN, None)), "-2147483648");
        assert_eq!(written(|out| integer(out, 5, Some(4))), "   5");
        assert_eq!(written(|out| integer(out, 12345, Some(3))), " 12345");
    }

    #[test]
    fn a_real_is_scientific_without_and_fixed_with_a_format() {
        assert_eq!(written(|out| real(out, 12.5, None, None)), " 1.250000E+01");
        assert_eq!(
            written(|out| real(out, -0.001, None, None)),
            "-1.000000E-03"
        );
        assert_eq!(written(|out| real(out, 12.5, Some(7), Some(3))), " 12.500");
        assert_eq!(written(|out| real(out, 1234.5, Some(3), Some(1))), "1234.5");
    }

    #[test]
    fn assumed_fixed_point_has_no_zero_before_the_point() {
        assert_eq!(fixed_point(0.5, 3), ".500");
        assert_eq!(fixed_point(-0.25, 3), "-.250");
        assert_eq!(fixed_point(-0.0001, 3), ".000");
        assert_eq!(fixed_point(-1.5, 1), "-1.5");
        assert_eq!(fixed_point(10.0, 2), "10.00");
    }

    #[test]
    fn strings_and_booleans_are_filled_on_the_right_or_cut() {
        assert_eq!(written(|out| text(out, b"abc", None)), "abc");
        assert_eq!(written(|out| text(out, b"abc", Some(5))), "abc  ");
        assert_eq!(written(|out| text(out, b"abc", Some(2))), "ab");
        assert_eq!(written(|out| boolean(out, false, Some(6))), "FALSE ");
    }

    #[test]
    fn other_bases_use_capital_digits() {
        assert_eq!(integer_text(255, 16), " FF");
        assert_eq!(integer_text(-5, 2), "-101");
    }
}
