//! Statements.

use super::{Checker, Label, scope::Symbol};
use crate::{
    ast::{self, Direction, Name, Path},
    span::Span,
    typed::{Case, Expr, Place, Root, Stmt, StmtKind, Target},
    types::Type,
};

impl Checker<'_> {
    pub(super) fn stmts(&mut self, stmts: &[ast::Stmt]) -> Vec<Stmt> {
        let mut checked = Vec::with_capacity(stmts.len());
        for stmt in stmts {
            if let Some(kind) = self.stmt(stmt) {
                checked.push(Stmt {
                    kind,
                    span: stmt.span,
                });
            }
        }
        checked
    }

    /// `None` if something was reported that leaves nothing to lower.
    fn stmt(&mut self, stmt: &ast::Stmt) -> Option<StmtKind> {
        match &stmt.kind {
            ast::StmtKind::Label(name) => Some(self.define_label(name)),
            ast::StmtKind::Goto(name) => Some(self.goto(name)),
            ast::StmtKind::Assign { target, value } => self.assign(target, value),
            ast::StmtKind::Call { name, args } => self.call_statement(name, args),
            ast::StmtKind::If {
                condition,
                then,
                otherwise,
            } => Some(StmtKind::If {
                condition: self.boolean(condition),
                then: self.stmts(then),
                otherwise: self.stmts(otherwise),
            }),
            ast::StmtKind::While { condition, body } => Some(StmtKind::While {
                condition: self.boolean(condition),
                body: self.stmts(body),
            }),
            ast::StmtKind::For {
                counter,
                from,
                to,
                direction,
                body,
            } => self.for_statement(counter, (from, to), *direction, body),
            ast::StmtKind::Repeat { body, until } => Some(StmtKind::Repeat {
                body: self.stmts(body),
                until: self.boolean(until),
            }),
            ast::StmtKind::Select {
                value,
                cases,
                otherwise,
            } => Some(self.select(value, cases, otherwise.as_deref())),
            ast::StmtKind::Return(value) => self.return_statement(value.as_ref(), stmt.span),
            ast::StmtKind::Read { file, items } => self.read(file.as_ref(), items),
            ast::StmtKind::Write { file, items } => self.write(file.as_ref(), items),
            ast::StmtKind::OpenFile { file, mode, name } => {
                let (mode, name) = (
                    self.expr_of(mode, &Type::TEXT),
                    self.expr_of(name, &Type::TEXT),
                );
                Some(StmtKind::OpenFile {
                    file: self.file(file)?,
                    mode,
                    name,
                })
            }
            ast::StmtKind::CloseFile(file) => self.file(file).map(StmtKind::CloseFile),
            ast::StmtKind::CancelFile(file) => self.file(file).map(StmtKind::CancelFile),
            ast::StmtKind::Motion(verb) => Some(StmtKind::Motion(*verb)),
            ast::StmtKind::Using { places, body } => Some(self.using(places, body)),
            ast::StmtKind::WaitFor(conditions) => {
                self.conditions(conditions).map(StmtKind::WaitFor)
            }
            ast::StmtKind::Delay(time) => Some(StmtKind::Delay(self.integer(time))),
            ast::StmtKind::ConnectTimer(path) => self.timer(path).map(StmtKind::ConnectTimer),
            ast::StmtKind::DisconnectTimer(path) => self.timer(path).map(StmtKind::DisconnectTimer),
            ast::StmtKind::Move {
                form,
                via,
                waits,
                whens,
                until,
            } => {
                self.karel_motion(stmt.span);
                self.move_statement((form, via.as_ref()), *waits, whens, until.as_ref())
            }
            ast::StmtKind::Condition {
                number,
                with,
                whens,
            } => self.condition_handler(number, with, whens, stmt.span),
            ast::StmtKind::ConditionState { verb, number } => Some(StmtKind::ConditionState {
                verb: *verb,
                number: self.integer(number),
            }),
            ast::StmtKind::Action(action) => self.action(*action, stmt.span),
            ast::StmtKind::Signal { what, number } => Some(StmtKind::Signal {
                what: *what,
                number: self.integer(number),
            }),
            ast::StmtKind::Task { verb, task } => Some(StmtKind::Task {
                verb: *verb,
                task: task.as_ref().map(|task| self.integer(task)),
            }),
            ast::StmtKind::Pulse { port, time, waits } => self.pulse(port, time, *waits),
            ast::StmtKind::Hand { verb, number } => Some(StmtKind::Hand {
                verb: *verb,
                number: self.integer(number),
            }),
        }
    }

    fn assign(&mut self, target: &Path, value: &ast::Expr) -> Option<StmtKind> {
        if target.root.text.starts_with('$') {
            let value_span = value.span;
            let value = self.expr(value);
            let place = self.system_place(target)?;
            let value = self.convert(value, &place.ty, value_span);
            return Some(StmtKind::Assign {
                target: Target::System(place),
                value,
            });
        }
        if let Some(port) = self.port_array(target) {
            return self.assign_port(port, target, value);
        }
        let place = self.place(target);
        let Some(place) = place else {
            // The value may hold more errors.
            let _ = self.expr(value);
            return None;
        };
        if place.ty.holds_path() {
            let message = "a PATH cannot be assigned";
            self.reports
                .error_with_help(target.span, message, "COPY_PATH copies its nodes");
            return None;
        }
        if place.ty.holds_file() {
            self.reports
                .error(target.span, "a FILE variable cannot be assigned");
            return None;
        }
        let value = self.expr_of(value, &place.ty.of_value());
        Some(StmtKind::Assign {
            target: Target::Place(place),
            value,
        })
    }

    fn for_statement(
        &mut self,
        counter: &Name,
        (from, to): (&ast::Expr, &ast::Expr),
        direction: Direction,
        body: &[ast::Stmt],
    ) -> Option<StmtKind> {
        let (from, to) = (self.integer(from), self.integer(to));
        let path = Path {
            root: counter.clone(),
            steps: Vec::new(),
            span: counter.span,
        };
        let place = self.place(&path);
        let body = self.stmts(body);
        let place = place?;
        if !matches!(place.ty, Type::Integer | Type::Error) {
            let message = format!(
                "the counter of a FOR must be an INTEGER, this is {}",
                place.ty
            );
            self.reports.error(counter.span, message);
        }
        Some(StmtKind::For {
            counter: place,
            from,
            to,
            direction,
            body,
        })
    }

    fn select(
        &mut self,
        value: &ast::Expr,
        cases: &[ast::Case],
        otherwise: Option<&[ast::Stmt]>,
    ) -> StmtKind {
        let value = self.integer(value);
        let checked = cases.iter().map(|case| Case {
            values: case
                .values
                .iter()
                .map(|value| self.integer(value))
                .collect(),
            body: self.stmts(&case.body),
        });
        let cases = checked.collect();
        let otherwise = otherwise.map(|stmts| self.stmts(stmts));
        StmtKind::Select {
            value,
            cases,
            otherwise,
        }
    }

    fn return_statement(&mut self, value: Option<&ast::Expr>, span: Span) -> Option<StmtKind> {
        let result = self.frame.result.clone();
        let value: Option<Expr> = match (value, result) {
            (Some(value), Some(result)) => {
                self.frame.returns_value = true;
                Some(self.expr_of(value, &result))
            }
            (Some(value), None) => {
                let message = if self.frame.is_main {
                    "the main program returns no value"
                } else {
                    "this routine returns no value"
                };
                self.reports.error(value.span, message);
                return None;
            }
            (None, Some(result)) => {
                self.frame.returns_value = true;
                let help = format!("write RETURN (value), a value of type {result}");
                self.reports
                    .error_with_help(span, "this function must return a value", help);
                return None;
            }
            (None, None) => None,
        };
        Some(StmtKind::Return(value))
    }

    /// A FILE variable.
    pub(super) fn file(&mut self, path: &Path) -> Option<Place> {
        let place = self.place(path)?;
        if place.ty != Type::File {
            if place.ty != Type::Error {
                let message = format!("expected a FILE variable, this is {}", place.ty);
                self.reports.error(path.span, message);
            }
            return None;
        }
        Some(place)
    }

    /// An INTEGER variable of a program: those of a routine go away while the clock goes on.
    fn timer(&mut self, path: &Path) -> Option<Place> {
        let place = self.place(path)?;
        if !matches!(place.ty, Type::Integer | Type::Error) {
            let message = format!("a timer must be an INTEGER, this is {}", place.ty);
            self.reports.error(path.span, message);
        }
        match place.root {
            Root::Global(_) | Root::Shared(_) => Some(place),
            Root::Local(_) | Root::Param(_) => {
                let message = "a timer must be a variable of the program, not of a routine";
                self.reports.error(path.span, message);
                None
            }
        }
    }

    fn define_label(&mut self, name: &Name) -> StmtKind {
        let using = self.using_cells();
        let id = self.label(name);
        if let Some(label) = self.frame.labels.get_mut(&name.text) {
            if label.defined {
                let message = format!("the label `{}` is defined twice", name.text);
                self.reports.error(name.span, message);
            }
            label.defined = true;
            label.using = using;
        }
        StmtKind::Label(id)
    }

    fn goto(&mut self, name: &Name) -> StmtKind {
        let using = self.using_cells();
        let id = self.label(name);
        if let Some(label) = self.frame.labels.get_mut(&name.text) {
            label.gotos.push((name.span, using));
        }
        StmtKind::Goto(id)
    }

    /// What tells one USING from another: its references are there only inside of it.
    fn using_cells(&self) -> Vec<u32> {
        self.frame.using.iter().map(|(cell, _)| *cell).collect()
    }

    fn label(&mut self, name: &Name) -> u32 {
        if let Some(label) = self.frame.labels.get(&name.text) {
            return label.id;
        }
        let id = self.frame.next_label;
        self.frame.next_label += 1;
        let label = Label {
            id,
            defined: false,
            first_use: name.span,
            using: Vec::new(),
            gotos: Vec::new(),
        };
        let _ = self.frame.labels.insert(name.text.clone(), label);
        id
    }

    pub(super) fn is_declared(&self, name: &str) -> bool {
        let is_variable = matches!(self.find_symbol(name), Some(Symbol::Variable { .. }));
        is_variable || self.using_field(name).is_some()
    }
}
