//! I/O ports as programs name them.

use std::fmt;

/// An array of ports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Port {
    /// `DIN`, digital inputs.
    DigitalIn,
    /// `DOUT`, digital outputs.
    DigitalOut,
    /// `RDI`, inputs at the robot's wrist.
    RobotIn,
    /// `RDO`, outputs at the robot's wrist.
    RobotOut,
    /// `FLG`, flags that programs share, `F[n]` of TP programs.
    Flag,
    /// `GIN`, groups of digital inputs as a number.
    GroupIn,
    /// `GOUT`, groups of digital outputs as a number.
    GroupOut,
    /// `AIN`, analog inputs.
    AnalogIn,
    /// `AOUT`, analog outputs.
    AnalogOut,
    /// `OPIN`, keys and switches of the operator panel.
    PanelIn,
    /// `OPOUT`, lamps of the operator panel, which the controller sets.
    PanelOut,
}

/// The value of a port.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PortValue {
    /// `ON` or `OFF`.
    Switch(bool),
    /// A number, of a group or an analog port.
    Number(i32),
}

impl Port {
    /// All of them.
    pub const ALL: [Port; 11] = [
        Port::DigitalIn,
        Port::DigitalOut,
        Port::RobotIn,
        Port::RobotOut,
        Port::Flag,
        Port::GroupIn,
        Port::GroupOut,
        Port::AnalogIn,
        Port::AnalogOut,
        Port::PanelIn,
        Port::PanelOut,
    ];

    /// The name of the array, `DOUT`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Port::DigitalIn => "DIN",
            Port::DigitalOut => "DOUT",
            Port::RobotIn => "RDI",
            Port::RobotOut => "RDO",
            Port::Flag => "FLG",
            Port::GroupIn => "GIN",
            Port::GroupOut => "GOUT",
            Port::AnalogIn => "AIN",
            Port::AnalogOut => "AOUT",
            Port::PanelIn => "OPIN",
            Port::PanelOut => "OPOUT",
        }
    }

    /// Whether programs only read it.
    #[must_use]
    pub fn is_input(self) -> bool {
        match self {
            Port::DigitalIn
            | Port::RobotIn
            | Port::GroupIn
            | Port::AnalogIn
            | Port::PanelIn
            | Port::PanelOut => true,
            Port::DigitalOut | Port::RobotOut | Port::Flag | Port::GroupOut | Port::AnalogOut => {
                false
            }
        }
    }

    /// Whether it is on or off, not a number.
    #[must_use]
    pub fn is_switch(self) -> bool {
        match self {
            Port::DigitalIn
            | Port::DigitalOut
            | Port::RobotIn
            | Port::RobotOut
            | Port::Flag
            | Port::PanelIn
            | Port::PanelOut => true,
            Port::GroupIn | Port::GroupOut | Port::AnalogIn | Port::AnalogOut => false,
        }
    }

    pub(crate) fn named(name: &str) -> Option<Port> {
        Port::ALL.into_iter().find(|port| port.name() == name)
    }
}

impl fmt::Display for Port {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
