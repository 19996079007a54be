//! READ and WRITE of binary data (`ATR_UF`).
//!
//! INTEGER, REAL and BOOLEAN are four bytes, SHORT two, BYTE one; a STRING is its bytes. `CR` is no
//! byte. Format specifiers change only strings.

use crate::{
    host::{Input, InputEnd},
    ir::ScalarType,
    position::{Config, Elbow, Front, Wrist},
    run::ByteOrder,
    status::Status,
    text_reader::{ReadResult, ReadValue},
    value::Text,
};

/// Bytes of a number.
fn size(ty: ScalarType) -> Option<usize> {
    match ty {
        ScalarType::Integer | ScalarType::Real | ScalarType::Boolean | ScalarType::Config => {
            Some(4)
        }
        ScalarType::Short => Some(2),
        ScalarType::Byte => Some(1),
        ScalarType::Text => None,
    }
}

/// Reads one item; how many bytes are used up, and what came out.
///
/// ASSUMPTION: a STRING without a width takes as many bytes as it can hold. What is there of an item
/// whose peer is gone is used up.
pub(crate) fn read_item(
    input: Input<'_>,
    ty: ScalarType,
    length: u32,
    width: Option<usize>,
    order: ByteOrder,
) -> (usize, ReadResult) {
    let wanted = size(ty).or(width).unwrap_or(length as usize);
    let Some(bytes) = input.bytes.get(..wanted) else {
        return match input.end {
            InputEnd::Open => (0, ReadResult::Incomplete),
            InputEnd::Closed(status) if input.bytes.is_empty() => (0, ReadResult::Failed(status)),
            InputEnd::Closed(_) => {
                let status = Status::INTP_SHORT_DATA;
                (input.bytes.len(), ReadResult::Failed(status))
            }
        };
    };
    let value = match ty {
        ScalarType::Text => {
            let kept = bytes.get(..wanted.min(length as usize)).unwrap_or_default();
            ReadValue::Text(Text::from(kept))
        }
        ScalarType::Integer | ScalarType::Config => {
            ReadValue::Integer(word(bytes, order).cast_signed())
        }
        ScalarType::Boolean => ReadValue::Boolean(word(bytes, order) != 0),
        ScalarType::Real => {
            let value = f32::from_bits(word(bytes, order));
            if !value.is_finite() {
                // KAREL has no such number; the bytes are gone all the same.
                return (wanted, ReadResult::Failed(Status::INTP_ILLEGAL_DATA));
            }
            ReadValue::Real(value)
        }
        ScalarType::Short => {
            let low = u16::try_from(word(bytes, order)).unwrap_or_default();
            ReadValue::Integer(low.cast_signed().into())
        }
        ScalarType::Byte => {
            let value = i32::try_from(word(bytes, order)).unwrap_or_default();
            ReadValue::Integer(value)
        }
    };
    (wanted, ReadResult::Value(value))
}

/// Up to four bytes as a number.
fn word(bytes: &[u8], order: ByteOrder) -> u32 {
    let shift = |word: u32, byte: &u8| (word << 8) | u32::from(*byte);
    match order {
        ByteOrder::Big => bytes.iter().fold(0, shift),
        ByteOrder::Little => bytes.iter().rev().fold(0, shift),
    }
}

/// Appends a number.
pub(crate) fn number(out: &mut Vec<u8>, word: u32, ty: ScalarType, order: ByteOrder) {
    let size = size(ty).unwrap_or(4);
    match order {
        ByteOrder::Big => out.extend(word.to_be_bytes().iter().skip(4 - size)),
        ByteOrder::Little => out.extend(word.to_le_bytes().iter().take(size)),
    }
}

/// A configuration as four bytes.
///
/// ASSUMPTION: the turns of J4, J5 and J6 from the lowest byte on, then a bit each for F, D and B.
pub(crate) fn config_word(config: Config) -> u32 {
    let [j4, j5, j6] = config.turns.map(i8::cast_unsigned);
    let bits = [
        config.wrist == Wrist::Flip,
        config.elbow == Elbow::Down,
        config.front == Front::Back,
    ];
    let bits = bits
        .iter()
        .rev()
        .fold(0, |bits, bit| bits << 1 | u8::from(*bit));
    u32::from_be_bytes([bits, j6, j5, j4])
}

/// The configuration of [`config_word`].
pub(crate) fn config(word: u32) -> Config {
    let [bits, j6, j5, j4] = word.to_be_bytes();
    let pick = |bit: u8| bits & (1 << bit) != 0;
    Config {
        wrist: if pick(0) { Wrist::Flip } else { Wrist::NoFlip },
        elbow: if pick(1) { Elbow::Down } else { Elbow::Up },
        front: if pick(2) { Front::Back } else { Front::Toward },
        turns: [j4, j5, j6].map(u8::cast_signed),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8], ty: ScalarType, order: ByteOrder) -> (usize, ReadResult) {
        let end = InputEnd::Open;
        read_item(Input { bytes, end }, ty, 4, None, order)
    }

    #[test]
    fn assumed_numbers_are_big_endian_and_can_be_turned_around() {
        let bytes = [0xff, 0xff, 0xff, 0xfe, 9];
        let big = read(&bytes, ScalarType::Integer, ByteOrder::Big);
        assert_eq!(big, (4, ReadResult::Value(ReadValue::Integer(-2))));
        let little = read(&bytes, ScalarType::Integer, ByteOrder::Little);
        assert_eq!(
            little,
            (4, ReadResult::Value(ReadValue::Integer(-16_777_217)))
        );
        let short = read(&bytes, ScalarType::Short, ByteOrder::Big);
        assert_eq!(short, (2, ReadResult::Value(ReadValue::Integer(-1))));
        let byte = read(&bytes, ScalarType::Byte, ByteOrder::Big);
        assert_eq!(byte, (1, ReadResult::Value(ReadValue::Integer(255))));
    }

    #[test]
    fn an_item_waits_for_all_of_its_bytes() {
        let cut = read(&[1, 2, 3], ScalarType::Real, ByteOrder::Big);
        assert_eq!(cut, (0, ReadResult::Incomplete));
    }

    #[test]
    fn what_was_written_is_read() {
        for order in [ByteOrder::Big, ByteOrder::Little] {
            let mut out = Vec::new();
            number(&mut out, 1.5_f32.to_bits(), ScalarType::Real, order);
            let back = read(&out, ScalarType::Real, order);
            assert_eq!(back, (4, ReadResult::Value(ReadValue::Real(1.5))));
            let mut out = Vec::new();
            number(&mut out, (-3_i32).cast_unsigned(), ScalarType::Short, order);
            let back = read(&out, ScalarType::Short, order);
            assert_eq!(back, (2, ReadResult::Value(ReadValue::Integer(-3))));
        }
    }
}
