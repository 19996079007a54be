//! Instructions of TP programs.

use super::{
    exec::{Exec, Flow, row_of},
    fault::Fault,
    task::Argument,
    tp_value::{Term, absent_option, no_such, not_entered, text_bytes},
};
use crate::{
    registers::Number,
    status::Status,
    syspath::SysPath,
    tp::{Branch, Call, ForHead, Index, Instruction, Operand},
    value::Value,
};

/// Rows of `$MACROTABLE` that are looked at.
const MACROS: i32 = 40;

impl Exec<'_> {
    pub(super) fn tp(&mut self, row: u32) -> Result<Flow, Fault> {
        let program = self.program;
        match row_of(&program.code.tp, row) {
            // Conditions do nothing but for a MONITOR.
            Instruction::Nothing | Instruction::When(..) => Ok(Flow::Next),
            Instruction::Jump(line) => Ok(self.jump(*line)),
            Instruction::Goto(goal) => self.tp_goto(goal),
            Instruction::Assign { target, value } => self.tp_assign(target, value),
            Instruction::If { condition, then } => {
                if !self.tp_holds(condition)? {
                    return Ok(Flow::Next);
                }
                self.tp_branch(then, None)
            }
            Instruction::Unless { condition, to } => {
                if self.tp_holds(condition)? {
                    return Ok(Flow::Next);
                }
                Ok(self.jump(*to))
            }
            Instruction::Case {
                condition,
                then,
                behind,
            } => {
                if let Some(condition) = condition
                    && !self.tp_holds(condition)?
                {
                    return Ok(Flow::Next);
                }
                self.tp_branch(then, Some(*behind))
            }
            Instruction::For { head, behind } => self.tp_for(head, *behind),
            Instruction::EndFor { head, again } => self.tp_end_for(head, *again),
            Instruction::WaitSeconds(time) => self.tp_wait(time),
            Instruction::WaitFor { condition, timeout } => {
                self.tp_wait_for(condition, timeout.as_ref())
            }
            Instruction::Call(call) => self.tp_call(call),
            Instruction::Macro(call) => self.tp_macro(call),
            Instruction::Unfinished => Err(not_entered()),
            Instruction::Run(name) => self.tp_run(name),
            Instruction::Move(motion) => self.tp_move(motion),
            Instruction::Pulse(port, index, width) => {
                self.tp_pulse((*port, *index), width.as_ref())
            }
            Instruction::Message(text) => {
                self.host.display(self.id, &text_bytes(text));
                self.host.display(self.id, b"\r\n");
                Ok(Flow::Next)
            }
            Instruction::SkipCondition(condition) => {
                self.task.tp.skip = Some(condition.clone());
                Ok(Flow::Next)
            }
            Instruction::OffsetCondition { tool, register } => {
                let n = Some(self.tp_index(*register)?);
                if *tool {
                    self.task.tp.tool_offset = n;
                } else {
                    self.task.tp.offset = n;
                }
                Ok(Flow::Next)
            }
            Instruction::Override(percent) => {
                let percent = self.tp_whole(percent, "OVERRIDE")?;
                let path = SysPath::from_name("$MCR").field("$GENOVERRIDE");
                self.tp_set_system(&path, Value::Integer(percent))?;
                Ok(Flow::Next)
            }
            Instruction::Timer(index, action) => self.tp_timer(*index, *action),
            Instruction::UserAlarm(index) => self.tp_user_alarm(*index),
            Instruction::Monitor(name, on) => self.tp_monitor(name, *on),
            Instruction::EnableRequest(index, on) => self.tp_enable_request(*index, *on),
            Instruction::Absent(absent) => Err(absent_option(absent)),
            Instruction::End => self.tp_end_program(),
            Instruction::Abort => {
                self.host.cancel_motions(self.id);
                Ok(self.end_task())
            }
            Instruction::Pause => {
                self.task.paused = true;
                self.task.pc += 1;
                Ok(Flow::Yield)
            }
        }
    }

    /// `behind`: where a program that is called comes back to, if not to the next line.
    fn tp_branch(&mut self, then: &Branch, behind: Option<u32>) -> Result<Flow, Fault> {
        match then {
            Branch::Jump(goal) => self.tp_goto(goal),
            Branch::Call(call) => {
                let flow = self.tp_call(call)?;
                if let (Some(behind), Some(caller)) = (behind, self.task.callers.last_mut()) {
                    caller.pc = behind as usize;
                }
                Ok(flow)
            }
            Branch::Assign(target, value) => {
                let flow = self.tp_assign(target, value)?;
                Ok(behind.map_or(flow, |behind| self.jump(behind)))
            }
            Branch::Pulse(port, index, width) => {
                let flow = self.tp_pulse((*port, *index), width.as_ref())?;
                Ok(behind.map_or(flow, |behind| self.jump(behind)))
            }
        }
    }

    fn tp_call(&mut self, call: &Call) -> Result<Flow, Fault> {
        let arguments = self.tp_arguments(call)?;
        self.call_with(&call.program, arguments)
    }

    /// What a program is given.
    pub(super) fn tp_arguments(&mut self, call: &Call) -> Result<Vec<Argument>, Fault> {
        let mut arguments = Vec::with_capacity(call.arguments.len());
        for argument in &call.arguments {
            arguments.push(match self.tp_operand(argument)? {
                Term::Number(number) => Argument::Number(number),
                Term::Text(text) => Argument::Text(text),
                other @ (Term::Switch(_) | Term::Position(_)) => {
                    let message = format!("{other:?} cannot be an argument of {}", call.program);
                    return Err(Fault::new(Status::INTP_TYPE, message));
                }
            });
        }
        Ok(arguments)
    }

    /// Whether the signal `RSR[n]` starts its program.
    fn tp_enable_request(&mut self, index: Index, on: bool) -> Result<Flow, Fault> {
        let n = self.tp_index(index)?;
        let done = self.host.enable_request(self.id, n, on);
        done.map_err(|status| no_such("RSR", n, status))?;
        Ok(Flow::Next)
    }

    /// Words in the place of a program.
    ///
    /// ASSUMPTION: words that the table does not have are those of the program that is named so without blanks.
    fn tp_macro(&mut self, call: &Call) -> Result<Flow, Fault> {
        let Call { program, arguments } = call;
        let table = SysPath::from_name("$MACROTABLE");
        let text = |row: i32, field: &str| {
            let path = table.clone().index(&[row]).field(field);
            match self.host.system_variable(self.id, &path) {
                Ok(Value::String(text)) => Some(text.to_string_lossless()),
                Ok(_) | Err(_) => None,
            }
        };
        let row = (1..=MACROS).find(|row| {
            let name = text(*row, "$MACRO_NAME").unwrap_or_default();
            name.trim().eq_ignore_ascii_case(program)
        });
        let found = row.and_then(|row| text(row, "$PROG_NAME"));
        let name = found.unwrap_or_else(|| program.replace(' ', ""));
        let name = name.trim().to_ascii_uppercase();
        if !self.programs.iter().any(|loaded| loaded.name() == name) {
            let message =
                format!("No row of $MACROTABLE is for {program}, and there is no program {name}");
            return Err(Fault::new(Status::INTP_CALL_FAILED, message));
        }
        let arguments = arguments.clone();
        self.tp_call(&Call {
            program: name.into(),
            arguments,
        })
    }

    fn tp_for(&mut self, head: &ForHead, behind: u32) -> Result<Flow, Fault> {
        let from = self.tp_whole(&head.from, "FOR")?;
        let to = self.tp_whole(&head.to, "FOR")?;
        let n = self.tp_index(head.counter)?;
        self.tp_set_number(n, Number::Integer(from))?;
        let nothing = if head.down { from < to } else { from > to };
        Ok(if nothing {
            self.jump(behind)
        } else {
            Flow::Next
        })
    }

    /// ASSUMPTION: the counter keeps its last value; and the limit is looked at anew each time.
    fn tp_end_for(&mut self, head: &ForHead, again: u32) -> Result<Flow, Fault> {
        let to = self.tp_whole(&head.to, "FOR")?;
        let n = self.tp_index(head.counter)?;
        let now = self.tp_whole(&Operand::Number(Index::Fixed(n)), "FOR")?;
        let more = if head.down { now > to } else { now < to };
        if !more {
            return Ok(Flow::Next);
        }
        let next = if head.down { now - 1 } else { now + 1 };
        self.tp_set_number(n, Number::Integer(next))?;
        Ok(self.jump(again))
    }

    fn tp_run(&mut self, name: &str) -> Result<Flow, Fault> {
        let started = self.others.start(self.programs, self.limits, name);
        let _task = started.map_err(|error| {
            Fault::new(Status::INTP_CALL_FAILED, format!("RUN {name}: {error}"))
        })?;
        Ok(Flow::Next)
    }
}
