//! Emergency stops, the fence and the enabling switch.

use karel::Interruption;

use super::Controller;
use crate::alarms::Severity;
use crate::hardware::safety::{StopCategory, StopSource, deadman_alarm};

impl Controller {
    /// An emergency stop is pressed or released. Pressed, it pauses the tasks and stops the arm in stages.
    pub(super) fn safety_stop(&mut self, source: StopSource, active: bool) {
        let operator = &mut self.hardware.operator;
        let before = operator.stops;
        if !active {
            operator.stops &= !source.bit();
            return;
        }
        operator.stops |= source.bit();
        if operator.stops != before {
            let (status, text) = source.alarm();
            self.hardware.post(status, text.to_owned(), Severity::Pause);
            self.pause_tasks(Interruption::Error);
            let category = source.category(self.stop_category);
            self.hardware.stop_for_safety(category);
        }
    }

    /// The enabling switch is held or released; released while the pendant is enabled, it stops the arm.
    ///
    /// ASSUMPTION: in the category of the emergency stop buttons.
    pub(super) fn set_deadman(&mut self, held: bool) {
        let operator = &mut self.hardware.operator;
        let before = std::mem::replace(&mut operator.deadman, held);
        if before && !held && operator.pendant {
            let (status, text) = deadman_alarm();
            self.hardware.post(status, text.to_owned(), Severity::Pause);
            self.pause_tasks(Interruption::Error);
            let category: StopCategory = self.stop_category;
            self.hardware.stop_for_safety(category);
        }
    }
}
