//! Server-sent events, from bytes: WHATWG HTML, "Interpreting an event stream". Blocks without data are told, too: they
//! may carry an id.

use std::collections::VecDeque;

use thiserror::Error;

/// The longest line, and the most data of one event.
const MAX_LINE: usize = 1024 * 1024;
const MAX_DATA: usize = 1024 * 1024;
const MAX_NAME: usize = 64;

/// The stream is not one of events.
#[derive(Clone, Debug, Eq, Error, PartialEq)]
pub(super) enum SseError {
    #[error("a line of more than {MAX_LINE} bytes")]
    Line,
    #[error("an event of more than {MAX_DATA} bytes")]
    Data,
    #[error("a line that is not UTF-8")]
    Text,
}

/// What stands between two empty lines.
#[derive(Clone, Debug, Default, Eq, PartialEq)]
pub(super) struct Block {
    pub(super) event: String,
    pub(super) id: Option<String>,
    pub(super) data: Option<String>,
}

/// Takes bytes as they come, and gives blocks.
#[derive(Debug, Default)]
pub(super) struct Parser {
    line: Vec<u8>,
    /// The last byte was a carriage return, which a line feed may follow.
    after_cr: bool,
    block: Block,
    any: bool,
    ready: VecDeque<Block>,
}

impl Parser {
    pub(super) fn next(&mut self) -> Option<Block> {
        self.ready.pop_front()
    }

    pub(super) fn push(&mut self, bytes: &[u8]) -> Result<(), SseError> {
        for &byte in bytes {
            let after_cr = std::mem::replace(&mut self.after_cr, byte == b'\r');
            match byte {
                b'\n' if after_cr => {}
                b'\n' | b'\r' => self.line()?,
                _ if self.line.len() >= MAX_LINE => return Err(SseError::Line),
                _ => self.line.push(byte),
            }
        }
        Ok(())
    }

    fn line(&mut self) -> Result<(), SseError> {
        let line = String::from_utf8(std::mem::take(&mut self.line)).map_err(|_| SseError::Text)?;
        let line = line.strip_prefix('\u{feff}').unwrap_or(&line);
        if line.is_empty() {
            if std::mem::take(&mut self.any) {
                self.ready.push_back(std::mem::take(&mut self.block));
            }
            return Ok(());
        }
        let (name, value) = line.split_once(':').unwrap_or((line, ""));
        let value = value.strip_prefix(' ').unwrap_or(value);
        match name {
            "event" if value.len() <= MAX_NAME => value.clone_into(&mut self.block.event),
            "id" if value.len() <= MAX_NAME && !value.contains('\0') => {
                self.block.id = Some(value.to_owned());
            }
            "data" => {
                let data = self.block.data.get_or_insert_default();
                if !data.is_empty() {
                    data.push('\n');
                }
                if data.len() + value.len() > MAX_DATA {
                    return Err(SseError::Data);
                }
                data.push_str(value);
            }
            // A comment, a retry time, or a field of later times.
            _ => return Ok(()),
        }
        self.any = true;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(chunks: &[&str]) -> Vec<Block> {
        let mut parser = Parser::default();
        for chunk in chunks {
            parser.push(chunk.as_bytes()).unwrap();
        }
        std::iter::from_fn(|| parser.next()).collect()
    }

    fn block(event: &str, id: Option<&str>, data: Option<&str>) -> Block {
        Block {
            event: event.to_owned(),
            id: id.map(str::to_owned),
            data: data.map(str::to_owned),
        }
    }

    #[test]
    fn blocks_are_the_same_however_the_bytes_are_cut_and_the_lines_end() {
        let text = ":hb\nid: 3-7\n\nevent: gap\nid:3-9\ndata: {\"a\":\ndata: 1}\n\n:only a comment\n\ndata\n\n";
        let expected = [
            block("", Some("3-7"), None),
            block("gap", Some("3-9"), Some("{\"a\":\n1}")),
            block("", None, Some("")),
        ];
        for text in [
            text.to_owned(),
            text.replace('\n', "\r\n"),
            text.replace('\n', "\r"),
        ] {
            assert_eq!(blocks(&[&text]), expected);
            for cut in 0..text.len() {
                let (one, other) = text.split_at(cut);
                assert_eq!(blocks(&[one, other]), expected, "cut at {cut}");
            }
        }
    }

    #[test]
    fn an_event_without_its_end_is_not_told() {
        assert_eq!(blocks(&["data: 1\n"]), []);
    }

    #[test]
    fn what_is_too_long_is_refused() {
        let mut parser = Parser::default();
        let long = vec![b'x'; MAX_LINE + 1];
        assert_eq!(parser.push(&long), Err(SseError::Line));
        let mut parser = Parser::default();
        let line = format!("data: {}\n", "x".repeat(MAX_DATA / 4));
        for _part in 0..3 {
            assert_eq!(parser.push(line.as_bytes()), Ok(()));
        }
        assert_eq!(parser.push(line.as_bytes()), Err(SseError::Data));
        assert_eq!(Parser::default().push(b"data: \xff\n"), Err(SseError::Text));
    }
}
