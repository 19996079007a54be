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

    /// Whether the next characters are these, and no longer word; nothing is taken.
    pub(super) fn begins_with(&mut self, text: &str) -> bool {
        let from = self.at;
        let last = text.chars().next_back();
        let found = if last.is_some_and(|c| c.is_ascii_alphanumeric()) {
            self.eat_word(text) || (text.len() <= 4 && self.eat_numbered(text))
        } else {
            self.eat(text)
        };
        self.at = from;
        found
    }

    /// Takes this word if a number follows at once: `EV50%`.
    fn eat_numbered(&mut self, word: &str) -> bool {
        let number = |rest: &[u8]| rest.get(word.len()).is_some_and(u8::is_ascii_digit);
        let found = self.sees(word) && number(self.rest());
        self.at += if found { word.len() } else { 0 };
        found
    }

    /// The words here, two at most; nothing is taken.
    pub(super) fn first_words(&mut self) -> String {
        self.skip_blanks();
        let part = |byte: &&u8| byte.is_ascii_alphabetic() || matches!(**byte, b'_' | b'.' | b' ');
        let text: Vec<u8> = self.rest().iter().take_while(part).copied().collect();
        let text = String::from_utf8_lossy(&text).into_owned();
        let words: Vec<&str> = text.split_whitespace().take(2).collect();
        words.join(" ")
    }

    /// Takes the rest of the line.
    pub(super) fn take_all(&mut self) {
        self.at = self.bytes.len();
    }

    pub(super) fn expect(&mut self, text: &str) -> Scanned<()> {
        if self.eat(text) {
            return Ok(());
        }
        Err(self.expected(&format!("`{text}`")))
    }

    /// A name: letters, digits, `_` and `-`, upper case. Programs of the field begin with `_` and `-`, too.
    pub(super) fn name(&mut self, what: &str) -> Scanned<String> {
        self.skip_blanks();
        let part = |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-');
        let length = self.rest().iter().take_while(|byte| part(byte)).count();
        let text = self.rest().get(..length).unwrap_or_default();
        if !text
            .first()
            .is_some_and(|byte| part(byte) && !byte.is_ascii_digit())
        {
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

    /// Takes what is before the next of these characters, which must be there, and that one if it is an end of the line.
    pub(super) fn up_to_any(&mut self, ends: &[u8]) -> Scanned<()> {
        let length = self.rest().iter().position(|byte| ends.contains(byte));
        let Some(length) = length else {
            self.at = self.bytes.len();
            return Err(self.expected("`}`"));
        };
        self.at += length;
        Ok(())
    }

    /// The rest of a bracket, which is taken: a comment may have brackets of its own, such as `F[5:UI[5]]`.
    pub(super) fn rest_of_bracket(&mut self) -> Scanned<&'a [u8]> {
        let mut open = 0_u32;
        let closes = |byte: &u8| {
            if *byte == b'[' {
                open += 1;
            } else if *byte == b']' {
                if open == 0 {
                    return true;
                }
                open -= 1;
            }
            is_line_end(*byte)
        };
        let length = self.rest().iter().position(closes);
        let found = length.filter(|length| self.rest().get(*length) == Some(&b']'));
        let Some(length) = found else {
            // Brackets that do not match: the first one that closes ends it.
            return self.up_to(b']');
        };
        let text = self.rest().get(..length).unwrap_or_default();
        self.at += length + 1;
        Ok(text)
    }

    /// A text up to its quote, which is taken; one between two letters belongs to the text: `'It can't move'`.
    pub(super) fn quoted(&mut self) -> Scanned<&'a [u8]> {
        let rest = self.rest();
        let line = rest.iter().take_while(|byte| !is_line_end(**byte)).count();
        let is_letter = |at: usize| rest.get(at).is_some_and(u8::is_ascii_alphabetic);
        let ends = |at: &usize| {
            let inside = at.checked_sub(1).is_some_and(is_letter) && is_letter(at + 1);
            rest.get(*at) == Some(&b'\'') && !inside
        };
        let Some(length) = (0..line).find(ends) else {
            return self.up_to(b'\'');
        };
        self.at += length + 1;
        Ok(rest.get(..length).unwrap_or_default())
    }

    /// `ON+` is `true`, `OFF-` is `false`.
    pub(super) fn edge(&mut self) -> Option<bool> {
        [("ON+", true), ("OFF-", false)]
            .into_iter()
            .find_map(|(text, rising)| self.eat(text).then_some(rising))
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

    /// Warns of what is from `from` to here.
    pub(super) fn suspicious(&mut self, from: usize, message: impl Into<String>) {
        let span = Span::new(self.start + from, self.start + self.at.max(from + 1));
        self.reports.warning(span, message);
    }

    /// Whether the rest of the line is this word.
    pub(super) fn is_only(&self, word: &str) -> bool {
        self.rest()
            .trim_ascii()
            .eq_ignore_ascii_case(word.as_bytes())
    }

    /// The words of a line that has nothing else but perhaps a list in parentheses; nothing is taken.
    pub(super) fn words(&mut self) -> Option<String> {
        self.skip_blanks();
        let text = self.rest();
        let end = text.iter().position(|byte| *byte == b'(');
        let (words, list) = text.split_at_checked(end.unwrap_or(text.len()))?;
        let part =
            |byte: &u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b' ' | b'.');
        let list = list.trim_ascii_end();
        let fits = words.first()?.is_ascii_alphabetic()
            && words.trim_ascii_end().iter().all(part)
            && (list.is_empty() || list.ends_with(b")"));
        fits.then(|| String::from_utf8_lossy(words.trim_ascii_end()).into_owned())
    }

    /// Takes what [`Scanner::words`] gave.
    pub(super) fn take_words(&mut self, words: &str) {
        self.at += words.len();
    }

    /// Reports what a controller does not take either.
    pub(super) fn refused(&mut self, what: &str, help: &str) -> Reported {
        self.take_all();
        let reported = self.wrong(0, what);
        self.reports.help(help);
        reported
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
