//! Statements of condition handlers: defining them, switching them on and off, and the terms of their conditions.

use std::time::Duration;

use super::{
    cell::Cell,
    exec::{Exec, Flow, row_of},
    fault::Fault,
    task::{Handler, HandlerKind, Signal, WhenState},
};
use crate::{
    ast::{ConditionVerb, Edge},
    host::MotionId,
    ir::{SignalTest, WhenShape},
};

/// Highest number of a condition handler, and most of them in a task.
///
/// ASSUMPTION: from descriptions of the language.
const MAX_CONDITION: i32 = 1000;

impl Exec<'_> {
    /// Defines a handler, disabled; one of the same number is replaced.
    pub(super) fn define_condition(&mut self, row: u32) -> Result<Flow, Fault> {
        let (milliseconds, number) = (self.pop_integer(), self.pop_integer());
        check_number(number)?;
        let Ok(milliseconds) = u64::try_from(milliseconds) else {
            let message = format!("$SCAN_TIME of {milliseconds} ms, less than 0");
            return Err(Fault::argument(message));
        };
        let period = if milliseconds == 0 {
            self.scan_period()
        } else {
            Duration::from_millis(milliseconds)
        };
        let kind = HandlerKind::Global(number);
        self.task.handlers.retain(|handler| handler.kind != kind);
        self.define(kind, row, period);
        Ok(Flow::Next)
    }

    /// The handler of the MOVE that follows.
    pub(super) fn define_local(&mut self, row: u32) -> Flow {
        let kind = HandlerKind::Local(None);
        // Of a MOVE that was refused before.
        self.task.handlers.retain(|handler| handler.kind != kind);
        let period = self.scan_period();
        self.define(kind, row, period);
        Flow::Next
    }

    fn define(&mut self, kind: HandlerKind, row: u32, period: Duration) {
        let program = self.program;
        let shape = row_of(&program.code.handlers, row);
        let when = |shape: &WhenShape| WhenState {
            condition: shape.condition,
            actions: shape.actions,
            edges: vec![None; shape.edges as usize],
            fired: false,
        };
        self.task.handlers.push(Handler {
            kind,
            program: self.task.program,
            enabled: false,
            whens: shape.whens.iter().map(when).collect(),
            period,
            next: Duration::ZERO,
            mark: 0,
        });
    }

    /// The motion of a MOVE with conditions has started.
    pub(super) fn local_starts(&mut self, motion: MotionId) -> bool {
        let is_there = self.enable(HandlerKind::Local(None));
        let handlers = self.task.handlers.iter_mut();
        for handler in handlers.filter(|handler| handler.kind == HandlerKind::Local(None)) {
            handler.kind = HandlerKind::Local(Some(motion));
        }
        is_there
    }

    /// The conditions of a MOVE ALONG stay until the motion to its last node ends.
    pub(super) fn local_goes_on(&mut self, from: MotionId, to: MotionId) {
        let handlers = self.task.handlers.iter_mut();
        for handler in handlers.filter(|handler| handler.kind == HandlerKind::Local(Some(from))) {
            handler.kind = HandlerKind::Local(Some(to));
        }
    }

    pub(super) fn local_ends(&mut self, motion: MotionId) {
        let kind = HandlerKind::Local(Some(motion));
        self.task.handlers.retain(|handler| handler.kind != kind);
    }

    fn enable(&mut self, kind: HandlerKind) -> bool {
        if self.task.handlers.is_empty() {
            return false;
        }
        if !self.task.has_enabled_handlers() {
            self.forget_alarms();
        }
        let (now, mark) = (self.host.now(), self.task.signals.now());
        let mut handlers = self.task.handlers.iter_mut();
        let Some(handler) = handlers.find(|handler| handler.kind == kind) else {
            return false;
        };
        if !handler.enabled {
            handler.enabled = true;
            // One that enables itself again waits for its next turn.
            handler.next = handler.next.max(now);
            handler.mark = mark;
            for when in &mut handler.whens {
                when.edges.fill(None);
            }
        }
        true
    }

    pub(super) fn condition_state(&mut self, verb: ConditionVerb) -> Result<Flow, Fault> {
        let number = self.pop_integer();
        check_number(number)?;
        let kind = HandlerKind::Global(number);
        let found = match verb {
            ConditionVerb::Enable => self.enable(kind),
            ConditionVerb::Disable => {
                let mut handlers = self.task.handlers.iter_mut();
                let found = handlers.find(|handler| handler.kind == kind);
                found.map(|handler| handler.enabled = false).is_some()
            }
            ConditionVerb::Purge => {
                let before = self.task.handlers.len();
                self.task.handlers.retain(|handler| handler.kind != kind);
                self.task.handlers.len() < before
            }
        };
        if found {
            // It is looked at as soon as this statement is done.
            self.task.pc += 1;
            return Ok(Flow::Yield);
        }
        let what = verb.text();
        Err(Fault::argument(format!(
            "{what} CONDITION[{number}], which is not defined"
        )))
    }

    pub(super) fn wait_begin(&mut self) -> Flow {
        self.task.listens = true;
        self.forget_alarms();
        self.task.mark = self.task.signals.now();
        self.task.edges.clear();
        Flow::Next
    }

    pub(super) fn signaled(&mut self, test: SignalTest) -> Flow {
        let number = match test {
            SignalTest::AnyError | SignalTest::AnyNode | SignalTest::Own(_) => 0,
            SignalTest::Event
            | SignalTest::Semaphore
            | SignalTest::Error
            | SignalTest::Node
            | SignalTest::Time(_)
            | SignalTest::Of(_) => self.pop_integer(),
        };
        let holds = if let SignalTest::Time(side) = test {
            let milliseconds = self.pop_integer();
            self.node_time(side, milliseconds, number)
        } else if test == SignalTest::Semaphore {
            // ASSUMPTION: it holds while the count is above 0, and takes nothing from it.
            self.semaphores
                .count(number)
                .is_some_and(|count| *count > 0)
        } else {
            let own = self.id;
            let mut signals = self.task.signals.since(self.task.mark);
            signals.any(|signal| match (signal, test) {
                (Signal::Event(event), SignalTest::Event) => event == number,
                (Signal::Error(code), SignalTest::Error) => code == number,
                (Signal::Error(_), SignalTest::AnyError)
                | (Signal::Node(_), SignalTest::AnyNode) => true,
                (Signal::Node(node), SignalTest::Node) => node == number,
                (Signal::Task(verb, task), SignalTest::Own(wanted)) => {
                    verb == wanted && task == own
                }
                (Signal::Task(verb, task), SignalTest::Of(wanted)) => {
                    verb == wanted && u32::try_from(number).is_ok_and(|number| task.0 == number)
                }
                _ => false,
            })
        };
        self.push(Cell::Boolean(holds));
        Flow::Next
    }

    pub(super) fn edge(&mut self, slot: u32, edge: Edge) -> Flow {
        let now = self.pop_boolean();
        let slot = slot as usize;
        let edges = &mut self.task.edges;
        if edges.len() <= slot {
            edges.resize(slot + 1, None);
        }
        let before = edges.get_mut(slot).and_then(|seen| seen.replace(now));
        let wanted = edge == Edge::Rising;
        self.push(Cell::Boolean(now == wanted && before == Some(!wanted)));
        Flow::Next
    }
}

fn check_number(number: i32) -> Result<(), Fault> {
    if (1..=MAX_CONDITION).contains(&number) {
        return Ok(());
    }
    Err(Fault::argument(format!(
        "There is no CONDITION[{number}], the last is {MAX_CONDITION}"
    )))
}
