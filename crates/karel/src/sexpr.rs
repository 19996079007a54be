//! The tree as S-expressions, for golden tests and for looking at a program.

use std::fmt::Write as _;

use crate::ast::{
    Condition, Conditions, Decl, Dim, Direction, Edge, Expr, ExprKind, Item, ItemKind, MoveForm,
    Param, Path, PathStep, Program, Routine, RoutineBody, Stmt, StmtKind, TypeExpr, TypeKind,
    Waits, When,
};

/// One line for each declaration and statement, indented by nesting.
pub(crate) fn program(program: &Program) -> String {
    let mut out = Printer {
        text: String::new(),
        indent: 0,
    };
    out.open(&format!("program {}", program.name.text));
    for directive in &program.directives {
        out.line(&format!(
            "(directive {} {:?})",
            directive.name, directive.argument
        ));
    }
    out.decls(&program.decls);
    out.nested("begin", &program.body);
    out.close();
    out.text
}

struct Printer {
    text: String,
    indent: usize,
}

impl Printer {
    fn line(&mut self, text: &str) {
        for _ in 0..self.indent {
            self.text.push_str("  ");
        }
        self.text.push_str(text);
        self.text.push('\n');
    }

    fn open(&mut self, head: &str) {
        self.line(&format!("({head}"));
        self.indent += 1;
    }

    /// Closes on the line of the last child.
    fn close(&mut self) {
        self.indent -= 1;
        let _ = self.text.pop();
        self.text.push_str(")\n");
    }

    fn nested(&mut self, head: &str, stmts: &[Stmt]) {
        self.open(head);
        for stmt in stmts {
            self.stmt(stmt);
        }
        self.close();
    }

    fn decls(&mut self, decls: &[Decl]) {
        for decl in decls {
            match decl {
                Decl::Const { name, value } => {
                    self.line(&format!("(const {} {})", name.text, expr(value)));
                }
                Decl::Type { name, ty } => {
                    self.line(&format!("(type {} {})", name.text, type_expr(ty)));
                }
                Decl::Var { names, ty, .. } => {
                    let names: Vec<&str> = names.iter().map(|name| name.text.as_str()).collect();
                    self.line(&format!("(var ({}) {})", names.join(" "), type_expr(ty)));
                }
                Decl::Routine(routine) => self.routine(routine),
            }
        }
    }

    fn routine(&mut self, routine: &Routine) {
        let mut head = format!(
            "routine {} ({})",
            routine.name.text,
            params(&routine.params)
        );
        if let Some(result) = &routine.result {
            let _ = write!(head, " {}", type_expr(result));
        }
        match &routine.body {
            RoutineBody::From(program) => self.line(&format!("({head} (from {}))", program.text)),
            RoutineBody::Here { decls, stmts, .. } => {
                self.open(&head);
                self.decls(decls);
                self.nested("begin", stmts);
                self.close();
            }
        }
    }

    #[expect(clippy::too_many_lines, reason = "one arm for each statement")]
    fn stmt(&mut self, stmt: &Stmt) {
        match &stmt.kind {
            StmtKind::Label(name) => self.line(&format!("(label {})", name.text)),
            StmtKind::Assign { target, value } => {
                self.line(&format!("(= {} {})", path(target), expr(value)));
            }
            StmtKind::Call { name, args } => {
                self.line(&format!("(call {}{})", name.text, tail(args)));
            }
            StmtKind::If {
                condition,
                then,
                otherwise,
            } => {
                self.open(&format!("if {}", expr(condition)));
                self.nested("then", then);
                if !otherwise.is_empty() {
                    self.nested("else", otherwise);
                }
                self.close();
            }
            StmtKind::While { condition, body } => {
                self.nested(&format!("while {}", expr(condition)), body);
            }
            StmtKind::For {
                counter,
                from,
                to,
                direction,
                body,
            } => {
                let word = match direction {
                    Direction::Up => "to",
                    Direction::Down => "downto",
                };
                let head = format!("for {} {} {word} {}", counter.text, expr(from), expr(to));
                self.nested(&head, body);
            }
            StmtKind::Repeat { body, until } => {
                self.nested(&format!("repeat-until {}", expr(until)), body);
            }
            StmtKind::Select {
                value,
                cases,
                otherwise,
            } => {
                self.open(&format!("select {}", expr(value)));
                for case in cases {
                    self.nested(&format!("case{}", tail(&case.values)), &case.body);
                }
                if let Some(otherwise) = otherwise {
                    self.nested("else", otherwise);
                }
                self.close();
            }
            StmtKind::Goto(name) => self.line(&format!("(goto {})", name.text)),
            StmtKind::Return(None) => self.line("(return)"),
            StmtKind::Return(Some(value)) => self.line(&format!("(return {})", expr(value))),
            StmtKind::Read { file, items: list } => {
                self.line(&format!(
                    "(read {}{})",
                    file_name(file.as_ref()),
                    items(list)
                ));
            }
            StmtKind::Write { file, items: list } => {
                self.line(&format!(
                    "(write {}{})",
                    file_name(file.as_ref()),
                    items(list)
                ));
            }
            StmtKind::OpenFile { file, mode, name } => {
                self.line(&format!(
                    "(open-file {} {} {})",
                    path(file),
                    expr(mode),
                    expr(name)
                ));
            }
            StmtKind::CloseFile(file) => self.line(&format!("(close-file {})", path(file))),
            StmtKind::CancelFile(file) => self.line(&format!("(cancel-file {})", path(file))),
            StmtKind::Motion(verb) => {
                self.line(&format!("({}-motion)", verb.text().to_ascii_lowercase()));
            }
            StmtKind::Using { places, body } => {
                self.nested(&format!("using {}", joined(places, path)), body);
            }
            StmtKind::WaitFor(conditions) => {
                self.line(&format!("(wait-for {})", conditions_text(conditions)));
            }
            StmtKind::Delay(time) => self.line(&format!("(delay {})", expr(time))),
            StmtKind::ConnectTimer(timer) => self.timer("connect", timer),
            StmtKind::DisconnectTimer(timer) => self.timer("disconnect", timer),
            StmtKind::Move {
                form,
                via,
                waits,
                whens,
                until,
            } => {
                let word = if *waits == Waits::No { " nowait" } else { "" };
                let mut head = move_form(form);
                if let Some(via) = via {
                    let _ = write!(head, " (via {})", expr(via));
                }
                head.push_str(word);
                if let Some(until) = until {
                    let _ = write!(head, " (until {})", conditions_text(until));
                }
                if whens.is_empty() {
                    return self.line(&format!("({head})"));
                }
                self.open(&head);
                self.whens(whens);
                self.close();
            }
            StmtKind::Condition {
                number,
                with,
                whens,
            } => {
                let mut head = format!("condition {}", expr(number));
                for (name, value) in with {
                    let _ = write!(head, " (with {} {})", path(name), expr(value));
                }
                if whens.is_empty() {
                    return self.line(&format!("({head})"));
                }
                self.open(&head);
                self.whens(whens);
                self.close();
            }
            StmtKind::ConditionState { verb, number } => {
                let word = verb.text().to_ascii_lowercase();
                self.line(&format!("({word}-condition {})", expr(number)));
            }
            StmtKind::Action(action) => {
                self.line(&format!("({})", action.text().to_ascii_lowercase()));
            }
            StmtKind::Signal { what, number } => {
                let word = what.text().to_ascii_lowercase();
                self.line(&format!("(signal-{word} {})", expr(number)));
            }
            StmtKind::Task { verb, task } => {
                let word = verb.text().to_ascii_lowercase();
                match task {
                    None => self.line(&format!("({word})")),
                    Some(task) => self.line(&format!("({word}-program {})", expr(task))),
                }
            }
            StmtKind::Pulse { port, time, waits } => {
                let word = if *waits == Waits::No { " nowait" } else { "" };
                self.line(&format!("(pulse {} {}{word})", path(port), expr(time)));
            }
            StmtKind::Hand { verb, number } => {
                let word = verb.text().to_ascii_lowercase();
                self.line(&format!("({word}-hand {})", expr(number)));
            }
        }
    }

    fn whens(&mut self, whens: &[When]) {
        for when in whens {
            let head = format!("when {}", conditions_text(&when.conditions));
            self.nested(&head, &when.actions);
        }
    }

    fn timer(&mut self, word: &str, timer: &Path) {
        self.line(&format!("({word}-timer {})", path(timer)));
    }
}

fn conditions_text(conditions: &Conditions) -> String {
    let terms = joined(&conditions.terms, condition);
    if conditions.all {
        terms
    } else {
        format!("(or {terms})")
    }
}

fn condition(condition: &Condition) -> String {
    let numbered =
        |word: &str, number: &Expr| format!("({} {})", word.to_ascii_lowercase(), expr(number));
    match condition {
        Condition::Expr(state) => expr(state),
        Condition::Task { verb, task: None } => {
            format!("({})", verb.text().to_ascii_lowercase())
        }
        Condition::Task {
            verb,
            task: Some(task),
        } => numbered(verb.text(), task),
        Condition::Error(None) => "(error *)".to_owned(),
        Condition::Error(Some(number)) => numbered("error", number),
        Condition::Signaled { what, number } => numbered(what.text(), number),
        Condition::PowerUp => "(powerup)".to_owned(),
        Condition::Edge { port, edge } => {
            let sign = if *edge == Edge::Rising { "+" } else { "-" };
            format!("(edge{sign} {})", path(port))
        }
        Condition::AtNode { node: None, .. } => "(at-node *)".to_owned(),
        Condition::AtNode {
            node: Some(node), ..
        } => numbered("at-node", node),
        Condition::NodeTime {
            time, side, node, ..
        } => {
            let side = side.text().to_ascii_lowercase();
            format!("(time-{side}-node {} {})", expr(time), expr(node))
        }
    }
}

fn move_form(form: &MoveForm) -> String {
    match form {
        MoveForm::To(target) => format!("move-to {}", expr(target)),
        MoveForm::Near { target, distance } => {
            format!("move-near {} {}", expr(target), expr(distance))
        }
        MoveForm::Axis { axis, distance } => {
            format!("move-axis {} {}", expr(axis), expr(distance))
        }
        MoveForm::Relative(vector) => format!("move-relative {}", expr(vector)),
        MoveForm::About { vector, angle } => {
            format!("move-about {} {}", expr(vector), expr(angle))
        }
        MoveForm::Away(distance) => format!("move-away {}", expr(distance)),
        MoveForm::Along(nodes) => format!("move-along {}", path(nodes)),
    }
}

fn tail(args: &[Expr]) -> String {
    args.iter()
        .fold(String::new(), |list, arg| list + " " + &expr(arg))
}

fn joined<T>(list: &[T], text: fn(&T) -> String) -> String {
    list.iter().map(text).collect::<Vec<_>>().join(" ")
}

fn file_name(file: Option<&Path>) -> String {
    file.map_or_else(|| "()".to_owned(), path)
}

fn items(items: &[Item]) -> String {
    let item = |item: &Item| {
        let value = match &item.kind {
            ItemKind::Value(value) => expr(value),
            ItemKind::LineEnd => "cr".to_owned(),
        };
        if item.formats.is_empty() {
            format!(" {value}")
        } else {
            format!(" (:: {value}{})", tail(&item.formats))
        }
    };
    items.iter().map(item).collect()
}

fn params(params: &[Param]) -> String {
    let list = params.iter().flat_map(|param| {
        param
            .names
            .iter()
            .map(|name| format!("({} {})", name.text, type_expr(&param.ty)))
    });
    list.collect::<Vec<_>>().join(" ")
}

fn type_expr(ty: &TypeExpr) -> String {
    match &ty.kind {
        TypeKind::Name(name) => name.text.clone(),
        TypeKind::Text(None) => "STRING".to_owned(),
        TypeKind::Text(Some(length)) => format!("(string {})", expr(length)),
        TypeKind::Array { dims, element } => {
            let dims = dims.iter().map(|dim| match dim {
                Dim::Length(length) => expr(length),
                Dim::Open(_) => "*".to_owned(),
            });
            let dims: Vec<String> = dims.collect();
            format!("(array ({}) {})", dims.join(" "), type_expr(element))
        }
        TypeKind::Structure(fields) => format!("(structure {})", params(fields)),
        TypeKind::Path { header, node } => {
            let part = |word: &str, ty: &Option<Box<TypeExpr>>| {
                let ty = ty.as_deref().map(type_expr);
                ty.map_or_else(String::new, |ty| format!(" ({word} {ty})"))
            };
            format!("(path{}{})", part("header", header), part("node", node))
        }
    }
}

fn path(path: &Path) -> String {
    path.steps
        .iter()
        .fold(path.root.text.clone(), |inner, step| match step {
            PathStep::Field(name) => format!("(. {inner} {})", name.text),
            PathStep::Index { subscripts, .. } => format!("([] {inner}{})", tail(subscripts)),
            PathStep::Range { first, last, .. } => {
                format!("(.. {inner} {} {})", expr(first), expr(last))
            }
        })
}

fn expr(expr_: &Expr) -> String {
    match &expr_.kind {
        ExprKind::Integer(value) => value.to_string(),
        ExprKind::Real(value) => format!("{value:?}"),
        ExprKind::Text(bytes) => format!("{:?}", crate::span::latin1(bytes)),
        ExprKind::Path(found) => path(found),
        ExprKind::Call { name, args } => format!("({}{})", name.text, tail(args)),
        ExprKind::Unary { op, operand } => format!("({} {})", op.text(), expr(operand)),
        ExprKind::Binary { op, left, right } => {
            format!("({} {} {})", op.text(), expr(left), expr(right))
        }
        ExprKind::Paren(inner) => format!("(paren {})", expr(inner)),
        ExprKind::Error => "<error>".to_owned(),
    }
}
