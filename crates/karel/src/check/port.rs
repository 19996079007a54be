//! I/O ports in expressions and assignments, and conditions that wait for them.

use super::Checker;
use crate::{
    ast::{self, Path, PathStep},
    port::Port,
    span::Span,
    typed::{Expr, ExprKind, Op, PortPlace, StmtKind, Target},
    types::Type,
};

impl Checker<'_> {
    /// The array of ports that a path means; a variable of the program may have its name.
    pub(super) fn port_array(&self, path: &Path) -> Option<Port> {
        let port = Port::named(&path.root.text)?;
        let name = &path.root.text;
        let hidden = self.find_symbol(name).is_some() || self.using_field(name).is_some();
        (!hidden).then_some(port)
    }

    pub(super) fn port_place(&mut self, port: Port, path: &Path) -> Option<PortPlace> {
        if let [PathStep::Index { subscripts, .. }] = path.steps.as_slice()
            && let [number] = subscripts.as_slice()
        {
            let number = Box::new(self.integer(number));
            return Some(PortPlace { port, number });
        }
        let message = format!("{port} needs the number of one port");
        let help = format!("write {port}[1]");
        self.reports.error_with_help(path.span, message, help);
        None
    }

    pub(super) fn port_expression(&mut self, port: Port, path: &Path) -> Option<Expr> {
        let place = self.port_place(port, path)?;
        Some(Expr {
            kind: ExprKind::Port(place),
            ty: port_type(port),
        })
    }

    pub(super) fn assign_port(
        &mut self,
        port: Port,
        target: &Path,
        value: &ast::Expr,
    ) -> Option<StmtKind> {
        let value = self.expr_of(value, &port_type(port));
        let place = self.port_place(port, target)?;
        if port.is_input() {
            let message = format!("{port} is an input and cannot be written");
            self.reports.error(target.span, message);
            return None;
        }
        Some(StmtKind::Assign {
            target: Target::Port(place),
            value,
        })
    }

    /// `WAIT FOR a, b`: both must hold at the same look.
    pub(super) fn wait_for(&mut self, conditions: &[ast::Expr], span: Span) -> Option<StmtKind> {
        let mut all: Option<Expr> = None;
        if conditions.len() > usize::from(crate::parser::MAX_HEIGHT) {
            self.reports.error(span, "too many conditions");
            return None;
        }
        for condition in conditions {
            let next = self.boolean(condition);
            all = Some(match all {
                None => next,
                Some(before) => Expr {
                    kind: ExprKind::Binary {
                        op: Op::And,
                        left: Box::new(before),
                        right: Box::new(next),
                    },
                    ty: Type::Boolean,
                },
            });
        }
        all.map(StmtKind::WaitFor)
    }
}

fn port_type(port: Port) -> Type {
    if port.is_switch() {
        Type::Boolean
    } else {
        Type::Integer
    }
}
