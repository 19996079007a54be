//! The deterministic core of a virtual mobile robot: events in, signals out, time in fixed steps.
//!
//! No I/O and no clock: the same configuration, events and steps give the same history.

mod dock;
mod drive;
mod snapshot;
mod talk;
mod tell;
mod trouble;
mod visit;

#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use api::{MobileErrorBody, OperatingMode};
use jiff::{SignedDuration, Timestamp};
use uuid::Uuid;

use crate::config::MobileConfig;
use crate::error::{ConfigError, Refusal};
use crate::fault_book::FaultBook;
use crate::floor::{Zone, body_of};
use crate::ledger::{DriveEnd, Ledger, LedgerEntry, LedgerEvent, Purpose, Violation};
use crate::mission::Mission;
use crate::motion::Motion;
use crate::outbound::{Outbound, Sending};
use crate::plan::Plan;
use crate::slots::Slots;

/// Orders that are remembered, so that a late copy is not driven again.
const KNOWN_ORDERS: usize = 256;

/// Zones that are remembered: those of a full map, and as many again.
const KNOWN_ZONES: usize = 2000;

/// How far a core came.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Advance {
    /// To the time it was given.
    Reached,
    /// To a moment at which a signal is to be sent.
    Sending,
}

/// See the module.
#[derive(Debug)]
pub(crate) struct Core {
    plan: Arc<Plan>,
    /// What the robot's clock said at its first start.
    epoch: Timestamp,
    now: Duration,
    boot: u64,
    motion: Motion,
    slots: Slots,
    faults: FaultBook,
    ledger: Ledger,
    outbound: Outbound,
    sends: VecDeque<Sending>,
    /// The last message that was taken.
    seen: u64,
    mission: Option<Mission>,
    /// The point it drives to by itself, without an order.
    visits: Option<String>,
    /// Orders that are over.
    known: VecDeque<Uuid>,
    mode: OperatingMode,
    paused: bool,
    charge: f64,
    errors: Vec<MobileErrorBody>,
    next_heartbeat: Duration,
    /// It has no power until then.
    down_until: Option<Duration>,
    /// It stands on its drive until then: a fault.
    late_until: Option<Duration>,
    stuck_since: Option<Duration>,
    drive: Option<Drive>,
    /// Where it stands, as it tells.
    at_point: Option<String>,
    /// Zones by their points: of its map, and those that orders told of. A zone stays closed when its order is over.
    known_zones: BTreeMap<String, Zone>,
    touching: BTreeSet<String>,
    /// A violation of these is recorded until the cause is gone.
    caught: BTreeSet<&'static str>,
    cell_away: bool,
    fastest_wheel: f64,
    /// For the floor plan.
    footprint_mm: [f64; 2],
    obstacle_circles: Vec<[f64; 3]>,
}

/// A drive under way.
#[derive(Clone, Copy, Debug)]
struct Drive {
    purpose: Purpose,
    from_mm: f64,
    /// Why it stands, if it does.
    stands: Option<DriveEnd>,
}

impl Core {
    pub(crate) fn try_new(
        config: &MobileConfig,
        epoch: Timestamp,
        boot: u64,
    ) -> Result<Self, ConfigError> {
        let plan = Arc::new(Plan::try_new(config)?);
        let motion =
            Motion::try_new(Arc::clone(&plan)).map_err(ConfigError::in_section("start"))?;
        let mut core = Self {
            slots: Slots::new(plan.slots.clone()),
            faults: FaultBook::default(),
            ledger: Ledger::default(),
            outbound: Outbound::new(boot, plan.backoff),
            sends: VecDeque::new(),
            seen: 0,
            mission: None,
            visits: None,
            known: VecDeque::new(),
            mode: config.mode,
            paused: false,
            charge: plan.battery.charge_percent,
            errors: Vec::new(),
            next_heartbeat: Duration::ZERO,
            down_until: None,
            late_until: None,
            stuck_since: None,
            drive: None,
            at_point: None,
            known_zones: plan.zones(),
            touching: BTreeSet::new(),
            caught: BTreeSet::new(),
            cell_away: false,
            fastest_wheel: 0.0,
            footprint_mm: [config.footprint.length_mm, config.footprint.width_mm],
            obstacle_circles: config
                .obstacles
                .iter()
                .map(|one| [one.x_mm, one.y_mm, one.radius_mm])
                .collect(),
            now: Duration::ZERO,
            epoch,
            boot,
            motion,
            plan,
        };
        core.note(LedgerEvent::Booted { boot });
        core.refresh_obstacles();
        core.watch_zones();
        for (number, fault) in config.faults.iter().enumerate() {
            let refuse = |error: Refusal| ConfigError::new(format!("faults[{number}]"), error);
            let _id = core.set_fault(fault.clone()).map_err(refuse)?;
        }
        Ok(core)
    }

    pub(crate) fn now(&self) -> Duration {
        self.now
    }

    /// The last message that was taken; nothing while it has no power.
    pub(crate) fn after(&self) -> Option<u64> {
        self.down_until.is_none().then_some(self.seen)
    }

    /// Steps up to `target`, or to the first moment at which a signal is to be sent.
    pub(crate) fn advance(&mut self, target: Duration) -> Advance {
        self.pump();
        loop {
            if !self.sends.is_empty() {
                return Advance::Sending;
            }
            let next = self.now.saturating_add(self.plan.step);
            if next > target {
                return Advance::Reached;
            }
            self.step(next);
        }
    }

    /// What is to be sent.
    pub(crate) fn take_sends(&mut self) -> Vec<Sending> {
        self.sends.drain(..).collect()
    }

    /// When it does something by itself. A driver may look later, and never needs to look sooner.
    pub(crate) fn next_wake(&self) -> Option<Duration> {
        let step = self.now.saturating_add(self.plan.step);
        if let Some(until) = self.down_until {
            return Some(until.max(step));
        }
        let busy = self.motion.has_route() || self.mission.is_some();
        if busy {
            return Some(step);
        }
        let heartbeat = (!self.heartbeat_stopped()).then_some(self.next_heartbeat);
        let wakes = [heartbeat, self.outbound.next_wake(), self.faults.next_end()];
        wakes.into_iter().flatten().min().map(|wake| wake.max(step))
    }

    pub(crate) fn ledger_after(&self, n: u64) -> Vec<LedgerEntry> {
        self.ledger.after(n)
    }

    pub(crate) fn ledger_dropped(&self) -> u64 {
        self.ledger.dropped()
    }

    fn step(&mut self, to: Duration) {
        let step = to.saturating_sub(self.now);
        self.now = to;
        if self.down() {
            return;
        }
        if self.faults.expire(to) {
            self.refresh_obstacles();
        }
        self.drain(step.as_secs_f64() / 3600.0 * self.plan.battery.drain_percent_per_h);
        self.step_phase();
        self.step_drive(step);
        self.step_phase();
        self.heartbeat();
        self.pump();
    }

    fn note(&mut self, event: LedgerEvent) {
        let pose = body_of(self.motion.pose());
        self.ledger.push(self.now, pose, event);
    }

    /// Records what must not be, once until `self.caught` forgets it.
    fn catch(&mut self, key: &'static str, what: Violation, detail: String) {
        if self.caught.insert(key) {
            self.note(LedgerEvent::Violation { what, detail });
        }
    }

    fn wall_time(&self) -> Timestamp {
        SignedDuration::try_from(self.now)
            .ok()
            .and_then(|passed| self.epoch.checked_add(passed).ok())
            .unwrap_or(Timestamp::MAX)
    }
}
