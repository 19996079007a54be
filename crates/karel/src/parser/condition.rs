//! Condition handlers, and the conditions of WAIT FOR and of a MOVE.

use super::{Parsed, Parser, Reported};
use crate::{
    ast::{
        Condition, Conditions, Edge, Expr, ExprKind, NodeSide, Signaled, Stmt, StmtKind, TaskVerb,
        When,
    },
    port::Port,
    token::{Keyword, Symbol, TokenKind},
};

/// Most conditions of one list.
const MAX_TERMS: usize = 100;

impl Parser<'_> {
    /// `CONDITION[n]: WITH .. WHEN .. DO .. ENDCONDITION`.
    pub(super) fn condition_statement(&mut self) -> Parsed<StmtKind> {
        let opener = self.bump().span;
        let number = self.bracketed()?;
        let _ = self.expect_symbol(Symbol::Colon)?;
        self.skip_separators();
        let mut with = Vec::new();
        if self.at_word("WITH") {
            self.position += 1;
            loop {
                let path = self.path()?;
                let _ = self.expect_symbol(Symbol::Equal)?;
                with.push((path, self.expression()?));
                if !self.eat_symbol(Symbol::Comma) {
                    break;
                }
            }
        }
        self.skip_separators();
        let mut whens = Vec::new();
        while self.at_keyword(Keyword::When) {
            whens.push(self.when(&[Keyword::When, Keyword::EndCondition])?);
        }
        self.expect_closer(Keyword::EndCondition, opener, "CONDITION")?;
        Ok(StmtKind::Condition {
            number,
            with,
            whens,
        })
    }

    /// `, WHEN .. DO .. ENDMOVE` or `, UNTIL ..` behind a MOVE.
    pub(super) fn move_clauses(&mut self) -> Parsed<(Vec<When>, Option<Conditions>)> {
        let opener = self.previous_span();
        let mut whens = Vec::new();
        let mut until = None;
        let mut clause = self.eat_symbol(Symbol::Comma);
        while clause {
            if self.eat_keyword(Keyword::Until) {
                until = Some(self.conditions()?);
            } else if self.at_keyword(Keyword::When) {
                while self.at_keyword(Keyword::When) {
                    whens.push(self.when(&[Keyword::When, Keyword::Until, Keyword::EndMove])?);
                }
                if self.eat_keyword(Keyword::Until) {
                    until = Some(self.conditions()?);
                    self.skip_separators();
                }
                self.expect_closer(Keyword::EndMove, opener, "MOVE with WHEN")?;
                return Ok((whens, until));
            } else {
                return Err(self.expected("WHEN or UNTIL"));
            }
            clause = self.eat_symbol(Symbol::Comma);
        }
        Ok((whens, until))
    }

    fn when(&mut self, closers: &'static [Keyword]) -> Parsed<When> {
        let start = self.bump().span;
        let mut conditions = None;
        let _ = self.head(Keyword::Do, |parser| {
            conditions = Some(parser.conditions()?);
            Ok(Expr {
                kind: ExprKind::Error,
                span: start,
                height: 1,
            })
        });
        let span = start.to(self.previous_span());
        let actions: Vec<Stmt> = self.inner_block(closers);
        Ok(When {
            conditions: conditions.ok_or(Reported)?,
            actions,
            span,
        })
    }

    /// `WAIT FOR a, b`.
    pub(super) fn wait_statement(&mut self) -> Parsed<StmtKind> {
        self.position += 1;
        let _ = self.expect_keyword(Keyword::For)?;
        Ok(StmtKind::WaitFor(self.conditions()?))
    }

    /// Terms joined by commas and AND, or by OR.
    fn conditions(&mut self) -> Parsed<Conditions> {
        let mut terms = vec![self.condition()?];
        let mut all = None;
        loop {
            let joins_all = if self.at_symbol(Symbol::Comma) || self.at_keyword(Keyword::And) {
                true
            } else if self.at_keyword(Keyword::Or) {
                false
            } else {
                break;
            };
            let at = self.bump().span;
            if all.is_some_and(|all| all != joins_all) {
                let help = "use two WHEN, or parentheses around states";
                let message = "AND and OR cannot join conditions of one list";
                self.reports.error_with_help(at, message, help);
                return Err(Reported);
            }
            all = Some(joins_all);
            if terms.len() >= MAX_TERMS {
                let message = format!("a list has at most {MAX_TERMS} conditions");
                self.reports.error(at, message);
                return Err(Reported);
            }
            terms.push(self.condition()?);
        }
        Ok(Conditions {
            terms,
            all: all.unwrap_or(true),
        })
    }

    fn condition(&mut self) -> Parsed<Condition> {
        let token = self.peek();
        let next = self.peek_ahead(1).kind;
        if token.kind == TokenKind::Keyword(Keyword::Abort) {
            self.position += 1;
            return self.task_condition(TaskVerb::Abort);
        }
        if token.kind != TokenKind::Name {
            return Ok(Condition::Expr(self.expression()?));
        }
        let word = self.name_of(token.span).text;
        let bracket = next == TokenKind::Symbol(Symbol::LeftBracket);
        let is_event = next == TokenKind::Keyword(Keyword::Program) || ends_condition(next);
        if is_event && let Some(verb) = TaskVerb::of_word(&word) {
            self.position += 1;
            return self.task_condition(verb);
        }
        if is_event && word == "POWERUP" {
            self.position += 1;
            return Ok(Condition::PowerUp);
        }
        if bracket && word == "ERROR" {
            self.position += 1;
            if self.peek_ahead(1).kind == TokenKind::Symbol(Symbol::Star) {
                self.position += 2;
                let _ = self.expect_symbol(Symbol::RightBracket)?;
                return Ok(Condition::Error(None));
            }
            return Ok(Condition::Error(Some(self.bracketed()?)));
        }
        if bracket && let Some(what) = Signaled::of_word(&word) {
            self.position += 1;
            let number = self.bracketed()?;
            return Ok(Condition::Signaled { what, number });
        }
        let at_node = next == TokenKind::Name && self.ahead_is_word(1, "NODE");
        if word == "AT" && at_node {
            self.position += 2;
            let node = self.node_number()?;
            let at = token.span;
            return Ok(Condition::AtNode { node, at });
        }
        if word == "TIME" && !bracket && !is_event && starts_operand(next) {
            return self.node_time();
        }
        if bracket && Port::named(&word).is_some() {
            let before = self.position;
            let port = self.path()?;
            let edge = if self.at_symbol(Symbol::Plus) {
                Some(Edge::Rising)
            } else if self.at_symbol(Symbol::Minus) {
                Some(Edge::Falling)
            } else {
                None
            };
            if let Some(edge) = edge
                && ends_condition(self.peek_ahead(1).kind)
            {
                self.position += 1;
                return Ok(Condition::Edge { port, edge });
            }
            self.position = before;
        }
        Ok(Condition::Expr(self.expression()?))
    }

    /// `TIME t BEFORE NODE[n]`.
    fn node_time(&mut self) -> Parsed<Condition> {
        let at = self.bump().span;
        let time = self.expression()?;
        let word = self.expect_name("BEFORE or AFTER")?;
        let Some(side) = NodeSide::of_word(&word.text) else {
            let message = format!("expected BEFORE or AFTER, found `{}`", word.text);
            self.reports.error(word.span, message);
            return Err(Reported);
        };
        self.expect_word("NODE")?;
        let Some(node) = self.node_number()? else {
            let message = "TIME needs the number of a node";
            self.reports.error(word.span, message);
            return Err(Reported);
        };
        Ok(Condition::NodeTime {
            time,
            side,
            node,
            at,
        })
    }

    /// `[n]`, or nothing for `[*]`.
    fn node_number(&mut self) -> Parsed<Option<Expr>> {
        if self.at_symbol(Symbol::LeftBracket)
            && self.peek_ahead(1).kind == TokenKind::Symbol(Symbol::Star)
        {
            self.position += 2;
            let _ = self.expect_symbol(Symbol::RightBracket)?;
            return Ok(None);
        }
        self.bracketed().map(Some)
    }

    fn task_condition(&mut self, verb: TaskVerb) -> Parsed<Condition> {
        let task = self.program_number()?;
        Ok(Condition::Task { verb, task })
    }

    /// `PROGRAM[n]`, if it stands here.
    pub(super) fn program_number(&mut self) -> Parsed<Option<Expr>> {
        if self.eat_keyword(Keyword::Program) {
            return Ok(Some(self.bracketed()?));
        }
        Ok(None)
    }

    /// `[expression]`.
    pub(super) fn bracketed(&mut self) -> Parsed<Expr> {
        let _ = self.expect_symbol(Symbol::LeftBracket)?;
        let inner = self.nested(Self::expression)?;
        let _ = self.expect_symbol(Symbol::RightBracket)?;
        Ok(inner)
    }
}

/// Whether an operand starts here: `TIME` is a name, too.
fn starts_operand(kind: TokenKind) -> bool {
    matches!(
        kind,
        TokenKind::Name | TokenKind::Integer | TokenKind::Symbol(Symbol::LeftParen)
    )
}

/// Whether nothing of the same condition can follow.
fn ends_condition(kind: TokenKind) -> bool {
    matches!(
        kind,
        TokenKind::LineEnd
            | TokenKind::EndOfFile
            | TokenKind::Symbol(Symbol::Comma | Symbol::Semicolon)
            | TokenKind::Keyword(
                Keyword::And | Keyword::Do | Keyword::EndMove | Keyword::Or | Keyword::Until
            )
    )
}
