//! Motion instructions of TP programs.

use super::{
    exec::{Exec, Flow},
    fault::Fault,
    task::{Pending, Watch},
    tp_value::{Term, no_such},
};
use crate::{
    frame::Frame,
    host::{Progress, TpMotion, TpSpeed, TpTarget, Wait},
    position::XyzwprExt,
    registers::PositionRegister,
    status::Status,
    syspath::SysPath,
    tp::{Index, Motion, MotionTarget, Operand, Shift, Speed, SpeedUnit, Taught, Wrist},
    value::Value,
};

impl Exec<'_> {
    pub(super) fn tp_move(&mut self, motion: &Motion) -> Result<Flow, Fault> {
        let id = if let Pending::Motion(id) | Pending::Skipped(id) = self.task.pending {
            id
        } else {
            let request = self.tp_request(motion)?;
            let beside = motion.beside.is_some().then(|| request.clone());
            match self.host.start_tp_motion(self.id, request, self.registers) {
                Progress::Pending(wait) => return Ok(Flow::Blocked(wait)),
                Progress::Ready(Ok(id)) => {
                    self.tp_forget(Watch::Skip);
                    self.tp_begin_beside(motion, id, beside.as_ref())?;
                    id
                }
                Progress::Ready(Err(status)) => {
                    return Err(Fault::from_host(status, "The motion was refused"));
                }
            }
        };
        if !matches!(self.task.pending, Pending::Skipped(_)) {
            self.task.pending = Pending::Motion(id);
            if motion.skip.is_some() && self.tp_skips()? {
                if let Some((register, what)) = &motion.skip_keeps {
                    self.tp_keep_position(*register, what)?;
                }
                self.host.cancel_arm(self.id);
                self.task.pending = Pending::Skipped(id);
            }
        }
        match self.host.motion_ended(id) {
            // It looks at the SKIP CONDITION again and again.
            Progress::Pending(_) if motion.skip.is_some() => {
                Ok(Flow::Blocked(Wait::Until(self.next_look())))
            }
            Progress::Pending(wait) => Ok(Flow::Blocked(wait)),
            Progress::Ready(status) if status.is_ok() => {
                let skipped = matches!(self.task.pending, Pending::Skipped(_));
                self.task.pending = Pending::None;
                let rounds = motion.rounding.is_some() && !skipped;
                self.task.tp.rounding = rounds.then_some(id);
                match &motion.skip {
                    Some(label) if skipped == motion.skip_jumps => self.tp_goto(label),
                    Some(_) | None => Ok(Flow::Next),
                }
            }
            Progress::Ready(status) => Err(Fault::from_host(status, "The motion failed")),
        }
    }

    /// The end of a program whose last motion may still be on its way.
    ///
    /// ASSUMPTION: a program that a TP program has called leaves that motion to it, so that the corner can be rounded;
    /// any other end waits until the arm stands still.
    pub(super) fn tp_end_program(&mut self) -> Result<Flow, Fault> {
        let caller = self.task.callers.last();
        let caller = caller.and_then(|caller| self.programs.get(caller.program));
        let goes_on = caller.is_some_and(|caller| !caller.program.code.tp.is_empty());
        if let Some(motion) = self.task.tp.rounding
            && !goes_on
        {
            match self.host.motion_rests(motion) {
                Progress::Pending(wait) => return Ok(Flow::Blocked(wait)),
                Progress::Ready(status) if status.is_ok() => self.task.tp.rounding = None,
                Progress::Ready(status) => {
                    return Err(Fault::from_host(status, "The motion failed"));
                }
            }
        }
        Ok(self.end_program())
    }

    fn tp_keep_position(&mut self, register: Index, what: &Operand) -> Result<(), Fault> {
        let n = self.tp_index(register)?;
        if let Term::Position(position) = self.tp_operand(what)? {
            let set = self.registers.set_position(n, position);
            set.map_err(|status| no_such("PR", n, status))?;
        }
        Ok(())
    }

    fn tp_skips(&mut self) -> Result<bool, Fault> {
        let Some(condition) = self.task.tp.skip.clone() else {
            let message = "Skip without a SKIP CONDITION";
            return Err(Fault::new(Status::INTP_UNINIT, message));
        };
        self.tp_sees(Watch::Skip, &condition)
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
        let speed = self.tp_speed(&motion.speed)?;
        let rounding_percent = match &motion.rounding {
            Some(operand) => Some(self.tp_rounding(operand)?),
            None => None,
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
            rounding_percent,
            incremental: motion.incremental,
            wrist_joint: motion.wrist == Wrist::AsJoints,
            least_rotation: motion.wrist == Wrist::LeastRotation,
            acceleration_percent,
            program: self.program.name_arc(),
            line: self.line(),
        })
    }

    fn tp_speed(&mut self, speed: &Speed) -> Result<TpSpeed, Fault> {
        let (speed, unit) = match speed {
            Speed::Greatest => return Ok(TpSpeed::Greatest),
            Speed::Of(speed, unit) => (self.tp_real(speed, "A speed")?, *unit),
        };
        Ok(match unit {
            SpeedUnit::Percent => TpSpeed::Percent(speed),
            SpeedUnit::MmPerSec => TpSpeed::MmPerSec(speed),
            SpeedUnit::CmPerMin => TpSpeed::MmPerSec(speed / 6.0),
            SpeedUnit::InchPerMin => TpSpeed::MmPerSec(speed * 25.4 / 60.0),
            SpeedUnit::DegPerSec => TpSpeed::DegPerSec(speed),
            SpeedUnit::Seconds => TpSpeed::Seconds(speed),
            SpeedUnit::Milliseconds => TpSpeed::Seconds(speed / 1000.0),
        })
    }

    fn tp_rounding(&mut self, operand: &Operand) -> Result<f32, Fault> {
        let percent = self.tp_real(operand, "CNT")?;
        if (0.0..=100.0).contains(&percent) {
            return Ok(percent);
        }
        Err(Fault::argument(format!(
            "CNT is {percent}, it must be 0 to 100"
        )))
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
            MotionTarget::TaughtBy(index, positions) => {
                let n = self.tp_index(*index)?;
                let changed = self.teaching.changed(self.program.name(), n);
                let taught = changed.or_else(|| positions.get(&n).map(AsRef::as_ref));
                let Some(taught) = taught else {
                    let message = format!("P[{n}] has no value");
                    return Err(Fault::new(Status::INTP_UNINIT, message));
                };
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
