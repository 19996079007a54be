//! Statements.

use super::Lowering;
use crate::{
    ast::{Direction, Relation, TaskVerb},
    ir::{Op, Outward},
    typed::{Case, Constant, Expr, ExprKind, Place, Stmt, StmtKind, Target},
};

impl<'a> Lowering<'a> {
    pub(super) fn stmts(&mut self, stmts: &'a [Stmt]) {
        for stmt in stmts {
            let free = self.temp;
            self.line = self.source.line(stmt.span);
            self.stmt(stmt);
            self.temp = free;
        }
    }

    #[expect(clippy::too_many_lines, reason = "one arm for each statement")]
    fn stmt(&mut self, stmt: &'a Stmt) {
        match &stmt.kind {
            StmtKind::Label(label) => {
                let here = self.here();
                if let Some(slot) = self.labels.get_mut(*label as usize) {
                    *slot = Some(here);
                }
            }
            StmtKind::Goto(label) => {
                let jump = self.emit_jump(Op::Jump);
                self.gotos.push((jump, *label));
            }
            StmtKind::Assign {
                target: Target::Place(place),
                value,
            } => self.assign(place, value),
            StmtKind::Assign {
                target: Target::System(place),
                value,
            } => {
                self.value(value);
                let row = self.system(place);
                self.emit(Op::Outward(Outward::StoreSystem(row)));
            }
            StmtKind::Assign {
                target: Target::Port(place),
                value,
            } => {
                self.scalar(value);
                self.scalar(&place.number);
                self.emit(Op::Outward(Outward::StorePort(place.port)));
            }
            StmtKind::Call(call) => self.call(call),
            StmtKind::Builtin(call) => self.builtin(call),
            StmtKind::If {
                condition,
                then,
                otherwise,
            } => {
                self.if_statement(condition, then, otherwise);
            }
            StmtKind::While { condition, body } => self.while_statement(condition, body),
            StmtKind::For {
                counter,
                from,
                to,
                direction,
                body,
            } => {
                self.for_statement(counter, from, to, *direction, body);
            }
            StmtKind::Repeat { body, until } => {
                let top = self.here();
                self.stmts(body);
                self.scalar(until);
                let jump = self.emit_jump(Op::JumpIfFalse);
                self.patch_to(jump, top);
            }
            StmtKind::Select {
                value,
                cases,
                otherwise,
            } => {
                self.select(value, cases, otherwise.as_deref());
            }
            StmtKind::Return(value) => self.return_statement(value.as_ref()),
            StmtKind::Read { file, items } => self.read(file, items),
            StmtKind::Write { file, items } => self.write(file.as_ref(), items),
            StmtKind::OpenFile { file, mode, name } => {
                self.address(file);
                self.scalar(mode);
                self.scalar(name);
                self.emit(Op::Outward(Outward::OpenFile));
            }
            StmtKind::CloseFile(file) => {
                self.address(file);
                self.emit(Op::Outward(Outward::CloseFile));
            }
            StmtKind::CancelFile(file) => {
                self.address(file);
                self.emit(Op::Outward(Outward::CancelFile));
            }
            StmtKind::Motion(verb) => self.emit(Op::Outward(Outward::Motion(*verb))),
            StmtKind::Using { places, body } => self.using(places, body),
            StmtKind::WaitFor(conditions) => self.wait_for(conditions),
            StmtKind::Delay(time) => {
                self.scalar(time);
                self.emit(Op::Outward(Outward::Delay));
            }
            StmtKind::ConnectTimer(timer) => self.timer(timer, Outward::ConnectTimer),
            StmtKind::DisconnectTimer(timer) => self.timer(timer, Outward::DisconnectTimer),
            StmtKind::Move {
                form,
                via,
                waits,
                whens,
                until,
            } => {
                let op = self.move_form(form, via.as_ref(), *waits);
                self.local_handler(whens, until.as_ref());
                self.emit(Op::Outward(op));
            }
            StmtKind::Condition {
                number,
                period,
                whens,
            } => self.define_condition(number, period.as_ref(), whens),
            StmtKind::ConditionState { verb, number } => {
                self.scalar(number);
                self.emit(Op::Outward(Outward::ConditionState(*verb)));
            }
            StmtKind::Action(action) => self.emit(Op::Outward(Outward::Action(*action))),
            StmtKind::Signal { what, number } => {
                self.scalar(number);
                self.emit(Op::Outward(Outward::Signal(*what)));
            }
            StmtKind::Task {
                verb: TaskVerb::Abort,
                task: None,
            } => self.emit(Op::Outward(Outward::EndTask)),
            StmtKind::Task { verb, task } => {
                match task {
                    Some(task) => self.scalar(task),
                    None => self.emit(Op::PushInteger(0)),
                }
                self.emit(Op::Outward(Outward::Task(*verb)));
            }
            StmtKind::Pulse { port, time, waits } => {
                self.scalar(&port.number);
                self.scalar(time);
                self.emit(Op::Outward(Outward::Pulse(port.port, *waits)));
            }
            StmtKind::Hand { verb, number } => {
                self.scalar(number);
                self.emit(Op::Outward(Outward::Hand(*verb)));
            }
        }
    }

    fn timer(&mut self, timer: &Place, op: Outward) {
        self.address(timer);
        self.emit(Op::Outward(op));
    }

    fn using(&mut self, places: &[(Place, u32)], body: &'a [Stmt]) {
        for (place, cell) in places {
            self.address(place);
            self.emit(Op::StoreLocal(*cell));
        }
        self.stmts(body);
    }

    fn assign(&mut self, place: &Place, value: &Expr) {
        if place.ty.is_scalar() {
            self.store(place, |lowering| lowering.scalar(value));
        } else {
            self.address(place);
            self.copy_to_address(value, &place.ty);
        }
    }

    fn if_statement(&mut self, condition: &Expr, then: &'a [Stmt], otherwise: &'a [Stmt]) {
        self.scalar(condition);
        let to_else = self.emit_jump(Op::JumpIfFalse);
        self.stmts(then);
        if otherwise.is_empty() {
            return self.patch(to_else);
        }
        let to_end = self.emit_jump(Op::Jump);
        self.patch(to_else);
        self.stmts(otherwise);
        self.patch(to_end);
    }

    fn while_statement(&mut self, condition: &Expr, body: &'a [Stmt]) {
        let line = self.line;
        let top = self.here();
        let forever = matches!(condition.kind, ExprKind::Constant(Constant::Boolean(true)));
        let to_end = if forever {
            None
        } else {
            self.scalar(condition);
            Some(self.emit_jump(Op::JumpIfFalse))
        };
        self.stmts(body);
        self.line = line;
        let back = self.emit_jump(Op::Jump);
        self.patch_to(back, top);
        if let Some(to_end) = to_end {
            self.patch(to_end);
        }
    }

    /// Both bounds are computed once, before the counter is set. The counter is an ordinary
    /// variable that is tested before each round, so writing to it changes the loop.
    ///
    /// ASSUMPTION: after the loop the counter is one step beyond the limit.
    fn for_statement(
        &mut self,
        counter: &Place,
        from: &Expr,
        to: &Expr,
        direction: Direction,
        body: &'a [Stmt],
    ) {
        let line = self.line;
        let limit = self.temporary(1);
        let start = self.temporary(1);
        self.scalar(from);
        self.emit(Op::StoreLocal(start));
        self.scalar(to);
        self.emit(Op::StoreLocal(limit));
        self.store(counter, |lowering| lowering.emit(Op::LoadLocal(start)));
        let (relation, step) = match direction {
            Direction::Up => (Relation::LessEqual, Op::AddInteger),
            Direction::Down => (Relation::GreaterEqual, Op::SubtractInteger),
        };
        let top = self.here();
        self.load(counter);
        self.emit(Op::LoadLocal(limit));
        self.emit(Op::CompareInteger(relation));
        let to_end = self.emit_jump(Op::JumpIfFalse);
        self.stmts(body);
        self.line = line;
        self.store(counter, |lowering| {
            lowering.load(counter);
            lowering.emit(Op::PushInteger(1));
            lowering.emit(step);
        });
        let back = self.emit_jump(Op::Jump);
        self.patch_to(back, top);
        self.patch(to_end);
    }

    fn select(&mut self, value: &Expr, cases: &'a [Case], otherwise: Option<&'a [Stmt]>) {
        let selected = self.temporary(1);
        self.scalar(value);
        self.emit(Op::StoreLocal(selected));
        let mut to_cases = Vec::new();
        for (number, case) in cases.iter().enumerate() {
            for value in &case.values {
                self.emit(Op::LoadLocal(selected));
                self.scalar(value);
                self.emit(Op::CompareInteger(Relation::Equal));
                to_cases.push((number, self.emit_jump(Op::JumpIfTrue)));
            }
        }
        match otherwise {
            Some(stmts) => self.stmts(stmts),
            None => self.emit(Op::Outward(Outward::NoCase)),
        }
        let mut to_end = vec![self.emit_jump(Op::Jump)];
        for (number, case) in cases.iter().enumerate() {
            for (_, jump) in to_cases.iter().filter(|(wanted, _)| *wanted == number) {
                self.patch(*jump);
            }
            self.stmts(&case.body);
            to_end.push(self.emit_jump(Op::Jump));
        }
        for jump in to_end {
            self.patch(jump);
        }
    }

    fn return_statement(&mut self, value: Option<&Expr>) {
        match value {
            // A RETURN of the main body ends the program.
            None if self.is_main => return self.emit(Op::Outward(Outward::EndProgram)),
            None => {}
            Some(value) if value.ty.is_scalar() => self.scalar(value),
            Some(value) => {
                self.emit(Op::AddressParam(0));
                self.copy_to_address(value, &value.ty);
            }
        }
        self.emit(Op::Return);
    }
}
