//! Instructions that end something, wait, or ask the host.

use super::{
    cell::Memory,
    exec::{Exec, Flow, row_of},
    fault::Fault,
    task::Pending,
};
use crate::{
    ast::Waits,
    builtins::{Context, Outcome, Running},
    host::{MotionId, MotionRequest, MoveEnd, Progress, Wait},
    ir::Outward,
    status::Status,
    types::PositionKind,
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
            Outward::EndProgram => Ok(self.end_program()),
            Outward::Builtin(row) => self.builtin(row),
            Outward::LoadSystem(row) => self.load_system(row),
            Outward::StoreSystem(row) => self.store_system(row),
            Outward::FetchSystem(row) => self.fetch_system(row),
            Outward::ReturnSystem(row) => self.return_system(row),
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
            Outward::Move(waits) => self.move_to(waits, false),
            Outward::MoveVia(waits) => self.move_to(waits, true),
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
            running: Running {
                name: &self.task.name,
                line: program.code.lines.get(self.task.pc).copied().unwrap_or(0),
            },
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
        let pause = std::time::Duration::from_millis(milliseconds);
        let until = self.host.now().saturating_add(pause);
        self.task.pending = Pending::Until(until);
        Ok(Flow::Blocked(Wait::Until(until)))
    }

    /// Conditions are looked at before the statement goes on.
    fn moves_with_conditions(&mut self, motion: MotionId, waits: Waits, operands: usize) -> Flow {
        if waits == Waits::Yes {
            self.task.pending = Pending::Motion(motion);
        } else {
            self.drop_operands(operands);
            self.task.pc += 1;
        }
        Flow::Yield
    }

    fn move_to(&mut self, waits: Waits, has_via: bool) -> Result<Flow, Fault> {
        let operands = 1 + usize::from(has_via);
        let motion = if let Pending::Motion(motion) = self.task.pending {
            motion
        } else {
            let at = self.operand_address(0);
            let target = self.memory().position(at, PositionKind::XyzwprExt)?;
            let via = if has_via {
                let at = self.operand_address(1);
                Some(self.memory().position(at, PositionKind::XyzwprExt)?)
            } else {
                None
            };
            let request = MotionRequest {
                target,
                via,
                group: 1,
                end: match waits {
                    Waits::Yes => MoveEnd::Wait,
                    Waits::No => MoveEnd::NoWait,
                },
                program: self.program.name_arc(),
                line: self
                    .program
                    .code
                    .lines
                    .get(self.task.pc)
                    .copied()
                    .unwrap_or(0),
            };
            match self.host.start_motion(self.id, request) {
                Progress::Pending(wait) => return Ok(Flow::Blocked(wait)),
                Progress::Ready(Ok(motion)) => {
                    if self.local_starts(motion) {
                        return Ok(self.moves_with_conditions(motion, waits, operands));
                    }
                    motion
                }
                Progress::Ready(Err(status)) => {
                    return Err(Fault::from_host(status, "The motion was refused"));
                }
            }
        };
        if waits == Waits::Yes {
            self.task.pending = Pending::Motion(motion);
            match self.host.motion_ended(motion) {
                Progress::Pending(wait) => return Ok(Flow::Blocked(wait)),
                Progress::Ready(status) if !status.is_ok() => {
                    return Err(Fault::from_host(status, "The motion failed"));
                }
                Progress::Ready(_) => self.task.pending = Pending::None,
            }
            self.local_ends(motion);
        }
        self.drop_operands(operands);
        Ok(Flow::Next)
    }
}
