//! Arguments of built-ins: what each kind of parameter takes.

use super::Checker;
use crate::{
    ast,
    builtins::Param,
    span::Span,
    typed::{Arg, Expr, ExprKind},
    types::Type,
};

impl Checker<'_> {
    pub(super) fn builtin_arg(&mut self, arg: &ast::Expr, param: Param) -> (Arg, Type) {
        match param {
            Param::Integer => self.value_arg(arg, &Type::Integer),
            Param::Real => self.value_arg(arg, &Type::Real),
            Param::Text => self.value_arg(arg, &Type::TEXT),
            Param::Boolean => self.value_arg(arg, &Type::Boolean),
            Param::InOutInteger => self.in_out_arg(arg, &Type::Integer),
            Param::InOutText => self.in_out_arg(arg, &Type::TEXT),
            Param::Position(kind) => self.value_arg(arg, &Type::Position(kind)),
            Param::Vector => self.value_arg(arg, &Type::vector()),
            Param::Number => {
                let value = self.expr(arg);
                if !value.ty.is_number() {
                    let message = format!("expected INTEGER or REAL, this is {}", value.ty);
                    self.reports.error(arg.span, message);
                }
                let ty = value.ty.clone();
                (Arg::Value(value), ty)
            }
            Param::Config => self.value_arg(arg, &Type::Config),
            Param::Joints => {
                let value = self.expr(arg);
                self.expect_joints(&value.ty, arg.span);
                let ty = value.ty.clone();
                (Arg::Value(value), ty)
            }
            Param::OutJoints => {
                let (found, ty) = self.any_variable(arg, false);
                self.expect_joints(&ty, arg.span);
                (found, ty)
            }
            Param::OutPosition => {
                let (found, ty) = self.any_variable(arg, false);
                if !matches!(ty, Type::Position(_) | Type::Error) {
                    let message = format!("expected a POSITION, this is {ty}");
                    self.reports.error(arg.span, message);
                }
                (found, ty)
            }
            Param::RealArray => self.array_arg(arg, "REAL", |ty| *ty == Type::Real),
            Param::IntegerArray => self.array_arg(arg, "INTEGER", |ty| *ty == Type::Integer),
            Param::TextArray => self.array_arg(arg, "STRING", Type::is_text),
            Param::OutConfig => self.out_arg(arg, &Type::Config),
            Param::OutBoolean => self.out_arg(arg, &Type::Boolean),
            Param::OutInteger => self.out_arg(arg, &Type::Integer),
            Param::OutReal => self.out_arg(arg, &Type::Real),
            Param::OutText => self.out_arg(arg, &Type::TEXT),
            Param::OutAny => self.any_variable(arg, true),
            Param::File => self.file_arg(arg),
            Param::AnyVariable => self.any_variable(strip_parens(arg), false),
            Param::AnyArray => {
                let (found, ty) = self.any_variable(arg, false);
                if !matches!(ty, Type::Array(_) | Type::Error) {
                    self.reports
                        .error(arg.span, format!("expected an array, this is {ty}"));
                }
                (found, ty)
            }
            Param::Path => {
                let (found, ty) = self.any_variable(arg, false);
                if !matches!(ty, Type::Path(_) | Type::Error) {
                    let message = format!("expected a PATH, this is {ty}");
                    self.reports.error(arg.span, message);
                }
                (found, ty)
            }
            Param::Queue => {
                let (found, ty) = self.any_variable(arg, false);
                if !ty.is_queue() && ty != Type::Error {
                    let message = format!("expected a QUEUE_TYPE, this is {ty}");
                    self.reports.error(arg.span, message);
                }
                (found, ty)
            }
            Param::AnyValue => self.any_value(arg),
        }
    }

    fn value_arg(&mut self, arg: &ast::Expr, wanted: &Type) -> (Arg, Type) {
        (Arg::Value(self.expr_of(arg, wanted)), wanted.clone())
    }

    /// A variable of exactly this type, or a constant, which is legal and ignored.
    fn out_arg(&mut self, arg: &ast::Expr, wanted: &Type) -> (Arg, Type) {
        let value = self.expr(arg);
        let actual = if let ExprKind::Place(place) = &value.kind {
            &place.ty
        } else {
            &value.ty
        };
        let fits = actual == wanted || (actual.is_text() && wanted.is_text());
        if *actual != Type::Error && !fits {
            let message = format!("this output needs a variable of type {wanted}, not {actual}");
            self.reports.error(arg.span, message);
        }
        let ty = value.ty;
        let arg = match value.kind {
            ExprKind::Place(place) => Arg::Reference(place),
            ExprKind::System(place) => Arg::System(place),
            ExprKind::Port(place) => {
                let message = format!("a port such as {} cannot be an output here", place.port);
                self.reports
                    .error_with_help(arg.span, message, "use a variable of the program");
                Arg::Discard
            }
            ExprKind::Constant(_)
            | ExprKind::Call(_)
            | ExprKind::Builtin(_)
            | ExprKind::Negate(_)
            | ExprKind::Not(_)
            | ExprKind::Binary { .. }
            | ExprKind::ToReal(_)
            | ExprKind::ToPosition(_)
            | ExprKind::ToJoints(_) => Arg::Discard,
        };
        (arg, ty)
    }

    fn array_arg(
        &mut self,
        arg: &ast::Expr,
        name: &str,
        is_element: fn(&Type) -> bool,
    ) -> (Arg, Type) {
        let (found, ty) = self.any_variable(arg, false);
        let mut fits = ty == Type::Error;
        if let Type::Array(array) = &ty {
            fits = is_element(&array.element) && array.dims.len() <= 1;
        }
        if !fits {
            let message = format!("expected an ARRAY OF {name}, this is {ty}");
            self.reports.error(arg.span, message);
        }
        (found, ty)
    }

    fn expect_joints(&mut self, ty: &Type, span: Span) {
        if !matches!(ty, Type::Joints(_) | Type::Error) {
            let message = format!("expected a JOINTPOS, this is {ty}");
            self.reports.error(span, message);
        }
    }

    fn in_out_arg(&mut self, arg: &ast::Expr, wanted: &Type) -> (Arg, Type) {
        let (found, ty) = self.any_value(arg);
        if ty != Type::Error && ty != *wanted {
            let message = format!("expected {wanted}, this is {ty}");
            self.reports.error(arg.span, message);
        }
        (found, ty)
    }

    fn file_arg(&mut self, arg: &ast::Expr) -> (Arg, Type) {
        let (found, ty) = self.any_variable(arg, false);
        if !matches!(ty, Type::File | Type::Error) {
            self.reports
                .error(arg.span, format!("expected a FILE variable, this is {ty}"));
        }
        (found, ty)
    }

    /// A variable of any type; it is not read, so it may be uninitialized.
    fn any_variable(&mut self, arg: &ast::Expr, system: bool) -> (Arg, Type) {
        let value = self.expr(arg);
        let ty = value.ty;
        let arg = match value.kind {
            ExprKind::Place(place) => Arg::Reference(place),
            ExprKind::System(place) if system => Arg::System(place),
            ExprKind::Constant(_)
            | ExprKind::System(_)
            | ExprKind::Port(_)
            | ExprKind::Call(_)
            | ExprKind::Builtin(_)
            | ExprKind::Negate(_)
            | ExprKind::Not(_)
            | ExprKind::Binary { .. }
            | ExprKind::ToReal(_)
            | ExprKind::ToPosition(_)
            | ExprKind::ToJoints(_) => {
                if ty != Type::Error {
                    self.reports.error(arg.span, "a variable is needed here");
                }
                Arg::Discard
            }
        };
        (arg, ty)
    }

    /// A variable by reference, uninitialized or not, or any other value as a copy.
    fn any_value(&mut self, arg: &ast::Expr) -> (Arg, Type) {
        let value = self.expr(arg);
        let ty = if matches!(value.ty, Type::Text(_)) {
            Type::TEXT
        } else {
            value.ty
        };
        if matches!(
            ty,
            Type::File | Type::Array(_) | Type::Structure(_) | Type::Path(_)
        ) {
            self.reports.error(
                arg.span,
                format!("a value of type {ty} is not supported here yet"),
            );
        }
        let arg = if let ExprKind::Place(place) = value.kind {
            Arg::Reference(place)
        } else {
            let value = Expr {
                kind: value.kind,
                ty: ty.clone(),
            };
            Arg::Copy {
                value,
                formal: ty.clone(),
            }
        };
        (arg, ty)
    }
}

fn strip_parens(mut expr: &ast::Expr) -> &ast::Expr {
    while let ast::ExprKind::Paren(inner) = &expr.kind {
        expr = inner;
    }
    expr
}
