//! Statements and blocks.

use super::{Parsed, Parser, Reported};
use crate::{
    ast::{Case, Direction, Expr, ExprKind, Stmt, StmtKind},
    span::Span,
    token::{Keyword, Symbol, TokenKind},
};

/// First words of statements that are KAREL and not run yet.
const NOT_YET: &[&str] = &[
    "ATTACH",
    "CONNECT",
    "CONTINUE",
    "DISABLE",
    "DISCONNECT",
    "ENABLE",
    "HOLD",
    "NOABORT",
    "NOMESSAGE",
    "NOPAUSE",
    "PAUSE",
    "PULSE",
    "PURGE",
    "RELAX",
    "RELEASE",
    "RESTORE",
    "RESUME",
    "SIGNAL",
    "STOP",
    "UNHOLD",
    "UNPAUSE",
];

impl Parser<'_> {
    /// Statements up to a word that closes a block; that word stays for the caller.
    ///
    /// A closing word that no open block waits for is reported and skipped here.
    pub(super) fn block(&mut self) -> Vec<Stmt> {
        let mut stmts = Vec::new();
        loop {
            self.skip_separators();
            if self.reports.is_full() {
                self.position = self.tokens.len();
            }
            let kind = self.peek().kind;
            if kind == TokenKind::EndOfFile {
                return stmts;
            } else if kind == TokenKind::Directive {
                self.position += 1;
            } else if let TokenKind::Keyword(word) = kind
                && closes_block(word)
            {
                if self.open_blocks.iter().any(|open| open.contains(&word)) {
                    return stmts;
                }
                let span = self.bump().span;
                self.reports
                    .error(span, format!("{} closes nothing here", word.text()));
                self.skip_to_separator();
            } else {
                self.block_statement(&mut stmts);
            }
        }
    }

    fn block_statement(&mut self, stmts: &mut Vec<Stmt>) {
        let start = self.position;
        let Ok(stmt) = self.nested(Self::statement) else {
            self.skip_to_separator();
            if self.position == start {
                self.position += 1;
            }
            return;
        };
        let label = matches!(stmt.kind, StmtKind::Label(_));
        stmts.push(stmt);
        if !label && !self.at_statement_end() {
            let _ = self.expected("the end of the statement");
            self.skip_to_separator();
        }
    }

    /// A separator, or a word that closes the block (a statement without its own end was reported).
    fn at_statement_end(&self) -> bool {
        let kind = self.peek().kind;
        let closes = matches!(kind, TokenKind::Keyword(word) if closes_block(word));
        closes || self.at_separator() || kind == TokenKind::EndOfFile
    }

    /// A block inside a statement that is closed by one of `closers`.
    fn inner_block(&mut self, closers: &'static [Keyword]) -> Vec<Stmt> {
        self.open_blocks.push(closers);
        let stmts = self.block();
        let _ = self.open_blocks.pop();
        stmts
    }

    fn expect_closer(&mut self, closer: Keyword, opener: Span, what: &str) -> Parsed<()> {
        if self.eat_keyword(closer) {
            return Ok(());
        }
        if self.gave_up {
            return Err(Reported);
        }
        self.gave_up = self.peek().kind == TokenKind::EndOfFile;
        let found = self.describe(self.peek());
        let message = format!(
            "this {what} is not closed: expected {}, found {found}",
            closer.text()
        );
        self.reports.error(opener, message);
        Ok(())
    }

    /// The head of a block: on an error, goes on behind `word` so that the block is still parsed.
    fn head(&mut self, word: Keyword, parse: impl FnOnce(&mut Self) -> Parsed<Expr>) -> Expr {
        let start = self.peek().span;
        let head = parse(self).and_then(|expr| self.expect_keyword(word).map(|_| expr));
        head.unwrap_or_else(|Reported| {
            while !self.at_separator()
                && !self.at_keyword(word)
                && self.peek().kind != TokenKind::EndOfFile
            {
                self.position += 1;
            }
            let _ = self.eat_keyword(word);
            Expr {
                kind: ExprKind::Error,
                span: start,
                height: 1,
            }
        })
    }

    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "any other token starts no statement"
    )]
    fn statement(&mut self) -> Parsed<Stmt> {
        let start = self.peek().span;
        let kind = match self.peek().kind {
            TokenKind::Name => self.name_statement()?,
            TokenKind::Keyword(keyword) => match keyword {
                Keyword::If => self.if_statement()?,
                Keyword::While => self.while_statement()?,
                Keyword::For => self.for_statement()?,
                Keyword::Repeat => self.repeat_statement()?,
                Keyword::Select => self.select_statement()?,
                Keyword::Goto => {
                    self.position += 1;
                    StmtKind::Goto(self.expect_name("a label")?)
                }
                Keyword::Return => self.return_statement()?,
                Keyword::Read => self.transfer_statement(Keyword::Read)?,
                Keyword::Write => self.transfer_statement(Keyword::Write)?,
                Keyword::Open => self.open_statement()?,
                Keyword::Close => self.close_statement()?,
                Keyword::Cancel => self.cancel_statement()?,
                Keyword::Delay => {
                    self.position += 1;
                    StmtKind::Delay(self.expression()?)
                }
                Keyword::Move => self.move_statement()?,
                Keyword::Abort => {
                    self.position += 1;
                    if self.at_separator() {
                        StmtKind::Abort
                    } else {
                        self.unsupported_line("ABORT PROGRAM")
                    }
                }
                Keyword::Wait => self.unsupported_line("WAIT FOR"),
                Keyword::Condition => self.unsupported_until("CONDITION", Keyword::EndCondition),
                Keyword::Using => self.using_statement()?,
                _ => return Err(self.expected("a statement")),
            },
            _ => return Err(self.expected("a statement")),
        };
        Ok(Stmt {
            kind,
            span: start.to(self.previous_span()),
        })
    }

    fn name_statement(&mut self) -> Parsed<StmtKind> {
        let next = self.peek_ahead(1).kind;
        let name = self.name_of(self.peek().span);
        if next == TokenKind::Symbol(Symbol::DoubleColon) {
            self.position += 2;
            return Ok(StmtKind::Label(name));
        }
        let is_variable = matches!(
            next,
            TokenKind::Symbol(
                Symbol::Equal | Symbol::Dot | Symbol::LeftBracket | Symbol::LeftParen
            )
        );
        if !is_variable && NOT_YET.contains(&name.text.as_str()) {
            return Ok(self.unsupported_line(&name.text));
        }
        if !is_variable && name.text == "GO" {
            self.position += 1;
            let _ = self.expect_keyword(Keyword::To)?;
            return Ok(StmtKind::Goto(self.expect_name("a label")?));
        }
        let path = self.path()?;
        if self.eat_symbol(Symbol::Equal) {
            let value = self.expression()?;
            return Ok(StmtKind::Assign {
                target: path,
                value,
            });
        }
        if !path.steps.is_empty() {
            return Err(self.expected("`=`"));
        }
        if self.at_symbol(Symbol::LeftParen) {
            let args = self.arguments()?;
            if self.at_symbol(Symbol::Equal) {
                let message = format!("`{}(..)` cannot be assigned to", path.root.text);
                let help = "subscripts stand in `[` and `]`";
                self.reports.error_with_help(path.root.span, message, help);
                return Err(Reported);
            }
            return Ok(StmtKind::Call {
                name: path.root,
                args,
            });
        }
        if !self.at_separator() && self.peek().kind != TokenKind::EndOfFile {
            return Err(self.expected("`=`, `(` or the end of the statement"));
        }
        Ok(StmtKind::Call {
            name: path.root,
            args: Vec::new(),
        })
    }

    fn if_statement(&mut self) -> Parsed<StmtKind> {
        let opener = self.bump().span;
        let condition = self.head(Keyword::Then, Self::expression);
        let then = self.inner_block(&[Keyword::Else, Keyword::EndIf]);
        let otherwise = if self.eat_keyword(Keyword::Else) {
            self.inner_block(&[Keyword::EndIf])
        } else {
            Vec::new()
        };
        self.expect_closer(Keyword::EndIf, opener, "IF")?;
        Ok(StmtKind::If {
            condition,
            then,
            otherwise,
        })
    }

    fn while_statement(&mut self) -> Parsed<StmtKind> {
        let opener = self.bump().span;
        let condition = self.head(Keyword::Do, Self::expression);
        let body = self.inner_block(&[Keyword::EndWhile]);
        self.expect_closer(Keyword::EndWhile, opener, "WHILE")?;
        Ok(StmtKind::While { condition, body })
    }

    fn for_statement(&mut self) -> Parsed<StmtKind> {
        let opener = self.bump().span;
        let mut counter_from = None;
        let to = self.head(Keyword::Do, |parser| {
            let counter = parser.expect_name("a counter variable")?;
            let _ = parser.expect_symbol(Symbol::Equal)?;
            let from = parser.expression()?;
            let direction = if parser.eat_keyword(Keyword::Downto) {
                Direction::Down
            } else if parser.eat_keyword(Keyword::To) {
                Direction::Up
            } else {
                return Err(parser.expected("TO or DOWNTO"));
            };
            counter_from = Some((counter, from, direction));
            parser.expression()
        });
        let body = self.inner_block(&[Keyword::EndFor]);
        self.expect_closer(Keyword::EndFor, opener, "FOR")?;
        let (counter, from, direction) = counter_from.ok_or(Reported)?;
        Ok(StmtKind::For {
            counter,
            from,
            to,
            direction,
            body,
        })
    }

    fn repeat_statement(&mut self) -> Parsed<StmtKind> {
        let opener = self.bump().span;
        let body = self.inner_block(&[Keyword::Until]);
        if !self.at_keyword(Keyword::Until) {
            self.expect_closer(Keyword::Until, opener, "REPEAT")?;
            return Err(Reported);
        }
        self.position += 1;
        let until = self.expression()?;
        Ok(StmtKind::Repeat { body, until })
    }

    fn select_statement(&mut self) -> Parsed<StmtKind> {
        let opener = self.bump().span;
        let value = self.head(Keyword::Of, Self::expression);
        self.skip_separators();
        let mut cases = Vec::new();
        while self.eat_keyword(Keyword::Case) {
            let values = self.case_values().unwrap_or_else(|Reported| {
                self.skip_to_separator();
                Vec::new()
            });
            let body = self.inner_block(&[Keyword::Case, Keyword::Else, Keyword::EndSelect]);
            cases.push(Case { values, body });
        }
        let otherwise = if self.eat_keyword(Keyword::Else) {
            if !self.eat_symbol(Symbol::Colon) {
                let _ = self.expected("`:`");
            }
            Some(self.inner_block(&[Keyword::EndSelect]))
        } else {
            None
        };
        self.expect_closer(Keyword::EndSelect, opener, "SELECT")?;
        Ok(StmtKind::Select {
            value,
            cases,
            otherwise,
        })
    }

    fn case_values(&mut self) -> Parsed<Vec<Expr>> {
        let values = self.arguments()?;
        let _ = self.expect_symbol(Symbol::Colon)?;
        Ok(values)
    }

    fn return_statement(&mut self) -> Parsed<StmtKind> {
        self.position += 1;
        if self.eat_symbol(Symbol::LeftParen) {
            let value = self.expression()?;
            let _ = self.expect_symbol(Symbol::RightParen)?;
            return Ok(StmtKind::Return(Some(value)));
        }
        Ok(StmtKind::Return(None))
    }

    fn using_statement(&mut self) -> Parsed<StmtKind> {
        let opener = self.bump().span;
        let _ = self.head(Keyword::Do, |parser| {
            loop {
                let path = parser.path()?;
                if !parser.eat_symbol(Symbol::Comma) {
                    return Ok(Expr {
                        kind: ExprKind::Path(path),
                        span: opener,
                        height: 1,
                    });
                }
            }
        });
        let _ = self.inner_block(&[Keyword::EndUsing]);
        self.expect_closer(Keyword::EndUsing, opener, "USING")?;
        Ok(StmtKind::Unsupported("USING".to_owned()))
    }

    pub(super) fn unsupported_line(&mut self, what: &str) -> StmtKind {
        self.skip_to_separator();
        StmtKind::Unsupported(what.to_owned())
    }

    pub(super) fn unsupported_until(&mut self, what: &str, closer: Keyword) -> StmtKind {
        while !self.at_keyword(closer)
            && !self.at_keyword(Keyword::End)
            && self.peek().kind != TokenKind::EndOfFile
        {
            self.position += 1;
        }
        let _ = self.eat_keyword(closer);
        StmtKind::Unsupported(what.to_owned())
    }
}

/// Words that end a list of statements.
fn closes_block(keyword: Keyword) -> bool {
    matches!(
        keyword,
        Keyword::Case
            | Keyword::Else
            | Keyword::End
            | Keyword::EndCondition
            | Keyword::EndFor
            | Keyword::EndIf
            | Keyword::EndMove
            | Keyword::EndSelect
            | Keyword::EndUsing
            | Keyword::EndWhile
            | Keyword::Routine
            | Keyword::Until
    )
}
