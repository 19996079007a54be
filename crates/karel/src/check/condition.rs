//! Condition handlers and conditions.

use super::{Checker, Handler, HandlerPart, scope::Scope, scope::Symbol};
use crate::{
    ast,
    ast::{Action, Path},
    span::Span,
    typed::{Condition, Conditions, Expr, Stmt, StmtKind, When},
};

impl Checker<'_> {
    /// `CONDITION[n]: .. ENDCONDITION`.
    ///
    /// ASSUMPTION: of the variables after WITH only `$SCAN_TIME` changes anything.
    pub(super) fn condition_handler(
        &mut self,
        number: &ast::Expr,
        with: &[(Path, ast::Expr)],
        whens: &[ast::When],
        span: Span,
    ) -> Option<StmtKind> {
        let number = self.integer(number);
        let mut period = None;
        for (path, value) in with {
            if path.root.text == "$SCAN_TIME" && path.steps.is_empty() {
                period = Some(self.integer(value));
            } else {
                let message = format!("WITH {} changes nothing", path.root.text);
                self.reports.warning(path.span, message);
                let _ = self.expr(value);
            }
        }
        if self.handler.is_some() {
            self.reports
                .error(span, "a condition handler cannot define another");
            return None;
        }
        let whens = self.whens(whens)?;
        Some(StmtKind::Condition {
            number,
            period,
            whens,
        })
    }

    pub(super) fn whens(&mut self, whens: &[ast::When]) -> Option<Vec<When>> {
        // All of them, for all of their messages.
        let checked: Vec<Option<When>> = whens.iter().map(|when| self.when(when)).collect();
        checked.into_iter().collect()
    }

    fn when(&mut self, when: &ast::When) -> Option<When> {
        let conditions = self.in_handler(HandlerPart::Condition, |checker| {
            checker.conditions(&when.conditions)
        });
        let (actions, labels, frame_cells) = self.in_handler(HandlerPart::Actions, |checker| {
            let along = std::mem::take(&mut checker.along);
            let actions: Vec<Stmt> = checker.stmts(&when.actions);
            checker.along = along;
            checker.refuse_missing_labels();
            let cells = checker.locals.cells;
            (actions, checker.frame.next_label, cells)
        });
        Some(When {
            conditions: conditions?,
            actions,
            span: when.span,
            labels,
            frame_cells,
        })
    }

    /// Runs `check` where only names of the program are known: a handler outlives the routine that
    /// defines it.
    pub(super) fn in_handler<T>(
        &mut self,
        part: HandlerPart,
        check: impl FnOnce(&mut Self) -> T,
    ) -> T {
        let mut scope = Scope::default();
        let mut hidden = Vec::new();
        for (name, symbol) in &self.locals.symbols {
            match symbol {
                Symbol::Variable { .. } => hidden.push(name.clone()),
                Symbol::Constant(_) | Symbol::Type(_) => {
                    let _ = scope.symbols.insert(name.clone(), symbol.clone());
                }
            }
        }
        let locals = std::mem::replace(&mut self.locals, scope);
        let frame = std::mem::take(&mut self.frame);
        let outer = self.handler.replace(Handler { hidden, part });
        let result = check(self);
        self.handler = outer;
        self.frame = frame;
        self.locals = locals;
        result
    }

    pub(super) fn conditions(&mut self, conditions: &ast::Conditions) -> Option<Conditions> {
        let terms = conditions.terms.iter();
        let terms: Vec<Option<Condition>> = terms.map(|term| self.condition(term)).collect();
        Some(Conditions {
            terms: terms.into_iter().collect::<Option<_>>()?,
            all: conditions.all,
        })
    }

    fn condition(&mut self, condition: &ast::Condition) -> Option<Condition> {
        if let ast::Condition::AtNode { at, .. } | ast::Condition::NodeTime { at, .. } = condition
            && !self.along
        {
            let message = "a condition of a NODE stands only in the WHEN of a MOVE ALONG";
            self.reports.error(*at, message);
            return None;
        }
        Some(match condition {
            ast::Condition::Expr(state) => Condition::State(self.boolean(state)),
            ast::Condition::Task { verb, task } => Condition::Task {
                verb: *verb,
                task: task.as_ref().map(|task| self.integer(task)),
            },
            ast::Condition::Error(number) => {
                let number: Option<Expr> = number.as_ref().map(|number| self.integer(number));
                Condition::Error(number)
            }
            ast::Condition::Signaled { what, number } => Condition::Signaled {
                what: *what,
                number: self.integer(number),
            },
            ast::Condition::PowerUp => Condition::PowerUp,
            ast::Condition::Edge { port, edge } => Condition::Edge {
                port: self.switch_port(port, "an edge")?,
                edge: *edge,
            },
            ast::Condition::AtNode { node, .. } => {
                Condition::AtNode(node.as_ref().map(|node| self.integer(node)))
            }
            ast::Condition::NodeTime {
                time, side, node, ..
            } => Condition::NodeTime {
                time: self.integer(time),
                side: *side,
                node: self.integer(node),
            },
        })
    }

    pub(super) fn action(&mut self, action: Action, span: Span) -> Option<StmtKind> {
        if self.in_actions() {
            return Some(StmtKind::Action(action));
        }
        let message = format!("{} stands only among the actions of a WHEN", action.text());
        self.reports.error(span, message);
        None
    }

    fn in_actions(&self) -> bool {
        let handler = self.handler.as_ref();
        handler.is_some_and(|handler| handler.part == HandlerPart::Actions)
    }

    /// Refuses what a condition cannot do: it is looked at between two statements.
    pub(super) fn refuse_call_in_condition(&mut self, name: &ast::Name) -> Option<()> {
        let handler = self.handler.as_ref();
        if handler.is_some_and(|handler| handler.part == HandlerPart::Condition) {
            let message = format!("a condition cannot call the routine `{}`", name.text);
            self.reports
                .error_with_help(name.span, message, "call it among the actions");
            return None;
        }
        Some(())
    }

    /// Says why a variable of the routine is not known in a handler.
    pub(super) fn is_hidden(&mut self, name: &ast::Name) -> bool {
        let handler = self.handler.as_ref();
        let hidden = handler.is_some_and(|handler| handler.hidden.contains(&name.text));
        if hidden {
            let message = format!(
                "a condition handler cannot use `{}`, a variable of the routine",
                name.text
            );
            self.reports.error_with_help(
                name.span,
                message,
                "use a variable of the program: the handler outlives the routine",
            );
        }
        hidden
    }
}
