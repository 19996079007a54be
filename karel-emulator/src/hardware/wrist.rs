//! Hands at the wrist, and the keyboard of the pendant: what programs reach with HAND and READ.

use karel::{FileId, HandAction, Port, PortValue, Status, TaskId};

use super::{Hardware, Wake};

/// Most characters that wait for a program.
pub(crate) const KEYBOARD_BYTES: usize = 4096;

impl Hardware {
    /// `OPEN HAND n` and its sisters.
    ///
    /// ASSUMPTION: hand n has the valves `RDO[2n-1]` to open and `RDO[2n]` to close it, and the switches `RDI[2n-1]`
    /// (open) and `RDI[2n]` (closed), which follow at once. RELAX lets both valves off, and the hand stays where it
    /// is. What hands hold is not simulated; a gripper is an output of the configuration.
    pub(super) fn move_hand(
        &mut self,
        task: TaskId,
        action: HandAction,
        number: i32,
    ) -> Result<(), Status> {
        let close = number.checked_mul(2).filter(|_| number > 0);
        let close = close.ok_or(Status::PRIO_PORT_NUMBER)?;
        let open = close - 1;
        let (opens, closes) = match action {
            HandAction::Open => (true, false),
            HandAction::Close => (false, true),
            HandAction::Relax => (false, false),
        };
        // Both exist, or nothing happens.
        let _both = (
            self.ports.get(Port::RobotOut, open)?,
            self.ports.get(Port::RobotOut, close)?,
        );
        let switch = PortValue::Switch;
        // One valve at a time has air.
        for (number, on) in [(open, opens), (close, closes)] {
            let _changed = self.ports.set(Port::RobotOut, number, switch(on))?;
        }
        if action != HandAction::Relax {
            for (number, on) in [(open, opens), (close, closes)] {
                let _changed = self.ports.set(Port::RobotIn, number, switch(on))?;
            }
        }
        tracing::info!(
            controller = %self.name, task = task.0,
            "A program does {action:?} with hand {number}.",
        );
        Ok(())
    }

    /// An operator types. `false` if there is no room for it; nothing is typed then.
    pub(crate) fn type_text(&mut self, bytes: &[u8]) -> bool {
        if self.keyboard.len() + bytes.len() > KEYBOARD_BYTES {
            return false;
        }
        self.keyboard.extend_from_slice(bytes);
        self.wakes.push(Wake::Readable(FileId::KEYBOARD));
        true
    }
}
