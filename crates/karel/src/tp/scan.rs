//! Reading the characters of one line.

use crate::{diagnostic::Reports, parser::Reported, span::Span};

/// A position in a line; every method skips blanks first.
pub(super) struct Scanner<'a> {
    bytes: &'a [u8],
    /// Where the line starts in its file.
    start: usize,
    at: usize,
    pub(super) reports: &'a mut Reports,
}

pub(super) type Scanned<T> = Result<T, Reported>;

impl<'a> Scanner<'a> {
    pub(super) fn new(bytes: &'a [u8], start: usize, reports: &'a mut Reports) -> Self {
        Self {
            bytes,
            start,
            at: 0,
            reports,
        }
    }

    fn rest(&self) -> &'a [u8] {
        self.bytes.get(self.at..).unwrap_or_default()
    }

    pub(super) fn skip_blanks(&mut self) {
        while self.rest().first().is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    pub(super) fn at_end(&mut self) -> bool {
        self.skip_blanks();
        self.rest().is_empty()
    }

    /// Whether the next characters are these, in any case; nothing is taken.
    pub(super) fn sees(&mut self, text: &str) -> bool {
        self.skip_blanks();
        let found = self.rest().get(..text.len());
        found.is_some_and(|found| found.eq_ignore_ascii_case(text.as_bytes()))
    }

    /// Takes these characters if they are next.
    pub(super) fn eat(&mut self, text: &str) -> bool {
        let found = self.sees(text);
        self.at += if found { text.len() } else { 0 };
        found
    }

    /// Takes this word if it is next and no longer.
    pub(super) fn eat_word(&mut self, word: &str) -> bool {
        let longer = |byte: &u8| byte.is_ascii_alphanumeric() || *byte == b'_';
        let found = self.sees(word) && !self.rest().get(word.len()).is_some_and(longer);
        self.at += if found { word.len() } else { 0 };
        found
    }

    pub(super) fn expect(&mut self, text: &str) -> Scanned<()> {
        if self.eat(text) {
            return Ok(());
        }
        Err(self.expected(&format!("`{text}`")))
    }

    /// A name: letters, digits, `_` and `-`, upper case.
    pub(super) fn name(&mut self, what: &str) -> Scanned<String> {
        self.skip_blanks();
        let part = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-');
        let length = self.rest().iter().take_while(|byte| part(byte)).count();
        let text = self.rest().get(..length).unwrap_or_default();
        if !text.first().is_some_and(u8::is_ascii_alphabetic) {
            return Err(self.expected(what));
        }
        self.at += length;
        Ok(String::from_utf8_lossy(text).to_ascii_uppercase())
    }

    /// A number as it is written: digits, perhaps with a sign and a point.
    pub(super) fn number(&mut self, what: &str) -> Scanned<&'a str> {
        self.skip_blanks();
        let rest = self.rest();
        let sign = usize::from(matches!(rest.first(), Some(b'-' | b'+')));
        let digits = rest.iter().skip(sign);
        let length = digits
            .take_while(|byte| byte.is_ascii_digit() || **byte == b'.')
            .count();
        let text = rest.get(..sign + length).unwrap_or_default();
        let text = std::str::from_utf8(text).unwrap_or_default();
        if length == 0 {
            return Err(self.expected(what));
        }
        self.at += text.len();
        Ok(text)
    }

    /// A whole number.
    pub(super) fn integer(&mut self, what: &str) -> Scanned<i32> {
        let from = {
            self.skip_blanks();
            self.at
        };
        let text = self.number(what)?;
        text.parse()
            .map_err(|_| self.wrong(from, format!("`{text}` is not {what}")))
    }

    /// Where the next character is.
    pub(super) fn here(&mut self) -> usize {
        self.skip_blanks();
        self.at
    }

    /// What is between here and the character `end` of the same line, which is taken.
    pub(super) fn up_to(&mut self, end: u8) -> Scanned<&'a [u8]> {
        let stops = |byte: &u8| *byte == end || is_line_end(*byte);
        let length = self.rest().iter().position(stops);
        let Some(length) = length.filter(|length| self.rest().get(*length) == Some(&end)) else {
            return Err(self.expected(&format!("`{}`", char::from(end))));
        };
        let text = self.rest().get(..length).unwrap_or_default();
        self.at += length + 1;
        Ok(text)
    }

    /// What may be the path of a system variable, up to anything else.
    pub(super) fn path_text(&mut self) -> String {
        self.skip_blanks();
        let mut depth = 0_i32;
        let part = |byte: &&u8| {
            depth += i32::from(**byte == b'[') - i32::from(**byte == b']');
            byte.is_ascii_alphanumeric()
                || matches!(**byte, b'$' | b'_' | b'.' | b'[' | b']')
                || (depth > 0 && **byte == b',')
        };
        let length = self.rest().iter().take_while(part).count();
        let text = self.rest().get(..length).unwrap_or_default();
        self.at += length;
        String::from_utf8_lossy(text).into_owned()
    }

    pub(super) fn expected(&mut self, what: &str) -> Reported {
        self.skip_blanks();
        let rest = self.rest();
        let found = if rest.is_empty() {
            "the end of the line".to_owned()
        } else {
            let line = rest.iter().take_while(|byte| !is_line_end(**byte));
            let text: String = line.take(20).map(|byte| char::from(*byte)).collect();
            format!("`{}`", text.trim_end())
        };
        self.wrong(self.at, format!("expected {what}, found {found}"))
    }

    /// Reports what is wrong from `from` to here.
    pub(super) fn wrong(&mut self, from: usize, message: impl Into<String>) -> Reported {
        let end = self.at.max(from + 1).min(self.bytes.len().max(from + 1));
        let span = Span::new(self.start + from, self.start + end);
        self.reports.error(span, message);
        Reported
    }

    /// Reports the whole line.
    pub(super) fn unsupported(&mut self, what: &str) -> Reported {
        self.at = self.bytes.len();
        self.wrong(0, format!("{what} is not supported yet"))
    }
}

fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\r' | b'\n')
}
