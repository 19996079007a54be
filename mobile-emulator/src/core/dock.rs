//! Docking, standing docked, and leaving: the phases of an order.

use api::{MobileErrorLevel, SignalName};
use units::{Degrees, Millimeters, Radians};

use super::Core;
use crate::fault::{Fault, SlipMoment};
use crate::fault_book::{Used, one_less};
use crate::floor::off;
use crate::ledger::{DriveEnd, LedgerEvent, OrderOutcome, Purpose, Violation};
use crate::mission::{Aborted, Mission, Phase, Slide};
use crate::motion::Manner;
use crate::route;

/// A share of the tolerance that docking aims at.
const DOCK_AIM: f64 = 0.2;

impl Core {
    /// The end of a route.
    pub(super) fn arrived(&mut self) {
        if self.mission.is_none()
            && let Some(point) = self.visits.take()
        {
            self.at_point = Some(point);
            self.signal(SignalName::MrArrived);
            return;
        }
        let Some(mission) = &mut self.mission else {
            return;
        };
        match mission.phase {
            Phase::Approach => mission.phase = Phase::AtEntry,
            Phase::Docking => self.judge_dock(),
            Phase::Leaving => {
                let clear = mission
                    .zone
                    .clearance(&self.plan.footprint, self.motion.believed())
                    .0
                    > 0.0;
                if clear {
                    self.tell_clear();
                }
                self.at_destination();
            }
            Phase::Delivering => self.at_destination(),
            Phase::AtEntry
            | Phase::DockFailed
            | Phase::Docked
            | Phase::Ready
            | Phase::Unloading => {}
        }
    }

    /// What needs no drive to come about.
    pub(super) fn step_phase(&mut self) {
        let Some(mission) = &self.mission else { return };
        match mission.phase {
            Phase::AtEntry if mission.permit => self.begin_docking(),
            Phase::Docked | Phase::Ready => self.step_docked(),
            Phase::Leaving => {
                let pose = self.motion.believed();
                let clearance = mission.zone.clearance(&self.plan.footprint, pose);
                if clearance >= self.plan.guard.resume_distance {
                    self.tell_clear();
                }
            }
            Phase::Unloading if mission.unloaded_at.is_some_and(|at| self.now >= at) => {
                self.unload();
            }
            Phase::Approach
            | Phase::AtEntry
            | Phase::Docking
            | Phase::DockFailed
            | Phase::Delivering
            | Phase::Unloading => {}
        }
    }

    fn begin_docking(&mut self) {
        let Some(mission) = &mut self.mission else {
            return;
        };
        let told = std::mem::replace(&mut mission.arrived_told, true);
        self.at_point = Some(mission.order.goal.clone());
        mission.phase = Phase::Docking;
        mission.marker_blind = false;
        mission.slide = None;
        let (dock, (tolerance_mm, _)) = (mission.dock, mission.tolerance);
        // The marker of the dock says where the robot is.
        self.motion.measure();
        if !told {
            self.signal(SignalName::MrArrived);
        }
        let here = self.motion.believed();
        let fails = self.faults.use_first(|fault| {
            if let Fault::DockFails { times } = fault {
                Some(((), one_less(times)))
            } else {
                None
            }
        });
        let target = if fails.is_some() {
            let half = here.displacement_to(dock);
            // Half the way: a marker that was lost, a wheel against an edge.
            let forward = Millimeters(0.5 * half.forward.0);
            let left = Millimeters(0.5 * half.left.0 + 2.0 * tolerance_mm);
            let turn = half.turn;
            here.moved_by(&mobile_base::Displacement {
                forward,
                left,
                turn,
            })
            .unwrap_or(here)
        } else {
            dock
        };
        let slip = self.faults.use_first(|fault| {
            if let Fault::Slip {
                forward_mm,
                left_mm,
                turn_deg,
                when: SlipMoment::Docking,
                noticed,
            } = fault
            {
                Some((((*forward_mm, *left_mm, *turn_deg), *noticed), Used::Up))
            } else {
                None
            }
        });
        if let (Some((forward_left_turn, noticed)), Some(mission)) = (slip, &mut self.mission) {
            let (way_mm, _) = off(here, target);
            mission.slide = Some(Slide {
                at_left_mm: 0.5 * way_mm,
                forward_left_turn,
                noticed,
            });
        }
        let aim = Millimeters((DOCK_AIM * tolerance_mm).max(0.05));
        let legs = vec![route::end(target, aim)];
        if let Err(reason) = self.set_out(legs, target, Purpose::Dock, Manner::Docking) {
            self.fail_dock(&reason);
        }
    }

    /// The slide that a fault put into this docking, when its moment has come.
    pub(super) fn slide(&mut self) {
        let left_mm = self.motion.left().0;
        let Some(mission) = &mut self.mission else {
            return;
        };
        if let Some(slide) = mission.slide
            && left_mm <= slide.at_left_mm
        {
            mission.slide = None;
            mission.marker_blind = !slide.noticed;
            self.slip(slide.forward_left_turn, slide.noticed);
        }
    }

    /// Slides at once.
    pub(super) fn slip(&mut self, (forward, left, turn): (f64, f64, f64), noticed: bool) {
        let slide = mobile_base::Displacement {
            forward: Millimeters(forward),
            left: Millimeters(left),
            turn: Radians::from(Degrees(turn)),
        };
        let Ok(truly) = self.motion.pose().moved_by(&slide) else {
            return;
        };
        let believed = if noticed {
            truly
        } else {
            self.motion.believed()
        };
        self.motion.place(truly, believed);
        self.note(LedgerEvent::Slipped { noticed });
        self.watch_zones();
    }

    /// At the end of docking: how far from the dock, by what it knows?
    fn judge_dock(&mut self) {
        let Some(mission) = &self.mission else { return };
        if !mission.marker_blind {
            self.motion.measure();
        }
        let (mm, deg) = off(self.motion.believed(), mission.dock);
        let (max_mm, max_deg) = mission.tolerance;
        if mm <= max_mm && deg <= max_deg {
            self.dock();
        } else {
            self.fail_dock(&format!(
                "{mm:.1} mm and {deg:.2} degrees from the dock; the tolerance is {max_mm} mm and {max_deg} degrees"
            ));
        }
    }

    fn dock(&mut self) {
        let Some(mission) = &mut self.mission else {
            return;
        };
        mission.phase = Phase::Docked;
        mission.exit = false;
        mission.docked_at = Some(self.now);
        let point = mission.order.goal.clone();
        let (off_mm, off_deg) = off(self.motion.pose(), mission.ordered_dock);
        let (max_mm, max_deg) = mission.tolerance;
        self.note(LedgerEvent::Docked {
            point,
            off_mm,
            off_deg,
        });
        self.clear_error("DOCKING_FAILED");
        self.signal(SignalName::MrDocked);
        if off_mm > max_mm || off_deg > max_deg {
            let _forget = self.caught.remove("dock");
            let detail = format!("{off_mm:.1} mm and {off_deg:.2} degrees from the ordered dock");
            self.catch("dock", Violation::ToldDockedOffDock, detail);
        }
    }

    fn fail_dock(&mut self, reason: &str) {
        let Some(mission) = &mut self.mission else {
            return;
        };
        mission.phase = Phase::DockFailed;
        let point = mission.order.goal.clone();
        let (off_mm, off_deg) = off(self.motion.pose(), mission.ordered_dock);
        self.note(LedgerEvent::DockFailed {
            point,
            off_mm,
            off_deg,
        });
        self.write_error(MobileErrorLevel::Warning, "DOCKING_FAILED", reason);
        self.signal(SignalName::MrDockFailed);
    }

    fn step_docked(&mut self) {
        let runs_off = self.docked_long_enough_to_run_off();
        let Some(mission) = &mut self.mission else {
            return;
        };
        if runs_off {
            mission.runaway = true;
            self.leave();
            return;
        }
        if mission.phase == Phase::Docked && !mission.permit && mission.aborted.is_none() {
            mission.phase = Phase::Ready;
            self.signal(SignalName::MrReady);
            return;
        }
        if mission.exit && mission.permit {
            let stays = |fault: &Fault| matches!(fault, Fault::DoesNotLeave { .. });
            if !self.faults.any(stays) {
                self.leave();
            }
        }
    }

    fn docked_long_enough_to_run_off(&mut self) -> bool {
        let docked_at = self.mission.as_ref().and_then(|mission| mission.docked_at);
        let Some(docked_at) = docked_at else {
            return false;
        };
        let long = self.now.saturating_sub(docked_at).as_secs_f64();
        let runs = self.faults.use_first(|fault| {
            if let Fault::DrivesOff { after_s } = fault
                && long >= *after_s
            {
                Some(((), Used::Up))
            } else {
                None
            }
        });
        runs.is_some()
    }

    /// Sets out of the zone.
    pub(super) fn leave(&mut self) {
        let Some(mission) = &mut self.mission else {
            return;
        };
        mission.phase = Phase::Leaving;
        mission.docked_at = None;
        let (places, to) = mission.way_out(&self.plan);
        self.at_point = None;
        self.refresh_obstacles();
        let legs = route::legs(&self.plan, self.motion.believed(), &places, to);
        let gone = legs.and_then(|legs| self.set_out(legs, to, Purpose::Leave, Manner::Driving));
        if let Err(reason) = gone {
            self.raise(MobileErrorLevel::Fatal, "NO_WAY_OUT", &reason);
        }
    }

    /// Out of the zone: its permit is used up.
    fn tell_clear(&mut self) {
        let Some(mission) = &mut self.mission else {
            return;
        };
        if mission.clear_told {
            return;
        }
        mission.phase = Phase::Delivering;
        mission.runaway = false;
        mission.permit = false;
        let ends = mission.aborted.is_some();
        self.signal(SignalName::MrClear);
        // ASSUMPTION: the hand-over ends here; what follows, `MR_DELIVERED`, is known by its order, not by a session.
        if let Some(mission) = &mut self.mission {
            mission.clear_told = true;
            mission.session = None;
        }
        if let Some(drive) = &mut self.drive
            && self
                .mission
                .as_ref()
                .is_some_and(|m| m.destination.is_some())
        {
            drive.purpose = Purpose::Deliver;
        }
        self.refresh_obstacles();
        if ends {
            self.end_drive(DriveEnd::GivenUp);
            self.end_aborted();
        }
    }

    /// Where the order ends.
    fn at_destination(&mut self) {
        let Some(mission) = &mut self.mission else {
            return;
        };
        if mission.aborted.is_some() {
            self.end_aborted();
            return;
        }
        let Some(destination) = &mission.destination else {
            self.end_order(OrderOutcome::Finished);
            return;
        };
        self.at_point = Some(destination.name.clone());
        match destination.unload {
            Some(time) => {
                mission.phase = Phase::Unloading;
                mission.unloaded_at = Some(self.now.saturating_add(time));
            }
            None => self.deliver(),
        }
    }

    fn unload(&mut self) {
        let ordered = self
            .mission
            .as_ref()
            .and_then(|mission| mission.order.unload.clone());
        let mut taken_off = Vec::new();
        for full in self.slots.list().iter().filter(|slot| slot.load.is_some()) {
            let wanted = ordered.as_ref().is_none_or(|ordered| {
                let mut ordered = ordered.iter();
                // An order that does not know the load means whatever lies in the slot.
                ordered.any(|one| {
                    one.slot == full.slot && (one.load.is_none() || one.load == full.load)
                })
            });
            if wanted {
                taken_off.push(full.slot.clone());
            }
        }
        for slot in taken_off {
            // The slot was full a moment ago.
            if let Ok(load) = self.slots.take(&slot) {
                self.note(LedgerEvent::LoadTaken { slot, load });
            }
        }
        self.signal(SignalName::LoadChanged);
        self.deliver();
    }

    fn deliver(&mut self) {
        self.signal(SignalName::MrDelivered);
        self.end_order(OrderOutcome::Finished);
    }

    fn end_aborted(&mut self) {
        let aborted = self.mission.as_ref().and_then(|mission| mission.aborted);
        self.end_order(match aborted {
            Some(Aborted::Cancelled) => OrderOutcome::Cancelled,
            Some(Aborted::Failed) => OrderOutcome::Failed,
            None => OrderOutcome::Finished,
        });
    }

    /// The order is over.
    pub(super) fn end_order(&mut self, outcome: OrderOutcome) {
        self.end_drive(DriveEnd::GivenUp);
        let Some(Mission { order, .. }) = self.mission.take() else {
            return;
        };
        let order = order.order;
        if outcome != OrderOutcome::Lost {
            self.remember(order);
        }
        self.clear_error("DOCKING_FAILED");
        self.note(LedgerEvent::OrderEnded { order, outcome });
        self.refresh_obstacles();
        self.next_heartbeat = self.now;
    }
}
