//! Expressions, and the paths of what they name.

use super::Name;
use crate::span::Span;

#[derive(Debug)]
pub(crate) struct Expr {
    pub(crate) kind: ExprKind,
    pub(crate) span: Span,
    /// Levels of the tree below and including this one.
    pub(crate) height: u16,
}

#[derive(Debug)]
pub(crate) enum ExprKind {
    /// Digits; the checker knows the range.
    Integer(i64),
    Real(f32),
    Text(Vec<u8>),
    Path(Path),
    Call {
        name: Name,
        args: Vec<Expr>,
    },
    Unary {
        op: UnaryOp,
        operand: Box<Expr>,
    },
    Binary {
        op: BinaryOp,
        left: Box<Expr>,
        right: Box<Expr>,
    },
    /// `(x)`: by value, even if x is a variable.
    Paren(Box<Expr>),
    /// Something was reported here already.
    Error,
}

/// A variable with subscripts and fields.
#[derive(Debug)]
pub(crate) struct Path {
    pub(crate) root: Name,
    pub(crate) steps: Vec<PathStep>,
    pub(crate) span: Span,
}

#[derive(Debug)]
pub(crate) enum PathStep {
    Field(Name),
    Index {
        subscripts: Vec<Expr>,
        span: Span,
    },
    /// `[first..last]`, nodes of a PATH.
    Range {
        first: Box<Expr>,
        last: Box<Expr>,
        span: Span,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum UnaryOp {
    Plus,
    Minus,
    Not,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum BinaryOp {
    Add,
    Subtract,
    Multiply,
    Divide,
    Div,
    Mod,
    And,
    Or,
    Relation(Relation),
    /// `>=<`, equal within a tolerance.
    Approx,
    /// `:`, frame composition.
    Compose,
    /// `@`, inner product.
    Inner,
    /// `#`, cross product.
    Cross,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Relation {
    Equal,
    NotEqual,
    Less,
    Greater,
    LessEqual,
    GreaterEqual,
}

impl Relation {
    pub(crate) fn text(self) -> &'static str {
        match self {
            Relation::Equal => "=",
            Relation::NotEqual => "<>",
            Relation::Less => "<",
            Relation::Greater => ">",
            Relation::LessEqual => "<=",
            Relation::GreaterEqual => ">=",
        }
    }
}

impl BinaryOp {
    pub(crate) fn text(self) -> &'static str {
        match self {
            BinaryOp::Add => "+",
            BinaryOp::Subtract => "-",
            BinaryOp::Multiply => "*",
            BinaryOp::Divide => "/",
            BinaryOp::Div => "DIV",
            BinaryOp::Mod => "MOD",
            BinaryOp::And => "AND",
            BinaryOp::Or => "OR",
            BinaryOp::Relation(relation) => relation.text(),
            BinaryOp::Approx => ">=<",
            BinaryOp::Compose => ":",
            BinaryOp::Inner => "@",
            BinaryOp::Cross => "#",
        }
    }
}

impl UnaryOp {
    pub(crate) fn text(self) -> &'static str {
        match self {
            UnaryOp::Plus => "+",
            UnaryOp::Minus => "-",
            UnaryOp::Not => "NOT",
        }
    }
}
