//! Faults in the controller, and when they end.

use std::time::Duration;

use karel::{Host, Position, SysPath, SysValue, TaskId, Value};

use super::{CmosMemory, Controller};
use crate::effects::{Effect, Event, Tag};
use crate::faults::{FaultBody, FaultError, FaultKind, FaultView, MAX_FAULTS, Memory, Passed};
use crate::ledger::seconds;

/// The faults that are active.
#[derive(Debug, Default)]
pub(super) struct Faults {
    active: Vec<Active>,
    last: u64,
    /// No task runs.
    pub(super) frozen: bool,
}

#[derive(Debug)]
struct Active {
    id: u64,
    body: FaultBody,
    until: Option<Duration>,
    /// System variables as they were before.
    before: Vec<(SysPath, SysValue)>,
}

impl Faults {
    /// When a fault ends by itself.
    pub(super) fn next_end(&self) -> Option<Duration> {
        self.active.iter().filter_map(|fault| fault.until).min()
    }
}

impl Controller {
    /// Injects a fault; its number.
    ///
    /// # Errors
    /// What is wrong with it: item, value, limit. Nothing has changed then.
    pub fn inject(&mut self, body: FaultBody) -> Result<u64, FaultError> {
        body.check()?;
        self.drop_spent();
        if self.faults.active.len() >= MAX_FAULTS {
            return Err(FaultError::TooMany);
        }
        let fault = body.fault.name();
        if !body.fault.is_wire()
            && let Some(active) = self.faults.active.iter().find(|a| same(&a.body, &body))
        {
            let id = active.id;
            return Err(FaultError::Active { fault, id });
        }
        let id = self.faults.last + 1;
        let before = self.begin(id, &body)?;
        self.faults.last = id;
        tracing::warn!(controller = %self.hardware.name, fault = id, "The fault {fault} was injected.");
        let until = body.for_ms.map(Duration::from_millis);
        let until = until.map(|time| self.hardware.now.saturating_add(time));
        if !matches!(body.fault, FaultKind::Reset | FaultKind::PowerLoss { .. }) {
            self.faults.active.push(Active {
                id,
                body,
                until,
                before,
            });
        }
        self.deliver();
        self.follow_tasks();
        self.wake_tasks();
        Ok(id)
    }

    /// The faults that are active, oldest first.
    #[must_use]
    pub fn faults(&self) -> Vec<FaultView> {
        let active = self.faults.active.iter();
        let active = active.filter(|fault| !self.wire.is_spent(fault.id));
        let view = |fault: &Active| {
            let (struck, times_left) = self.wire.rule(fault.id).unwrap_or((1, None));
            FaultView {
                id: fault.id,
                fault: fault.body.fault.clone(),
                scope: fault.body.scope.clone(),
                times_left,
                until_s: fault.until.map(seconds),
                struck,
            }
        };
        active.map(view).collect()
    }

    /// How many faults are active.
    pub(super) fn fault_count(&self) -> usize {
        let active = self.faults.active.iter();
        active.filter(|fault| !self.wire.is_spent(fault.id)).count()
    }

    /// Ends a fault, as if its time were over.
    ///
    /// # Errors
    /// There is none of this number.
    pub fn clear_fault(&mut self, id: u64) -> Result<(), FaultError> {
        let found = self.faults.active.iter().position(|fault| fault.id == id);
        let index = found.ok_or(FaultError::NoSuchFault { id })?;
        let fault = self.faults.active.remove(index);
        self.end(&fault);
        self.deliver();
        Ok(())
    }

    /// Ends every fault; how many there were.
    pub fn clear_faults(&mut self) -> usize {
        let faults = std::mem::take(&mut self.faults.active);
        for fault in &faults {
            self.end(fault);
        }
        self.deliver();
        faults.len()
    }

    fn begin(&mut self, id: u64, body: &FaultBody) -> Result<Vec<(SysPath, SysValue)>, FaultError> {
        let mut before = Vec::new();
        match &body.fault {
            FaultKind::Drop
            | FaultKind::Delay { .. }
            | FaultKind::Split { .. }
            | FaultKind::Truncate { .. }
            | FaultKind::Corrupt { .. }
            | FaultKind::Stall
            | FaultKind::HalfOpen
            | FaultKind::Reset => {
                let kind = body.fault.clone();
                let reset = self.wire.add(id, kind, body.scope.clone(), body.times);
                for connection in reset {
                    self.hardware.socket_event(Event::PeerLost { connection });
                    let mut passed = Passed::default();
                    let reset = Effect::Reset { connection };
                    self.wire.outgoing(self.hardware.now, reset, &mut passed);
                    self.released.append(&mut passed.effects);
                }
            }
            FaultKind::Freeze => {
                self.faults.frozen = true;
                self.hardware.hold_arm(false);
            }
            FaultKind::WedgeTag { tag } => {
                if let Some(tag) = Tag::parse(tag) {
                    self.hardware.wedge(tag, true);
                }
            }
            FaultKind::PowerLoss { memory, off_ms } => {
                let memory = match memory {
                    Memory::Kept => CmosMemory::Kept,
                    Memory::Lost => CmosMemory::Lost,
                };
                self.power_off(memory);
                if *off_ms == 0 {
                    self.power_on();
                } else {
                    let off = Duration::from_millis(*off_ms);
                    self.off_until = Some(self.hardware.now.saturating_add(off));
                }
            }
            FaultKind::ServoOff => self.set_servo_power(false),
            FaultKind::WrongToolFrame { tool, frame } => {
                before = self.change_tool(*tool, <[f64; 6]>::from(*frame))?;
            }
            FaultKind::OptionMissing { option } => {
                let _new = self.hardware.missing.insert(*option);
                self.power_cycle(CmosMemory::Kept);
            }
            FaultKind::SlowOverride { percent } => {
                self.hardware.override_limit = Some(*percent);
                self.hardware.follow_override();
            }
        }
        Ok(before)
    }

    fn end(&mut self, fault: &Active) {
        let name = fault.body.fault.name();
        tracing::warn!(controller = %self.hardware.name, fault = fault.id, "The fault {name} is over.");
        self.wire.remove(fault.id);
        match &fault.body.fault {
            FaultKind::Freeze => {
                self.faults.frozen = false;
                if !self.hardware.operator.hold && self.hardware.may_move().is_ok() {
                    self.hardware.resume_arm();
                }
            }
            FaultKind::WedgeTag { tag } => {
                if let Some(tag) = Tag::parse(tag) {
                    self.hardware.wedge(tag, false);
                }
            }
            FaultKind::ServoOff => self.set_servo_power(true),
            FaultKind::WrongToolFrame { .. } => {
                for (path, value) in &fault.before {
                    // It was there before.
                    let _set = self
                        .hardware
                        .set_system_variable(TaskId(0), path, value.clone());
                }
            }
            FaultKind::OptionMissing { option } => {
                let _was_missing = self.hardware.missing.remove(option);
                self.power_cycle(CmosMemory::Kept);
            }
            FaultKind::SlowOverride { .. } => {
                self.hardware.override_limit = None;
                self.hardware.follow_override();
            }
            FaultKind::Drop
            | FaultKind::Delay { .. }
            | FaultKind::Split { .. }
            | FaultKind::Truncate { .. }
            | FaultKind::Corrupt { .. }
            | FaultKind::Stall
            | FaultKind::HalfOpen
            | FaultKind::Reset
            | FaultKind::PowerLoss { .. } => {}
        }
    }

    /// Sets `$UTOOL` and the tool of the pendant's menu; what they were before.
    fn change_tool(
        &mut self,
        tool: Option<i32>,
        frame: [f64; 6],
    ) -> Result<Vec<(SysPath, SysValue)>, FaultError> {
        if let Some(wrong) = frame
            .iter()
            .find(|value| value.abs() > 1e6 || value.is_nan())
        {
            let reason = format!("{wrong} is no length or angle, the limit is 1000000");
            return Err(FaultError::Frame { reason });
        }
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a REAL of KAREL has 32 bits"
        )]
        let [x, y, z, w, p, r] = frame.map(|value| value as f32);
        let frame = Position {
            x,
            y,
            z,
            w,
            p,
            r,
            ..Position::default()
        };
        let selected = self.hardware.variables.integer("$MNUTOOLNUM[1]");
        let number = tool.unwrap_or_else(|| selected.unwrap_or(0));
        let mut paths = vec![SysPath::from_name("$UTOOL")];
        if number != 0 {
            paths.push(SysPath::from_name("$MNUTOOL").index(&[1, number]));
        }
        let mut before = Vec::new();
        for path in &paths {
            let value = match self.hardware.system_variable(TaskId(0), path) {
                Ok(value) => SysValue::Value(value),
                Err(karel::Status::INTP_UNINIT) => SysValue::Uninit,
                Err(status) => {
                    let reason = format!("{path} cannot be read ({status})");
                    return Err(FaultError::Frame { reason });
                }
            };
            before.push((path.clone(), value));
        }
        for path in &paths {
            let value = SysValue::Value(Value::Position(frame));
            // It can be read and is no live one.
            let _set = self.hardware.set_system_variable(TaskId(0), path, value);
        }
        Ok(before)
    }

    /// Faults whose time has come end.
    pub(super) fn end_faults(&mut self) {
        let now = self.hardware.now;
        if self.off_until.is_some_and(|on| on <= now) {
            self.power_on();
        }
        let due = |fault: &Active| fault.until.is_some_and(|until| until <= now);
        while let Some(index) = self.faults.active.iter().position(due) {
            let fault = self.faults.active.remove(index);
            self.end(&fault);
        }
        self.drop_spent();
    }

    /// A power cycle cures wedged tags.
    pub(super) fn end_wedges(&mut self) {
        let wedged = |fault: &Active| matches!(fault.body.fault, FaultKind::WedgeTag { .. });
        self.faults.active.retain(|fault| !wedged(fault));
    }

    /// What the wire has held and is due passes.
    pub(super) fn deliver(&mut self) {
        let mut passed = Passed::default();
        self.wire.release(self.hardware.now, &mut passed);
        self.released.append(&mut passed.effects);
        self.take_passed(passed);
    }

    /// Events that passed the wire reach the controller.
    pub(super) fn take_passed(&mut self, passed: Passed) {
        self.released.extend(passed.effects);
        for event in passed.events {
            self.hardware.socket_event(event);
        }
        self.wake_tasks();
    }

    fn drop_spent(&mut self) {
        let spent = |fault: &Active| self.wire.is_spent(fault.id);
        let spent: Vec<u64> = self
            .faults
            .active
            .iter()
            .filter(|f| spent(f))
            .map(|f| f.id)
            .collect();
        for id in spent {
            self.faults.active.retain(|fault| fault.id != id);
            self.wire.remove(id);
        }
    }
}

/// Whether two faults of the controller are one: a tag each, an option each.
fn same(a: &FaultBody, b: &FaultBody) -> bool {
    match (&a.fault, &b.fault) {
        (FaultKind::WedgeTag { tag: a }, FaultKind::WedgeTag { tag: b }) => {
            Tag::parse(a) == Tag::parse(b)
        }
        (FaultKind::OptionMissing { option: a }, FaultKind::OptionMissing { option: b }) => a == b,
        (a, b) => a.name() == b.name(),
    }
}
