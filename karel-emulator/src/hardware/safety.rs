//! Emergency stops in stages: the arm brakes, then the drives lose their power.

use karel::Status;
use serde::{Deserialize, Serialize};

use super::Hardware;
use super::operator::{OperatingMode, SRVO_EMERGENCY_STOP, SRVO_PENDANT};
use crate::motion::{Brake, Path};

/// What stops the arm for safety.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StopSource {
    /// The emergency stop button of the operator panel.
    Panel,
    /// That of the teach pendant.
    Pendant,
    /// An emergency stop somewhere else in the cell.
    External,
    /// The fence is open.
    Fence,
}

/// How an emergency stop stops the arm.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, utoipa::ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum StopCategory {
    /// 0: the drives lose their power at once, the brakes stop the arm.
    PowerOff,
    /// 1: the drives stop the arm, then they lose their power.
    #[default]
    Controlled,
}

/// Whether the drives have power.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Drives {
    #[default]
    On,
    /// Until the arm stands still.
    Stopping,
    /// Until a RESET.
    Off,
}

/// SRVO-002, SRVO-004 and SRVO-007.
///
/// ASSUMPTION: the numbers are from memory of error lists.
const SRVO_PENDANT_STOP: Status = Status::new(11, 2);
const SRVO_FENCE: Status = Status::new(11, 4);
const SRVO_EXTERNAL_STOP: Status = Status::new(11, 7);

/// Bits of `$MOR.$SAFETY_STAT`.
const BIT_DEADMAN: i32 = 4;
const BIT_PENDANT_ENABLED: i32 = 512;

/// The speed of the tool center point in T1, mm/s.
///
/// ASSUMPTION: `$SPEED` and percentages above it are traveled at it; no alarm is raised.
const REDUCED_SPEED: f64 = 250.0;

impl StopSource {
    /// Its bit in `$MOR.$SAFETY_STAT`.
    pub(crate) fn bit(self) -> i32 {
        match self {
            Self::Panel => 1,
            Self::Pendant => 2,
            Self::Fence => 8,
            Self::External => 64,
        }
    }

    /// The alarm that it raises.
    pub(crate) fn alarm(self) -> (Status, &'static str) {
        match self {
            Self::Panel => (SRVO_EMERGENCY_STOP, "Operator panel E-stop"),
            Self::Pendant => (SRVO_PENDANT_STOP, "Teach pendant E-stop"),
            Self::External => (SRVO_EXTERNAL_STOP, "External emergency stops"),
            Self::Fence => (SRVO_FENCE, "Fence open"),
        }
    }

    /// ASSUMPTION: an open fence is always a controlled stop, the buttons stop as the controller is set up.
    pub(crate) fn category(self, buttons: StopCategory) -> StopCategory {
        match self {
            Self::Fence => StopCategory::Controlled,
            Self::Panel | Self::Pendant | Self::External => buttons,
        }
    }
}

/// The alarm of an enabling switch that is released while the pendant is enabled.
pub(crate) fn deadman_alarm() -> (Status, &'static str) {
    (SRVO_PENDANT, "Deadman switch released")
}

impl Hardware {
    /// The first stage of a stop; the second one follows when the arm stands still.
    pub(crate) fn stop_for_safety(&mut self, category: StopCategory) {
        let (brake, drives) = match category {
            StopCategory::PowerOff => (Brake::PowerOff, Drives::Off),
            StopCategory::Controlled => (Brake::Controlled, Drives::Stopping),
        };
        if self.operator.drives != Drives::Off {
            self.operator.drives = drives;
        }
        self.executor.hold(self.now, false, brake);
        self.follow_motions();
    }

    /// The drives have lost their power: the brakes stop the arm.
    pub(crate) fn stop_without_power(&mut self) {
        self.executor.hold(self.now, false, Brake::PowerOff);
        self.follow_motions();
    }

    /// The drives lose their power as soon as the arm stands still.
    pub(super) fn follow_drives(&mut self) {
        if self.operator.drives == Drives::Stopping && !self.executor.is_moving() {
            self.operator.drives = Drives::Off;
            tracing::info!(controller = %self.name, "The arm stands still, the drives are off.");
        }
    }

    /// RESET: the drives get power, unless something still forbids it. Whether they have it.
    pub(super) fn power_drives(&mut self) -> bool {
        let free = self.operator.stops == 0 && !self.operator.servo_off;
        if free {
            self.operator.drives = Drives::On;
        }
        free
    }

    /// RESET: no alarm is active any more and the drives have power, unless something forbids it. Whether it was done.
    pub(crate) fn reset_alarms(&mut self) -> bool {
        let done = self.power_drives();
        if done {
            self.alarms.reset();
        }
        done
    }

    /// Whether the drives have power.
    pub(crate) fn drives_powered(&self) -> bool {
        self.operator.drives != Drives::Off && !self.operator.servo_off
    }

    /// `$MOR.$SAFETY_STAT`.
    pub(super) fn safety_status(&self) -> i32 {
        let mut status = self.operator.stops;
        if self.operator.pendant {
            status |= BIT_PENDANT_ENABLED;
            if !self.operator.deadman {
                status |= BIT_DEADMAN;
            }
        }
        status
    }

    /// The path, slow enough for the mode: in T1 the tool is not faster than 250 mm/s.
    pub(super) fn at_speed_of_mode(&self, path: Path, tool: &karel::Position) -> Path {
        if self.operator.mode != OperatingMode::T1 {
            return path;
        }
        let place = |joints: &kinematics::PendantJoints| {
            let tcp = self.planner.tcp_in_world(joints, tool);
            tcp.isometry().translation.vector.into()
        };
        let fastest = path.fastest(place);
        if fastest <= REDUCED_SPEED {
            return path;
        }
        path.slower(REDUCED_SPEED / fastest)
    }
}
