//! Expressions: types, operators, conversions.

use super::{Checker, call::result_type};
use crate::{
    ast::{self, BinaryOp, Relation, UnaryOp},
    builtins::{self, Builtin, Param},
    generation::Generation,
    span::Span,
    typed::{Arg, BuiltinCall, Constant, Expr, ExprKind, Op, Step},
    types::Type,
    value::Text,
};

impl Checker<'_> {
    /// An expression of any type. What was reported has [`Type::Error`].
    pub(super) fn expr(&mut self, expr: &ast::Expr) -> Expr {
        self.try_expr(expr).unwrap_or_else(error)
    }

    fn try_expr(&mut self, expr: &ast::Expr) -> Option<Expr> {
        match &expr.kind {
            ast::ExprKind::Integer(value) => {
                let Ok(value) = i32::try_from(*value) else {
                    self.reports
                        .error(expr.span, "this INTEGER does not fit into 32 bits");
                    return None;
                };
                Some(constant(Constant::Integer(value)))
            }
            ast::ExprKind::Real(value) => {
                if !value.is_finite() {
                    self.reports
                        .error(expr.span, "this REAL does not fit into 32 bits");
                    return None;
                }
                Some(constant(Constant::Real(*value)))
            }
            ast::ExprKind::Text(bytes) => {
                if bytes.len() > self.generation.longest_string() {
                    self.too_long(bytes.len(), expr.span);
                    return None;
                }
                Some(constant(Constant::Text(Text::new(bytes.clone()))))
            }
            ast::ExprKind::Path(path) => self.path_expression(path),
            ast::ExprKind::Call { name, args } => self.function_call(name, args),
            ast::ExprKind::Unary { op, operand } => self.unary(*op, operand, expr.span),
            ast::ExprKind::Binary { op, left, right } => {
                let (left, right) = (self.expr(left), self.expr(right));
                self.binary(*op, left, right, expr.span)
            }
            ast::ExprKind::Paren(inner) => Some(self.expr(inner)),
            ast::ExprKind::Error => None,
        }
    }

    /// A string literal that no variable of this generation can hold.
    pub(super) fn too_long(&mut self, bytes: usize, span: Span) {
        let most = self.generation.longest_string();
        let of = match self.generation {
            Generation::Any => String::new(),
            Generation::V7 | Generation::V9 => format!(" of {}", self.generation.name()),
        };
        let message = format!("a string{of} has at most {most} bytes, this one has {bytes}");
        self.reports.error(span, message);
    }

    fn unary(&mut self, op: UnaryOp, operand: &ast::Expr, span: Span) -> Option<Expr> {
        if op == UnaryOp::Minus
            && let ast::ExprKind::Integer(value) = operand.kind
            && let Ok(value) = i32::try_from(value.saturating_neg())
        {
            return Some(constant(Constant::Integer(value)));
        }
        let operand = self.try_expr(operand)?;
        let ty = operand.ty.clone();
        let fits = match op {
            UnaryOp::Plus | UnaryOp::Minus => ty.is_number(),
            UnaryOp::Not => matches!(ty, Type::Integer | Type::Boolean | Type::Error),
        };
        if !fits {
            self.reports
                .error(span, format!("{} cannot be applied to {ty}", op.text()));
            return None;
        }
        let kind = match op {
            UnaryOp::Plus => return Some(operand),
            UnaryOp::Minus => ExprKind::Negate(Box::new(operand)),
            UnaryOp::Not => ExprKind::Not(Box::new(operand)),
        };
        Some(Expr { kind, ty })
    }

    fn binary(&mut self, op: BinaryOp, left: Expr, right: Expr, span: Span) -> Option<Expr> {
        if left.ty == Type::Error || right.ty == Type::Error {
            return None;
        }
        let numbers = left.ty.is_number() && right.ty.is_number();
        let integers = left.ty == Type::Integer && right.ty == Type::Integer;
        let booleans = left.ty == Type::Boolean && right.ty == Type::Boolean;
        let texts = left.ty.is_text() && right.ty.is_text();
        match op {
            BinaryOp::Add if texts => return result(Op::Concatenate, Type::TEXT, left, right),
            BinaryOp::Add if numbers => return sum(Op::Add, left, right),
            BinaryOp::Subtract if numbers => return sum(Op::Subtract, left, right),
            BinaryOp::Multiply if numbers => return sum(Op::Multiply, left, right),
            // INTEGER / INTEGER is a REAL.
            BinaryOp::Divide if numbers => {
                return result(Op::Divide, Type::Real, to_real(left), to_real(right));
            }
            BinaryOp::Div if integers => return result(Op::Div, Type::Integer, left, right),
            BinaryOp::Mod if integers => return result(Op::Mod, Type::Integer, left, right),
            BinaryOp::And if integers => return result(Op::And, Type::Integer, left, right),
            BinaryOp::And if booleans => return result(Op::And, Type::Boolean, left, right),
            BinaryOp::Or if integers => return result(Op::Or, Type::Integer, left, right),
            BinaryOp::Or if booleans => return result(Op::Or, Type::Boolean, left, right),
            BinaryOp::Relation(relation) => {
                let comparable = integers || texts || (booleans && is_equality(relation));
                if comparable {
                    return result(Op::Relation(relation), Type::Boolean, left, right);
                }
                if numbers {
                    let (left, right) = (to_real(left), to_real(right));
                    return result(Op::Relation(relation), Type::Boolean, left, right);
                }
            }
            BinaryOp::Approx
            | BinaryOp::Compose
            | BinaryOp::Inner
            | BinaryOp::Cross
            | BinaryOp::Add
            | BinaryOp::Subtract
            | BinaryOp::Multiply
            | BinaryOp::Divide
            | BinaryOp::Div
            | BinaryOp::Mod
            | BinaryOp::And
            | BinaryOp::Or => {}
        }
        if let Some(builtin) = geometric(op, &left.ty, &right.ty) {
            return Some(self.operator_call(builtin, left, right, span));
        }
        self.wrong_operands(op, &left.ty, &right.ty, span);
        None
    }

    /// An operator on vectors and positions: a built-in that has no name in programs.
    fn operator_call(
        &mut self,
        builtin: &'static Builtin,
        left: Expr,
        right: Expr,
        span: Span,
    ) -> Expr {
        let mut args = Vec::new();
        let mut types = Vec::new();
        for (operand, param) in [left, right].into_iter().zip(builtin.params) {
            let wanted = if let Param::Position(kind) = param {
                Type::Position(*kind)
            } else if let Param::Vector = param {
                Type::vector()
            } else {
                Type::Real
            };
            args.push(Arg::Value(self.convert(operand, &wanted, span)));
            types.push(wanted);
        }
        let ty = result_type(builtin, &types).unwrap_or(Type::Error);
        Expr {
            kind: ExprKind::Builtin(BuiltinCall {
                builtin,
                args,
                types,
                result: Some(ty.clone()),
            }),
            ty,
        }
    }

    fn wrong_operands(&mut self, op: BinaryOp, left: &Type, right: &Type, span: Span) {
        let message = format!("`{}` cannot be applied to {left} and {right}", op.text());
        let relations = *left == Type::Boolean || *right == Type::Boolean;
        let help = match op {
            BinaryOp::And | BinaryOp::Or if relations => {
                "AND and OR bind tighter than relations: put parentheses around each relation"
            }
            BinaryOp::And | BinaryOp::Or => "AND and OR take two INTEGERs or two BOOLEANs",
            BinaryOp::Div | BinaryOp::Mod => "ROUND or TRUNC turns a REAL into an INTEGER",
            BinaryOp::Add
            | BinaryOp::Subtract
            | BinaryOp::Multiply
            | BinaryOp::Divide
            | BinaryOp::Relation(_) => return self.reports.error(span, message),
            BinaryOp::Approx => "`>=<` compares two positions",
            BinaryOp::Compose => "`:` takes two POSITIONs, or a POSITION and a VECTOR",
            BinaryOp::Inner | BinaryOp::Cross => "`@` and `#` take two VECTORs",
        };
        self.reports.error_with_help(span, message, help);
    }

    /// An expression that must be of type `wanted`, converted if KAREL converts it.
    pub(super) fn expr_of(&mut self, written: &ast::Expr, wanted: &Type) -> Expr {
        let expr = self.expr(written);
        self.convert(expr, wanted, written.span)
    }

    pub(super) fn integer(&mut self, written: &ast::Expr) -> Expr {
        self.expr_of(written, &Type::Integer)
    }

    pub(super) fn boolean(&mut self, written: &ast::Expr) -> Expr {
        self.expr_of(written, &Type::Boolean)
    }

    /// The implicit conversions: INTEGER to REAL, and between the cartesian types.
    pub(super) fn convert(&mut self, expr: Expr, wanted: &Type, span: Span) -> Expr {
        if expr.ty == Type::Error || *wanted == Type::Error || expr.ty == *wanted {
            return expr;
        }
        let expr = if matches!(wanted, Type::Position(_)) {
            node_position(expr)
        } else {
            expr
        };
        match (&expr.ty, wanted) {
            (Type::Position(from), Type::Position(to)) if from == to => expr,
            (Type::Integer, Type::Real) => to_real(expr),
            (Type::Text(_), Type::Text(_)) => expr,
            (Type::Position(_), Type::Position(_)) => Expr {
                kind: ExprKind::ToPosition(Box::new(expr)),
                ty: wanted.clone(),
            },
            (Type::Joints(_), Type::Joints(_)) => Expr {
                kind: ExprKind::ToJoints(Box::new(expr)),
                ty: wanted.clone(),
            },
            (Type::Array(from), Type::Array(to))
                if to.dims.is_empty() && from.element == to.element =>
            {
                expr
            }
            (Type::Real, Type::Integer) => {
                self.reports.error_with_help(
                    span,
                    "expected INTEGER, this is REAL",
                    "ROUND or TRUNC turns a REAL into an INTEGER",
                );
                error()
            }
            _ => {
                self.reports
                    .error(span, format!("expected {wanted}, this is {}", expr.ty));
                error()
            }
        }
    }
}

/// The built-in behind an operator on vectors and positions.
fn geometric(op: BinaryOp, left: &Type, right: &Type) -> Option<&'static Builtin> {
    let kind = |ty: &Type| {
        if ty.position_kind().is_some() {
            Some('P')
        } else if ty.is_vector() {
            Some('V')
        } else {
            ty.is_number().then_some('R')
        }
    };
    builtins::find(&format!("{}{}{}", op.text(), kind(left)?, kind(right)?))
}

/// `+ - *` of two numbers: INTEGER if both are, else REAL.
fn sum(op: Op, left: Expr, right: Expr) -> Option<Expr> {
    if left.ty == Type::Integer && right.ty == Type::Integer {
        return result(op, Type::Integer, left, right);
    }
    result(op, Type::Real, to_real(left), to_real(right))
}

#[expect(clippy::unnecessary_wraps, reason = "every caller returns it as it is")]
fn result(op: Op, ty: Type, left: Expr, right: Expr) -> Option<Expr> {
    let kind = ExprKind::Binary {
        op,
        left: Box::new(left),
        right: Box::new(right),
    };
    Some(Expr { kind, ty })
}

fn is_equality(relation: Relation) -> bool {
    matches!(relation, Relation::Equal | Relation::NotEqual)
}

fn constant(constant: Constant) -> Expr {
    Expr {
        ty: constant.ty(),
        kind: ExprKind::Constant(constant),
    }
}

/// A standard node where a position is wanted: the position of the node.
fn node_position(mut expr: Expr) -> Expr {
    if let ExprKind::Place(place) = &mut expr.kind
        && place.ty.is_standard_node()
        && let Some((offset, ty)) = place.ty.field("NODE_POS")
    {
        place.steps.push(Step::Offset(offset));
        place.ty = ty.clone();
        expr.ty = ty;
    }
    expr
}

/// Stands for what was reported; never lowered.
pub(super) fn error() -> Expr {
    Expr {
        kind: ExprKind::Constant(Constant::Integer(0)),
        ty: Type::Error,
    }
}

fn to_real(expr: Expr) -> Expr {
    match expr {
        Expr { ty: Type::Real, .. } => expr,
        // A literal is converted here, once.
        Expr {
            kind: ExprKind::Constant(Constant::Integer(value)),
            ..
        } => constant(Constant::Real(crate::value::real_of(value))),
        Expr { .. } => Expr {
            kind: ExprKind::ToReal(Box::new(expr)),
            ty: Type::Real,
        },
    }
}
