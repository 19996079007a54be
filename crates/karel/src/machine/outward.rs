//! Instructions that end something, wait, or ask the host.

use std::time::Duration;

use super::{
    Names,
    cell::{Cell, Memory},
    exec::{Exec, Flow, row_of},
    fault::Fault,
    locate_variable,
    task::Pending,
};
use crate::{
    builtins::{Context, Outcome, Running},
    host::Wait,
    ir::Outward,
    status::Status,
    syspath::SysPath,
    types::{TextLength, Type, grid_lengths, text_array_lengths},
};

impl Exec<'_> {
    /// Executes one of them.
    #[inline(never)]
    pub(super) fn outward(&mut self, op: Outward) -> Result<Flow, Fault> {
        match op {
            Outward::CallExternal(row) => self.call_external(row),
            Outward::MissingReturn => Err(Fault::new(
                Status::INTP_MISSING_RETURN,
                "END of a function without RETURN",
            )),
            Outward::NoCase => Err(Fault::new(Status::INTP_NO_CASE, "No match in CASE")),
            Outward::EndTask => Ok(self.end_task()),
            Outward::EndProgram => self.tp_end_program(),
            Outward::Builtin(row) => self.builtin(row),
            Outward::LoadSystem(row) => self.load_system(row),
            Outward::StoreSystem(row) => self.store_system(row),
            Outward::FetchSystem(row) => self.fetch_system(row),
            Outward::ReturnSystem(row) => self.return_system(row),
            Outward::ByName(row) => self.by_name(row),
            Outward::LoadPort(port) => self.load_port(port),
            Outward::StorePort(port) => self.store_port(port),
            Outward::Scan => Ok(self.scan()),
            Outward::OpenFile => Ok(self.open_file()),
            Outward::CloseFile => Ok(self.close_file()),
            Outward::CancelFile => Ok(self.cancel_file()),
            Outward::WaitBegin => Ok(self.wait_begin()),
            Outward::ConditionEnd => unreachable!("only a look at conditions executes them"),
            Outward::Signaled(test) => Ok(self.signaled(test)),
            Outward::Edge { slot, edge } => Ok(self.edge(slot, edge)),
            Outward::DefineCondition(row) => self.define_condition(row),
            Outward::DefineLocal(row) => Ok(self.define_local(row)),
            Outward::ConditionState(verb) => self.condition_state(verb),
            Outward::Action(action) => Ok(self.action(action)),
            Outward::ActionGate => Ok(self.action_gate()),
            Outward::Signal(what) => self.signal(what),
            Outward::Task(verb) => Ok(self.task_verb(verb)),
            Outward::Pulse(port, waits) => self.pulse(port, waits),
            Outward::Hand(verb) => self.hand(verb),
            Outward::Motion(verb) => Ok(self.motion_verb(verb)),
            Outward::Read(row) => Ok(self.read(row)),
            Outward::Write(row) => self.write(row),
            Outward::Delay => self.delay(),
            Outward::ConnectTimer => {
                let at = self.pop_address();
                self.timers.connect(at, self.host.now());
                Ok(Flow::Next)
            }
            Outward::DisconnectTimer => {
                let at = self.pop_address();
                self.timers.disconnect(at);
                Ok(Flow::Next)
            }
            Outward::Move(kind, waits) => self.move_arm(kind, waits),
            Outward::MoveAlong(row, waits) => self.move_along(row, waits),
            Outward::Tp(row) => self.tp(row),
        }
    }

    fn builtin(&mut self, row: u32) -> Result<Flow, Fault> {
        if let Some(flow) = self.pause_is_over() {
            return Ok(flow);
        }
        let program = self.program;
        let site = row_of(&program.code.builtins, row);
        let count = site.operands as usize;
        let start = self.task.operands.len() - count;
        let mut context = Context {
            task: self.id,
            program: self.program,
            programs: self.programs,
            tasks: self.others,
            registers: self.registers,
            semaphores: self.semaphores,
            pending: &mut self.task.pending,
            arguments: &self.task.tp.arguments,
            comments: self.comments,
            paths: self.paths,
            created: self.created,
            dictionaries: self.dictionaries,
            port_setup: self.port_setup,
            teaching: self.teaching,
            running: Running {
                name: &self.task.name,
                line: program.code.lines.get(self.task.pc).copied().unwrap_or(0),
            },
            callers: &self.task.callers,
            limits: self.limits,
            host: self.host,
            memory: Memory {
                globals: self.globals,
                frames: &mut self.task.frames,
            },
            operands: self.task.operands.get(start..).unwrap_or_default(),
            site,
        };
        let outcome = (site.builtin.code)(&mut context)?;
        self.hear_own_deeds();
        match outcome {
            Outcome::Pending(wait) => return Ok(Flow::Blocked(wait)),
            Outcome::EndTask => return Ok(self.end_task()),
            Outcome::PauseTask => {
                self.drop_operands(count);
                self.task.paused = true;
                self.task.pc += 1;
                return Ok(Flow::Yield);
            }
            Outcome::CallProgram { name, line } => {
                self.drop_operands(count);
                return self.call_program_at(&name, line);
            }
            Outcome::Done => self.drop_operands(count),
            Outcome::Value(value) => {
                self.drop_operands(count);
                self.push(value);
            }
            Outcome::DoneThenPause(pause) => {
                self.drop_operands(count);
                let until = self.host.now() + pause;
                self.task.pending = Pending::Until(until);
                return Ok(Flow::Blocked(Wait::Until(until)));
            }
        }
        Ok(Flow::Next)
    }

    /// A program that pauses, continues or ends another sees that in its own conditions, too.
    pub(super) fn hear_own_deeds(&mut self) {
        for signal in self.others.take_deeds() {
            self.task.signal(signal);
        }
    }

    /// The variable whose names are on the stack.
    fn by_name(&mut self, row: u32) -> Result<Flow, Fault> {
        let (variable, home) = (self.pop_text(), self.pop_text());
        let (variable, home) = (variable.to_string_lossless(), home.to_string_lossless());
        let program = self.program;
        let formal = row_of(&program.code.types, row);
        let home = match home.trim() {
            "" => program.name(),
            name => name,
        };
        let names = Names {
            programs: self.programs,
            paths: self.paths,
            created: self.created,
            globals: self.globals,
        };
        let path = SysPath::parse(&variable).map_err(|_| Status::VARS_UNKNOWN);
        let found = path.and_then(|path| locate_variable(names, home, &path));
        let found = found.map_err(|status| {
            let message = format!("BYNAME finds no variable {variable} of {home}");
            Fault::new(status, message)
        })?;
        let Some(extra) = reference_extra(&found.ty, formal) else {
            let message = format!("[{home}]{variable} is {}, not {formal}", found.ty);
            return Err(Fault::new(Status::INTP_TYPE, message));
        };
        self.push(Cell::Address(found.at.with_extra(extra)));
        Ok(Flow::Next)
    }

    /// If the instruction is a pause that was begun: whether it goes on waiting.
    pub(super) fn pause_is_over(&mut self) -> Option<Flow> {
        let Pending::Until(until) = self.task.pending else {
            return None;
        };
        if self.host.now() < until {
            return Some(Flow::Blocked(Wait::Until(until)));
        }
        self.task.pending = Pending::None;
        Some(Flow::Next)
    }

    fn delay(&mut self) -> Result<Flow, Fault> {
        if let Some(flow) = self.pause_is_over() {
            return Ok(flow);
        }
        let milliseconds = self.pop_integer();
        let Ok(milliseconds) = u64::try_from(milliseconds) else {
            return Err(Fault::argument(format!(
                "DELAY of {milliseconds} ms, less than 0"
            )));
        };
        let pause = Duration::from_millis(milliseconds);
        let pause = whole_periods(pause, self.host.interpolation_period());
        let until = self.host.now().saturating_add(pause);
        self.task.pending = Pending::Until(until);
        Ok(Flow::Blocked(Wait::Until(until)))
    }
}

/// What a reference to a variable carries beside its address; `None` if the types do not fit.
fn reference_extra(actual: &Type, formal: &Type) -> Option<u32> {
    match (actual, formal) {
        (Type::Text(_), Type::Text(TextLength::Any)) => actual.length(),
        (Type::Array(from), Type::Array(to)) if to.is_open_grid() => {
            let fits = from.element == to.element && from.dims.len() == to.dims.len();
            grid_lengths(&from.dims).filter(|_| fits)
        }
        (Type::Array(from), Type::Array(to)) if to.dims.is_empty() => {
            let [length] = from.dims.as_slice() else {
                return None;
            };
            if to.element == Type::TEXT {
                return Some(text_array_lengths(*length, from.element.length()?));
            }
            (from.element == to.element).then_some(*length)
        }
        _ => (actual == formal).then(|| actual.length().unwrap_or(0)),
    }
}

/// What a `DELAY` of `pause` lasts: reported by the authors of a driver whose loop of 40 Hz ran at 31 Hz on a controller
/// of 8 ms, and at 27 Hz on one of 12 ms.
fn whole_periods(pause: Duration, period: Duration) -> Duration {
    if period.is_zero() {
        return pause;
    }
    let periods = pause.as_nanos().div_ceil(period.as_nanos());
    let nanoseconds = periods.saturating_mul(period.as_nanos());
    Duration::from_nanos(u64::try_from(nanoseconds).unwrap_or(u64::MAX))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_lasts_whole_periods() {
        let ms = Duration::from_millis;
        for (pause, period, lasts) in [
            (24, 8, 24),
            (25, 8, 32),
            (25, 12, 36),
            (0, 8, 0),
            (1, 8, 8),
            (25, 0, 25),
        ] {
            assert_eq!(whole_periods(ms(pause), ms(period)), ms(lasts));
        }
    }
}
