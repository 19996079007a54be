//! Calls of routines and built-ins.

use super::{Checker, Home, Signature};
use crate::{
    ast::{self, Name},
    builtins::{self, Builtin, Param, Returns},
    ir::{self, External},
    span::Span,
    typed::{Arg, BuiltinCall, Call, Callee, Expr, ExprKind, StmtKind},
    types::{JointKind, PositionKind, TextLength, Type},
};

impl Checker<'_> {
    pub(super) fn is_routine(&self, name: &str) -> bool {
        self.routines.contains_key(name) || builtins::find(name).is_some()
    }

    /// A call as a statement.
    pub(super) fn call_statement(&mut self, name: &Name, args: &[ast::Expr]) -> Option<StmtKind> {
        if let Some(signature) = self.signature(&name.text) {
            if signature.result.is_some() {
                let message = format!("`{}` is a function, its result must be used", name.text);
                self.reports.error(name.span, message);
            }
            return self.user_call(&signature, name, args).map(StmtKind::Call);
        }
        if let Some(builtin) = builtins::find(&name.text) {
            if !matches!(builtin.returns, Returns::Nothing) {
                let message = format!("`{}` is a function, its result must be used", name.text);
                self.reports.error(name.span, message);
            }
            return self
                .builtin_call(builtin, name, args)
                .map(StmtKind::Builtin);
        }
        self.unknown_routine(name);
        None
    }

    /// A call in an expression.
    pub(super) fn function_call(&mut self, name: &Name, args: &[ast::Expr]) -> Option<Expr> {
        if let Some(signature) = self.signature(&name.text) {
            let call = self.user_call(&signature, name, args)?;
            let Some(ty) = call.result.clone() else {
                return self.no_result(name);
            };
            return Some(Expr {
                kind: ExprKind::Call(call),
                ty,
            });
        }
        if let Some(builtin) = builtins::find(&name.text) {
            let call = self.builtin_call(builtin, name, args)?;
            let Some(ty) = call.result.clone() else {
                return self.no_result(name);
            };
            return Some(Expr {
                kind: ExprKind::Builtin(call),
                ty,
            });
        }
        self.unknown_routine(name);
        None
    }

    fn no_result(&mut self, name: &Name) -> Option<Expr> {
        self.reports
            .error(name.span, format!("`{}` returns nothing", name.text));
        None
    }

    fn unknown_routine(&mut self, name: &Name) {
        if self.find_symbol(&name.text).is_some() {
            let message = format!("`{}` is not a routine", name.text);
            self.reports
                .error_with_help(name.span, message, "subscripts stand in `[` and `]`");
        } else if builtins::is_planned(&name.text) {
            let message = format!("the built-in {} is not supported yet", name.text);
            self.reports.error(name.span, message);
        } else {
            let message = format!("there is no routine `{}`", name.text);
            self.report_unknown(name, &message, &builtins::names());
        }
    }

    fn signature(&self, name: &str) -> Option<Signature> {
        self.routines
            .get(name)
            .and_then(|index| self.signatures.get(*index))
            .cloned()
    }

    fn user_call(
        &mut self,
        signature: &Signature,
        name: &Name,
        args: &[ast::Expr],
    ) -> Option<Call> {
        let callee = match &signature.home {
            Home::Here(routine) => Callee::Here(*routine),
            Home::Promised => return None,
            Home::External(program) => Callee::External(self.external(program, signature)),
        };
        if args.len() != signature.params.len() {
            self.wrong_count(
                name,
                args.len(),
                signature.params.len(),
                signature.params.len(),
            );
            return None;
        }
        let params = signature.params.iter();
        let checked = args
            .iter()
            .zip(params)
            .map(|(arg, (_, formal))| self.user_arg(arg, formal));
        let args: Vec<Arg> = checked.collect();
        Some(Call {
            callee,
            args,
            result: signature.result.clone(),
        })
    }

    /// The row of a routine of another program; it is looked for when programs are loaded.
    fn external(&mut self, program: &str, signature: &Signature) -> u32 {
        let mut known = self.externals.iter();
        let known = known.position(|known| known.routine == signature.name);
        let row = known.unwrap_or_else(|| {
            self.externals.push(External {
                program: program.to_owned(),
                routine: signature.name.clone(),
                signature: ir::Signature {
                    params: signature.types(),
                    result: signature.result.clone(),
                },
            });
            self.externals.len() - 1
        });
        u32::try_from(row).unwrap_or(u32::MAX)
    }

    fn wrong_count(&mut self, name: &Name, given: usize, least: usize, most: usize) {
        let takes = if least == most {
            least.to_string()
        } else {
            format!("{least} to {most}")
        };
        let noun = if most == 1 { "argument" } else { "arguments" };
        let message = format!("`{}` takes {takes} {noun}, here are {given}", name.text);
        self.reports.error(name.span, message);
    }

    /// By reference if the actual argument is a variable of exactly the formal type; otherwise a
    /// copy: expressions, constants, `(variable)`, and whatever is converted.
    fn user_arg(&mut self, arg: &ast::Expr, formal: &Type) -> Arg {
        let value = self.expr(arg);
        let is_variable = matches!(arg.kind, ast::ExprKind::Path(_));
        if let ExprKind::Place(place) = value.kind {
            if is_variable && passes_by_reference(&place.ty, formal) {
                return Arg::Reference(place);
            }
            let value = Expr {
                ty: place.ty.clone(),
                kind: ExprKind::Place(place),
            };
            return self.copied_arg(value, formal, arg.span);
        }
        self.copied_arg(value, formal, arg.span)
    }

    fn copied_arg(&mut self, value: Expr, formal: &Type, span: Span) -> Arg {
        let value = self.convert(value, formal, span);
        if value.ty.holds_file() {
            self.reports
                .error(span, "a FILE can only be passed as a variable");
        }
        let open = matches!(formal, Type::Array(array) if array.dims.is_empty());
        let formal = if open {
            value.ty.clone()
        } else {
            formal.clone()
        };
        Arg::Copy { value, formal }
    }

    fn builtin_call(
        &mut self,
        builtin: &'static Builtin,
        name: &Name,
        args: &[ast::Expr],
    ) -> Option<BuiltinCall> {
        if args.len() < builtin.required || args.len() > builtin.params.len() {
            self.wrong_count(name, args.len(), builtin.required, builtin.params.len());
            return None;
        }
        let mut checked = Vec::new();
        let mut types = Vec::new();
        for (arg, param) in args.iter().zip(builtin.params) {
            let (arg, ty) = self.builtin_arg(arg, *param);
            checked.push(arg);
            types.push(ty);
        }
        let result = match builtin.returns {
            Returns::Nothing => None,
            Returns::Integer => Some(Type::Integer),
            Returns::Real => Some(Type::Real),
            Returns::Boolean => Some(Type::Boolean),
            Returns::Text => Some(Type::TEXT),
            Returns::XyzwprExt => Some(Type::Position(PositionKind::XyzwprExt)),
            Returns::Joints => Some(Type::Joints(JointKind::OfGroup)),
            Returns::SameAsFirst => types.first().cloned(),
        };
        Some(BuiltinCall {
            builtin,
            args: checked,
            types,
            result,
        })
    }

    fn builtin_arg(&mut self, arg: &ast::Expr, param: Param) -> (Arg, Type) {
        match param {
            Param::Integer => self.value_arg(arg, &Type::Integer),
            Param::Real => self.value_arg(arg, &Type::Real),
            Param::Text => self.value_arg(arg, &Type::TEXT),
            Param::Boolean => self.value_arg(arg, &Type::Boolean),
            Param::InOutInteger => self.in_out_arg(arg, &Type::Integer),
            Param::InOutText => self.in_out_arg(arg, &Type::TEXT),
            Param::Position(kind) => self.value_arg(arg, &Type::Position(kind)),
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
            Param::RealArray => {
                let (found, ty) = self.any_variable(arg, false);
                let mut fits = ty == Type::Error;
                if let Type::Array(array) = &ty {
                    fits = array.element == Type::Real && array.dims.len() <= 1;
                }
                if !fits {
                    let message = format!("expected an ARRAY OF REAL, this is {ty}");
                    self.reports.error(arg.span, message);
                }
                (found, ty)
            }
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
            Param::AnyValue => self.any_value(arg),
        }
    }

    fn value_arg(&mut self, arg: &ast::Expr, wanted: &Type) -> (Arg, Type) {
        (Arg::Value(self.expr_of(arg, wanted)), wanted.clone())
    }

    /// A variable of exactly this type, or a constant, which is legal and ignored.
    fn out_arg(&mut self, arg: &ast::Expr, wanted: &Type) -> (Arg, Type) {
        let value = self.expr(arg);
        let fits = value.ty == *wanted || (value.ty.is_text() && wanted.is_text());
        if value.ty != Type::Error && !fits {
            let message = format!(
                "this output needs a variable of type {wanted}, not {}",
                value.ty
            );
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
        if matches!(ty, Type::File | Type::Array(_) | Type::Structure(_)) {
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

fn passes_by_reference(actual: &Type, formal: &Type) -> bool {
    match (actual, formal) {
        (Type::Text(_), Type::Text(TextLength::Any)) => true,
        (Type::Array(from), Type::Array(to)) if to.dims.is_empty() => {
            from.element == to.element && from.dims.len() <= 1
        }
        _ => actual == formal,
    }
}
