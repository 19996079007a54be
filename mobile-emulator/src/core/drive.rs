//! Driving: along routes, before obstacles, and never into a zone without a permit.

use std::time::Duration;

use api::{MobileErrorLevel, OperatingMode};
use mobile_base::{Leg, Obstacle, PlanarPose, Point};
use units::Millimeters;

use super::{Core, Drive};
use crate::fault::Fault;
use crate::fault_book::Used;
use crate::floor::{Zone, body_of};
use crate::ledger::{DriveEnd, LedgerEvent, Purpose, Violation};
use crate::motion::{Manner, Stepped};

/// Wheels that turn for so long without moving the robot are noticed.
const STUCK_AFTER: Duration = Duration::from_secs(5);

impl Core {
    /// Sets out along legs.
    pub(super) fn set_out(
        &mut self,
        legs: Vec<Leg>,
        to: PlanarPose,
        purpose: Purpose,
        manner: Manner,
    ) -> Result<(), String> {
        self.end_drive(DriveEnd::GivenUp);
        self.motion
            .start(legs, manner)
            .map_err(|error| error.to_string())?;
        self.drive = Some(Drive {
            purpose,
            from_mm: self.motion.odometer_mm(),
            stands: None,
        });
        self.stuck_since = None;
        let late = self.faults.use_first(|fault| {
            if let Fault::Late { delay_s } = fault {
                Some((*delay_s, Used::Up))
            } else {
                None
            }
        });
        if let Some(late) = late {
            self.be_late(late);
        }
        self.note(LedgerEvent::DriveStarted {
            purpose,
            to: body_of(to),
        });
        Ok(())
    }

    /// Stands on the drive for a while.
    pub(super) fn be_late(&mut self, seconds: f64) {
        let delay = Duration::try_from_secs_f64(seconds).unwrap_or_default();
        self.late_until = Some(self.now.saturating_add(delay));
    }

    /// Ends the drive under way, if there is one.
    pub(super) fn end_drive(&mut self, reason: DriveEnd) {
        if let Some(drive) = self.drive.take() {
            if reason != DriveEnd::Arrived {
                self.motion.give_up();
            }
            self.late_until = None;
            let driven_mm = self.motion.odometer_mm() - drive.from_mm;
            self.note(LedgerEvent::DriveEnded {
                purpose: drive.purpose,
                driven_mm,
                reason,
            });
        }
    }

    /// Whether it means to move at this moment.
    pub(super) fn driving(&self) -> bool {
        self.motion.has_route() && self.drive.is_some_and(|drive| drive.stands.is_none())
    }

    /// Why it stands although it has somewhere to go.
    pub(super) fn stands(&self) -> Option<DriveEnd> {
        self.drive.and_then(|drive| drive.stands)
    }

    pub(super) fn step_drive(&mut self, step: Duration) {
        if !self.motion.has_route() {
            self.motion.rest();
            return;
        }
        if let Some(reason) = self.held_back() {
            self.motion.rest();
            self.stand(Some(reason));
            return;
        }
        if self
            .faults
            .any(|fault| matches!(fault, Fault::Stuck { .. }))
        {
            self.motion.rest();
            self.stand(None);
            self.notice_stuck();
            return;
        }
        if self.stuck_since.take().is_some() {
            self.clear_error("STUCK");
        }
        let before = self.motion.odometer_mm();
        let stepped = self.motion.step(step);
        let way_mm = self.motion.odometer_mm() - before;
        self.drain(way_mm / 1e6 * self.plan.battery.drain_percent_per_km);
        self.watch_wheels();
        self.slide();
        self.watch_zones();
        let zones_from = self.plan.obstacles.len() + self.fault_obstacles().len();
        match stepped.end(zones_from) {
            Some(DriveEnd::Arrived) => {
                self.end_drive(DriveEnd::Arrived);
                self.arrived();
            }
            other => self.stand(other),
        }
        if stepped == Stepped::OffPath {
            self.raise(
                MobileErrorLevel::Fatal,
                "OFF_PATH",
                "too far from the path to go on",
            );
        }
    }

    /// Why it must stand, whatever the route says.
    fn held_back(&self) -> Option<DriveEnd> {
        let by_mode = match self.mode {
            OperatingMode::Automatic | OperatingMode::Semiautomatic => false,
            OperatingMode::Intervened | OperatingMode::Manual | OperatingMode::Service => true,
        };
        let late = self.late_until.is_some_and(|until| self.now < until);
        if by_mode || self.paused || late {
            return Some(DriveEnd::Paused);
        }
        let lost = self
            .faults
            .any(|fault| matches!(fault, Fault::Unlocalized { .. }));
        (lost || self.charge <= self.plan.battery.empty_percent).then_some(DriveEnd::Disabled)
    }

    fn stand(&mut self, reason: Option<DriveEnd>) {
        let Some(mut drive) = self.drive else {
            return;
        };
        if drive.stands == reason {
            return;
        }
        drive.stands = reason;
        self.drive = Some(drive);
        let purpose = drive.purpose;
        let event = match reason {
            Some(reason) => LedgerEvent::DriveEnded {
                purpose,
                driven_mm: self.motion.odometer_mm() - drive.from_mm,
                reason,
            },
            None => LedgerEvent::DriveResumed { purpose },
        };
        self.note(event);
    }

    fn notice_stuck(&mut self) {
        let since = *self.stuck_since.get_or_insert(self.now);
        if self.now.saturating_sub(since) >= STUCK_AFTER {
            let description = format!(
                "the wheels turn, and the robot has not moved for {} s",
                STUCK_AFTER.as_secs()
            );
            self.raise(MobileErrorLevel::Fatal, "STUCK", &description);
        }
    }

    fn watch_wheels(&mut self) {
        let limit = self.plan.base.dimensions().max_wheel_speed.0;
        for speed in self.motion.wheels() {
            let speed = speed.0.abs();
            self.fastest_wheel = self.fastest_wheel.max(speed);
            if speed > limit {
                let detail = format!("{speed} rad/s; the limit is {limit} rad/s");
                self.catch("wheel", Violation::WheelTooFast, detail);
            }
        }
    }

    /// The zones it knows, by the point's name, and whether it may move in them.
    pub(super) fn zones(&self) -> Vec<(String, Zone, bool)> {
        let mission = self.mission.as_ref().filter(|mission| !mission.clear_told);
        let mut zones = Vec::new();
        if let Some(mission) = mission {
            let name = mission.order.goal.clone();
            zones.push((name, mission.zone.clone(), mission.permit));
        }
        for (name, zone) in &self.known_zones {
            if mission.is_some_and(|mission| mission.order.goal == *name) {
                continue;
            }
            // Points may share a zone, and then they share the permit.
            let same = mission.filter(|mission| mission.zone.area == zone.area);
            let free = same.is_some_and(|mission| mission.permit);
            zones.push((name.clone(), zone.clone(), free));
        }
        zones
    }

    fn fault_obstacles(&self) -> Vec<Obstacle> {
        let each = self.faults.iter().filter_map(|fault| {
            if let Fault::Obstacle {
                x_mm,
                y_mm,
                radius_mm,
                ..
            } = fault
            {
                Point::try_new(Millimeters(*x_mm), Millimeters(*y_mm))
                    .and_then(|center| Obstacle::disc(center, Millimeters(*radius_mm)))
                    .ok()
            } else {
                None
            }
        });
        each.collect()
    }

    /// Whatever the body must not touch: what stands around, and zones without a permit.
    pub(super) fn refresh_obstacles(&mut self) {
        let mut obstacles = self.plan.obstacles.clone();
        obstacles.extend(self.fault_obstacles());
        let heedless = self
            .faults
            .any(|fault| matches!(fault, Fault::IgnoresPermit { .. }))
            || self.mission.as_ref().is_some_and(|mission| mission.runaway);
        if !heedless {
            let closed = self.zones().into_iter().filter(|(_, _, free)| !free);
            obstacles.extend(closed.map(|(_, zone, _)| zone.outline().clone()));
        }
        self.motion.set_obstacles(obstacles);
    }

    /// Records which zones it touches, by where it truly is, and whether it may move there.
    pub(super) fn watch_zones(&mut self) {
        let pose = self.motion.pose();
        let moved = self.motion.moved();
        let zones = self.zones();
        let mut caught = None;
        for (name, zone, free) in &zones {
            let touches = zone.clearance(&self.plan.footprint, pose).0 <= 0.0;
            let event = match (touches, self.touching.contains(name)) {
                (true, false) => {
                    let _new = self.touching.insert(name.clone());
                    LedgerEvent::ZoneEntered {
                        point: name.clone(),
                    }
                }
                (false, true) => {
                    let _old = self.touching.remove(name);
                    LedgerEvent::ZoneLeft {
                        point: name.clone(),
                    }
                }
                (true, true) | (false, false) => {
                    if touches && moved && !free {
                        caught = Some(name.clone());
                    }
                    continue;
                }
            };
            if touches && moved && !free {
                caught = Some(name.clone());
            }
            self.note(event);
        }
        // Zones that are known no more are touched no more.
        self.touching
            .retain(|name| zones.iter().any(|(known, ..)| known == name));
        match caught {
            Some(name) => self.catch(
                "zone",
                Violation::MovedInZoneWithoutPermit,
                format!("in the zone of {name}"),
            ),
            None => {
                let _gone = self.caught.remove("zone");
            }
        }
    }
}
