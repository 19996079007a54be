use thiserror::Error;

/// The longest line read, without its end.
pub const MAX_LINE_BYTES: usize = 512;

/// The modulus of the checksum: a prime, so that no change of one byte is lost in the multiplications.
const MODULUS: u32 = 65_521;

/// The checksum over the bytes before a line's last blank: `c = (c * 31 + b) mod 65521`.
#[must_use]
pub fn checksum(bytes: &[u8]) -> u32 {
    bytes
        .iter()
        .fold(0, |sum, byte| (sum * 31 + u32::from(*byte)) % MODULUS)
}

/// Takes a stream apart into lines, byte by byte. CR, LF and CR LF end a line; empty lines are skipped.
#[derive(Clone, Debug, Default)]
pub struct LineDecoder {
    line: Vec<u8>,
    state: State,
}

#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
enum State {
    #[default]
    Filling,
    /// The line in hand was given out; the next byte begins another.
    Given,
    /// The line is too long; what is left of it is dropped.
    Skipping,
}

/// A line longer than [`MAX_LINE_BYTES`]. The rest of it is dropped.
#[derive(Clone, Copy, Debug, Eq, Error, PartialEq)]
#[error("a line is longer than {MAX_LINE_BYTES} bytes")]
pub struct LineTooLong;

impl LineDecoder {
    /// Takes the next byte of the stream; gives the line it ends, if it ends one.
    ///
    /// # Errors
    /// The byte makes the line too long. That is said once a line.
    pub fn push(&mut self, byte: u8) -> Result<Option<&[u8]>, LineTooLong> {
        if self.state == State::Given {
            self.line.clear();
            self.state = State::Filling;
        }
        if byte == b'\r' || byte == b'\n' {
            let skipped = self.state == State::Skipping;
            self.state = State::Given;
            let line = (!skipped && !self.line.is_empty()).then_some(&*self.line);
            return Ok(line);
        }
        if self.state == State::Skipping {
            return Ok(None);
        }
        if self.line.len() == MAX_LINE_BYTES {
            self.line.clear();
            self.state = State::Skipping;
            return Err(LineTooLong);
        }
        self.line.push(byte);
        Ok(None)
    }

    /// How many bytes of an unfinished line have come.
    #[must_use]
    pub fn pending(&self) -> usize {
        match self.state {
            State::Filling => self.line.len(),
            State::Given | State::Skipping => 0,
        }
    }
}

/// A line that is being written.
#[derive(Debug)]
pub(super) struct LineWriter(Vec<u8>);

impl LineWriter {
    pub(super) fn new(kind: &str) -> Self {
        let mut line = Vec::with_capacity(128);
        line.extend_from_slice(kind.as_bytes());
        Self(line)
    }

    pub(super) fn word(&mut self, word: &str) -> &mut Self {
        self.0.push(b' ');
        self.0.extend_from_slice(word.as_bytes());
        self
    }

    pub(super) fn integer(&mut self, value: impl Into<i64>) -> &mut Self {
        self.word(&value.into().to_string())
    }

    pub(super) fn flag(&mut self, value: bool) -> &mut Self {
        self.word(if value { "1" } else { "0" })
    }

    /// The line with its checksum and its end, CR LF.
    pub(super) fn finish(mut self) -> Vec<u8> {
        let sum = checksum(&self.0);
        let _line = self.integer(sum);
        self.0.extend_from_slice(b"\r\n");
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(decoder: &mut LineDecoder, bytes: &[u8]) -> Vec<Result<Vec<u8>, LineTooLong>> {
        bytes
            .iter()
            .filter_map(|byte| match decoder.push(*byte) {
                Ok(line) => line.map(|line| Ok(line.to_vec())),
                Err(error) => Some(Err(error)),
            })
            .collect()
    }

    #[test]
    fn every_line_end_ends_a_line_and_empty_lines_are_skipped() {
        let mut decoder = LineDecoder::default();
        let seen = lines(&mut decoder, b"\r\na\rb\nc\r\n\n\r\rd");
        let expected: Vec<_> = ["a", "b", "c"].map(|line| Ok(line.into())).to_vec();
        assert_eq!(seen, expected);
        assert_eq!(decoder.pending(), 1);
        assert_eq!(lines(&mut decoder, b"\n"), [Ok(b"d".to_vec())]);
        assert_eq!(decoder.pending(), 0);
    }

    #[test]
    fn a_line_of_the_full_length_passes_and_a_longer_one_is_said_once() {
        let mut decoder = LineDecoder::default();
        let full = [b'x'; MAX_LINE_BYTES];
        assert_eq!(lines(&mut decoder, &full), []);
        assert_eq!(lines(&mut decoder, b"\n"), [Ok(full.to_vec())]);
        let long = [b'x'; 3 * MAX_LINE_BYTES];
        assert_eq!(lines(&mut decoder, &long), [Err(LineTooLong)]);
        assert_eq!(lines(&mut decoder, b"\nnext\n"), [Ok(b"next".to_vec())]);
    }

    #[test]
    fn the_checksum_is_the_one_worked_out_by_hand() {
        assert_eq!(checksum(b""), 0);
        assert_eq!(checksum(b"X"), 88);
        // 83 * 31 * 31 + 32 * 31 + 49 = 80804; minus 65521.
        assert_eq!(checksum(b"S 1"), 15_283);
    }
}
