//! `%INCLUDE`: the tokens of the file stand where the directive stood.

use super::{MAX_SOURCE_BYTES, decl::directive, is_source_text};
use crate::{
    diagnostic::Reports,
    headers,
    include::{IncludeFile, IncludeFiles, Includes},
    lexer,
    span::{Source, Span},
    token::{Token, TokenKind},
};

/// Deepest nesting of files.
const MAX_DEPTH: usize = 16;

/// Most files that a program may include, each time counted.
const MAX_FILES: usize = 256;

/// A file whose tokens are being taken.
struct Open {
    key: String,
    tokens: std::vec::IntoIter<Token>,
}

/// The tokens of the program with those of the files that it includes.
pub(super) fn tokens(
    source: &mut Source,
    includes: &dyn Includes,
    reports: &mut Reports,
) -> Vec<Token> {
    let mut found = Vec::new();
    let mut open = vec![Open {
        key: String::new(),
        tokens: lexer::lex(source, source.program(), reports).into_iter(),
    }];
    let mut files = 0;
    while let Some(file) = open.last_mut() {
        let Some(token) = file.tokens.next() else {
            let _done = open.pop();
            continue;
        };
        match token.kind {
            TokenKind::EndOfFile if open.len() > 1 => {}
            TokenKind::Directive => {
                let written = directive(source.slice(token.span), token.span);
                if written.name != "%INCLUDE" {
                    found.push(token);
                    continue;
                }
                files += 1;
                if files > MAX_FILES {
                    let message = format!("more than {MAX_FILES} files are included");
                    reports.error(token.span, message);
                    return found;
                }
                let path = written.argument;
                if let Some(tokens) =
                    file_tokens(source, includes, &path, token.span, &open, reports)
                {
                    open.push(tokens);
                }
            }
            TokenKind::Name
            | TokenKind::Keyword(_)
            | TokenKind::Integer
            | TokenKind::Real
            | TokenKind::Text
            | TokenKind::Symbol(_)
            | TokenKind::LineEnd
            | TokenKind::EndOfFile => found.push(token),
        }
    }
    found
}

/// The tokens of one file; reports and returns `None` if there are none to take.
fn file_tokens(
    source: &mut Source,
    includes: &dyn Includes,
    path: &str,
    at: Span,
    open: &[Open],
    reports: &mut Reports,
) -> Option<Open> {
    let key = IncludeFiles::key(path);
    let stem = key.rsplit('/').next().unwrap_or_default();
    let header = || {
        let text = headers::text(stem)?.into_bytes();
        let name = stem.to_owned();
        Some(IncludeFile { name, text })
    };
    let Some(file) = includes.find(path).or_else(header) else {
        reports.error(at, format!("there is no file {path} to include"));
        return None;
    };
    if open.iter().any(|open| open.key == key) {
        reports.error(at, format!("the file {path} includes itself"));
        return None;
    }
    if open.len() > MAX_DEPTH {
        reports.error(
            at,
            format!("files include each other deeper than {MAX_DEPTH} levels"),
        );
        return None;
    }
    if source.bytes.len() + file.text.len() > MAX_SOURCE_BYTES {
        let message = format!(
            "with the {} bytes of {path} the program has more than {MAX_SOURCE_BYTES}",
            file.text.len()
        );
        reports.error(at, message);
        return None;
    }
    let span = source.add(&file.text, &file.name);
    let is_blank = file.text.iter().all(u8::is_ascii_whitespace);
    if !is_blank && !is_source_text(source.slice(span), span.start(), reports) {
        return None;
    }
    Some(Open {
        key,
        tokens: lexer::lex(source, span, reports).into_iter(),
    })
}
