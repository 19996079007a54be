use super::error::DecodeError;
use super::line::checksum;
use super::values::LARGEST;

/// The tokens of a line whose checksum is right.
#[derive(Debug)]
pub(super) struct Fields<'a> {
    tokens: std::slice::Split<'a, u8, fn(&u8) -> bool>,
}

#[expect(
    clippy::trivially_copy_pass_by_ref,
    reason = "the signature a slice's split wants"
)]
fn is_blank(byte: &u8) -> bool {
    *byte == b' '
}

impl<'a> Fields<'a> {
    /// The tokens of a line without its end, and the first of them: what kind of line it is.
    pub(super) fn open(line: &'a [u8]) -> Result<(&'a [u8], Self), DecodeError> {
        let odd = line.iter().position(|byte| !(b' '..=b'~').contains(byte));
        if let Some(at) = odd {
            let byte = line.get(at).copied().unwrap_or(0);
            return Err(DecodeError::Byte { at, byte });
        }
        let blank = line
            .iter()
            .rposition(is_blank)
            .ok_or(DecodeError::NoChecksum)?;
        let (body, rest) = line.split_at(blank);
        let received = rest
            .get(1..)
            .and_then(integer)
            .and_then(|sum| u32::try_from(sum).ok())
            .ok_or(DecodeError::NoChecksum)?;
        let computed = checksum(body);
        if received != computed {
            return Err(DecodeError::Checksum { received, computed });
        }
        let mut tokens = body.split(is_blank as fn(&u8) -> bool);
        let kind = tokens.next().unwrap_or_default();
        Ok((kind, Self { tokens }))
    }

    pub(super) fn token(&mut self, item: &'static str) -> Result<&'a [u8], DecodeError> {
        self.tokens
            .next()
            .filter(|token| !token.is_empty())
            .ok_or(DecodeError::Missing { item })
    }

    pub(super) fn integer(&mut self, item: &'static str) -> Result<i32, DecodeError> {
        integer(self.token(item)?).ok_or(DecodeError::NotANumber { item })
    }

    pub(super) fn in_range(
        &mut self,
        item: &'static str,
        min: i32,
        max: i32,
    ) -> Result<i32, DecodeError> {
        let value = self.integer(item)?;
        if (min..=max).contains(&value) {
            Ok(value)
        } else {
            Err(DecodeError::OutOfRange {
                item,
                value,
                min,
                max,
            })
        }
    }

    /// A number that is not negative.
    pub(super) fn count(&mut self, item: &'static str) -> Result<u32, DecodeError> {
        Ok(self.in_range(item, 0, LARGEST)?.unsigned_abs())
    }

    /// A number of 0 to `max`.
    pub(super) fn small(&mut self, item: &'static str, max: u8) -> Result<u8, DecodeError> {
        let value = self.in_range(item, 0, i32::from(max))?;
        Ok(u8::try_from(value).unwrap_or(max))
    }

    pub(super) fn flag(&mut self, item: &'static str) -> Result<bool, DecodeError> {
        Ok(self.in_range(item, 0, 1)? == 1)
    }

    pub(super) fn six(&mut self, items: [&'static str; 6]) -> Result<[i32; 6], DecodeError> {
        let mut values = [0; 6];
        for (value, item) in values.iter_mut().zip(items) {
            *value = self.integer(item)?;
        }
        Ok(values)
    }

    pub(super) fn end(mut self) -> Result<(), DecodeError> {
        match self.tokens.next() {
            None => Ok(()),
            Some(_) => Err(DecodeError::Trailing),
        }
    }
}

/// An integer in its canonical form, of at most [`LARGEST`] either way.
fn integer(token: &[u8]) -> Option<i32> {
    let (negative, digits) = match token {
        [b'-', digits @ ..] => (true, digits),
        digits => (false, digits),
    };
    let canonical = match digits {
        [] => false,
        [b'0'] => !negative,
        [first, ..] => *first != b'0' && digits.len() <= 10,
    };
    if !canonical {
        return None;
    }
    let mut value: i64 = 0;
    for digit in digits {
        if !digit.is_ascii_digit() {
            return None;
        }
        value = value * 10 + i64::from(digit - b'0');
    }
    let value = i32::try_from(value).ok()?;
    Some(if negative { -value } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_taken_in_their_canonical_form_only() {
        for value in [0, 1, -1, 10, LARGEST, -LARGEST] {
            assert_eq!(integer(value.to_string().as_bytes()), Some(value));
        }
        for text in [
            "",
            "-",
            "+1",
            "01",
            "-0",
            "-01",
            "00",
            "1.0",
            "2147483648",
            "-2147483648",
            "99999999999",
            "1e3",
            "x",
        ] {
            assert_eq!(integer(text.as_bytes()), None, "{text}");
        }
    }
}
