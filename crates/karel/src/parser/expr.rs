//! Expressions.
//!
//! Precedence from high to low: NOT and unary signs of a primary; `: @ #`; `* / AND DIV MOD`;
//! a leading sign, `+ - OR`; relations.
//! ASSUMPTION: the order is Pascal's, known from descriptions of the language; sources in the
//! field put parentheses where it would matter.

use super::{MAX_HEIGHT, Parsed, Parser, Reported};
use crate::{
    ast::{BinaryOp, Expr, ExprKind, Path, PathStep, Relation, UnaryOp},
    span::{Span, latin1},
    token::{Keyword, Symbol, TokenKind},
};

/// Precedence levels of binary operators; higher binds tighter.
const RELATION: u8 = 0;
const SUM: u8 = 1;
const PRODUCT: u8 = 2;
const VECTOR: u8 = 3;

impl Parser<'_> {
    pub(super) fn expression(&mut self) -> Parsed<Expr> {
        self.binary(RELATION)
    }

    /// An expression without relations: format specifiers, dimensions, constants.
    pub(super) fn simple(&mut self) -> Parsed<Expr> {
        self.binary(SUM)
    }

    fn binary(&mut self, level: u8) -> Parsed<Expr> {
        let mut left = if level <= SUM {
            self.signed()?
        } else {
            self.primary()?
        };
        while let Some((op, op_level)) = self.operator().filter(|(_, found)| *found >= level) {
            let operator = self.bump().span;
            let right = self.binary(op_level + 1)?;
            let span = left.span.to(right.span);
            let height = left.height.max(right.height);
            let kind = ExprKind::Binary {
                op,
                left: Box::new(left),
                right: Box::new(right),
            };
            left = self.node(kind, span, height, operator)?;
        }
        Ok(left)
    }

    /// A sign before the first term of a sum covers that whole term: `-a * b` is `-(a * b)`.
    fn signed(&mut self) -> Parsed<Expr> {
        let op = if self.at_symbol(Symbol::Plus) {
            UnaryOp::Plus
        } else if self.at_symbol(Symbol::Minus) {
            UnaryOp::Minus
        } else {
            return self.primary();
        };
        let sign = self.bump().span;
        let operand = self.nested(|parser| parser.binary(PRODUCT))?;
        self.unary(op, sign, operand)
    }

    fn unary(&mut self, op: UnaryOp, sign: Span, operand: Expr) -> Parsed<Expr> {
        let span = sign.to(operand.span);
        let height = operand.height;
        self.node(
            ExprKind::Unary {
                op,
                operand: Box::new(operand),
            },
            span,
            height,
            sign,
        )
    }

    /// A node above one of `below` levels, unless the tree gets too high.
    fn node(&mut self, kind: ExprKind, span: Span, below: u16, at: Span) -> Parsed<Expr> {
        if below >= MAX_HEIGHT {
            self.reports.error_with_help(
                at,
                format!("this expression is too long: more than {MAX_HEIGHT} levels"),
                "compute it in several statements",
            );
            return Err(Reported);
        }
        Ok(Expr {
            kind,
            span,
            height: below + 1,
        })
    }

    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "any other token is no operator"
    )]
    fn operator(&self) -> Option<(BinaryOp, u8)> {
        let relation = |relation| Some((BinaryOp::Relation(relation), RELATION));
        match self.peek().kind {
            TokenKind::Keyword(Keyword::Or) => Some((BinaryOp::Or, SUM)),
            TokenKind::Keyword(Keyword::And) => Some((BinaryOp::And, PRODUCT)),
            TokenKind::Keyword(Keyword::Div) => Some((BinaryOp::Div, PRODUCT)),
            TokenKind::Keyword(Keyword::Mod) => Some((BinaryOp::Mod, PRODUCT)),
            TokenKind::Symbol(Symbol::Plus) => Some((BinaryOp::Add, SUM)),
            TokenKind::Symbol(Symbol::Minus) => Some((BinaryOp::Subtract, SUM)),
            TokenKind::Symbol(Symbol::Star) => Some((BinaryOp::Multiply, PRODUCT)),
            TokenKind::Symbol(Symbol::Slash) => Some((BinaryOp::Divide, PRODUCT)),
            TokenKind::Symbol(Symbol::Colon) => Some((BinaryOp::Compose, VECTOR)),
            TokenKind::Symbol(Symbol::At) => Some((BinaryOp::Inner, VECTOR)),
            TokenKind::Symbol(Symbol::Hash) => Some((BinaryOp::Cross, VECTOR)),
            TokenKind::Symbol(Symbol::Equal) => relation(Relation::Equal),
            TokenKind::Symbol(Symbol::NotEqual) => relation(Relation::NotEqual),
            TokenKind::Symbol(Symbol::Less) => relation(Relation::Less),
            TokenKind::Symbol(Symbol::Greater) => relation(Relation::Greater),
            TokenKind::Symbol(Symbol::LessEqual) => relation(Relation::LessEqual),
            TokenKind::Symbol(Symbol::GreaterEqual) => relation(Relation::GreaterEqual),
            TokenKind::Symbol(Symbol::ApproxEqual) => Some((BinaryOp::Approx, RELATION)),
            _ => None,
        }
    }

    #[expect(
        clippy::wildcard_enum_match_arm,
        reason = "any other token starts no expression"
    )]
    fn primary(&mut self) -> Parsed<Expr> {
        let token = self.peek();
        let text = self.source.slice(token.span);
        match token.kind {
            TokenKind::Integer => {
                // Beyond 18 digits the checker's range message is the same.
                let value = latin1(text).parse().unwrap_or(i64::MAX);
                self.position += 1;
                Ok(leaf(ExprKind::Integer(value), token.span))
            }
            TokenKind::Real => {
                let value = latin1(text).parse().unwrap_or(f32::INFINITY);
                self.position += 1;
                Ok(leaf(ExprKind::Real(value), token.span))
            }
            TokenKind::Text => {
                let value = text_value(text);
                self.position += 1;
                Ok(leaf(ExprKind::Text(value), token.span))
            }
            TokenKind::Symbol(Symbol::LeftParen) => self.parenthesized(),
            TokenKind::Keyword(Keyword::Not) => {
                let sign = self.bump().span;
                let operand = self.nested(Self::primary)?;
                self.unary(UnaryOp::Not, sign, operand)
            }
            TokenKind::Symbol(Symbol::Minus) => {
                let sign = self.bump().span;
                let operand = self.nested(Self::primary)?;
                self.unary(UnaryOp::Minus, sign, operand)
            }
            TokenKind::Name => self.name_expression(),
            _ => Err(self.expected("an expression")),
        }
    }

    fn parenthesized(&mut self) -> Parsed<Expr> {
        let open = self.bump().span;
        let inner = self.nested(Self::expression)?;
        let close = self.expect_symbol(Symbol::RightParen)?;
        let height = inner.height;
        self.node(
            ExprKind::Paren(Box::new(inner)),
            open.to(close),
            height,
            open,
        )
    }

    fn name_expression(&mut self) -> Parsed<Expr> {
        let path = self.path()?;
        if path.steps.is_empty() && self.at_symbol(Symbol::LeftParen) {
            let args = self.nested(Self::arguments)?;
            let span = path.span.to(self.previous_span());
            let below = args.iter().map(|arg| arg.height).max().unwrap_or(0);
            return self.node(
                ExprKind::Call {
                    name: path.root,
                    args,
                },
                span,
                below,
                span,
            );
        }
        let below = path_height(&path);
        let span = path.span;
        self.node(ExprKind::Path(path), span, below, span)
    }

    /// `(a, b)` with the parentheses; `()` is an empty list.
    pub(super) fn arguments(&mut self) -> Parsed<Vec<Expr>> {
        let _ = self.expect_symbol(Symbol::LeftParen)?;
        let mut args = Vec::new();
        if self.eat_symbol(Symbol::RightParen) {
            return Ok(args);
        }
        loop {
            args.push(self.expression()?);
            if !self.eat_symbol(Symbol::Comma) {
                let _ = self.expect_symbol(Symbol::RightParen)?;
                return Ok(args);
            }
        }
    }

    /// `name`, `name[1, 2].field`, `$GROUP[1].$UFRAME`.
    pub(super) fn path(&mut self) -> Parsed<Path> {
        let root = self.expect_name("a variable")?;
        let mut path = Path {
            span: root.span,
            root,
            steps: Vec::new(),
        };
        loop {
            if self.eat_symbol(Symbol::Dot) {
                let field = self.expect_name("a field")?;
                path.steps.push(PathStep::Field(field));
            } else if self.at_symbol(Symbol::LeftBracket) {
                path.steps.push(self.nested(Self::subscripts)?);
            } else {
                path.span = path.root.span.to(self.previous_span());
                return Ok(path);
            }
            if path.steps.len() > usize::from(MAX_HEIGHT) {
                self.reports.error(
                    path.span,
                    "this variable has too many subscripts and fields",
                );
                return Err(Reported);
            }
        }
    }

    fn subscripts(&mut self) -> Parsed<PathStep> {
        let open = self.bump().span;
        let mut subscripts = vec![self.expression()?];
        while self.eat_symbol(Symbol::Comma) {
            subscripts.push(self.expression()?);
        }
        if subscripts.len() == 1 && self.eat_symbol(Symbol::DoubleDot) {
            let last = Box::new(self.expression()?);
            let close = self.expect_symbol(Symbol::RightBracket)?;
            let first = subscripts.pop().map(Box::new).ok_or(Reported)?;
            return Ok(PathStep::Range {
                first,
                last,
                span: open.to(close),
            });
        }
        let close = self.expect_symbol(Symbol::RightBracket)?;
        Ok(PathStep::Index {
            subscripts,
            span: open.to(close),
        })
    }
}

fn leaf(kind: ExprKind, span: Span) -> Expr {
    Expr {
        kind,
        span,
        height: 1,
    }
}

fn path_height(path: &Path) -> u16 {
    let heights = path.steps.iter().map(|step| match step {
        PathStep::Field(_) => 0,
        PathStep::Index { subscripts, .. } => subscripts
            .iter()
            .map(|subscript| subscript.height)
            .max()
            .unwrap_or(0),
        PathStep::Range { first, last, .. } => first.height.max(last.height),
    });
    heights.max().unwrap_or(0)
}

/// The bytes of a string token: no quotes around it, doubled ones single.
fn text_value(token: &[u8]) -> Vec<u8> {
    let inner = token.strip_prefix(b"'").unwrap_or(token);
    let inner = inner.strip_suffix(b"'").unwrap_or(inner);
    let mut value = Vec::with_capacity(inner.len());
    let mut previous_quote = false;
    for byte in inner {
        previous_quote = *byte == b'\'' && !previous_quote;
        if !previous_quote {
            value.push(*byte);
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_doubled_quote_is_one() {
        assert_eq!(text_value(b"'it''s'"), b"it's");
        assert_eq!(text_value(b"''''"), b"'");
        assert_eq!(text_value(b"''"), b"");
        assert_eq!(text_value(b"'a''''b'"), b"a''b");
    }
}
