//! I/O ports: what programs and the world outside put on them.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use karel::{Port, PortValue, Status};
use serde::{Deserialize, Serialize};

/// How many ports there are of each kind.
///
/// ASSUMPTION: a controller with its usual boards; the ports of the wrist are eight.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PortCounts {
    /// `DIN` and `DOUT`, each.
    pub digital: u16,
    /// `RDI` and `RDO`, each.
    pub robot: u16,
    /// `FLG`.
    pub flags: u16,
    /// `GIN` and `GOUT`, each.
    pub groups: u16,
    /// `AIN` and `AOUT`, each.
    pub analog: u16,
}

impl Default for PortCounts {
    fn default() -> Self {
        Self {
            digital: 512,
            robot: 8,
            flags: 1024,
            groups: 100,
            analog: 25,
        }
    }
}

/// A port that is not off, as people and tests see it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
pub struct PortView {
    /// `DOUT[3]`.
    pub port: String,
    /// 1 for one that is on, else the number.
    pub value: i32,
}

/// Why an input cannot be set from outside.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SetInputError {
    /// Programs set it.
    #[error("{port} is not an input")]
    NotAnInput {
        /// The array.
        port: Port,
    },
    /// There are not as many.
    #[error("there is no {port}[{number}], the last is {port}[{count}]")]
    NoSuchPort {
        /// The array.
        port: Port,
        /// The number asked for.
        number: u16,
        /// How many there are.
        count: u16,
    },
    /// A number for a switch, a switch for a number, or a number out of range.
    #[error("{port} cannot be {value:?}")]
    Value {
        /// The array.
        port: Port,
        /// The value.
        value: PortValue,
    },
    /// The controller stopped.
    #[error(transparent)]
    Stopped(#[from] crate::error::ControllerStopped),
}

/// All ports; those that are off are not stored.
#[derive(Debug)]
pub(crate) struct Ports {
    counts: PortCounts,
    values: BTreeMap<(Port, u16), i32>,
    /// What programs see of inputs that are simulated, whatever the world puts on them.
    simulated: BTreeMap<(Port, u16), i32>,
}

impl Ports {
    pub(crate) fn new(counts: PortCounts) -> Self {
        Self {
            counts,
            values: BTreeMap::new(),
            simulated: BTreeMap::new(),
        }
    }

    /// The value of a port.
    pub(crate) fn get(&self, port: Port, number: i32) -> Result<PortValue, Status> {
        let number = self.number(port, number)?;
        let key = (port, number);
        let value = self.simulated.get(&key).or_else(|| self.values.get(&key));
        let value = value.copied().unwrap_or(0);
        Ok(if port.is_switch() {
            PortValue::Switch(value != 0)
        } else {
            PortValue::Number(value)
        })
    }

    /// Sets a port. Whether that changed it.
    pub(crate) fn set(
        &mut self,
        port: Port,
        number: i32,
        value: PortValue,
    ) -> Result<bool, Status> {
        let number = self.number(port, number)?;
        let value = raw(port, value).ok_or(Status::INTP_ARGUMENT)?;
        let before = if value == 0 {
            self.values.remove(&(port, number))
        } else {
            self.values.insert((port, number), value)
        };
        Ok(before.unwrap_or(0) != value)
    }

    /// Sets an input from outside. Whether that changed it.
    pub(crate) fn set_input(
        &mut self,
        port: Port,
        number: u16,
        value: PortValue,
    ) -> Result<bool, SetInputError> {
        if !port.is_input() {
            return Err(SetInputError::NotAnInput { port });
        }
        self.set(port, i32::from(number), value)
            .map_err(|status| match status {
                Status::PRIO_PORT_NUMBER => SetInputError::NoSuchPort {
                    port,
                    number,
                    count: self.count(port),
                },
                _ => SetInputError::Value { port, value },
            })
    }

    /// Simulates an input: programs see this value until [`Self::end_simulation`].
    pub(crate) fn simulate(
        &mut self,
        port: Port,
        number: u16,
        value: PortValue,
    ) -> Result<(), SetInputError> {
        self.check_input(port, number)?;
        let value = raw(port, value).ok_or(SetInputError::Value { port, value })?;
        let _before = self.simulated.insert((port, number), value);
        Ok(())
    }

    /// Programs see again what the world puts on an input.
    pub(crate) fn end_simulation(&mut self, port: Port, number: u16) -> Result<(), SetInputError> {
        self.check_input(port, number)?;
        let _before = self.simulated.remove(&(port, number));
        Ok(())
    }

    /// Whether an input is simulated.
    pub(crate) fn is_simulated(&self, port: Port, number: u16) -> bool {
        self.simulated.contains_key(&(port, number))
    }

    fn check_input(&self, port: Port, number: u16) -> Result<(), SetInputError> {
        if !port.is_input() {
            return Err(SetInputError::NotAnInput { port });
        }
        let no_such = |_| SetInputError::NoSuchPort {
            port,
            number,
            count: self.count(port),
        };
        self.number(port, number.into()).map(drop).map_err(no_such)
    }

    /// Outputs and flags are off when the controller is switched on; inputs are the world's.
    pub(crate) fn power_cycle(&mut self) {
        self.values.retain(|(port, _), _| port.is_input());
    }

    /// Every port that is not off.
    pub(crate) fn view(&self) -> Vec<PortView> {
        let mut seen = self.values.clone();
        seen.extend(&self.simulated);
        let view = |(&(port, number), &value): (&(Port, u16), &i32)| PortView {
            port: format!("{port}[{number}]"),
            value,
        };
        seen.iter().map(view).collect()
    }

    pub(crate) fn count(&self, port: Port) -> u16 {
        match port {
            Port::DigitalIn | Port::DigitalOut => self.counts.digital,
            Port::RobotIn | Port::RobotOut => self.counts.robot,
            Port::Flag => self.counts.flags,
            Port::GroupIn | Port::GroupOut => self.counts.groups,
            Port::AnalogIn | Port::AnalogOut => self.counts.analog,
            // The operator panel is not stored here.
            Port::PanelIn | Port::PanelOut => 0,
        }
    }

    fn number(&self, port: Port, number: i32) -> Result<u16, Status> {
        u16::try_from(number)
            .ok()
            .filter(|number| (1..=self.count(port)).contains(number))
            .ok_or(Status::PRIO_PORT_NUMBER)
    }
}

/// The stored form of a value, `None` if the port cannot have it.
fn raw(port: Port, value: PortValue) -> Option<i32> {
    match value {
        PortValue::Switch(on) => port.is_switch().then_some(i32::from(on)),
        PortValue::Number(number) => {
            let fits = !port.is_switch() && range(port).contains(&number);
            fits.then_some(number)
        }
    }
}

/// ASSUMPTION: groups have up to 16 bits, analog ports 16 with a sign; what does not fit is INTP-322.
fn range(port: Port) -> RangeInclusive<i32> {
    match port {
        Port::GroupIn | Port::GroupOut => 0..=65_535,
        Port::DigitalIn
        | Port::DigitalOut
        | Port::RobotIn
        | Port::RobotOut
        | Port::Flag
        | Port::AnalogIn
        | Port::AnalogOut
        | Port::PanelIn
        | Port::PanelOut => -32_768..=32_767,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn assumed_groups_have_sixteen_bits_and_analog_ports_a_sign() {
        let mut ports = Ports::new(PortCounts::default());
        for (port, value, fits) in [
            (Port::GroupOut, 65_535, true),
            (Port::GroupOut, 65_536, false),
            (Port::GroupOut, -1, false),
            (Port::AnalogOut, -32_768, true),
            (Port::AnalogOut, 32_768, false),
            (Port::DigitalOut, 1, false),
        ] {
            let set = ports.set(port, 1, PortValue::Number(value));
            assert_eq!(set.is_ok(), fits, "{port} {value}");
        }
    }

    #[test]
    fn inputs_keep_their_values_through_a_power_cycle_and_outputs_do_not() {
        let mut ports = Ports::new(PortCounts::default());
        let on = PortValue::Switch(true);
        assert_eq!(ports.set_input(Port::DigitalIn, 3, on), Ok(true));
        assert_eq!(ports.set(Port::Flag, 2, on), Ok(true));
        assert_eq!(ports.set(Port::Flag, 2, on), Ok(false), "nothing changed");
        assert_eq!(
            ports.simulate(Port::DigitalIn, 3, PortValue::Switch(false)),
            Ok(())
        );
        assert_eq!(ports.get(Port::DigitalIn, 3), Ok(PortValue::Switch(false)));
        assert_eq!(ports.end_simulation(Port::DigitalIn, 3), Ok(()));
        assert!(
            ports.simulate(Port::DigitalOut, 3, on).is_err(),
            "not an input"
        );
        assert!(
            ports.simulate(Port::DigitalIn, 513, on).is_err(),
            "there is none"
        );
        ports.power_cycle();
        let left: Vec<String> = ports.view().into_iter().map(|view| view.port).collect();
        assert_eq!(left, ["DIN[3]"]);
    }
}
