//! Which tokens a text becomes.

use super::*;

/// Tokens as text, `/` for a line end, up to the final one.
fn tokens(text: &str) -> String {
    let source = Source::new(text.as_bytes(), "t.kl");
    let mut reports = Reports::default();
    let tokens = lex(&source, source.program(), &mut reports);
    let words = tokens
        .iter()
        .filter(|token| token.span.start() < source.bytes.len())
        .map(|token| {
            if token.kind == TokenKind::LineEnd {
                "/".to_owned()
            } else {
                crate::span::latin1(source.slice(token.span))
            }
        });
    words.collect::<Vec<_>>().join(" ")
}

#[test]
fn numbers_do_not_eat_a_range() {
    assert_eq!(
        tokens("1..5 1.5 1. .5 1E-3 1e"),
        "1 .. 5 1.5 1. .5 1E-3 1 e"
    );
}

#[test]
fn lines_join_after_ampersand_operator_comma_equal_and_inside_parentheses() {
    assert_eq!(tokens("a & -- why\nb\nc"), "a b / c");
    assert_eq!(tokens("a = \nb + -- x\n\n c\nd"), "a = b + c / d");
    assert_eq!(tokens("f(a -- x\n b\n)\nc"), "f ( a b ) / c");
    assert_eq!(tokens("IF (a)\n THEN\nb"), "IF ( a ) THEN / b");
}

#[test]
fn marks_of_editors_are_blanks() {
    let source = Source::new(b"\xEF\xBB\xBFa\x0C\n\x1A", "t.kl");
    let mut reports = Reports::default();
    let kinds: Vec<TokenKind> = lex(&source, source.program(), &mut reports)
        .iter()
        .map(|t| t.kind)
        .collect();
    let end = [TokenKind::LineEnd, TokenKind::EndOfFile];
    assert_eq!(kinds, [[TokenKind::Name, TokenKind::LineEnd], end].concat());
    assert!(!reports.has_errors());
}

#[test]
fn a_parenthesis_that_is_never_closed_ends_at_the_next_statement_word() {
    assert_eq!(tokens("f(a\nENDIF"), "f ( a / ENDIF");
}

#[test]
fn a_doubled_quote_is_part_of_the_string_and_comments_are_not() {
    assert_eq!(tokens("'it''s' -- it's\n'--'"), "'it''s' / '--'");
}

#[test]
fn a_directive_is_one_token_without_its_comment() {
    assert_eq!(
        tokens("%NOPAUSE=ERROR+COMMAND -- x\r\n%STACKSIZE = 4"),
        "%NOPAUSE=ERROR+COMMAND / %STACKSIZE = 4"
    );
}
