//! I/O ports, and the pauses of a task that waits for a condition.

use std::time::Duration;

use super::{
    cell::Cell,
    exec::{Exec, Flow},
    fault::Fault,
    task::Pending,
};
use crate::{
    host::Wait,
    port::{Port, PortValue},
    status::Status,
    syspath::SysPath,
    value::Value,
};

/// How often conditions are looked at if `$SCAN_TIME` does not say it.
const SCAN: Duration = Duration::from_millis(32);

impl Exec<'_> {
    pub(super) fn load_port(&mut self, port: Port) -> Result<Flow, Fault> {
        let number = self.pop_integer();
        let value = self.host.port(port, number);
        let value = value.map_err(|status| illegal(status, port, number))?;
        self.push(match (value, port.is_switch()) {
            (PortValue::Switch(on), true) => Cell::Boolean(on),
            (PortValue::Number(value), false) => Cell::Integer(value),
            (PortValue::Switch(on), false) => Cell::Integer(i32::from(on)),
            (PortValue::Number(value), true) => Cell::Boolean(value != 0),
        });
        Ok(Flow::Next)
    }

    pub(super) fn store_port(&mut self, port: Port) -> Result<Flow, Fault> {
        let number = self.pop_integer();
        let value = if port.is_switch() {
            PortValue::Switch(self.pop_boolean())
        } else {
            PortValue::Number(self.pop_integer())
        };
        let set = self.host.set_port(self.id, port, number, value);
        set.map_err(|status| illegal(status, port, number))?;
        Ok(Flow::Next)
    }

    /// The task rests until conditions are looked at again.
    ///
    /// ASSUMPTION: that is every `$SCAN_TIME` milliseconds, counted from this look.
    pub(super) fn scan(&mut self) -> Flow {
        if let Pending::Until(until) = self.task.pending {
            if self.host.now() < until {
                return Flow::Blocked(Wait::Until(until));
            }
            self.task.pending = Pending::None;
            self.hear_alarms();
            return Flow::Next;
        }
        let period = self.scan_period();
        let until = self.host.now().saturating_add(period);
        self.task.pending = Pending::Until(until);
        Flow::Blocked(Wait::Until(until))
    }

    /// `$SCAN_TIME`, or what it is if nobody says it.
    pub(super) fn scan_period(&self) -> Duration {
        let path = SysPath::from_name("$SCAN_TIME");
        let period = match self.host.system_variable(self.id, &path) {
            Ok(Value::Integer(time)) => u64::try_from(time).ok().filter(|time| *time > 0),
            Ok(_) | Err(_) => None,
        };
        period.map_or(SCAN, Duration::from_millis)
    }
}

pub(super) fn illegal(status: Status, port: Port, number: i32) -> Fault {
    if status == Status::PRIO_PORT_NUMBER {
        return Fault::new(status, format!("Illegal port number {port}[{number}]"));
    }
    Fault::new(status, format!("Illegal value for {port}[{number}]"))
}
