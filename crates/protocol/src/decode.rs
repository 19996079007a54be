use thiserror::Error;

use crate::{Item, MAX_COMMAND_BYTES, MAX_SPEED, MIN_SPEED, WireMove};

/// Reads one whole command, exactly in the form [`WireMove::encode`] writes it.
///
/// Stricter than a controller, whose formatted READ takes any run of blanks and any last digit: one blank between
/// the fields, no plus sign, no leading zero, no `-0`, nothing before or after.
///
/// # Errors
/// The first field that does not fit, or bytes behind the last one.
pub fn decode_command(bytes: &[u8]) -> Result<WireMove, DecodeError> {
    if bytes.len() > MAX_COMMAND_BYTES {
        return Err(DecodeError::TooLong { len: bytes.len() });
    }
    let mut fields = bytes.split(|byte| *byte == b' ');
    let mut point = [0; 6];
    for (slot, item) in point.iter_mut().zip(Item::ALL) {
        *slot = integer(item, fields.next())?;
    }
    let speed = integer(Item::Speed, fields.next())?;
    let speed = u16::try_from(speed)
        .ok()
        .filter(|speed| (MIN_SPEED..=MAX_SPEED).contains(speed))
        .ok_or(DecodeError::Speed { value: speed })?;
    match fields.next() {
        Some(b"1") => {}
        Some(_) => return Err(DecodeError::NotANumber { item: Item::Last }),
        None => return Err(DecodeError::Missing { item: Item::Last }),
    }
    if fields.next().is_some() {
        return Err(DecodeError::Trailing);
    }
    Ok(WireMove::from_parts(point, speed))
}

fn integer(item: Item, field: Option<&[u8]>) -> Result<i32, DecodeError> {
    let field = field
        .filter(|field| !field.is_empty())
        .ok_or(DecodeError::Missing { item })?;
    let (negative, digits) = match field.split_first() {
        Some((b'-', digits)) => (true, digits),
        _ => (false, field),
    };
    let canonical = match digits.first() {
        Some(b'0') => digits.len() == 1 && !negative,
        Some(_) => digits.iter().all(u8::is_ascii_digit),
        None => false,
    };
    if !canonical {
        return Err(DecodeError::NotANumber { item });
    }
    digits
        .iter()
        .try_fold(0_i32, |value, digit| {
            let digit = i32::from(digit - b'0');
            let value = value.checked_mul(10)?;
            if negative {
                value.checked_sub(digit)
            } else {
                value.checked_add(digit)
            }
        })
        .ok_or(DecodeError::Overflow { item })
}

/// Why bytes are not a command.
#[derive(Clone, Copy, Debug, Eq, Error, PartialEq)]
pub enum DecodeError {
    /// A field is absent or empty.
    #[error("{item} is missing")]
    Missing {
        /// Which field.
        item: Item,
    },
    /// A field is not a decimal integer in its shortest form.
    #[error("{item} is not a decimal integer in its shortest form")]
    NotANumber {
        /// Which field.
        item: Item,
    },
    /// A field does not fit 32 bits.
    #[error("{item} does not fit 32 bits")]
    Overflow {
        /// Which field.
        item: Item,
    },
    /// The speed is outside 1 to 1999.
    #[error("SPEED is {value} mm/s, outside {MIN_SPEED} to {MAX_SPEED}")]
    Speed {
        /// The speed in mm/s.
        value: i32,
    },
    /// Bytes follow the last field.
    #[error("bytes follow the last digit")]
    Trailing,
    /// Longer than any command.
    #[error("{len} bytes, and no command is longer than {MAX_COMMAND_BYTES}")]
    TooLong {
        /// How many bytes.
        len: usize,
    },
}
