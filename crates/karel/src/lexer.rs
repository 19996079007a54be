//! Bytes to tokens.
//!
//! KAREL ends statements at line ends, so the lexer decides which line ends count: not one after
//! `&`, inside parentheses or brackets, after a binary operator, `,` or `=`, nor one before THEN
//! or DO. A parenthesis that is never closed ends at the next word that starts a statement.

use crate::{
    diagnostic::Reports,
    span::{Source, Span},
    token::{Keyword, Symbol, Token, TokenKind},
};

/// Splits one file of `source` into tokens; the last is always [`TokenKind::EndOfFile`].
pub(crate) fn lex(source: &Source, file: Span, reports: &mut Reports) -> Vec<Token> {
    let marked = source.slice(file).starts_with(UTF8_MARK);
    let mark = if marked { UTF8_MARK.len() } else { 0 };
    let mut lexer = Lexer {
        bytes: source.bytes.get(..file.end()).unwrap_or_default(),
        offset: file.start() + mark,
        depth: 0,
        tokens: Vec::new(),
        reports,
    };
    while lexer.offset < lexer.bytes.len() && !lexer.reports.is_full() {
        lexer.step();
    }
    let end = file.end();
    lexer.tokens.push(Token {
        kind: TokenKind::LineEnd,
        span: Span::new(end, end),
    });
    lexer.tokens.push(Token {
        kind: TokenKind::EndOfFile,
        span: Span::new(end, end),
    });
    lexer.tokens
}

/// What some editors put in front of a text.
const UTF8_MARK: &[u8] = b"\xEF\xBB\xBF";

/// More than any controller takes.
const MAX_NAME: usize = 128;

/// Tokens of a line that may end with the sign of an edge.
const MAX_EDGE_LINE: usize = 64;

struct Lexer<'a> {
    bytes: &'a [u8],
    offset: usize,
    /// Open parentheses and brackets.
    depth: usize,
    tokens: Vec<Token>,
    reports: &'a mut Reports,
}

impl Lexer<'_> {
    fn peek(&self, ahead: usize) -> Option<u8> {
        self.bytes.get(self.offset + ahead).copied()
    }

    fn rest(&self) -> &[u8] {
        self.bytes.get(self.offset..).unwrap_or_default()
    }

    fn step(&mut self) {
        let start = self.offset;
        let Some(byte) = self.peek(0) else { return };
        match byte {
            // Form feed and the end mark of old editors are blanks.
            b' ' | b'\t' | b'\r' | 0x0C | 0x1A => self.offset += 1,
            b'\n' => self.line_end(),
            b'-' if self.peek(1) == Some(b'-') => self.skip_to_line_end(),
            b'&' => self.continuation(),
            b'%' => self.directive(),
            b'\'' => self.text(),
            b'A'..=b'Z' | b'a'..=b'z' | b'$' | b'_' => self.word(),
            b'0'..=b'9' => self.number(),
            b'.' if self.peek(1).is_some_and(|next| next.is_ascii_digit()) => self.number(),
            _ => match Symbol::ALL
                .iter()
                .find(|(text, _)| self.rest().starts_with(text.as_bytes()))
            {
                Some((text, symbol)) => {
                    self.offset += text.len();
                    self.symbol(*symbol, start);
                }
                None => self.unknown(byte),
            },
        }
    }

    fn push(&mut self, kind: TokenKind, start: usize) {
        self.tokens.push(Token {
            kind,
            span: Span::new(start, self.offset),
        });
    }

    fn symbol(&mut self, symbol: Symbol, start: usize) {
        if matches!(symbol, Symbol::LeftParen | Symbol::LeftBracket) {
            self.depth += 1;
        } else if matches!(symbol, Symbol::RightParen | Symbol::RightBracket) {
            self.depth = self.depth.saturating_sub(1);
        }
        self.push(TokenKind::Symbol(symbol), start);
    }

    fn line_end(&mut self) {
        let start = self.offset;
        self.offset += 1;
        let joins = self
            .tokens
            .last()
            .is_some_and(|last| continues_line(last.kind) && !self.is_edge(last.kind));
        if self.depth == 0 && !joins {
            self.push(TokenKind::LineEnd, start);
        }
    }

    /// `WAIT FOR DIN[1]+`: a sign that ends the line and no operator.
    fn is_edge(&self, last: TokenKind) -> bool {
        if !matches!(last, TokenKind::Symbol(Symbol::Plus | Symbol::Minus)) {
            return false;
        }
        let mut before = self.tokens.iter().rev().skip(1);
        let bracket = before.next().map(|token| token.kind);
        bracket == Some(TokenKind::Symbol(Symbol::RightBracket))
            && before
                .take(MAX_EDGE_LINE)
                .take_while(|token| token.kind != TokenKind::LineEnd)
                .last()
                .is_some_and(|first| {
                    matches!(
                        first.kind,
                        TokenKind::Keyword(Keyword::Wait | Keyword::Until | Keyword::Move)
                    )
                })
    }

    fn skip_to_line_end(&mut self) {
        while self.peek(0).is_some_and(|byte| byte != b'\n') {
            self.offset += 1;
        }
    }

    /// `&` joins the next line; blanks and a comment may follow it.
    fn continuation(&mut self) {
        let start = self.offset;
        self.offset += 1;
        while matches!(self.peek(0), Some(b' ' | b'\t' | b'\r')) {
            self.offset += 1;
        }
        if self.rest().starts_with(b"--") {
            self.skip_to_line_end();
        }
        match self.peek(0) {
            Some(b'\n') => self.offset += 1,
            None => {}
            Some(_) => self.reports.error_with_help(
                Span::new(start, start + 1),
                "`&` is not the last token of its line",
                "`&` joins a line with the next one; use AND for the logical operator",
            ),
        }
    }

    fn directive(&mut self) {
        let start = self.offset;
        while let Some(byte) = self.peek(0) {
            if byte == b'\n' || self.rest().starts_with(b"--") {
                break;
            }
            self.offset += 1;
        }
        let text = self
            .bytes
            .get(start..self.offset)
            .unwrap_or_default()
            .trim_ascii_end();
        let span = Span::new(start, start + text.len());
        self.tokens.push(Token {
            kind: TokenKind::Directive,
            span,
        });
    }

    fn text(&mut self) {
        let start = self.offset;
        self.offset += 1;
        loop {
            match self.peek(0) {
                Some(b'\'') if self.peek(1) == Some(b'\'') => self.offset += 2,
                Some(b'\'') => {
                    self.offset += 1;
                    break;
                }
                None | Some(b'\n') => {
                    self.reports.error_with_help(
                        Span::new(start, self.offset),
                        "this string is not closed on its line",
                        "end it with `'`; a quote inside a string is written `''`",
                    );
                    break;
                }
                Some(_) => self.offset += 1,
            }
        }
        self.push(TokenKind::Text, start);
    }

    fn word(&mut self) {
        let start = self.offset;
        while self
            .peek(0)
            .is_some_and(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'$'))
        {
            self.offset += 1;
        }
        let word = self.bytes.get(start..self.offset).unwrap_or_default();
        let Some(keyword) = Keyword::find(word) else {
            return self.name(start);
        };
        if self.depth > 0 && keyword.is_structural() {
            self.depth = 0;
            self.tokens.push(Token {
                kind: TokenKind::LineEnd,
                span: Span::new(start, start),
            });
        }
        if matches!(keyword, Keyword::Then | Keyword::Do) {
            while self
                .tokens
                .last()
                .is_some_and(|last| last.kind == TokenKind::LineEnd)
            {
                let _ = self.tokens.pop();
            }
        }
        self.push(TokenKind::Keyword(keyword), start);
    }

    fn name(&mut self, start: usize) {
        let end = self.offset.min(start + MAX_NAME);
        let span = Span::new(start, end);
        if end < self.offset {
            let message = format!("a name has at most {MAX_NAME} characters");
            self.reports.error(span, message);
        }
        // Cut, so that no later message repeats all of it.
        self.tokens.push(Token {
            kind: TokenKind::Name,
            span,
        });
    }

    /// `12`, `1.5`, `1.`, `.5`, `1E-3`; the `1` of `1..5` stays alone.
    fn number(&mut self) {
        let start = self.offset;
        let mut kind = TokenKind::Integer;
        self.digits();
        if self.peek(0) == Some(b'.') && self.peek(1) != Some(b'.') {
            kind = TokenKind::Real;
            self.offset += 1;
            self.digits();
        }
        if matches!(self.peek(0), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(self.peek(1), Some(b'+' | b'-')));
            if self
                .peek(1 + sign)
                .is_some_and(|byte| byte.is_ascii_digit())
            {
                kind = TokenKind::Real;
                self.offset += 1 + sign;
                self.digits();
            }
        }
        self.push(kind, start);
    }

    fn digits(&mut self) {
        while self.peek(0).is_some_and(|byte| byte.is_ascii_digit()) {
            self.offset += 1;
        }
    }

    fn unknown(&mut self, byte: u8) {
        let span = Span::new(self.offset, self.offset + 1);
        self.offset += 1;
        let message = if byte.is_ascii_graphic() {
            format!("`{}` means nothing in KAREL", char::from(byte))
        } else {
            format!("the byte 0x{byte:02X} means nothing in KAREL")
        };
        match byte {
            b'"' => self.double_quoted(span, &message),
            b'{' | b'}' | b'!' => {
                self.reports
                    .error_with_help(span, message, "comments start with `--`");
            }
            _ => self.reports.error(span, message),
        }
    }
}

impl Lexer<'_> {
    /// A string in the wrong quotes: one message, and a string token in its place.
    fn double_quoted(&mut self, quote: Span, message: &str) {
        self.reports
            .error_with_help(quote, message, "strings stand in `'`");
        let line_rest = self
            .rest()
            .split(|byte| *byte == b'\n')
            .next()
            .unwrap_or_default();
        if let Some(length) = line_rest.iter().position(|byte| *byte == b'"') {
            self.offset += length + 1;
            self.push(TokenKind::Text, quote.start());
        }
    }
}

/// Whether a line that ends with this token goes on in the next line.
fn continues_line(kind: TokenKind) -> bool {
    match kind {
        TokenKind::Symbol(symbol) => match symbol {
            Symbol::ApproxEqual
            | Symbol::LessEqual
            | Symbol::GreaterEqual
            | Symbol::NotEqual
            | Symbol::Less
            | Symbol::Greater
            | Symbol::Equal
            | Symbol::Plus
            | Symbol::Minus
            | Symbol::Star
            | Symbol::Slash
            | Symbol::At
            | Symbol::Hash
            | Symbol::Comma => true,
            Symbol::DoubleColon
            | Symbol::Colon
            | Symbol::DoubleDot
            | Symbol::Dot
            | Symbol::Semicolon
            | Symbol::LeftParen
            | Symbol::RightParen
            | Symbol::LeftBracket
            | Symbol::RightBracket
            | Symbol::Bar => false,
        },
        TokenKind::Keyword(keyword) => {
            matches!(
                keyword,
                Keyword::And | Keyword::Or | Keyword::Div | Keyword::Mod
            )
        }
        TokenKind::Name
        | TokenKind::Integer
        | TokenKind::Real
        | TokenKind::Text
        | TokenKind::Directive
        | TokenKind::LineEnd
        | TokenKind::EndOfFile => false,
    }
}

#[cfg(test)]
mod tests;
