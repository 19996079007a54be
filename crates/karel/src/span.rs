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

/// A program's source and the files that it includes, one behind the other.
#[derive(Clone, Debug)]
pub(crate) struct Source {
    pub(crate) bytes: Vec<u8>,
    files: Vec<File>,
}

#[derive(Clone, Debug)]
struct File {
    name: Arc<str>,
    start: u32,
    end: u32,
    line_starts: Vec<u32>,
}

impl Source {
    pub(crate) fn new(bytes: &[u8], file_name: &str) -> Source {
        let mut source = Source {
            bytes: Vec::new(),
            files: Vec::new(),
        };
        let _program = source.add(bytes, file_name);
        source
    }

    /// Adds an included file and returns where it is. CR LF becomes LF: the same text has the same columns.
    pub(crate) fn add(&mut self, bytes: &[u8], file_name: &str) -> Span {
        if !self.files.is_empty() {
            // The end of one file is not the start of the next.
            self.bytes.push(b'\n');
        }
        let start = self.bytes.len();
        for line in bytes.split_inclusive(|byte| *byte == b'\n') {
            if let Some(line) = line.strip_suffix(b"\r\n") {
                self.bytes.extend_from_slice(line);
                self.bytes.push(b'\n');
            } else {
                self.bytes.extend_from_slice(line);
            }
        }
        let added = self.bytes.get(start..).unwrap_or_default();
        let after_line_ends = added
            .iter()
            .enumerate()
            .filter(|(_, byte)| **byte == b'\n')
            .map(|(offset, _)| saturating_u32(start + offset + 1))
            .collect::<Vec<u32>>();
        let span = Span::new(start, self.bytes.len());
        self.files.push(File {
            name: file_name.into(),
            start: span.start,
            end: span.end,
            line_starts: std::iter::once(span.start).chain(after_line_ends).collect(),
        });
        span
    }

    /// The program itself, without what it includes.
    pub(crate) fn program(&self) -> Span {
        self.files.first().map_or(Span::default(), |file| Span {
            start: file.start,
            end: file.end,
        })
    }

    fn file(&self, offset: u32) -> &File {
        let after = self.files.partition_point(|file| file.start <= offset);
        let file = self.files.get(after.wrapping_sub(1));
        file.expect("the program is a file that starts at 0")
    }

    /// Name of the file, line and column, both from 1; columns count bytes.
    pub(crate) fn position(&self, offset: u32) -> (Arc<str>, u32, u32) {
        let file = self.file(offset);
        let line = file.line_starts.partition_point(|start| *start <= offset);
        let start = file.line_starts.get(line.wrapping_sub(1));
        let start = start.copied().unwrap_or(file.start);
        (file.name.clone(), saturating_u32(line), offset - start + 1)
    }

    /// The line within its file.
    pub(crate) fn line(&self, span: Span) -> u32 {
        self.position(span.start).1
    }

    /// The bytes of the line at `offset`, without its end.
    pub(crate) fn line_bytes(&self, offset: u32) -> &[u8] {
        let file = self.file(offset);
        let next = file.line_starts.partition_point(|start| *start <= offset);
        let start = file.line_starts.get(next.wrapping_sub(1));
        let start = start.copied().unwrap_or(file.start);
        let end = file.line_starts.get(next).copied().unwrap_or(file.end);
        self.bytes
            .get(start as usize..end as usize)
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
            let d = source.bytes.iter().position(|byte| *byte == b'd');
            let offset = u32::try_from(d.unwrap()).unwrap();
            assert_eq!(source.position(offset), ("t.kl".into(), 2, 2));
            assert_eq!(source.line_bytes(0), b"ab");
            assert_eq!(source.line_bytes(offset), b"cd");
            let end = source.program().end;
            assert_eq!(source.line_bytes(end), b"");
        }
    }

    #[test]
    fn an_included_file_has_lines_of_its_own() {
        let mut source = Source::new(b"ab\ncd", "t.kl");
        let included = source.add(b"x\ny", "u.kl");
        let y = included.start + 2;
        assert_eq!(source.position(y), ("u.kl".into(), 2, 1));
        assert_eq!(source.line_bytes(y), b"y");
        assert_eq!(source.position(source.program().end).0, "t.kl".into());
        assert_eq!(source.line_bytes(source.program().end), b"cd");
    }
}
