//! Byte ranges of a source, and the source's lines.

use std::sync::Arc;

/// A range of bytes of one source: `start` included, `end` excluded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub(crate) struct Span {
    pub(crate) start: u32,
    pub(crate) end: u32,
}

impl Span {
    pub(crate) fn new(start: usize, end: usize) -> Span {
        Span {
            start: saturating_u32(start),
            end: saturating_u32(end),
        }
    }

    /// From the start of `self` to the end of `other`.
    pub(crate) fn to(self, other: Span) -> Span {
        Span {
            start: self.start,
            end: other.end.max(self.start),
        }
    }

    pub(crate) fn start(self) -> usize {
        self.start as usize
    }

    pub(crate) fn end(self) -> usize {
        self.end as usize
    }
}

/// The parser refuses sources that do not fit, so nothing saturates in practice.
fn saturating_u32(offset: usize) -> u32 {
    u32::try_from(offset).unwrap_or(u32::MAX)
}

/// A source with the starts of its lines.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) file_name: Arc<str>,
    pub(crate) bytes: Arc<[u8]>,
    line_starts: Vec<u32>,
}

impl Source {
    pub(crate) fn new(bytes: &[u8], file_name: &str) -> Source {
        let after_line_ends = bytes
            .iter()
            .enumerate()
            .filter(|(_, byte)| **byte == b'\n')
            .map(|(offset, _)| saturating_u32(offset + 1));
        Source {
            file_name: file_name.into(),
            bytes: bytes.into(),
            line_starts: std::iter::once(0).chain(after_line_ends).collect(),
        }
    }

    /// Line and column, both from 1; columns count bytes.
    pub(crate) fn position(&self, offset: u32) -> (u32, u32) {
        let line = self.line_starts.partition_point(|start| *start <= offset);
        let start = self
            .line_starts
            .get(line.wrapping_sub(1))
            .copied()
            .unwrap_or(0);
        (saturating_u32(line), offset - start + 1)
    }

    pub(crate) fn line(&self, span: Span) -> u32 {
        self.position(span.start).0
    }

    /// The bytes of a line, counted from 1, without its end.
    pub(crate) fn line_bytes(&self, line: u32) -> &[u8] {
        let index = line.saturating_sub(1) as usize;
        let start = self
            .line_starts
            .get(index)
            .map_or(self.bytes.len(), |start| *start as usize);
        let end = self
            .line_starts
            .get(index + 1)
            .map_or(self.bytes.len(), |end| *end as usize);
        self.bytes
            .get(start..end)
            .unwrap_or_default()
            .trim_ascii_end()
    }

    pub(crate) fn slice(&self, span: Span) -> &[u8] {
        self.bytes.get(span.start()..span.end()).unwrap_or_default()
    }
}

/// Latin-1 bytes as text.
pub(crate) fn latin1(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| char::from(*byte)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_from_one_with_either_line_end() {
        for text in ["ab\ncd\n", "ab\r\ncd\r\n"] {
            let source = Source::new(text.as_bytes(), "t.kl");
            let offset = u32::try_from(text.find('d').unwrap()).unwrap();
            assert_eq!(source.position(offset), (2, 2));
            assert_eq!(source.line_bytes(1), b"ab");
            assert_eq!(source.line_bytes(2), b"cd");
            assert_eq!(source.line_bytes(9), b"");
        }
    }
}
