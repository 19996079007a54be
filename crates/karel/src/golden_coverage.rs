//! Whether every statement, condition, operator, built-in and error number has a golden program.
//!
//! The lists are taken from the code itself: a new statement does not compile here without a name, a new row of the table
//! of built-ins and a new status are found by walking them. Golden programs are `tests/cases` here, and
//! `karel-emulator/tests/cases` for what needs devices, an arm and alarms.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::ast::{
    Action, BinaryOp, Condition, ConditionVerb, Conditions, Decl, Expr, ExprKind, HandVerb, Item,
    ItemKind, MotionVerb, MoveForm, NodeSide, RoutineBody, Signaled, Stmt, StmtKind, TaskVerb,
    UnaryOp, Waits, When,
};
use crate::diagnostic::Reports;
use crate::include::IncludeFiles;
use crate::span::Source;
use crate::{Program, builtins, parser, tp};

/// Gives every pattern a name, and keeps the names.
macro_rules! named {
    ($all:ident, $name_of:ident($of:ty) { $($pattern:pat => $name:literal)* }) => {
        const $all: &[&str] = &[$($name),*];

        fn $name_of(of: &$of) -> &'static str {
            match of { $($pattern => $name),* }
        }
    };
}

named! { STATEMENTS, statement(StmtKind) {
    StmtKind::Label(_) => "label"
    StmtKind::Assign { .. } => "assignment"
    StmtKind::Call { .. } => "call"
    StmtKind::If { .. } => "IF"
    StmtKind::While { .. } => "WHILE"
    StmtKind::For { .. } => "FOR"
    StmtKind::Repeat { .. } => "REPEAT"
    StmtKind::Select { .. } => "SELECT"
    StmtKind::Goto(_) => "GOTO"
    StmtKind::Return(_) => "RETURN"
    StmtKind::Read { .. } => "READ"
    StmtKind::Write { .. } => "WRITE"
    StmtKind::OpenFile { .. } => "OPEN FILE"
    StmtKind::CloseFile(_) => "CLOSE FILE"
    StmtKind::CancelFile(_) => "CANCEL FILE"
    StmtKind::Motion(MotionVerb::Cancel) => "CANCEL"
    StmtKind::Motion(MotionVerb::Stop) => "STOP"
    StmtKind::Motion(MotionVerb::Resume) => "RESUME"
    StmtKind::Motion(MotionVerb::Hold) => "HOLD"
    StmtKind::Motion(MotionVerb::Unhold) => "UNHOLD"
    StmtKind::Motion(MotionVerb::Attach) => "ATTACH"
    StmtKind::Motion(MotionVerb::Release) => "RELEASE"
    StmtKind::Using { .. } => "USING"
    StmtKind::Delay(_) => "DELAY"
    StmtKind::ConnectTimer(_) => "CONNECT TIMER"
    StmtKind::DisconnectTimer(_) => "DISCONNECT TIMER"
    StmtKind::WaitFor(_) => "WAIT FOR"
    StmtKind::Move { via: Some(_), .. } => "MOVE VIA"
    StmtKind::Move { until: Some(_), .. } => "MOVE UNTIL"
    StmtKind::Move { form: MoveForm::To(_), waits: Waits::No, .. } => "MOVE TO NOWAIT"
    StmtKind::Move { form: MoveForm::To(_), .. } => "MOVE TO"
    StmtKind::Move { form: MoveForm::Near { .. }, .. } => "MOVE NEAR"
    StmtKind::Move { form: MoveForm::Axis { .. }, .. } => "MOVE AXIS"
    StmtKind::Move { form: MoveForm::Relative(_), .. } => "MOVE RELATIVE"
    StmtKind::Move { form: MoveForm::About { .. }, .. } => "MOVE ABOUT"
    StmtKind::Move { form: MoveForm::Away(_), .. } => "MOVE AWAY"
    StmtKind::Move { form: MoveForm::Along(_), .. } => "MOVE ALONG"
    StmtKind::Condition { .. } => "CONDITION"
    StmtKind::ConditionState { verb: ConditionVerb::Enable, .. } => "ENABLE"
    StmtKind::ConditionState { verb: ConditionVerb::Disable, .. } => "DISABLE"
    StmtKind::ConditionState { verb: ConditionVerb::Purge, .. } => "PURGE"
    StmtKind::Action(Action::NoAbort) => "NOABORT"
    StmtKind::Action(Action::NoPause) => "NOPAUSE"
    StmtKind::Action(Action::Unpause) => "UNPAUSE"
    StmtKind::Action(Action::NoMessage) => "NOMESSAGE"
    StmtKind::Action(Action::Restore) => "RESTORE"
    StmtKind::Signal { what: Signaled::Event, .. } => "SIGNAL EVENT"
    StmtKind::Signal { what: Signaled::Semaphore, .. } => "SIGNAL SEMAPHORE"
    StmtKind::Task { verb: TaskVerb::Abort, task: None } => "ABORT"
    StmtKind::Task { verb: TaskVerb::Abort, task: Some(_) } => "ABORT PROGRAM"
    StmtKind::Task { verb: TaskVerb::Pause, task: None } => "PAUSE"
    StmtKind::Task { verb: TaskVerb::Pause, task: Some(_) } => "PAUSE PROGRAM"
    StmtKind::Task { verb: TaskVerb::Continue, task: None } => "CONTINUE"
    StmtKind::Task { verb: TaskVerb::Continue, task: Some(_) } => "CONTINUE PROGRAM"
    StmtKind::Pulse { waits: Waits::Yes, .. } => "PULSE"
    StmtKind::Pulse { waits: Waits::No, .. } => "PULSE NOWAIT"
    StmtKind::Hand { verb: HandVerb::Open, .. } => "OPEN HAND"
    StmtKind::Hand { verb: HandVerb::Close, .. } => "CLOSE HAND"
    StmtKind::Hand { verb: HandVerb::Relax, .. } => "RELAX HAND"
} }

named! { CONDITIONS, condition(Condition) {
    Condition::Expr(_) => "expression"
    Condition::Task { verb: TaskVerb::Abort, task: None } => "ABORT"
    Condition::Task { verb: TaskVerb::Abort, task: Some(_) } => "ABORT PROGRAM"
    Condition::Task { verb: TaskVerb::Pause, task: None } => "PAUSE"
    Condition::Task { verb: TaskVerb::Pause, task: Some(_) } => "PAUSE PROGRAM"
    Condition::Task { verb: TaskVerb::Continue, task: None } => "CONTINUE"
    Condition::Task { verb: TaskVerb::Continue, task: Some(_) } => "CONTINUE PROGRAM"
    Condition::Error(None) => "ERROR[*]"
    Condition::Error(Some(_)) => "ERROR[n]"
    Condition::Signaled { what: Signaled::Event, .. } => "EVENT"
    Condition::Signaled { what: Signaled::Semaphore, .. } => "SEMAPHORE"
    Condition::PowerUp => "POWERUP"
    Condition::Edge { .. } => "edge"
    Condition::AtNode { node: Some(_), .. } => "AT NODE[n]"
    Condition::AtNode { node: None, .. } => "AT NODE[*]"
    Condition::NodeTime { side: NodeSide::Before, .. } => "TIME BEFORE NODE"
    Condition::NodeTime { side: NodeSide::After, .. } => "TIME AFTER NODE"
} }

named! { OPERATORS, operator(BinaryOp) {
    BinaryOp::Add => "+"
    BinaryOp::Subtract => "-"
    BinaryOp::Multiply => "*"
    BinaryOp::Divide => "/"
    BinaryOp::Div => "DIV"
    BinaryOp::Mod => "MOD"
    BinaryOp::And => "AND"
    BinaryOp::Or => "OR"
    BinaryOp::Relation(crate::ast::Relation::Equal) => "="
    BinaryOp::Relation(crate::ast::Relation::NotEqual) => "<>"
    BinaryOp::Relation(crate::ast::Relation::Less) => "<"
    BinaryOp::Relation(crate::ast::Relation::Greater) => ">"
    BinaryOp::Relation(crate::ast::Relation::LessEqual) => "<="
    BinaryOp::Relation(crate::ast::Relation::GreaterEqual) => ">="
    BinaryOp::Approx => ">=<"
    BinaryOp::Compose => ":"
    BinaryOp::Inner => "@"
    BinaryOp::Cross => "#"
} }

named! { SIGNS, sign(UnaryOp) {
    UnaryOp::Plus => "unary +"
    UnaryOp::Minus => "unary -"
    UnaryOp::Not => "NOT"
} }

/// What the golden programs have. Only programs without errors count: what is refused does not run.
#[derive(Default)]
struct Seen {
    statements: BTreeSet<&'static str>,
    conditions: BTreeSet<&'static str>,
    operators: BTreeSet<&'static str>,
    /// Every name that is called or read.
    names: BTreeSet<String>,
}

impl Seen {
    fn program(&mut self, tree: &crate::ast::Program) {
        self.decls(&tree.decls);
        self.stmts(&tree.body);
    }

    fn decls(&mut self, decls: &[Decl]) {
        for decl in decls {
            match decl {
                Decl::Const { value, .. } => self.expr(value),
                Decl::Routine(routine) => match &routine.body {
                    RoutineBody::Here { decls, stmts, .. } => {
                        self.decls(decls);
                        self.stmts(stmts);
                    }
                    RoutineBody::From(_) => {}
                },
                Decl::Type { .. } | Decl::Var { .. } => {}
            }
        }
    }

    fn stmts(&mut self, stmts: &[Stmt]) {
        for stmt in stmts {
            let _new = self.statements.insert(statement(&stmt.kind));
            self.parts(&stmt.kind);
        }
    }

    fn parts(&mut self, kind: &StmtKind) {
        match kind {
            StmtKind::Assign { target, value } => {
                self.path(target);
                self.expr(value);
            }
            StmtKind::Call { name, args } => {
                let _new = self.names.insert(name.text.clone());
                self.exprs(args);
            }
            StmtKind::If {
                condition,
                then,
                otherwise,
            } => {
                self.expr(condition);
                self.stmts(then);
                self.stmts(otherwise);
            }
            StmtKind::While { condition, body } => {
                self.expr(condition);
                self.stmts(body);
            }
            StmtKind::For { from, to, body, .. } => {
                self.expr(from);
                self.expr(to);
                self.stmts(body);
            }
            StmtKind::Repeat { body, until } => {
                self.stmts(body);
                self.expr(until);
            }
            StmtKind::Select {
                value,
                cases,
                otherwise,
            } => {
                self.expr(value);
                for case in cases {
                    self.exprs(&case.values);
                    self.stmts(&case.body);
                }
                self.stmts(otherwise.as_deref().unwrap_or_default());
            }
            StmtKind::Read { items, .. } | StmtKind::Write { items, .. } => self.items(items),
            StmtKind::OpenFile { mode, name, .. } => {
                self.expr(mode);
                self.expr(name);
            }
            StmtKind::Using { body, .. } => self.stmts(body),
            StmtKind::WaitFor(conditions) => self.conditions(conditions),
            StmtKind::Move {
                form,
                via,
                whens,
                until,
                ..
            } => {
                self.form(form);
                if let Some(via) = via {
                    self.expr(via);
                }
                self.whens(whens);
                if let Some(until) = until {
                    self.conditions(until);
                }
            }
            StmtKind::Condition { whens, .. } => self.whens(whens),
            StmtKind::Delay(value)
            | StmtKind::Return(Some(value))
            | StmtKind::ConditionState { number: value, .. }
            | StmtKind::Signal { number: value, .. }
            | StmtKind::Pulse { time: value, .. }
            | StmtKind::Task {
                task: Some(value), ..
            }
            | StmtKind::Hand { number: value, .. } => self.expr(value),
            StmtKind::Label(_)
            | StmtKind::Goto(_)
            | StmtKind::Return(None)
            | StmtKind::CloseFile(_)
            | StmtKind::CancelFile(_)
            | StmtKind::Motion(_)
            | StmtKind::ConnectTimer(_)
            | StmtKind::DisconnectTimer(_)
            | StmtKind::Action(_)
            | StmtKind::Task { task: None, .. } => {}
        }
    }

    fn form(&mut self, form: &MoveForm) {
        match form {
            MoveForm::To(target) | MoveForm::Relative(target) | MoveForm::Away(target) => {
                self.expr(target);
            }
            MoveForm::Near { target, distance } => {
                self.expr(target);
                self.expr(distance);
            }
            MoveForm::Axis { axis, distance } => {
                self.expr(axis);
                self.expr(distance);
            }
            MoveForm::About { vector, angle } => {
                self.expr(vector);
                self.expr(angle);
            }
            MoveForm::Along(path) => self.path(path),
        }
    }

    fn whens(&mut self, whens: &[When]) {
        for when in whens {
            self.conditions(&when.conditions);
            self.stmts(&when.actions);
        }
    }

    fn conditions(&mut self, conditions: &Conditions) {
        for term in &conditions.terms {
            let _new = self.conditions.insert(condition(term));
            match term {
                Condition::Expr(value) => self.expr(value),
                Condition::Task { .. }
                | Condition::Error(_)
                | Condition::Signaled { .. }
                | Condition::PowerUp
                | Condition::Edge { .. }
                | Condition::AtNode { .. }
                | Condition::NodeTime { .. } => {}
            }
        }
    }

    fn items(&mut self, items: &[Item]) {
        for item in items {
            match &item.kind {
                ItemKind::Value(value) => self.expr(value),
                ItemKind::LineEnd => {}
            }
        }
    }

    fn exprs(&mut self, exprs: &[Expr]) {
        for expr in exprs {
            self.expr(expr);
        }
    }

    fn path(&mut self, path: &crate::ast::Path) {
        let _new = self.names.insert(path.root.text.clone());
        for step in &path.steps {
            if let crate::ast::PathStep::Index { subscripts, .. } = step {
                self.exprs(subscripts);
            }
        }
    }

    fn expr(&mut self, expr: &Expr) {
        match &expr.kind {
            ExprKind::Path(path) => self.path(path),
            ExprKind::Call { name, args } => {
                let _new = self.names.insert(name.text.clone());
                self.exprs(args);
            }
            ExprKind::Unary { op, operand } => {
                let _new = self.operators.insert(sign(op));
                self.expr(operand);
            }
            ExprKind::Binary { op, left, right } => {
                let _new = self.operators.insert(operator(op));
                self.expr(left);
                self.expr(right);
            }
            ExprKind::Paren(inner) => self.expr(inner),
            ExprKind::Integer(_) | ExprKind::Real(_) | ExprKind::Text(_) | ExprKind::Error => {}
        }
    }
}

fn folders() -> [PathBuf; 2] {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    [
        here.join("tests/cases"),
        here.join("../../karel-emulator/tests/cases"),
    ]
}

/// Listings without an arm, and without errors unless their name begins with `wrong`.
fn listings() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases/tp")
}

fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|end| end == extension));
    paths.sort();
    paths
}

/// What golden programs that run have.
fn seen() -> Seen {
    let mut seen = Seen::default();
    for folder in folders() {
        let mut includes = IncludeFiles::default();
        let more = folder.join("more");
        if more.is_dir() {
            for path in files(&more, "kl") {
                let name = path.file_name().unwrap().to_string_lossy().into_owned();
                includes.insert(&name, fs::read(path).unwrap());
            }
        }
        let loaded = if more.is_dir() {
            files(&more, "kl")
        } else {
            Vec::new()
        };
        for path in [files(&folder, "kl"), loaded].concat() {
            let text = fs::read(&path).unwrap();
            if text.starts_with(b"-- golden: tree")
                || Program::with_includes(&text, "x.kl", &includes).is_err()
            {
                continue;
            }
            let mut source = Source::new(&text, "x.kl");
            let mut reports = Reports::default();
            let tree = parser::parse(&mut source, Some(&includes), &mut reports);
            seen.program(&tree.unwrap());
        }
    }
    seen
}

fn missing<'a>(all: &[&'a str], seen: &BTreeSet<&str>) -> Vec<&'a str> {
    let unseen = all.iter().filter(|name| !seen.contains(*name));
    unseen.copied().collect()
}

#[test]
fn every_statement_condition_and_operator_has_a_golden_program() {
    let seen = seen();
    let none: [&str; 0] = [];
    assert_eq!(missing(STATEMENTS, &seen.statements), none, "statements");
    assert_eq!(missing(CONDITIONS, &seen.conditions), none, "conditions");
    assert_eq!(missing(OPERATORS, &seen.operators), none, "operators");
    assert_eq!(missing(SIGNS, &seen.operators), none, "signs");
}

#[test]
fn every_built_in_has_a_golden_program() {
    let seen = seen();
    let names = builtins::names().into_iter();
    let unseen: Vec<&str> = names.filter(|name| !seen.names.contains(*name)).collect();
    assert!(unseen.is_empty(), "{unseen:?}");
}

/// Constants of `status.rs`: their names and numbers.
fn statuses() -> Vec<(String, i32)> {
    let mut found = Vec::new();
    for line in include_str!("status.rs").lines() {
        let Some(rest) = line.trim().strip_prefix("pub const ") else {
            continue;
        };
        let Some((name, value)) = rest.split_once(": Status = Status(") else {
            continue;
        };
        let digits = value.trim_end_matches(");").replace('_', "");
        found.push((name.to_owned(), digits.parse().unwrap()));
    }
    found
}

#[test]
fn every_error_number_has_a_golden_program() {
    let statuses = statuses();
    assert!(statuses.len() > 40, "the constants are found");
    let mut text = String::new();
    for folder in folders().into_iter().chain([listings()]) {
        for path in files(&folder, "out") {
            text += &String::from_utf8_lossy(&fs::read(path).unwrap());
        }
    }
    let words: BTreeSet<&str> = text
        .split(|c: char| !c.is_ascii_alphanumeric() && c != '-')
        .collect();
    let unseen: Vec<String> = statuses
        .into_iter()
        .filter(|(_, number)| *number != 0)
        .filter(|(_, number)| {
            let shown = crate::Status(*number).to_string();
            !words.contains(shown.as_str()) && !words.contains(number.to_string().as_str())
        })
        .map(|(name, number)| format!("{name} {number}"))
        .collect();
    assert!(unseen.is_empty(), "{unseen:#?}");
}

/// Every instruction of a TP program that is documented is in a golden listing.
#[test]
fn every_instruction_of_a_tp_program_has_a_golden_listing() {
    let mut text = String::new();
    for folder in folders().into_iter().chain([listings()]) {
        for path in [files(&folder, "ls"), files(&folder.join("more"), "ls")].concat() {
            if path.to_string_lossy().contains("tp/wrong") {
                continue;
            }
            let bytes = fs::read(&path).unwrap();
            let mut reports = Reports::default();
            let source = Source::new(&bytes, "x.ls");
            assert!(
                tp::parse(&source, &mut reports).is_some() && !reports.has_errors(),
                "{}",
                path.display()
            );
            text += &String::from_utf8_lossy(&bytes);
        }
    }
    let unseen: Vec<&str> = TP_WORDS
        .iter()
        .copied()
        .filter(|word| !text.contains(word))
        .collect();
    assert!(unseen.is_empty(), "{unseen:?}");
}

/// The instructions and operands of docs/karel.md.
const TP_WORDS: &[&str] = &[
    "J P[",
    "L P[",
    "C P[",
    "J PR[",
    "mm/sec",
    "cm/min",
    "%",
    "R[1]mm/sec",
    "FINE",
    "CNT",
    "ACC",
    "PTH",
    "Offset,PR[",
    "Tool_Offset,PR[",
    "OFFSET CONDITION",
    "TOOL_OFFSET CONDITION",
    "SKIP CONDITION",
    "Skip,LBL[",
    "CALL ",
    "AR[",
    "RUN ",
    "END",
    "ABORT",
    "PAUSE",
    "LBL[",
    "JMP LBL[",
    "IF ",
    "SELECT ",
    "ELSE,",
    "FOR ",
    "ENDFOR",
    "THEN",
    "ELSE ;",
    "ENDIF",
    "AND",
    "OR",
    "!",
    "WAIT ",
    "TIMEOUT,LBL[",
    "PR[3,3]",
    "SR[",
    "LPOS",
    "JPOS",
    "UFRAME[",
    "UTOOL[",
    "UFRAME_NUM",
    "UTOOL_NUM",
    "$",
    "DI[",
    "DO[",
    "RI[",
    "RO[",
    "GI[",
    "GO[",
    "AI[",
    "AO[",
    "F[",
    "UI[",
    "UO[",
    "SI[",
    "SO[",
    "PULSE,",
    "OVERRIDE",
    "MESSAGE[",
    "PAYLOAD[",
    "DIV",
    "MOD",
    " INC",
    "TA ",
    "TB ",
    "DB ",
    "SkipJump,LBL[",
    "AP_LD",
    "RT_LD",
    "JMP LBL[R[",
    "=ON+",
    "=OFF-",
    "ERR_NUM",
    "STRLEN ",
    "SUBSTR ",
    "FINDSTR ",
    "ABS[",
    "=P[",
    "P[1]=",
    "SOFTFLOAT[",
    "FOLLOW UP",
    "COL GUARD",
    "STICK DETECT",
];
