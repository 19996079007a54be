//! What an operator, a test or a broken part does to the controller from outside.

use karel::{Interruption, Status};
use kinematics::{LimitViolations, PendantJoints};
use serde::{Deserialize, Serialize};

use super::{Controller, Phase};
use crate::alarms::Severity;
use crate::hardware::operator::{OperatingMode, SRVO_NO_POWER, SRVO_PENDANT, SYST_MODE};
use crate::hardware::safety::StopSource;
use crate::hardware::wrist::KEYBOARD_BYTES;
use crate::ledger::JointsDeg;

/// An action at the controller that no program asks for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Operation {
    /// The mode switch. Leaving AUTO pauses what moves.
    SetMode(OperatingMode),
    /// The teach pendant's switch. Enabling it pauses what moves.
    SetPendant(bool),
    /// The emergency stop button: pressed, or released. After the release, a RESET is due.
    EmergencyStop(bool),
    /// Another emergency stop than that of the operator panel, or the fence: pressed or open, or not.
    SafetyStop {
        /// Which one.
        source: StopSource,
        /// Whether it stops.
        active: bool,
    },
    /// The enabling switch of the pendant: held, or released. In T1 and T2 programs move the arm while it is held.
    SetDeadman(bool),
    /// HOLD: tasks pause, the arm brakes on its path and waits, and so does whatever is started later.
    Hold,
    /// CYCLE START: what is paused goes on from where it is.
    CycleStart,
    /// An alarm that comes from nowhere in particular.
    RaiseAlarm {
        /// Four letters, such as `SRVO`.
        facility: String,
        /// The number within the facility, up to 999.
        number: u16,
        /// What is wrong.
        text: String,
        /// How much it stops.
        severity: Severity,
    },
    /// RESET: no alarm is active any more, unless the emergency stop is still pressed.
    Reset,
    /// The general override, 0 to 100 percent.
    SetOverride(i32),
    /// A person moves the arm there with the pendant, which takes no time here.
    Jog(JointsDeg),
    /// The servos get power, or lose it: the arm brakes then, and no motion starts.
    SetServoPower(bool),
    /// The STEP key: tasks pause after each line, and go on for one line with CYCLE START.
    SetSingleStep(bool),
    /// The gripper does not move any more, or can again.
    JamGripper(bool),
    /// The part falls out of the gripper.
    LosePart,
    /// Keys of the pendant's keyboard, one byte each: LF is ENTER, codes from 128 on are keys that are no characters.
    Type(String),
}

/// Why an [`Operation`] was refused; nothing has changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OperateError {
    /// CYCLE START while something forbids it.
    #[error("the tasks cannot go on: {reason}")]
    CannotStart {
        /// What forbids it.
        reason: String,
    },
    /// A facility that does not exist.
    #[error("there is no facility {facility:?}, such as SRVO or MOTN")]
    Facility {
        /// What was given.
        facility: String,
    },
    /// An alarm number above 999.
    #[error("the alarm number is {number}, the highest is 999")]
    AlarmNumber {
        /// What was given.
        number: u16,
    },
    /// An override that is no percentage.
    #[error("the override is {percent} %, it must be 0 to 100")]
    Override {
        /// What was given.
        percent: i32,
    },
    /// The arm may not be moved by hand now.
    #[error("the arm cannot be jogged: {reason}")]
    CannotJog {
        /// What forbids it.
        reason: String,
    },
    /// The arm may not be moved there.
    #[error("the arm cannot be jogged there: {violations}")]
    JogLimits {
        /// The joints that are outside.
        violations: LimitViolations,
    },
    /// The configuration has no gripper, or there is no part in it.
    #[error("there is no {what}")]
    Missing {
        /// `gripper` or `part in a gripper`.
        what: &'static str,
    },
    /// A character that no key has.
    #[error("the keyboard has no key for {character:?}")]
    Key {
        /// What was given.
        character: char,
    },
    /// More than programs have read.
    #[error("{limit} characters at most can wait for a program")]
    KeyboardFull {
        /// The limit.
        limit: usize,
    },
    /// The controller stopped.
    #[error(transparent)]
    Stopped(#[from] crate::error::ControllerStopped),
}

impl Controller {
    /// Does what an operator does.
    ///
    /// ASSUMPTION: leaving AUTO, enabling the pendant and the emergency stop pause every task that `%NOPAUSE` does not
    /// protect and brake the arm on its path as HOLD does; alarms of the severity "abort" end the tasks that
    /// `%NOABORT` does not protect.
    ///
    /// # Errors
    /// What is asked for is not possible now; nothing has changed.
    pub fn operate(&mut self, operation: Operation) -> Result<(), OperateError> {
        let done = self.carry_out(operation);
        self.follow_tasks();
        self.wake_tasks();
        done
    }

    fn carry_out(&mut self, operation: Operation) -> Result<(), OperateError> {
        match operation {
            Operation::SetMode(mode) => self.set_mode(mode),
            Operation::SetPendant(enabled) => self.set_pendant(enabled),
            Operation::EmergencyStop(pressed) => self.safety_stop(StopSource::Panel, pressed),
            Operation::SafetyStop { source, active } => self.safety_stop(source, active),
            Operation::SetDeadman(held) => self.set_deadman(held),
            Operation::Hold => {
                self.hardware.operator.hold = true;
                self.pause_tasks(Interruption::Command);
                self.hardware.hold_arm(true);
            }
            Operation::CycleStart => self.cycle_start()?,
            Operation::RaiseAlarm {
                facility,
                number,
                text,
                severity,
            } => self.raise_alarm(&facility, number, text, severity)?,
            Operation::Reset => self.reset(),
            Operation::SetOverride(percent) => {
                if !self.hardware.set_override(percent) {
                    return Err(OperateError::Override { percent });
                }
            }
            Operation::Jog(joints) => self.jog(joints)?,
            Operation::SetServoPower(on) => self.set_servo_power(on),
            Operation::SetSingleStep(on) => self.set_single_step(on),
            Operation::JamGripper(jammed) => {
                if !self.hardware.jam_gripper(jammed) {
                    return Err(OperateError::Missing { what: "gripper" });
                }
            }
            Operation::Type(text) => self.type_text(&text)?,
            Operation::LosePart => {
                if !self.hardware.lose_part() {
                    let what = "part in a gripper";
                    return Err(OperateError::Missing { what });
                }
            }
        }
        Ok(())
    }

    fn type_text(&mut self, text: &str) -> Result<(), OperateError> {
        let mut bytes = Vec::new();
        for character in text.chars() {
            let byte = u8::try_from(character);
            bytes.push(byte.map_err(|_| OperateError::Key { character })?);
        }
        if self.hardware.type_text(&bytes) {
            return Ok(());
        }
        let limit = KEYBOARD_BYTES;
        Err(OperateError::KeyboardFull { limit })
    }

    fn set_mode(&mut self, mode: OperatingMode) {
        if self.hardware.operator.mode == mode {
            return;
        }
        self.hardware.operator.mode = mode;
        let text = format!("Operation mode {mode} selected");
        self.hardware.post(SYST_MODE, text, Severity::Warn);
        if mode != OperatingMode::Auto {
            self.interrupt(Interruption::Error);
        }
    }

    fn set_pendant(&mut self, enabled: bool) {
        if self.hardware.operator.pendant == enabled {
            return;
        }
        self.hardware.operator.pendant = enabled;
        if enabled {
            let text = "The teach pendant was enabled".to_owned();
            self.hardware.post(SRVO_PENDANT, text, Severity::Warn);
            self.interrupt(Interruption::PendantEnabled);
        }
    }

    pub(super) fn set_servo_power(&mut self, on: bool) {
        let was_off = std::mem::replace(&mut self.hardware.operator.servo_off, !on);
        if !on && !was_off {
            let text = "Servo power off".to_owned();
            self.hardware.post(SRVO_NO_POWER, text, Severity::Pause);
            self.pause_tasks(Interruption::Error);
            self.hardware.stop_without_power();
        }
    }

    /// RESET: no alarm is active any more and the drives get power, unless the emergency stop is still pressed or the
    /// servos have no power.
    pub fn reset(&mut self) {
        let _done = self.hardware.reset_alarms();
    }

    fn raise_alarm(
        &mut self,
        facility: &str,
        number: u16,
        text: String,
        severity: Severity,
    ) -> Result<(), OperateError> {
        let code = Status::facility_code(facility).ok_or_else(|| OperateError::Facility {
            facility: facility.to_owned(),
        })?;
        if number > 999 {
            return Err(OperateError::AlarmNumber { number });
        }
        let status = Status::new(code, number.into());
        self.hardware.post(status, text, severity);
        match severity {
            Severity::Warn => {}
            Severity::Pause => self.interrupt(Interruption::Error),
            Severity::Abort => {
                for task in &mut self.tasks {
                    let protected = self
                        .machine
                        .root_program(task.id)
                        .is_some_and(|program| !program.is_abortable_by_error());
                    if protected || matches!(task.phase, Phase::Over) {
                        continue;
                    }
                    // Its condition handlers may refuse.
                    self.machine.request_abort(task.id, &mut self.hardware);
                    if self.machine.is_alive(task.id) {
                        continue;
                    }
                    self.hardware.release_ports(task.id);
                    task.phase = Phase::Over;
                    task.look = None;
                }
                let text = format!("{status} aborted the tasks");
                self.hardware.stop_arm(&text);
            }
        }
        Ok(())
    }

    pub(super) fn cycle_start(&mut self) -> Result<(), OperateError> {
        if let Some(reason) = self.hardware.start_obstacle() {
            return Err(OperateError::CannotStart { reason });
        }
        self.hardware.operator.hold = false;
        let ids: Vec<_> = self.machine.tasks().collect();
        for id in ids {
            if self.machine.resume(id) && self.single_step {
                self.step_one_line(id);
            }
        }
        self.hardware.resume_arm();
        Ok(())
    }

    fn jog(&mut self, joints: JointsDeg) -> Result<(), OperateError> {
        let cannot = |reason: &str| {
            Err(OperateError::CannotJog {
                reason: reason.to_owned(),
            })
        };
        if !self.hardware.operator.pendant {
            return cannot("the teach pendant is not enabled");
        }
        if self.hardware.operator.stops != 0 {
            return cannot("the emergency stop is pressed");
        }
        let joints = PendantJoints::try_from_degrees(joints.into());
        let joints = joints.map_err(|error| OperateError::CannotJog {
            reason: error.to_string(),
        })?;
        let model = self.hardware.planner.model();
        model
            .check_limits(&joints)
            .map_err(|violations| OperateError::JogLimits { violations })?;
        if !self.hardware.jog(joints) {
            return cannot("a program moves the arm, or has not finished");
        }
        Ok(())
    }

    /// Tasks pause and the arm brakes on its path.
    pub(super) fn interrupt(&mut self, by: Interruption) {
        self.pause_tasks(by);
        self.hardware.hold_arm(false);
    }

    pub(super) fn pause_tasks(&mut self, by: Interruption) {
        let ids: Vec<_> = self.machine.tasks().collect();
        for id in ids {
            let pausable = self.machine.root_program(id);
            if pausable.is_some_and(|program| program.is_pausable(by)) {
                let _was_alive = self.machine.pause(id);
            }
        }
    }
}
