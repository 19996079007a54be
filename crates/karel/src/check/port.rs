//! I/O ports in expressions, assignments and pulses.

use super::Checker;
use crate::{
    ast::{self, Path, PathStep},
    port::Port,
    typed::{Expr, ExprKind, PortPlace, StmtKind, Target},
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

    /// A port that can be written and is on or off.
    pub(super) fn pulse(
        &mut self,
        path: &Path,
        time: &ast::Expr,
        waits: ast::Waits,
    ) -> Option<StmtKind> {
        let time = self.integer(time);
        let port = self.switch_port(path, "PULSE")?;
        if port.port.is_input() {
            let message = format!("{} is an input and cannot be written", port.port);
            self.reports.error(path.span, message);
            return None;
        }
        Some(StmtKind::Pulse { port, time, waits })
    }

    /// A port that is on or off.
    pub(super) fn switch_port(&mut self, path: &Path, what: &str) -> Option<PortPlace> {
        let Some(port) = self.port_array(path).filter(|port| port.is_switch()) else {
            let message = format!("{what} needs a port that is on or off, such as DOUT[1]");
            self.reports.error(path.span, message);
            return None;
        };
        self.port_place(port, path)
    }
}

fn port_type(port: Port) -> Type {
    if port.is_switch() {
        Type::Boolean
    } else {
        Type::Integer
    }
}
