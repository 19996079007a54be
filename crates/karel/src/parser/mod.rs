//! Tokens to tree.
//!
//! Recursive descent. An error is reported where it is found, the parser skips to the next
//! statement separator and goes on, so that one run reports as much as possible. Nesting is
//! limited, so no input can exhaust the stack.

mod condition;
mod control;
mod decl;
mod expr;
mod include;
mod io;
mod motion;
mod stmt;
mod word;

use crate::{
    ast::{Name, Program},
    diagnostic::Reports,
    include::Includes,
    lexer,
    span::{Source, Span, latin1},
    token::{Keyword, Symbol, Token, TokenKind},
};

/// Deepest nesting of blocks and parentheses.
pub(crate) const MAX_NESTING: usize = 100;

/// Highest expression tree.
pub(crate) const MAX_HEIGHT: u16 = 200;

/// Longest source.
pub(crate) const MAX_SOURCE_BYTES: usize = 1 << 20;

/// A message was reported; the caller resynchronizes.
#[derive(Debug)]
pub(crate) struct Reported;

pub(crate) type Parsed<T> = Result<T, Reported>;

/// Parses a program. `None` if there is nothing that the checker could look at.
///
/// Included files are added to `source`; without `includes` the directives stay as they are.
pub(crate) fn parse(
    source: &mut Source,
    includes: Option<&dyn Includes>,
    reports: &mut Reports,
) -> Option<Program> {
    if !is_source_text(&source.bytes, 0, reports) {
        return None;
    }
    let tokens = match includes {
        Some(includes) => include::tokens(source, includes, reports),
        None => lexer::lex(source, source.program(), reports),
    };
    let mut parser = Parser {
        source,
        tokens: &tokens,
        position: 0,
        depth: 0,
        open_blocks: Vec::new(),
        gave_up: false,
        reports,
    };
    parser.program().ok()
}

/// Refuses what is no KAREL source at all, with one message instead of thousands.
pub(crate) fn is_source_text(bytes: &[u8], start: usize, reports: &mut Reports) -> bool {
    if bytes.len() > MAX_SOURCE_BYTES {
        let message = format!(
            "the file has {} bytes, a program may have at most {MAX_SOURCE_BYTES}",
            bytes.len()
        );
        reports.error(Span::new(0, 0), message);
        return false;
    }
    let strange =
        |byte: &u8| byte.is_ascii_control() && !matches!(byte, b'\t' | b'\n' | b'\r' | 0x0C | 0x1A);
    if let Some(offset) = bytes.iter().position(strange) {
        let byte = bytes.get(offset).copied().unwrap_or_default();
        reports.error_with_help(
            Span::new(start + offset, start + offset + 1),
            format!("this is not KAREL source text: byte 0x{byte:02X} at offset {offset}"),
            "translated programs (.pc) cannot be run, only their .kl source",
        );
        return false;
    }
    if bytes.iter().all(u8::is_ascii_whitespace) {
        reports.error(Span::new(0, 0), "the file is empty; PROGRAM was expected");
        return false;
    }
    true
}

pub(crate) struct Parser<'a> {
    source: &'a Source,
    tokens: &'a [Token],
    position: usize,
    depth: usize,
    /// The words that close each open block, innermost last.
    open_blocks: Vec<&'static [Keyword]>,
    /// The rest cannot be understood; saying more about it would only be noise.
    gave_up: bool,
    reports: &'a mut Reports,
}

impl Parser<'_> {
    fn peek(&self) -> Token {
        self.peek_ahead(0)
    }

    /// The token after `ahead` others; the end of the file stays the last.
    fn peek_ahead(&self, ahead: usize) -> Token {
        let end = self.source.program().end();
        let end_of_file = Token {
            kind: TokenKind::EndOfFile,
            span: Span::new(end, end),
        };
        self.tokens
            .get(self.position + ahead)
            .copied()
            .unwrap_or(end_of_file)
    }

    fn bump(&mut self) -> Token {
        let token = self.peek();
        self.position += 1;
        token
    }

    fn previous_span(&self) -> Span {
        self.tokens
            .get(self.position.wrapping_sub(1))
            .map_or(Span::default(), |token| token.span)
    }

    fn at_symbol(&self, symbol: Symbol) -> bool {
        self.peek().kind == TokenKind::Symbol(symbol)
    }

    fn at_keyword(&self, keyword: Keyword) -> bool {
        self.peek().kind == TokenKind::Keyword(keyword)
    }

    fn eat_symbol(&mut self, symbol: Symbol) -> bool {
        let found = self.at_symbol(symbol);
        self.position += usize::from(found);
        found
    }

    fn eat_keyword(&mut self, keyword: Keyword) -> bool {
        let found = self.at_keyword(keyword);
        self.position += usize::from(found);
        found
    }

    fn expect_symbol(&mut self, symbol: Symbol) -> Parsed<Span> {
        if self.at_symbol(symbol) {
            return Ok(self.bump().span);
        }
        Err(self.expected(&format!("`{}`", symbol.text())))
    }

    fn expect_keyword(&mut self, keyword: Keyword) -> Parsed<Span> {
        if self.at_keyword(keyword) {
            return Ok(self.bump().span);
        }
        Err(self.expected(keyword.text()))
    }

    fn expect_name(&mut self, what: &str) -> Parsed<Name> {
        let token = self.peek();
        if token.kind == TokenKind::Name {
            self.position += 1;
            return Ok(self.name_of(token.span));
        }
        if let TokenKind::Keyword(keyword) = token.kind {
            let text = keyword.text();
            self.reports.error(
                token.span,
                format!("expected {what}, but {text} is a reserved word"),
            );
            return Err(Reported);
        }
        Err(self.expected(what))
    }

    fn name_of(&self, span: Span) -> Name {
        Name {
            text: latin1(self.source.slice(span)).to_ascii_uppercase(),
            span,
        }
    }

    /// Reports what was expected at the current token.
    fn expected(&mut self, what: &str) -> Reported {
        if self.gave_up {
            return Reported;
        }
        let token = self.peek();
        let found = self.describe(token);
        let message = format!("expected {what}, found {found}");
        self.reports.error(token.span, message);
        Reported
    }

    fn describe(&self, token: Token) -> String {
        match token.kind {
            TokenKind::LineEnd => "the end of the line".to_owned(),
            TokenKind::EndOfFile => "the end of the file".to_owned(),
            TokenKind::Name
            | TokenKind::Keyword(_)
            | TokenKind::Integer
            | TokenKind::Real
            | TokenKind::Text
            | TokenKind::Directive
            | TokenKind::Symbol(_) => {
                let text = latin1(self.source.slice(token.span));
                let short: String = text.chars().take(40).collect();
                format!("`{short}`")
            }
        }
    }

    fn at_separator(&self) -> bool {
        self.peek().kind == TokenKind::LineEnd || self.at_symbol(Symbol::Semicolon)
    }

    fn skip_separators(&mut self) {
        while self.at_separator() {
            self.position += 1;
        }
    }

    /// Resynchronizes after an error: to the next separator or the end of the file.
    fn skip_to_separator(&mut self) {
        while !self.at_separator() && self.peek().kind != TokenKind::EndOfFile {
            self.position += 1;
        }
    }

    /// Runs `parse` one level deeper, or reports that the nesting is too deep.
    fn nested<T>(&mut self, parse: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.depth >= MAX_NESTING {
            let span = self.peek().span;
            self.reports
                .error(span, format!("nested deeper than {MAX_NESTING} levels"));
            // Everything that follows is inside: nothing sensible can be said about it.
            self.position = self.tokens.len();
            self.gave_up = true;
            return Err(Reported);
        }
        self.depth += 1;
        let result = parse(self);
        self.depth -= 1;
        result
    }
}

#[cfg(test)]
mod tests {
    use crate::{diagnostic::Reports, span::Source};

    fn first_error(bytes: &[u8]) -> String {
        let mut source = Source::new(bytes, "t.kl");
        let mut reports = Reports::default();
        let _ = super::parse(&mut source, None, &mut reports);
        let first = reports
            .into_diagnostics(&source)
            .into_iter()
            .next()
            .expect("no diagnostic");
        format!("{}:{} {}", first.line, first.column, first.message)
    }

    #[test]
    fn what_is_not_karel_gets_one_clear_message() {
        assert_eq!(
            first_error(b""),
            "1:1 the file is empty; PROGRAM was expected"
        );
        assert_eq!(
            first_error(b"hello world"),
            "1:1 expected PROGRAM, found `hello`"
        );
        let binary = first_error(b"\x7fELF\x01\x02");
        assert_eq!(
            binary,
            "1:1 this is not KAREL source text: byte 0x7F at offset 0"
        );
        assert!(first_error(&vec![b' '; 2 << 20]).contains("at most 1048576"));
    }

    #[test]
    fn deep_nesting_is_an_error_and_not_a_stack_overflow() {
        let deep = "IF TRUE THEN\n".repeat(10_000);
        assert_eq!(
            first_error(format!("PROGRAM t\nBEGIN\n{deep}END t\n").as_bytes()),
            "103:1 nested deeper than 100 levels"
        );
        let parens = "(".repeat(10_000);
        let message = first_error(format!("PROGRAM t\nBEGIN\nx = {parens}1\nEND t\n").as_bytes());
        assert!(message.contains("nested deeper"), "{message}");
        let chain = "1+".repeat(10_000);
        let message = first_error(format!("PROGRAM t\nBEGIN\nx = {chain}1\nEND t\n").as_bytes());
        assert!(message.contains("too long"), "{message}");
        let nots = "NOT ".repeat(10_000);
        let message = first_error(format!("PROGRAM t\nBEGIN\nx = {nots}TRUE\nEND t\n").as_bytes());
        assert!(message.contains("nested deeper"), "{message}");
        let arrays = "ARRAY[1] OF ".repeat(10_000);
        let message =
            first_error(format!("PROGRAM t\nVAR\nx: {arrays}REAL\nBEGIN\nEND t\n").as_bytes());
        assert!(message.contains("nested deeper"), "{message}");
    }
}
