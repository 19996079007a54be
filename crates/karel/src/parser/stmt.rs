//! Statements and blocks.

use super::{Parsed, Parser, Reported};
use crate::{
    ast::{Stmt, StmtKind, TaskVerb},
    token::{Keyword, Symbol, TokenKind},
};

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
                Keyword::Abort => self.task_statement(TaskVerb::Abort)?,
                Keyword::Wait => self.wait_statement()?,
                Keyword::Condition => self.condition_statement()?,
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
        if !is_variable && let Some(kind) = self.word_statement(&name)? {
            return Ok(kind);
        }
        if !is_variable && matches!(name.text.as_str(), "CONNECT" | "DISCONNECT") {
            return self.timer_statement(name.text == "CONNECT");
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
            let name = &path.root.text;
            let message = format!("`{name}` is no statement; with `=` or `(` it could be one");
            let found = self.expected("`=`, `(` or the end of the statement");
            self.reports.help(&message);
            return Err(found);
        }
        Ok(StmtKind::Call {
            name: path.root,
            args: Vec::new(),
        })
    }

    /// `CONNECT TIMER TO variable`, `DISCONNECT TIMER variable`.
    fn timer_statement(&mut self, connect: bool) -> Parsed<StmtKind> {
        self.position += 1;
        let word = self.expect_name("TIMER")?;
        if word.text != "TIMER" {
            let message = format!("expected TIMER, found `{}`", word.text);
            self.reports.error(word.span, message);
            return Err(Reported);
        }
        if connect {
            let _ = self.expect_keyword(Keyword::To)?;
            return Ok(StmtKind::ConnectTimer(self.path()?));
        }
        Ok(StmtKind::DisconnectTimer(self.path()?))
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
            | Keyword::When
    )
}
