//! READ of text: bytes to values, one item at a time.
//!
//! A pure function over the bytes that arrived, whether more can follow, where in a line the last
//! READ stopped, and the item's format. It says what to store and how many bytes are used up, so
//! the same message gives the same values however the network splits it.

mod token;

use crate::{
    host::{Input, InputEnd},
    status::Status,
    value::Text,
};
use token::{can_become, parse};
pub(crate) use token::{parse_integer, parse_real};

/// A token longer than this is given up as illegal.
pub(crate) const MAX_TOKEN: usize = 254;

/// Where in a line the last READ of a file stopped.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum LineState {
    #[default]
    Inside,
    /// Behind a CR: an LF that follows belongs to it.
    AfterCr,
    /// The rest of the line is to be dropped.
    SkippingLine,
    /// The rest of an illegal token is to be dropped, with its delimiter.
    SkippingToken,
}

/// What a READ item asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ItemFormat {
    pub(crate) kind: ItemKind,
    /// `::n`.
    pub(crate) width: Option<usize>,
    /// `ATR_EOL`; CR and LF without it.
    pub(crate) line_end: Option<u8>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ItemKind {
    Integer {
        base: u32,
    },
    Real,
    Boolean,
    /// A string variable of this length.
    Text {
        length: usize,
    },
    /// `CR`.
    LineEnd,
}

/// What came out. `consumed` bytes are to be dropped in every case.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reading {
    pub(crate) consumed: usize,
    pub(crate) line_state: LineState,
    pub(crate) result: ReadResult,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ReadResult {
    /// More bytes are needed.
    Incomplete,
    Value(ReadValue),
    /// The item and those after it in the statement become uninitialized.
    Failed(Status),
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ReadValue {
    Integer(i32),
    Real(f32),
    Boolean(bool),
    Text(Text),
    /// Nothing to store.
    Nothing,
}

/// Reads one item from `input`.
pub(crate) fn read_item(input: Input<'_>, line_state: LineState, format: ItemFormat) -> Reading {
    let mut reader = Reader {
        bytes: input.bytes,
        end: input.end,
        offset: 0,
        line_state,
        line_end: format.line_end,
    };
    let result = if format.width == Some(0) {
        reader.poll(format.kind)
    } else {
        reader.item(format)
    };
    Reading {
        consumed: reader.offset,
        line_state: reader.line_state,
        result,
    }
}

struct Reader<'a> {
    bytes: &'a [u8],
    end: InputEnd,
    offset: usize,
    line_state: LineState,
    line_end: Option<u8>,
}

impl<'a> Reader<'a> {
    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.offset..).unwrap_or_default()
    }

    fn peek(&self) -> Option<u8> {
        self.rest().first().copied()
    }

    /// ASSUMPTION: `::0` takes no byte and never waits: an empty string and status 0 while the
    /// peer is there. Programs use it as a poll.
    fn poll(&self, kind: ItemKind) -> ReadResult {
        match (self.end, kind) {
            (InputEnd::Closed(status), _) if self.rest().is_empty() => ReadResult::Failed(status),
            (_, ItemKind::Text { .. }) => ReadResult::Value(ReadValue::Text(Text::default())),
            (_, ItemKind::LineEnd) => ReadResult::Value(ReadValue::Nothing),
            (_, ItemKind::Integer { .. } | ItemKind::Real | ItemKind::Boolean) => {
                ReadResult::Failed(Status::INTP_SHORT_DATA)
            }
        }
    }

    fn item(&mut self, format: ItemFormat) -> ReadResult {
        if !self.settle_line() {
            return self.wait_or_end();
        }
        match (format.kind, format.width) {
            (ItemKind::LineEnd, _) => self.line_end(),
            (ItemKind::Text { length }, None) => self.text_line(length),
            (_, Some(width)) => self.fixed_width(width, format.kind),
            (_, None) => self.token(format.kind),
        }
    }

    /// Finishes what the last READ left to do. `false` if that needs more bytes.
    fn settle_line(&mut self) -> bool {
        let settled = match self.line_state {
            LineState::SkippingLine => self.drop_line(),
            LineState::SkippingToken => self.drop_token(),
            LineState::Inside | LineState::AfterCr => true,
        };
        if !settled {
            return false;
        }
        if self.line_state == LineState::AfterCr
            && let Some(byte) = self.peek()
        {
            self.offset += usize::from(byte == b'\n');
            self.line_state = LineState::Inside;
        }
        true
    }

    /// Drops bytes through the next line end. `false` if it has not arrived.
    fn drop_line(&mut self) -> bool {
        self.line_state = LineState::SkippingLine;
        while let Some(byte) = self.peek() {
            self.offset += 1;
            if self.ends_line(byte) {
                return true;
            }
        }
        false
    }

    /// Drops bytes through the next delimiter. `false` if it has not arrived.
    fn drop_token(&mut self) -> bool {
        self.line_state = LineState::SkippingToken;
        while let Some(byte) = self.peek() {
            self.offset += 1;
            if self.is_delimiter(byte) {
                self.line_state = LineState::Inside;
                let _ = self.ends_line(byte);
                return true;
            }
        }
        false
    }

    /// Notes a line end that was just consumed.
    fn ends_line(&mut self, byte: u8) -> bool {
        match byte {
            _ if self.line_end.is_some() => {
                let ends = self.line_end == Some(byte);
                if ends {
                    self.line_state = LineState::Inside;
                }
                return ends;
            }
            b'\n' => self.line_state = LineState::Inside,
            b'\r' => self.line_state = LineState::AfterCr,
            _ => return false,
        }
        true
    }

    fn is_line_end(&self, byte: u8) -> bool {
        match self.line_end {
            Some(end) => byte == end,
            None => matches!(byte, b'\r' | b'\n'),
        }
    }

    fn is_delimiter(&self, byte: u8) -> bool {
        is_blank(byte) || matches!(byte, b',' | b'\r' | b'\n') || self.is_line_end(byte)
    }

    fn wait_or_end(&self) -> ReadResult {
        match self.end {
            InputEnd::Open => ReadResult::Incomplete,
            InputEnd::Closed(status) => ReadResult::Failed(status),
        }
    }

    /// `CR`: skips to the end of the line.
    fn line_end(&mut self) -> ReadResult {
        if self.rest().is_empty() {
            return self.wait_or_end();
        }
        if self.drop_line() {
            return ReadResult::Value(ReadValue::Nothing);
        }
        // What is missing of the line is this item's own business.
        self.line_state = LineState::Inside;
        self.wait_or_end()
    }

    /// A number or a BOOLEAN without a width: blanks and line ends are skipped, then everything up
    /// to a blank, comma, CR or LF is taken, and exactly one such delimiter is consumed.
    ///
    /// ASSUMPTION: known only from programs that work. They read the last field with width 1, so
    /// the delimiter of the field before it must be gone; and their clients send no line end, so a
    /// value must be complete with its delimiter. The end of the stream ends a token as well.
    fn token(&mut self, kind: ItemKind) -> ReadResult {
        while let Some(byte) = self.peek()
            && (is_blank(byte) || matches!(byte, b'\r' | b'\n') || self.is_line_end(byte))
        {
            self.offset += 1;
            let _ = self.ends_line(byte);
        }
        let rest = self.rest();
        let Some(length) = rest.iter().position(|byte| self.is_delimiter(*byte)) else {
            return self.open_token(rest, kind);
        };
        let token = rest.get(..length).unwrap_or_default();
        if token.len() > MAX_TOKEN {
            return self.illegal_token();
        }
        let Some(value) = parse(token, kind) else {
            return self.illegal_token();
        };
        let delimiter = rest.get(length).copied().unwrap_or(b' ');
        self.offset += length + 1;
        self.line_state = LineState::Inside;
        let _ = self.ends_line(delimiter);
        ReadResult::Value(value)
    }

    /// A token whose delimiter has not arrived.
    fn open_token(&mut self, token: &[u8], kind: ItemKind) -> ReadResult {
        if token.is_empty() {
            return self.wait_or_end();
        }
        let hopeless = token.len() > MAX_TOKEN || !can_become(token, kind);
        match self.end {
            InputEnd::Open if hopeless => self.illegal_token(),
            InputEnd::Open => ReadResult::Incomplete,
            InputEnd::Closed(_) => match parse(token, kind) {
                Some(value) if !hopeless => {
                    self.offset += token.len();
                    ReadResult::Value(value)
                }
                Some(_) | None => self.illegal_token(),
            },
        }
    }

    /// Illegal data: INTP-333. The token is dropped with its one delimiter, whether they arrived or not; the rest of
    /// the line is for the next READ.
    ///
    /// ASSUMPTION: no recording of a controller was available. A published program reads eight fields with eight
    /// READs and answers `a b c d e f g h` at once, while its client keeps its side open. So each READ of an illegal
    /// field must take that field and no other: if the whole line went with the first, seven READs would wait.
    fn illegal_token(&mut self) -> ReadResult {
        let _ = self.drop_token();
        ReadResult::Failed(Status::INTP_ILLEGAL_DATA)
    }

    /// `::n`: exactly n bytes, whatever they are, legal or not.
    fn fixed_width(&mut self, width: usize, kind: ItemKind) -> ReadResult {
        if width > MAX_TOKEN {
            return ReadResult::Failed(Status::INTP_ARGUMENT);
        }
        let Some(field) = self.rest().get(..width) else {
            return match self.end {
                InputEnd::Open => ReadResult::Incomplete,
                InputEnd::Closed(status) => {
                    let nothing = self.rest().is_empty();
                    self.offset = self.bytes.len();
                    ReadResult::Failed(if nothing {
                        status
                    } else {
                        Status::INTP_SHORT_DATA
                    })
                }
            };
        };
        let is_text = matches!(kind, ItemKind::Text { .. });
        let trimmed = if is_text { field } else { field.trim_ascii() };
        self.offset += width;
        parse(trimmed, kind).map_or(
            ReadResult::Failed(Status::INTP_ILLEGAL_DATA),
            ReadResult::Value,
        )
    }

    /// A string without a width: to the end of the line, cut to the variable's length.
    fn text_line(&mut self, length: usize) -> ReadResult {
        let rest = self.rest();
        let line = rest.iter().position(|byte| self.is_line_end(*byte));
        let taken = match (line, self.end) {
            (Some(end), _) => {
                self.offset += end + 1;
                let _ = rest.get(end).map(|byte| self.ends_line(*byte));
                end
            }
            // As long as any string can be: the rest of the line does not matter any more.
            (None, _) if rest.len() >= MAX_TOKEN => {
                self.offset += rest.len();
                self.line_state = LineState::SkippingLine;
                rest.len()
            }
            (None, InputEnd::Open) => return ReadResult::Incomplete,
            (None, InputEnd::Closed(status)) if rest.is_empty() => {
                return ReadResult::Failed(status);
            }
            (None, InputEnd::Closed(_)) => {
                self.offset += rest.len();
                rest.len()
            }
        };
        let text = rest.get(..taken.min(length)).unwrap_or_default();
        ReadResult::Value(ReadValue::Text(text.into()))
    }
}

fn is_blank(byte: u8) -> bool {
    matches!(byte, b' ' | b'\t')
}

#[cfg(test)]
mod tests;
