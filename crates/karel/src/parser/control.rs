//! Statements that hold blocks: IF, WHILE, FOR, REPEAT, SELECT, USING.

use super::{Parsed, Parser, Reported};
use crate::{
    ast::{Case, Direction, Expr, ExprKind, Stmt, StmtKind},
    span::Span,
    token::{Keyword, Symbol, TokenKind},
};

impl Parser<'_> {
    pub(super) fn if_statement(&mut self) -> Parsed<StmtKind> {
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

    pub(super) fn while_statement(&mut self) -> Parsed<StmtKind> {
        let opener = self.bump().span;
        let condition = self.head(Keyword::Do, Self::expression);
        let body = self.inner_block(&[Keyword::EndWhile]);
        self.expect_closer(Keyword::EndWhile, opener, "WHILE")?;
        Ok(StmtKind::While { condition, body })
    }

    pub(super) fn for_statement(&mut self) -> Parsed<StmtKind> {
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

    pub(super) fn repeat_statement(&mut self) -> Parsed<StmtKind> {
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

    pub(super) fn select_statement(&mut self) -> Parsed<StmtKind> {
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

    pub(super) fn using_statement(&mut self) -> Parsed<StmtKind> {
        let opener = self.bump().span;
        let mut places = Vec::new();
        let _ = self.head(Keyword::Do, |parser| {
            loop {
                places.push(parser.path()?);
                if !parser.eat_symbol(Symbol::Comma) {
                    return Ok(Expr {
                        kind: ExprKind::Error,
                        span: opener,
                        height: 1,
                    });
                }
            }
        });
        let body = self.inner_block(&[Keyword::EndUsing]);
        self.expect_closer(Keyword::EndUsing, opener, "USING")?;
        Ok(StmtKind::Using { places, body })
    }

    /// A block inside a statement that is closed by one of `closers`.
    pub(super) fn inner_block(&mut self, closers: &'static [Keyword]) -> Vec<Stmt> {
        self.open_blocks.push(closers);
        let stmts = self.block();
        let _ = self.open_blocks.pop();
        stmts
    }

    pub(super) fn expect_closer(
        &mut self,
        closer: Keyword,
        opener: Span,
        what: &str,
    ) -> Parsed<()> {
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
    pub(super) fn head(
        &mut self,
        word: Keyword,
        parse: impl FnOnce(&mut Self) -> Parsed<Expr>,
    ) -> Expr {
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
}
