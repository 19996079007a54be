//! Instructions of TP programs.

use std::time::Duration;

use super::{
    exec::{Exec, Flow, row_of},
    fault::Fault,
    task::{Argument, Pending},
    tp_value::{Term, no_such, text_bytes},
};
use crate::{
    frame::Frame,
    host::{Progress, TpMotion, TpSpeed, TpTarget, Wait},
    port::{Port, PortValue},
    position::XyzwprExt,
    registers::{Number, PositionRegister},
    status::Status,
    syspath::SysPath,
    tp::{
        Branch, Call, Expr, ForHead, Index, Instruction, Motion, MotionTarget, Operand, Shift,
        SpeedUnit, Taught,
    },
    value::Value,
};

/// How often a WAIT for a condition looks.
///
/// ASSUMPTION: one interpolation period.
const LOOK: Duration = Duration::from_millis(8);

impl Exec<'_> {
    pub(super) fn tp(&mut self, row: u32) -> Result<Flow, Fault> {
        let program = self.program;
        match row_of(&program.code.tp, row) {
            Instruction::Nothing => Ok(Flow::Next),
            Instruction::Jump(line) => Ok(self.jump(*line)),
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
            Instruction::WaitFor { condition, timeout } => self.tp_wait_for(condition, *timeout),
            Instruction::Call(call) => self.tp_call(call),
            Instruction::Run(name) => self.tp_run(name),
            Instruction::Move(motion) => self.tp_move(motion),
            Instruction::Pulse(port, index, width) => self.tp_pulse((*port, *index), width),
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
            Instruction::End => Ok(self.end_program()),
            Instruction::Abort => Ok(self.end_task()),
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
            Branch::Jump(line) => Ok(self.jump(*line)),
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
        }
    }

    fn tp_call(&mut self, call: &Call) -> Result<Flow, Fault> {
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
        self.call_with(&call.program, arguments)
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

    /// ASSUMPTION: `$WAITTMOUT` is in hundredths of a second, 30 s if this controller has none.
    fn tp_wait_for(&mut self, condition: &Expr, timeout: Option<u32>) -> Result<Flow, Fault> {
        if self.tp_holds(condition)? {
            self.task.pending = Pending::None;
            return Ok(Flow::Next);
        }
        let look = self.host.now() + LOOK;
        let Some(label) = timeout else {
            return Ok(Flow::Blocked(Wait::Until(look)));
        };
        let until = if let Pending::Deadline(until) = self.task.pending {
            until
        } else {
            let path = SysPath::from_name("$WAITTMOUT");
            let hundredths = match self.host.system_variable(self.id, &path) {
                Ok(Value::Integer(value)) => u64::try_from(value).unwrap_or(0),
                Ok(_) | Err(_) => 3000,
            };
            self.host.now() + Duration::from_millis(hundredths * 10)
        };
        if self.host.now() >= until {
            self.task.pending = Pending::None;
            return Ok(self.jump(label));
        }
        self.task.pending = Pending::Deadline(until);
        Ok(Flow::Blocked(Wait::Until(look.min(until))))
    }

    /// ASSUMPTION: the output is on for that time, whatever it was before, and then off; the next
    /// line does not wait.
    fn tp_pulse(&mut self, (port, index): (Port, Index), width: &Operand) -> Result<Flow, Fault> {
        let n = self.tp_index(index)?;
        let seconds = self.tp_real(width, "PULSE")?;
        let width = Duration::try_from_secs_f32(seconds)
            .map_err(|_| Fault::argument(format!("PULSE,{seconds}sec")))?;
        let on = PortValue::Switch(true);
        let set = self.host.set_port(self.id, port, n, on);
        set.map_err(|status| no_such(port.name(), n, status))?;
        let at = self.host.now().saturating_add(width);
        let off = PortValue::Switch(false);
        if !self.pulses.add(self.id, (port, n), off, at) {
            return Err(Fault::new(Status::INTP_LIMIT, "Too many pulses"));
        }
        Ok(Flow::Next)
    }

    fn tp_run(&mut self, name: &str) -> Result<Flow, Fault> {
        let started = self.others.start(self.programs, self.limits, name);
        let _task = started.map_err(|error| {
            Fault::new(Status::INTP_CALL_FAILED, format!("RUN {name}: {error}"))
        })?;
        Ok(Flow::Next)
    }

    fn tp_wait(&mut self, time: &Operand) -> Result<Flow, Fault> {
        if let Pending::Until(until) = self.task.pending {
            if self.host.now() < until {
                return Ok(Flow::Blocked(Wait::Until(until)));
            }
            self.task.pending = Pending::None;
            return Ok(Flow::Next);
        }
        let seconds = self.tp_real(time, "WAIT")?;
        let pause = Duration::try_from_secs_f32(seconds)
            .map_err(|_| Fault::argument(format!("WAIT {seconds}(sec)")))?;
        let until = self.host.now().saturating_add(pause);
        self.task.pending = Pending::Until(until);
        Ok(Flow::Blocked(Wait::Until(until)))
    }

    fn tp_move(&mut self, motion: &Motion) -> Result<Flow, Fault> {
        let id = if let Pending::Motion(id) | Pending::Skipped(id) = self.task.pending {
            id
        } else {
            let request = self.tp_request(motion)?;
            match self.host.start_tp_motion(self.id, request, self.registers) {
                Progress::Pending(wait) => return Ok(Flow::Blocked(wait)),
                Progress::Ready(Ok(id)) => id,
                Progress::Ready(Err(status)) => {
                    return Err(Fault::from_host(status, "The motion was refused"));
                }
            }
        };
        if !matches!(self.task.pending, Pending::Skipped(_)) {
            self.task.pending = Pending::Motion(id);
            if motion.skip.is_some() && self.tp_skips()? {
                self.host.cancel_arm(self.id);
                self.task.pending = Pending::Skipped(id);
            }
        }
        match self.host.motion_ended(id) {
            // It looks at the SKIP CONDITION again and again.
            Progress::Pending(_) if motion.skip.is_some() => {
                Ok(Flow::Blocked(Wait::Until(self.host.now() + LOOK)))
            }
            Progress::Pending(wait) => Ok(Flow::Blocked(wait)),
            Progress::Ready(status) if status.is_ok() => {
                let skipped = matches!(self.task.pending, Pending::Skipped(_));
                self.task.pending = Pending::None;
                match motion.skip {
                    Some(label) if !skipped => Ok(self.jump(label)),
                    Some(_) | None => Ok(Flow::Next),
                }
            }
            Progress::Ready(status) => Err(Fault::from_host(status, "The motion failed")),
        }
    }

    fn tp_skips(&mut self) -> Result<bool, Fault> {
        let Some(condition) = self.task.tp.skip.clone() else {
            let message = "Skip without a SKIP CONDITION";
            return Err(Fault::new(Status::INTP_UNINIT, message));
        };
        self.tp_holds(&condition)
    }

    fn tp_request(&mut self, motion: &Motion) -> Result<TpMotion, Fault> {
        let target = self.tp_target(&motion.target)?;
        let via = match &motion.via {
            Some(via) => Some(self.tp_target(via)?),
            None => None,
        };
        let shifts = (motion.offset, motion.tool_offset);
        let target = self.tp_shifted(target, shifts)?;
        let via = match via {
            Some(via) => Some(self.tp_shifted(via, shifts)?),
            None => None,
        };
        let speed = self.tp_real(&motion.speed, "A speed")?;
        let speed = match motion.unit {
            SpeedUnit::Percent => TpSpeed::Percent(speed),
            SpeedUnit::MmPerSec => TpSpeed::MmPerSec(speed),
            SpeedUnit::CmPerMin => TpSpeed::MmPerSec(speed / 6.0),
        };
        let acceleration_percent = match &motion.acceleration {
            Some(operand) => self.tp_real(operand, "ACC")?,
            None => 100.0,
        };
        Ok(TpMotion {
            interpolation: motion.interpolation,
            via,
            target,
            speed,
            acceleration_percent,
            program: self.program.name_arc(),
            line: self.line(),
        })
    }

    fn tp_target(&self, target: &MotionTarget) -> Result<TpTarget, Fault> {
        match target {
            MotionTarget::Register(index) => {
                let n = self.tp_index(*index)?;
                let position = self.registers.position(n);
                match position.map_err(|status| no_such("PR", n, status))? {
                    PositionRegister::Cartesian(position) => Ok(TpTarget::Cartesian(*position)),
                    PositionRegister::Joints(joints) => Ok(TpTarget::Joints(joints.clone())),
                    PositionRegister::Unset => {
                        let message = format!("PR[{n}] has no value");
                        Err(Fault::new(Status::INTP_UNINIT, message))
                    }
                }
            }
            MotionTarget::Taught(taught) => {
                // A program may have changed it: `SET_POS_TPE`.
                let changed = self.teaching.changed(self.program.name(), taught.number);
                let taught = changed.unwrap_or(taught);
                self.check_frames(taught)?;
                Ok(taught.target.clone())
            }
        }
    }

    /// The target shifted by the registers of `Offset` and `Tool_Offset`.
    ///
    /// ASSUMPTION: an offset is a shift of the user frame, a tool offset one of the tool.
    fn tp_shifted(
        &self,
        target: TpTarget,
        (offset, tool_offset): (Shift, Shift),
    ) -> Result<TpTarget, Fault> {
        let state = &self.task.tp;
        let offset = self.tp_shift(offset, state.offset)?;
        let tool_offset = self.tp_shift(tool_offset, state.tool_offset)?;
        if offset.is_none() && tool_offset.is_none() {
            return Ok(target);
        }
        let TpTarget::Cartesian(pose) = target else {
            let message = "An offset of a target in joints is not supported";
            return Err(Fault::new(Status::INTP_TYPE, message));
        };
        let mut frame = Frame::from(&pose);
        if let Some(offset) = offset {
            frame = Frame::from(&offset).times(&frame);
        }
        if let Some(tool_offset) = tool_offset {
            frame = frame.times(&Frame::from(&tool_offset));
        }
        let [x, y, z, w, p, r] = frame.components().map(narrow);
        Ok(TpTarget::Cartesian(XyzwprExt {
            x,
            y,
            z,
            w,
            p,
            r,
            ..pose
        }))
    }

    fn tp_shift(&self, shift: Shift, condition: Option<i32>) -> Result<Option<XyzwprExt>, Fault> {
        let n = match shift {
            Shift::No => return Ok(None),
            Shift::Register(index) => self.tp_index(index)?,
            Shift::Condition => condition.ok_or_else(|| {
                Fault::new(Status::INTP_UNINIT, "Offset without an OFFSET CONDITION")
            })?,
        };
        match self.registers.position(n) {
            Ok(PositionRegister::Cartesian(position)) => Ok(Some(*position)),
            Ok(PositionRegister::Joints(_)) => {
                let message = format!("PR[{n}] has joints, an offset needs a pose");
                Err(Fault::new(Status::INTP_TYPE, message))
            }
            Ok(PositionRegister::Unset) => {
                let message = format!("PR[{n}] has no value");
                Err(Fault::new(Status::INTP_UNINIT, message))
            }
            Err(status) => Err(no_such("PR", n, status)),
        }
    }

    /// A taught position is only good in the frames in which it was taught.
    fn check_frames(&self, taught: &Taught) -> Result<(), Fault> {
        let numbers = [
            ("$MNUFRAMENUM", "user frame", taught.frame),
            ("$MNUTOOLNUM", "tool", taught.tool),
        ];
        for (name, what, wanted) in numbers {
            let path = SysPath::from_name(name).index(&[1]);
            let active = self.host.system_variable(self.id, &path);
            if let (Some(wanted), Ok(Value::Integer(active))) = (wanted, active)
                && wanted != active
            {
                let n = taught.number;
                let message = format!("P[{n}] is for the {what} {wanted}, active is {active}");
                return Err(Fault::new(Status::INTP_FRAME, message));
            }
        }
        Ok(())
    }
}

#[expect(clippy::cast_possible_truncation, reason = "positions have REALs")]
fn narrow(value: f64) -> f32 {
    value as f32
}
