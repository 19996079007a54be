use std::fmt;
use std::ops::Deref;

/// The longest command: six numbers of 11 characters, a speed of 4, the digit, and 7 blanks.
pub const MAX_COMMAND_BYTES: usize = 6 * 11 + 4 + 1 + 7;

/// An encoded command, without a heap allocation.
#[derive(Clone, Copy, Eq, PartialEq)]
pub struct CommandBytes {
    bytes: [u8; MAX_COMMAND_BYTES],
    len: usize,
}

impl CommandBytes {
    pub(crate) fn new() -> Self {
        Self {
            bytes: [0; MAX_COMMAND_BYTES],
            len: 0,
        }
    }

    /// Appends one byte. What does not fit is dropped: the buffer is sized for the longest command there is.
    pub(crate) fn push(&mut self, byte: u8) {
        if let Some(slot) = self.bytes.get_mut(self.len) {
            *slot = byte;
            self.len += 1;
        }
        debug_assert!(self.len <= MAX_COMMAND_BYTES);
    }

    /// Appends a decimal integer, with a minus sign where it is negative.
    pub(crate) fn push_integer(&mut self, value: i32) {
        if value < 0 {
            self.push(b'-');
        }
        let mut digits = [0_u8; 10];
        let mut rest = value.unsigned_abs();
        let mut count = 0;
        for slot in digits.iter_mut().rev() {
            *slot = b'0' + u8::try_from(rest % 10).unwrap_or(0);
            rest /= 10;
            count += 1;
            if rest == 0 {
                break;
            }
        }
        for digit in digits.iter().skip(digits.len() - count) {
            self.push(*digit);
        }
    }
}

impl Deref for CommandBytes {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }
}

impl AsRef<[u8]> for CommandBytes {
    fn as_ref(&self) -> &[u8] {
        self
    }
}

impl fmt::Debug for CommandBytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "CommandBytes(\"{}\")", self.escape_ascii())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn integers_are_written_in_decimal() {
        for value in [0, 1, -1, 9, 10, 1999, i32::MAX, i32::MIN, -180_000] {
            let mut bytes = CommandBytes::new();
            bytes.push_integer(value);
            assert_eq!(&*bytes, value.to_string().as_bytes());
        }
    }
}
