//! I/O ports as programs name them.

use std::{collections::BTreeMap, fmt};

use crate::value::Text;

/// What can have a comment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Commented {
    Port(Port),
    /// `R[n]`.
    Number,
    /// `PR[n]`.
    Position,
    /// `SR[n]`.
    Text,
}

/// Comments of ports and registers, which programs may write and read.
#[derive(Debug, Default)]
pub(crate) struct Comments(BTreeMap<(Commented, i32), Text>);

impl Comments {
    /// Longest comment, and most of them.
    const LONGEST: usize = 24;
    const MOST: usize = 1 << 14;

    /// `false` if there are too many.
    pub(crate) fn set(&mut self, what: (Commented, i32), mut comment: Text) -> bool {
        comment.truncate(Comments::LONGEST);
        let fits = self.0.len() < Comments::MOST || self.0.contains_key(&what);
        if fits {
            let _before = self.0.insert(what, comment);
        }
        fits
    }

    pub(crate) fn get(&self, what: (Commented, i32)) -> Text {
        self.0.get(&what).cloned().unwrap_or_default()
    }
}

/// What programs say of ports and what changes nothing here: assignments and modes.
#[derive(Debug, Default)]
pub(crate) struct PortSetup {
    assignments: BTreeMap<(Port, i32), [i32; 5]>,
    modes: BTreeMap<(Port, i32), i32>,
}

impl PortSetup {
    const MOST: usize = 1 << 12;

    /// `false` if there are too many.
    pub(crate) fn assign(&mut self, port: (Port, i32), values: [i32; 5]) -> bool {
        let fits = self.assignments.len() < PortSetup::MOST;
        if fits {
            let _before = self.assignments.insert(port, values);
        }
        fits
    }

    pub(crate) fn assignment(&self, port: (Port, i32)) -> Option<[i32; 5]> {
        self.assignments.get(&port).copied()
    }

    /// `false` if there are too many.
    pub(crate) fn set_mode(&mut self, port: (Port, i32), mode: i32) -> bool {
        let fits = self.modes.len() < PortSetup::MOST;
        if fits {
            let _before = self.modes.insert(port, mode);
        }
        fits
    }

    pub(crate) fn mode(&self, port: (Port, i32)) -> i32 {
        self.modes.get(&port).copied().unwrap_or(0)
    }
}

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
    /// `TPIN`, keys of the teach pendant.
    PendantIn,
    /// `TPOUT`, lamps of the teach pendant.
    PendantOut,
    /// `UIN`, user operator panel inputs.
    UserIn,
    /// `UOUT`, user operator panel outputs, which the controller sets.
    UserOut,
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
    pub const ALL: [Port; 15] = [
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
        Port::PendantIn,
        Port::PendantOut,
        Port::UserIn,
        Port::UserOut,
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
            Port::PendantIn => "TPIN",
            Port::PendantOut => "TPOUT",
            Port::UserIn => "UIN",
            Port::UserOut => "UOUT",
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
            | Port::PanelOut
            | Port::PendantIn
            | Port::UserIn
            | Port::UserOut => true,
            Port::DigitalOut
            | Port::RobotOut
            | Port::Flag
            | Port::GroupOut
            | Port::AnalogOut
            | Port::PendantOut => false,
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
            | Port::PanelOut
            | Port::PendantIn
            | Port::PendantOut
            | Port::UserIn
            | Port::UserOut => true,
            Port::GroupIn | Port::GroupOut | Port::AnalogIn | Port::AnalogOut => false,
        }
    }

    /// The port of a number that programs have from `kliotyps`.
    pub(crate) fn of_type(number: i32) -> Option<Port> {
        let index = usize::try_from(number).ok()?.checked_sub(1)?;
        Port::ALL.get(index).copied()
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
