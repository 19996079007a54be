//! What an operator does at the controller: mode switch, pendant, emergency stop, HOLD.

use karel::{AlarmView, Port, PortValue, Status};
use serde::{Deserialize, Serialize};

use super::Hardware;
use super::safety::Drives;
use crate::alarms::Severity;
use crate::motion::Refusal;

/// The mode switch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "UPPERCASE")]
pub enum OperatingMode {
    /// Manual with reduced speed.
    T1,
    /// Manual with full speed.
    T2,
    /// Automatic.
    #[default]
    Auto,
}

impl std::fmt::Display for OperatingMode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::T1 => "T1",
            Self::T2 => "T2",
            Self::Auto => "AUTO",
        })
    }
}

/// Switches and keys; the power does not change them.
#[derive(Clone, Copy, Debug, Default)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a switch or a lamp of its own"
)]
pub(crate) struct Operator {
    pub(crate) mode: OperatingMode,
    pub(crate) pendant: bool,
    /// The enabling switch of the pendant is held.
    pub(crate) deadman: bool,
    /// Emergency stops that are pressed, as bits of `$MOR.$SAFETY_STAT`.
    pub(crate) stops: i32,
    pub(crate) drives: Drives,
    pub(crate) hold: bool,
    /// The servos have no power.
    pub(crate) servo_off: bool,
}

/// SRVO-001: the emergency stop of the operator panel.
pub(crate) const SRVO_EMERGENCY_STOP: Status = Status::new(11, 1);
/// SRVO-003: the pendant is enabled.
///
/// ASSUMPTION: this number and the next one are ours.
pub(crate) const SRVO_PENDANT: Status = Status::new(11, 3);
/// SRVO-998: the servos have no power. A number of our own.
pub(crate) const SRVO_NO_POWER: Status = Status::new(11, 998);
/// SYST-040: the mode was changed, or does not permit a motion.
pub(crate) const SYST_MODE: Status = Status::new(24, 40);

/// Lamps of the operator panel, as indices of `OPOUT`.
///
/// ASSUMPTION: 2 is HELD; 0, 3 and 7 are REMOTE, FAULT and TP ENABLED.
mod lamp {
    pub(super) const REMOTE: i32 = 0;
    pub(super) const CYCLE: i32 = 1;
    pub(super) const HELD: i32 = 2;
    pub(super) const FAULT: i32 = 3;
    pub(super) const PENDANT: i32 = 7;
}

/// The mode switch's two contacts, as indices of `OPIN`.
///
/// ASSUMPTION: both are closed in AUTO, the first one alone in T1, none in T2.
mod contact {
    pub(super) const FIRST: i32 = 8;
    pub(super) const SECOND: i32 = 9;
}

/// Keys and lamps of the operator panel are numbered from 0 to this.
const LAST_PANEL_PORT: i32 = 15;

impl Hardware {
    /// Whether a motion may start; a motion that is held by HOLD may, and waits.
    ///
    /// ASSUMPTION: in T1 and T2 a program moves the arm while somebody holds the enabling switch of the enabled
    /// pendant.
    pub(crate) fn may_move(&self) -> Result<(), Refusal> {
        let operator = self.operator;
        if operator.stops != 0 {
            let text = "The emergency stop is pressed";
            return Err(Refusal::new(SRVO_EMERGENCY_STOP, text));
        }
        if !self.drives_powered() || operator.drives != Drives::On {
            return Err(Refusal::new(SRVO_NO_POWER, "The servos have no power"));
        }
        let mode = operator.mode;
        match (operator.pendant, mode) {
            (false, OperatingMode::Auto) => Ok(()),
            (true, OperatingMode::T1 | OperatingMode::T2) if operator.deadman => Ok(()),
            (true, _) => Err(Refusal::new(SRVO_PENDANT, "The teach pendant is enabled")),
            (false, _) => {
                let text = format!("The mode is {mode}, a program moves the arm in AUTO only");
                Err(Refusal::new(SYST_MODE, text))
            }
        }
    }

    /// Why tasks cannot go on now.
    pub(crate) fn start_obstacle(&self) -> Option<String> {
        if self.alarms.active() > 0 {
            return Some("an alarm waits for a RESET".to_owned());
        }
        self.may_move().err().map(|refusal| refusal.text)
    }

    /// Sets the general override. `false` if it is no percentage.
    pub(crate) fn set_override(&mut self, percent: i32) -> bool {
        let path = karel::SysPath::from_name("$MCR").field("$GENOVERRIDE");
        let value = karel::SysValue::Value(karel::Value::Integer(percent));
        let set = self.variables.set(&path, value).is_ok();
        self.follow_override();
        set
    }

    /// A person moves the arm. `false` if a program has it.
    pub(crate) fn jog(&mut self, joints: kinematics::PendantJoints) -> bool {
        let from = self.executor.joints(self.now);
        if !self.executor.place(joints) {
            return false;
        }
        self.note_jog(&from, &joints);
        true
    }

    /// A key or a lamp of the operator panel.
    pub(super) fn panel_port(&self, port: Port, number: i32) -> Result<PortValue, Status> {
        if !(0..=LAST_PANEL_PORT).contains(&number) {
            return Err(Status::PRIO_PORT_NUMBER);
        }
        let Operator {
            mode,
            pendant,
            hold,
            ..
        } = self.operator;
        let on = if port == Port::PanelOut {
            match number {
                lamp::REMOTE => mode == OperatingMode::Auto && !pendant,
                lamp::CYCLE => self.executor.is_moving(),
                lamp::HELD => hold,
                lamp::FAULT => self.alarms.active() > 0,
                lamp::PENDANT => pendant,
                _ => false,
            }
        } else {
            match number {
                contact::FIRST => mode != OperatingMode::T2,
                contact::SECOND => mode == OperatingMode::Auto,
                _ => false,
            }
        };
        Ok(PortValue::Switch(on))
    }

    /// The alarm with this number, or the newest before it.
    pub(super) fn alarm_view(&self, newest: i32) -> Option<AlarmView> {
        let newest = u64::try_from(newest).ok()?;
        let alarm = self.alarms.iter().rev().find(|alarm| alarm.seq <= newest)?;
        let severity = match alarm.severity {
            Severity::Warn => 0,
            Severity::Pause => 2,
            Severity::Abort => 11,
        };
        let facility = karel::Status::facility_code(&alarm.facility).unwrap_or(24);
        Some(AlarmView {
            seq: i32::try_from(alarm.seq).unwrap_or(i32::MAX),
            code: facility * 1000 + i32::try_from(alarm.number % 1000).unwrap_or(0),
            message: alarm.headline(),
            severity,
            program: alarm.program.clone().unwrap_or_default(),
        })
    }
}
