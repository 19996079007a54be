//! Instructions of TP programs.

use std::time::Duration;

use super::{
    exec::{Exec, Flow, row_of},
    fault::Fault,
    task::Pending,
};
use crate::{
    ast::Relation,
    host::{Progress, TpMotion, TpSpeed, TpTarget, Wait},
    port::PortValue,
    registers::{Number, PositionRegister},
    status::Status,
    syspath::SysPath,
    tp::{
        Arithmetic, Branch, Condition, Expr, Index, Instruction, Motion, MotionTarget, Operand,
        Place, SpeedUnit, Taught, Test,
    },
    value::{SysValue, Value, real_of},
};

/// How often a WAIT for a condition looks.
///
/// ASSUMPTION: one interpolation period.
const LOOK: Duration = Duration::from_millis(8);

/// A value of an instruction.
#[derive(Clone, Debug, PartialEq)]
enum Term {
    Number(Number),
    Switch(bool),
    Position(PositionRegister),
}

impl Exec<'_> {
    pub(super) fn tp(&mut self, row: u32) -> Result<Flow, Fault> {
        let program = self.program;
        match row_of(&program.code.tp, row) {
            Instruction::Nothing => Ok(Flow::Next),
            Instruction::Jump(line) => Ok(self.jump(*line)),
            Instruction::Assign { target, value } => self.tp_assign(*target, value),
            Instruction::If { condition, then } => {
                if !self.tp_holds(condition)? {
                    return Ok(Flow::Next);
                }
                match then {
                    Branch::Jump(line) => Ok(self.jump(*line)),
                    Branch::Call(name) => self.call_program(name),
                }
            }
            Instruction::WaitSeconds(time) => self.tp_wait(*time),
            Instruction::WaitFor(condition) => {
                if self.tp_holds(condition)? {
                    return Ok(Flow::Next);
                }
                Ok(Flow::Blocked(Wait::Until(self.host.now() + LOOK)))
            }
            Instruction::Call(name) => self.call_program(name),
            Instruction::Run(name) => self.tp_run(name),
            Instruction::Move(motion) => self.tp_move(motion),
            Instruction::End => Ok(self.end_program()),
            Instruction::Abort => Ok(self.end_task()),
        }
    }

    fn tp_run(&mut self, name: &str) -> Result<Flow, Fault> {
        let started = self.others.start(self.programs, self.limits, name);
        let _task = started.map_err(|error| {
            Fault::new(Status::INTP_CALL_FAILED, format!("RUN {name}: {error}"))
        })?;
        Ok(Flow::Next)
    }

    fn tp_wait(&mut self, time: Operand) -> Result<Flow, Fault> {
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

    fn tp_assign(&mut self, target: Place, value: &Expr) -> Result<Flow, Fault> {
        let value = self.tp_value(value)?;
        match (target, value) {
            (Place::Number(index), Term::Number(value)) => {
                let n = self.tp_index(index)?;
                let set = self.registers.set_number(n, value);
                set.map_err(|status| no_such("R", n, status))?;
            }
            (Place::Position(index), Term::Position(value)) => {
                let n = self.tp_index(index)?;
                let set = self.registers.set_position(n, value);
                set.map_err(|status| no_such("PR", n, status))?;
            }
            (Place::Port(port, index), Term::Switch(on)) => {
                let n = self.tp_index(index)?;
                let set = self.host.set_port(self.id, port, n, PortValue::Switch(on));
                set.map_err(|status| no_such(port.name(), n, status))?;
            }
            (Place::UserFrame, Term::Number(number)) => {
                self.tp_frame("$MNUFRAMENUM", number)?;
            }
            (Place::Tool, Term::Number(number)) => self.tp_frame("$MNUTOOLNUM", number)?,
            (place, value) => {
                let message = format!("{place:?} cannot be {value:?}");
                return Err(Fault::new(Status::INTP_TYPE, message));
            }
        }
        Ok(Flow::Next)
    }

    fn tp_frame(&mut self, name: &str, number: Number) -> Result<(), Fault> {
        let Number::Integer(number) = number else {
            return Err(Fault::argument("The number of a frame is a whole number"));
        };
        let path = SysPath::from_name(name).index(&[1]);
        let value = SysValue::Value(Value::Integer(number));
        let set = self.host.set_system_variable(self.id, &path, value);
        set.map_err(|status| Fault::new(status, format!("There is no frame {number}")))
    }

    fn tp_index(&self, index: Index) -> Result<i32, Fault> {
        match index {
            Index::Fixed(number) => Ok(number),
            Index::Register(register) => match self.tp_register(register)? {
                Number::Integer(number) => Ok(number),
                Number::Real(value) => Err(Fault::argument(format!(
                    "R[{register}] is {value}, no number of a register"
                ))),
            },
        }
    }

    fn tp_register(&self, n: i32) -> Result<Number, Fault> {
        self.registers
            .number(n)
            .map_err(|status| no_such("R", n, status))
    }

    fn tp_operand(&self, operand: Operand) -> Result<Term, Fault> {
        Ok(match operand {
            Operand::Integer(value) => Term::Number(Number::Integer(value)),
            Operand::Real(value) => Term::Number(Number::Real(value)),
            Operand::Switch(on) => Term::Switch(on),
            Operand::Number(index) => Term::Number(self.tp_register(self.tp_index(index)?)?),
            Operand::Position(index) => {
                let n = self.tp_index(index)?;
                let position = self.registers.position(n);
                Term::Position(position.map_err(|status| no_such("PR", n, status))?.clone())
            }
            Operand::Port(port, index) => {
                let n = self.tp_index(index)?;
                match self.host.port(port, n) {
                    Ok(PortValue::Switch(on)) => Term::Switch(on),
                    Ok(PortValue::Number(value)) => Term::Number(Number::Integer(value)),
                    Err(status) => return Err(no_such(port.name(), n, status)),
                }
            }
        })
    }

    fn tp_real(&self, operand: Operand, what: &str) -> Result<f32, Fault> {
        match self.tp_operand(operand)? {
            Term::Number(Number::Integer(value)) => Ok(real_of(value)),
            Term::Number(Number::Real(value)) => Ok(value),
            Term::Switch(_) | Term::Position(_) => Err(Fault::new(
                Status::INTP_TYPE,
                format!("{what} needs a number"),
            )),
        }
    }

    fn tp_value(&self, value: &Expr) -> Result<Term, Fault> {
        let mut result = self.tp_operand(value.first)?;
        if value.negated {
            let Term::Switch(on) = result else {
                return Err(Fault::new(Status::INTP_TYPE, "`!` needs ON or OFF"));
            };
            result = Term::Switch(!on);
        }
        for (operator, operand) in &value.rest {
            let (Term::Number(a), Term::Number(b)) = (result, self.tp_operand(*operand)?) else {
                return Err(Fault::new(Status::INTP_TYPE, "A calculation needs numbers"));
            };
            result = Term::Number(calculate(*operator, a, b)?);
        }
        Ok(result)
    }

    fn tp_holds(&self, condition: &Condition) -> Result<bool, Fault> {
        for test in &condition.tests {
            if self.tp_test(test)? != condition.all {
                return Ok(!condition.all);
            }
        }
        Ok(condition.all)
    }

    fn tp_test(&self, test: &Test) -> Result<bool, Fault> {
        let left = self.tp_operand(test.left)?;
        let holds = match test.right {
            None => match left {
                Term::Switch(on) => on,
                Term::Number(_) | Term::Position(_) => {
                    return Err(Fault::new(Status::INTP_TYPE, "A condition needs ON or OFF"));
                }
            },
            Some((relation, right)) => compare(&left, relation, &self.tp_operand(right)?)?,
        };
        Ok(holds != test.negated)
    }

    fn tp_move(&mut self, motion: &Motion) -> Result<Flow, Fault> {
        let id = if let Pending::Motion(id) = self.task.pending {
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
        self.task.pending = Pending::Motion(id);
        match self.host.motion_ended(id) {
            Progress::Pending(wait) => Ok(Flow::Blocked(wait)),
            Progress::Ready(status) if status.is_ok() => {
                self.task.pending = Pending::None;
                Ok(Flow::Next)
            }
            Progress::Ready(status) => Err(Fault::from_host(status, "The motion failed")),
        }
    }

    fn tp_request(&self, motion: &Motion) -> Result<TpMotion, Fault> {
        let target = match &motion.target {
            MotionTarget::Register(index) => {
                let n = self.tp_index(*index)?;
                let position = self.registers.position(n);
                match position.map_err(|status| no_such("PR", n, status))? {
                    PositionRegister::Cartesian(position) => TpTarget::Cartesian(*position),
                    PositionRegister::Joints(joints) => TpTarget::Joints(joints.clone()),
                    PositionRegister::Unset => {
                        let message = format!("PR[{n}] has no value");
                        return Err(Fault::new(Status::INTP_UNINIT, message));
                    }
                }
            }
            MotionTarget::Taught(taught) => {
                self.check_frames(taught)?;
                taught.target.clone()
            }
        };
        let speed = self.tp_real(motion.speed, "A speed")?;
        let speed = match motion.unit {
            SpeedUnit::Percent => TpSpeed::Percent(speed),
            SpeedUnit::MmPerSec => TpSpeed::MmPerSec(speed),
            SpeedUnit::CmPerMin => TpSpeed::MmPerSec(speed / 6.0),
        };
        let acceleration_percent = match motion.acceleration {
            Some(operand) => self.tp_real(operand, "ACC")?,
            None => 100.0,
        };
        Ok(TpMotion {
            interpolation: motion.interpolation,
            target,
            speed,
            acceleration_percent,
            program: self.program.name_arc(),
            line: self.line(),
        })
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

fn no_such(what: &str, n: i32, status: Status) -> Fault {
    Fault::new(status, format!("There is no {what}[{n}]"))
}

fn calculate(operator: Arithmetic, a: Number, b: Number) -> Result<Number, Fault> {
    if let (Number::Integer(a), Number::Integer(b)) = (a, b)
        && operator != Arithmetic::Divide
    {
        if b == 0 && matches!(operator, Arithmetic::Div | Arithmetic::Mod) {
            return Err(Fault::divide_by_zero());
        }
        let result = match operator {
            Arithmetic::Add => a.checked_add(b),
            Arithmetic::Subtract => a.checked_sub(b),
            Arithmetic::Multiply => a.checked_mul(b),
            Arithmetic::Div => a.checked_div(b),
            Arithmetic::Mod => a.checked_rem(b),
            Arithmetic::Divide => None,
        };
        return result.map(Number::Integer).ok_or_else(Fault::overflow);
    }
    let (a, b) = (real(a), real(b));
    let result = match operator {
        Arithmetic::Add => a + b,
        Arithmetic::Subtract => a - b,
        Arithmetic::Multiply => a * b,
        Arithmetic::Divide | Arithmetic::Div | Arithmetic::Mod if b == 0.0 => {
            return Err(Fault::divide_by_zero());
        }
        Arithmetic::Divide => a / b,
        Arithmetic::Div => (a / b).trunc(),
        Arithmetic::Mod => a % b,
    };
    super::finite(result).map(Number::Real)
}

fn real(number: Number) -> f32 {
    match number {
        Number::Integer(value) => real_of(value),
        Number::Real(value) => value,
    }
}

fn compare(left: &Term, relation: Relation, right: &Term) -> Result<bool, Fault> {
    let order = match (left, right) {
        (Term::Number(Number::Integer(a)), Term::Number(Number::Integer(b))) => a.cmp(b),
        (Term::Number(a), Term::Number(b)) => super::arithmetic::order(real(*a), real(*b)),
        (Term::Switch(a), Term::Switch(b))
            if matches!(relation, Relation::Equal | Relation::NotEqual) =>
        {
            a.cmp(b)
        }
        _ => {
            let message = format!("{left:?} cannot be compared with {right:?}");
            return Err(Fault::new(Status::INTP_TYPE, message));
        }
    };
    Ok(super::arithmetic::holds(relation, order))
}
