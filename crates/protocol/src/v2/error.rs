use thiserror::Error;

/// Why a value cannot be written on the wire. Nothing is clamped.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum ValueError {
    /// A value is NaN or infinite.
    #[error("{item} is {value}, which is not a finite number")]
    NotFinite {
        /// Which value.
        item: &'static str,
        /// The value, in mm or degrees.
        value: f64,
    },
    /// A value in thousandths does not fit the wire.
    #[error(
        "{item} is {value:e}, outside the wire's -2147483.647 to 2147483.647 (32-bit thousandths)"
    )]
    TooLarge {
        /// Which value.
        item: &'static str,
        /// The value, in mm or degrees.
        value: f64,
    },
    /// A whole number is outside its range.
    #[error("{item} is {value}, not a whole number of {min} to {max}")]
    OutOfRange {
        /// Which value.
        item: &'static str,
        /// The value.
        value: i64,
        /// The smallest legal one.
        min: i64,
        /// The largest legal one.
        max: i64,
    },
}

/// Why a line is none of the wire's.
#[derive(Clone, Copy, Debug, Eq, Error, PartialEq)]
pub enum DecodeError {
    /// A byte that no line contains.
    #[error("byte {at} is {byte:#04x}, which no line contains")]
    Byte {
        /// Where, from 0.
        at: usize,
        /// The byte.
        byte: u8,
    },
    /// The last token is not a checksum in its canonical form.
    #[error("the line does not end in a checksum")]
    NoChecksum,
    /// The checksum is another one.
    #[error("the checksum is {received}, and the line's is {computed}")]
    Checksum {
        /// What the line says.
        received: u32,
        /// What its bytes give.
        computed: u32,
    },
    /// The first token is none of those expected here.
    #[error("the line is none of those expected: {expected}")]
    Kind {
        /// What may stand there.
        expected: &'static str,
    },
    /// A token is missing, or there are two blanks.
    #[error("{item} is missing")]
    Missing {
        /// Which token.
        item: &'static str,
    },
    /// A token is not an integer in its canonical form.
    #[error("{item} is not a number in its canonical form, or not of 32 bits")]
    NotANumber {
        /// Which token.
        item: &'static str,
    },
    /// A number is outside its range.
    #[error("{item} is {value}, not {min} to {max}")]
    OutOfRange {
        /// Which token.
        item: &'static str,
        /// The number.
        value: i32,
        /// The smallest legal one.
        min: i32,
        /// The largest legal one.
        max: i32,
    },
    /// A token is not one of the letters that may stand there.
    #[error("{item} is not {expected}")]
    Letter {
        /// Which token.
        item: &'static str,
        /// What may stand there.
        expected: &'static str,
    },
    /// More follows than the line has tokens.
    #[error("the line has more tokens than it should")]
    Trailing,
}
