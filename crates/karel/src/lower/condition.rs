//! Condition handlers: conditions and actions become routines of their own.

use super::{Lowering, add_row, count};
use crate::{
    ast::{MotionVerb, Signaled},
    ir::{HandlerShape, Op, Outward, RoutineCode, SignalTest, Signature, WhenShape},
    span::Span,
    typed::{Condition, Conditions, Expr, Stmt, When},
};

/// What becomes a routine behind those of the program.
pub(super) enum Deferred<'a> {
    Condition(&'a Conditions, u32),
    Actions(&'a When),
    /// `UNTIL` cancels the motion.
    Cancel(u32),
}

impl<'a> Lowering<'a> {
    pub(super) fn define_condition(
        &mut self,
        number: &'a Expr,
        period: Option<&'a Expr>,
        whens: &'a [When],
    ) {
        let row = self.handler_row(whens, None);
        self.scalar(number);
        match period {
            Some(period) => self.scalar(period),
            None => self.emit(Op::PushInteger(0)),
        }
        self.emit(Op::Outward(Outward::DefineCondition(row)));
    }

    pub(super) fn local_handler(&mut self, whens: &'a [When], until: Option<&'a Conditions>) {
        if whens.is_empty() && until.is_none() {
            return;
        }
        let row = self.handler_row(whens, until);
        self.emit(Op::Outward(Outward::DefineLocal(row)));
    }

    fn handler_row(&mut self, whens: &'a [When], until: Option<&'a Conditions>) -> u32 {
        let mut shapes = Vec::new();
        for when in whens {
            let line = self.line_of(when.span);
            let condition = self.defer(Deferred::Condition(&when.conditions, line));
            shapes.push(WhenShape {
                condition,
                actions: self.defer(Deferred::Actions(when)),
                edges: edges(&when.conditions),
            });
        }
        if let Some(until) = until {
            let line = self.line;
            let condition = self.defer(Deferred::Condition(until, line));
            shapes.push(WhenShape {
                condition,
                actions: self.defer(Deferred::Cancel(line)),
                edges: edges(until),
            });
        }
        add_row(&mut self.code.handlers, HandlerShape { whens: shapes })
    }

    fn line_of(&self, span: Span) -> u32 {
        self.source.line(span)
    }

    fn defer(&mut self, part: Deferred<'a>) -> u32 {
        self.deferred.push(part);
        self.next_routine += 1;
        self.next_routine - 1
    }

    /// Lowers what was deferred, in order; handlers do not define handlers.
    pub(super) fn handlers(&mut self) {
        // A MOVE among the actions defers more.
        let mut parts = std::collections::VecDeque::from(std::mem::take(&mut self.deferred));
        while let Some(part) = parts.pop_front() {
            let entry = count(self.here());
            self.temp = 0;
            self.most_cells = 0;
            self.edges = 0;
            match part {
                Deferred::Condition(conditions, line) => {
                    self.line = line;
                    self.conditions(conditions);
                    self.emit(Op::Outward(Outward::ConditionEnd));
                }
                Deferred::Actions(when) => {
                    self.line = self.line_of(when.span);
                    self.temp = when.frame_cells;
                    self.most_cells = when.frame_cells;
                    self.labels = vec![None; when.labels as usize];
                    self.in_actions = true;
                    let actions: &'a [Stmt] = &when.actions;
                    self.stmts(actions);
                    self.in_actions = false;
                    self.emit(Op::Return);
                    self.patch_gotos();
                }
                Deferred::Cancel(line) => {
                    self.line = line;
                    self.emit(Op::Outward(Outward::Motion(MotionVerb::Cancel)));
                    self.emit(Op::Return);
                }
            }
            self.code.routines.push(RoutineCode {
                name: "CONDITION".into(),
                signature: Signature {
                    params: Vec::new(),
                    result: None,
                },
                entry,
                args: 0,
                frame_cells: self.most_cells,
                files: Vec::new(),
                paths: Vec::new(),
            });
            parts.extend(std::mem::take(&mut self.deferred));
        }
    }

    pub(super) fn wait_for(&mut self, conditions: &Conditions) {
        self.edges = 0;
        let signals = conditions
            .terms
            .iter()
            .any(|term| !matches!(term, Condition::State(_)));
        if signals {
            self.emit(Op::Outward(Outward::WaitBegin));
        }
        let top = self.here();
        self.conditions(conditions);
        let to_end = self.emit_jump(Op::JumpIfTrue);
        self.emit(Op::Outward(Outward::Scan));
        let back = self.emit_jump(Op::Jump);
        self.patch_to(back, top);
        self.patch(to_end);
    }

    /// Pushes whether they hold.
    fn conditions(&mut self, conditions: &Conditions) {
        let (join, none) = if conditions.all {
            (Op::AndBoolean, true)
        } else {
            (Op::OrBoolean, false)
        };
        for (index, term) in conditions.terms.iter().enumerate() {
            self.condition(term);
            if index > 0 {
                self.emit(join);
            }
        }
        if conditions.terms.is_empty() {
            self.emit(Op::PushBoolean(none));
        }
    }

    fn condition(&mut self, condition: &Condition) {
        let test = match condition {
            Condition::State(state) => return self.scalar(state),
            // A task that was switched off is gone, so it never sees the power come back.
            Condition::PowerUp => return self.emit(Op::PushBoolean(false)),
            Condition::Edge { port, edge } => {
                self.scalar(&port.number);
                self.emit(Op::Outward(Outward::LoadPort(port.port)));
                let slot = self.edges;
                self.edges += 1;
                return self.emit(Op::Outward(Outward::Edge { slot, edge: *edge }));
            }
            Condition::Task { verb, task: None } => SignalTest::Own(*verb),
            Condition::AtNode(None) => SignalTest::AnyNode,
            Condition::AtNode(Some(node)) => {
                self.scalar(node);
                SignalTest::Node
            }
            Condition::NodeTime { time, side, node } => {
                self.scalar(time);
                self.scalar(node);
                SignalTest::Time(*side)
            }
            Condition::Error(None) => SignalTest::AnyError,
            Condition::Task {
                verb,
                task: Some(task),
            } => {
                self.scalar(task);
                SignalTest::Of(*verb)
            }
            Condition::Error(Some(number)) => {
                self.scalar(number);
                SignalTest::Error
            }
            Condition::Signaled { what, number } => {
                self.scalar(number);
                match what {
                    Signaled::Event => SignalTest::Event,
                    Signaled::Semaphore => SignalTest::Semaphore,
                }
            }
        };
        self.emit(Op::Outward(Outward::Signaled(test)));
    }
}

fn edges(conditions: &Conditions) -> u32 {
    let terms = conditions.terms.iter();
    count(
        terms
            .filter(|term| matches!(term, Condition::Edge { .. }))
            .count(),
    )
}
