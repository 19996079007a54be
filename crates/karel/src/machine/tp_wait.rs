//! Time in TP programs: WAIT, PULSE, TIMER, and what is looked at again and again.

use std::time::Duration;

use super::{
    exec::{Exec, Flow},
    fault::Fault,
    task::{Monitor, Pending, Watch},
    tp_value::no_such,
};
use crate::{
    host::{AlarmSeverity, ProgramAlarm, Wait},
    port::{Port, PortValue},
    status::Status,
    syspath::SysPath,
    tp::{Expr, Goal, Index, Instruction, Operand, TimerAction},
    value::Value,
};

/// How often a WAIT, a SKIP CONDITION and a MONITOR look at a host without interpolation.
const LOOK: Duration = Duration::from_millis(8);

/// Most programs of conditions that a task looks at.
///
/// ASSUMPTION: enough for programs of the field.
const MOST_MONITORS: usize = 10;

impl Exec<'_> {
    /// When a WAIT, a SKIP CONDITION or a MONITOR looks again.
    ///
    /// ASSUMPTION: after one interpolation period.
    pub(super) fn next_look(&self) -> Duration {
        let period = self.host.interpolation_period();
        self.host.now() + if period.is_zero() { LOOK } else { period }
    }

    /// ASSUMPTION: `$WAITTMOUT` is in hundredths of a second, 30 s if this controller has none.
    pub(super) fn tp_wait_for(
        &mut self,
        condition: &Expr,
        timeout: Option<&Goal>,
    ) -> Result<Flow, Fault> {
        if self.tp_sees(Watch::Line, condition)? {
            self.tp_forget(Watch::Line);
            self.task.pending = Pending::None;
            return Ok(Flow::Next);
        }
        let look = self.next_look();
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
            self.tp_forget(Watch::Line);
            self.task.pending = Pending::None;
            return self.tp_goto(label);
        }
        self.task.pending = Pending::Deadline(until);
        Ok(Flow::Blocked(Wait::Until(look.min(until))))
    }

    pub(super) fn tp_wait(&mut self, time: &Operand) -> Result<Flow, Fault> {
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

    /// ASSUMPTION: the output is on for that time, whatever it was before, and then off; the next
    /// line does not wait.
    pub(super) fn tp_pulse(
        &mut self,
        (port, index): (Port, Index),
        width: Option<&Operand>,
    ) -> Result<Flow, Fault> {
        let n = self.tp_index(index)?;
        let seconds = match width {
            Some(width) => self.tp_real(width, "PULSE")?,
            None => self.pulse_width(),
        };
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

    /// ASSUMPTION: `$DEFPULSE` counts tenths of a second; 0.4 s where the controller has none.
    fn pulse_width(&self) -> f32 {
        let path = SysPath::from_name("$DEFPULSE");
        let tenths = match self.host.system_variable(self.id, &path) {
            Ok(Value::Integer(tenths)) => tenths,
            Ok(_) | Err(_) => 4,
        };
        crate::value::real_of(tenths) / 10.0
    }

    pub(super) fn tp_timer(&mut self, index: Index, action: TimerAction) -> Result<Flow, Fault> {
        let n = self.tp_index(index)?;
        let now = self.host.now();
        let done = self.timers.act(n, action, now);
        let () = done.ok_or_else(|| no_such("TIMER", n, Status::VARS_INDEX))?;
        Ok(Flow::Next)
    }

    /// ASSUMPTION: a user alarm is INTP-213 and pauses the program; its words are `$UALRM_MSG[n]`, and without any its
    /// number is its text.
    pub(super) fn tp_user_alarm(&mut self, index: Index) -> Result<Flow, Fault> {
        let n = self.tp_index(index)?;
        let path = SysPath::from_name("$UALRM_MSG").index(&[n]);
        let words = match self.host.system_variable(self.id, &path) {
            Ok(Value::String(words)) => words.to_string_lossless(),
            Ok(_) | Err(_) => String::new(),
        };
        let text = if words.is_empty() {
            format!("UALM[{n}]")
        } else {
            format!("{words} UALM[{n}]")
        };
        let alarm = ProgramAlarm {
            status: Status::INTP_USER_ALARM,
            text,
            severity: AlarmSeverity::Pause,
            program: self.program.name_arc(),
            line: self.line(),
        };
        self.host.raise_alarm(self.id, alarm);
        self.task.paused = true;
        self.task.pc += 1;
        Ok(Flow::Yield)
    }

    /// ASSUMPTION: a monitor ends with its task, and as soon as one of its conditions held.
    pub(super) fn tp_monitor(&mut self, name: &str, on: bool) -> Result<Flow, Fault> {
        let mut programs = self.programs.iter();
        let Some(program) = programs.position(|loaded| loaded.name() == name) else {
            let message = format!("There is no program {name}");
            return Err(Fault::new(Status::INTP_CALL_FAILED, message));
        };
        self.tp_forget(Watch::Monitor(program));
        let next = self.host.now();
        let monitors = &mut self.task.tp.monitors;
        monitors.retain(|monitor| monitor.program != program);
        if on {
            if monitors.len() >= MOST_MONITORS {
                return Err(Fault::new(Status::INTP_LIMIT, "Too many monitors"));
            }
            monitors.push(Monitor { program, next });
        }
        Ok(Flow::Next)
    }

    /// The action of the first condition that holds is to interrupt the task.
    pub(super) fn look_at_monitors(&mut self, now: Duration) -> Result<(), Fault> {
        if self.task.paused {
            return Ok(());
        }
        let next = self.next_look();
        for at in 0..self.task.tp.monitors.len() {
            let Some(monitor) = self.task.tp.monitors.get_mut(at) else {
                break;
            };
            if monitor.next > now {
                continue;
            }
            monitor.next = next;
            let program = monitor.program;
            let programs = self.programs;
            let lines = programs.get(program).map(|loaded| &loaded.program.code.tp);
            for line in lines.into_iter().flatten() {
                self.looked = self.looked.saturating_add(1);
                let Instruction::When(condition, call) = line else {
                    continue;
                };
                if !self.tp_sees(Watch::Monitor(program), condition)? {
                    continue;
                }
                let arguments = self.tp_arguments(call)?;
                let _ended = self.task.tp.monitors.remove(at);
                self.tp_trigger(&call.program, arguments)?;
                return Ok(());
            }
        }
        Ok(())
    }
}
