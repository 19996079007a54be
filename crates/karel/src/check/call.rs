//! Calls of routines and built-ins.

use super::{Checker, Home, Signature};
use crate::{
    ast::{self, Name},
    builtins::{
        self, Builtin, Returns,
        absent::{self, Absent},
    },
    ir::{self, External},
    span::Span,
    typed::{Arg, BuiltinCall, Call, Callee, Expr, ExprKind, StmtKind},
    types::{self, JointKind, PositionKind, TextLength, Type},
};

impl Checker<'_> {
    pub(super) fn is_routine(&self, name: &str) -> bool {
        self.routines.contains_key(name)
            || builtins::find(name).is_some()
            || absent::find(name).is_some()
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
            self.refuse_function(builtin, name);
            return self
                .builtin_call(builtin, name, args)
                .map(StmtKind::Builtin);
        }
        if let Some(absent) = absent::find(&name.text) {
            self.refuse_function(&absent.builtin, name);
            return Some(StmtKind::Builtin(self.absent_call(absent, name, args)));
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
        if let Some(absent) = absent::find(&name.text) {
            let call = self.absent_call(absent, name, args);
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

    fn refuse_function(&mut self, builtin: &Builtin, name: &Name) {
        if !matches!(builtin.returns, Returns::Nothing) {
            let message = format!("`{}` is a function, its result must be used", name.text);
            self.reports.error(name.span, message);
        }
    }

    /// A built-in that this controller does not have: its arguments are only looked at.
    fn absent_call(
        &mut self,
        absent: &'static Absent,
        name: &Name,
        args: &[ast::Expr],
    ) -> BuiltinCall {
        for arg in args {
            let _any = self.expr(arg);
        }
        let message = format!(
            "{} needs {}: calling it will be INTP-320",
            name.text, absent.needs
        );
        self.reports.warning(name.span, message);
        BuiltinCall {
            builtin: &absent.builtin,
            args: Vec::new(),
            types: Vec::new(),
            result: result_type(&absent.builtin, &[]),
        }
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
        } else if name.text == "BYNAME" {
            let message = "BYNAME stands only as an argument of a routine of a program";
            self.reports.error(name.span, message);
        } else if name.text == "DELETE_TPE" {
            let message = format!("there is no routine `{}`", name.text);
            let help = "CLEAR('NAME.TP', status) deletes a TP program";
            self.reports.error_with_help(name.span, message, help);
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
        self.refuse_call_in_condition(name)?;
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
        if let ast::ExprKind::Call { name, args } = &arg.kind
            && name.text == "BYNAME"
            && self.signature(&name.text).is_none()
        {
            return self.by_name(name, args, formal);
        }
        let value = self.expr(arg);
        let is_variable = matches!(arg.kind, ast::ExprKind::Path(_));
        if let ExprKind::Place(place) = value.kind {
            if is_variable && passes_by_reference(&place.ty, formal) {
                return match open_lengths(&place.ty, formal) {
                    Some(Some(lengths)) => Arg::OpenArray { place, lengths },
                    Some(None) => {
                        let message = format!("{} is too long for {formal}", place.ty);
                        self.reports.error(arg.span, message);
                        Arg::Discard
                    }
                    None => Arg::Reference(place),
                };
            }
            let value = Expr {
                ty: place.ty.of_value(),
                kind: ExprKind::Place(place),
            };
            return self.copied_arg(value, formal, arg.span);
        }
        self.copied_arg(value, formal, arg.span)
    }

    /// `BYNAME(program, variable, entry)`: the entry is an opaque cache and is not looked at.
    fn by_name(&mut self, name: &Name, args: &[ast::Expr], formal: &Type) -> Arg {
        let [program, variable, entry] = args else {
            self.wrong_count(name, args.len(), 3, 3);
            return Arg::Discard;
        };
        let _entry = self.integer(entry);
        Arg::ByName {
            program: self.expr_of(program, &Type::TEXT),
            variable: self.expr_of(variable, &Type::TEXT),
            formal: formal.clone(),
        }
    }

    fn copied_arg(&mut self, value: Expr, formal: &Type, span: Span) -> Arg {
        let value = self.convert(value, formal, span);
        if !value.ty.is_copied() {
            let what = if value.ty.holds_path() {
                "a PATH can only be passed as a variable"
            } else {
                "a FILE can only be passed as a variable"
            };
            self.reports.error(span, what);
        }
        let open = matches!(formal, Type::Array(array) if array.is_open());
        if matches!(formal, Type::Array(array) if array.element == Type::TEXT) {
            self.reports
                .error(span, "an array of strings can only be passed as a variable");
        }
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
        let result = result_type(builtin, &types);
        Some(BuiltinCall {
            builtin,
            args: checked,
            types,
            result,
        })
    }
}

/// The type of what a built-in returns.
pub(super) fn result_type(builtin: &Builtin, types: &[Type]) -> Option<Type> {
    match builtin.returns {
        Returns::Nothing => None,
        Returns::Integer => Some(Type::Integer),
        Returns::Real => Some(Type::Real),
        Returns::Boolean => Some(Type::Boolean),
        Returns::Text => Some(Type::TEXT),
        Returns::XyzwprExt => Some(Type::Position(PositionKind::XyzwprExt)),
        Returns::Position => Some(Type::Position(PositionKind::Position)),
        Returns::Vector => Some(Type::vector()),
        Returns::Joints => Some(Type::Joints(JointKind::OfGroup)),
        Returns::SameAsFirst => types.first().cloned(),
    }
}

/// The lengths that a reference to an array carries where several of them are open: `None` if
/// there is no need for that, nothing in it if they are too long.
#[expect(clippy::option_option, reason = "not needed, and not possible")]
fn open_lengths(actual: &Type, formal: &Type) -> Option<Option<u32>> {
    let (Type::Array(from), Type::Array(to)) = (actual, formal) else {
        return None;
    };
    if to.is_open_grid() && !from.is_open_grid() {
        return Some(types::grid_lengths(&from.dims));
    }
    if to.element != Type::TEXT {
        return None;
    }
    let ([length], Some(text)) = (from.dims.as_slice(), from.element.length()) else {
        return None;
    };
    Some(Some(types::text_array_lengths(*length, text)))
}

fn passes_by_reference(actual: &Type, formal: &Type) -> bool {
    match (actual, formal) {
        (Type::Text(_), Type::Text(TextLength::Any)) => true,
        (Type::Array(from), Type::Array(to)) if to.dims.is_empty() => {
            let texts = to.element == Type::TEXT && from.element.is_text();
            (from.element == to.element || texts) && from.dims.len() <= 1
        }
        (Type::Array(from), Type::Array(to)) if to.is_open_grid() => {
            from.element == to.element && from.dims.len() == to.dims.len()
        }
        _ => actual == formal,
    }
}
