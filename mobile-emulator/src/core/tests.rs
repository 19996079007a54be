//! The core on its own: thousands of histories that no test could wait for over HTTP.
#![expect(
    clippy::wildcard_enum_match_arm,
    reason = "a test looks for the events it is about"
)]

use std::time::Duration;

use api::{
    FloorAreaBody, FloorPoseBody, MobileMessage, OutboxMessage, RoutePointBody, SignalName,
    TransportOrderBody,
};
use jiff::Timestamp;
use proptest::prelude::*;
use uuid::Uuid;

use super::{Advance, Core};
use crate::config::{MobileConfig, RouteShape};
use crate::fault::{Fault, SlipMoment};
use crate::floor::Zone;
use crate::ledger::{LedgerEvent, Violation};
use crate::mission::Phase;
use crate::outbound::SendOutcome;

/// Something that happens to a robot.
#[derive(Clone, Debug)]
enum Doing {
    Wait(u16),
    Message(bool, u8),
    Order(u8, u8),
    Fault(u8),
    Load(bool, bool),
}

fn doing() -> impl Strategy<Value = Doing> {
    prop_oneof![
        6 => (1_u16..800).prop_map(Doing::Wait),
        6 => (prop::bool::weighted(0.9), 0_u8..11).prop_map(|(mine, kind)| Doing::Message(mine, kind)),
        3 => (0_u8..3, 0_u8..3).prop_map(|(id, update)| Doing::Order(id, update)),
        1 => (0_u8..12).prop_map(Doing::Fault),
        1 => (any::<bool>(), any::<bool>()).prop_map(|(put, first)| Doing::Load(put, first)),
    ]
}

fn config(shape: RouteShape) -> MobileConfig {
    let mut config = MobileConfig::new("mr1")
        .with_slot("a", Some("box-1"))
        .with_slot("b", None);
    config.step_ms = 20;
    config.drive.route = shape;
    config
}

fn zone() -> FloorAreaBody {
    FloorAreaBody {
        min_x_mm: 2000.0,
        min_y_mm: 0.0,
        max_x_mm: 4000.0,
        max_y_mm: 2000.0,
    }
}

fn order(id: u8, update: u8) -> TransportOrderBody {
    let place = |x_mm, y_mm| RoutePointBody {
        x_mm,
        y_mm,
        heading_deg: None,
    };
    TransportOrderBody {
        order: Uuid::from_u128(u128::from(id) + 1),
        update: u32::from(update),
        goal: "s1/p1".to_owned(),
        dock: FloorPoseBody {
            x_mm: 3000.0,
            y_mm: 1000.0,
            heading_deg: 90.0,
        },
        dock_tolerance: None,
        zone: Some(zone()),
        route: vec![place(600.0, 200.0), place(1200.0, 900.0)],
        then_to: (id == 1).then(|| "out/o1".to_owned()),
        then_pose: (id == 1).then_some(FloorPoseBody {
            x_mm: -1500.0,
            y_mm: -500.0,
            heading_deg: 0.0,
        }),
        then_route: Vec::new(),
        unload: None,
    }
}

/// The core, a cell that takes every signal, and what the cell has said about the permit.
struct World {
    core: Core,
    n: u64,
    taken: Vec<api::SignalBody>,
}

impl World {
    fn new(config: &MobileConfig) -> Self {
        Self {
            core: Core::try_new(config, Timestamp::UNIX_EPOCH, 1).unwrap(),
            n: 0,
            taken: Vec::new(),
        }
    }

    fn session(mine: bool) -> Uuid {
        Uuid::from_u128(if mine { 7 } else { 8 })
    }

    fn message(&mut self, session: Uuid, message: MobileMessage) {
        self.n += 1;
        self.core.message(OutboxMessage {
            n: self.n,
            at: Timestamp::UNIX_EPOCH,
            session: Some(session),
            message,
        });
    }

    fn advance(&mut self, by: Duration) {
        let target = self.core.now() + by;
        while self.core.advance(target) == Advance::Sending {
            for sending in self.core.take_sends() {
                let answer = "accepted".to_owned();
                let outcome = SendOutcome::Answered {
                    status: 200,
                    answer,
                };
                self.core.outcome(&sending.signal, outcome);
                self.taken.push(sending.signal);
            }
        }
    }

    /// Steps one by one, and judges each from outside: where the robot is, and what it may.
    fn watched(&mut self, steps: u16) {
        let area = Zone::try_new(zone()).unwrap();
        for _ in 0..steps {
            let before = self.core.motion.pose();
            let may = self
                .core
                .mission
                .as_ref()
                .is_some_and(|mission| mission.permit && !mission.clear_told);
            let known = !self.core.known_zones.is_empty();
            self.advance(self.core.plan.step);
            let after = self.core.motion.pose();
            let touches = area.clearance(&self.core.plan.footprint, after).0 <= 0.0;
            assert!(
                !(known && touches && before != after && !may),
                "it moved in the zone without a permit, at {after:?}: {:#?}",
                self.core.state()
            );
            let limit = self.core.plan.base.dimensions().max_wheel_speed.0;
            for wheel in self.core.motion.wheels() {
                assert!(wheel.0.abs() <= limit, "{wheel} of {limit}");
            }
        }
    }

    fn act(&mut self, doing: &Doing) {
        match doing {
            Doing::Wait(steps) => self.watched(*steps),
            Doing::Order(id, update) => {
                let order = MobileMessage::TransportOrder(Box::new(order(*id, *update)));
                self.message(Self::session(true), order);
            }
            Doing::Message(mine, kind) => {
                let message = match kind {
                    0 | 1 => MobileMessage::MovePermit { granted: true },
                    2 => MobileMessage::MovePermit { granted: false },
                    3 | 4 => MobileMessage::ExitGranted,
                    5 => MobileMessage::StartPause,
                    6 => MobileMessage::StopPause,
                    7 => MobileMessage::Retry,
                    8 => MobileMessage::SkipRetry,
                    9 => MobileMessage::CellReady,
                    _ => MobileMessage::CancelOrder {
                        order: Uuid::from_u128(1),
                    },
                };
                self.message(Self::session(*mine), message);
            }
            Doing::Fault(kind) => {
                // Those that do not make it disobey.
                let for_s = Some(2.0);
                let fault = match kind {
                    0 => Fault::Late { delay_s: 2.0 },
                    1 => Fault::Stuck { for_s },
                    2 => Fault::DockFails { times: 1 },
                    3 => Fault::Slip {
                        forward_mm: 8.0,
                        left_mm: -4.0,
                        turn_deg: 1.0,
                        when: SlipMoment::Docking,
                        noticed: true,
                    },
                    4 => Fault::Lie {
                        x_mm: 700.0,
                        y_mm: 0.0,
                        heading_deg: 0.0,
                        for_s,
                    },
                    5 => Fault::Unlocalized { for_s },
                    6 => Fault::DoesNotLeave { for_s },
                    7 => Fault::HeartbeatStops { for_s },
                    8 => Fault::Crash { down_s: 1.0 },
                    9 => Fault::Mode {
                        mode: api::OperatingMode::Manual,
                    },
                    10 => Fault::Mode {
                        mode: api::OperatingMode::Automatic,
                    },
                    _ => Fault::Obstacle {
                        x_mm: 1600.0,
                        y_mm: 700.0,
                        radius_mm: 50.0,
                        for_s,
                    },
                };
                // Too many faults are refused, and that is fine here.
                let _id = self.core.set_fault(fault);
                if *kind == 8 {
                    // The cell sends what was not acknowledged again, under its old numbers.
                    self.n = 0;
                }
            }
            Doing::Load(put, first) => {
                let slot = if *first { "a" } else { "b" };
                // What does not fit is refused; the world stays whole.
                if *put {
                    let _full = self.core.put(slot, "box-1");
                } else {
                    let _empty = self.core.take(slot);
                }
            }
        }
        let loads = self.core.slots.list();
        let boxes = loads
            .iter()
            .filter(|slot| slot.load.as_deref() == Some("box-1"));
        assert!(boxes.count() <= 1, "a load is in two places: {loads:?}");
    }

    /// What an obedient cell sees, in the order of the hand-over.
    fn judge(&self) {
        let events = self.core.ledger_after(0);
        let caught = events.iter().find_map(|entry| match &entry.event {
            LedgerEvent::Violation { what, detail }
                if *what == Violation::MovedInZoneWithoutPermit
                    || *what == Violation::WheelTooFast =>
            {
                Some(format!("{what:?} at {} s: {detail}", entry.time_s))
            }
            _ => None,
        });
        assert_eq!(caught, None);
        let mut last = (0, 0);
        let mut ready_needs_docked = false;
        for signal in &self.taken {
            let number = (signal.boot, signal.seq);
            let next = (last.0, last.1 + 1);
            assert!(
                number == next || (number.0 > last.0 && number.1 == 1),
                "{number:?} follows {last:?}"
            );
            last = number;
            match signal.signal {
                SignalName::MrDocked => ready_needs_docked = true,
                SignalName::MrReady => {
                    assert!(ready_needs_docked, "ready without being docked");
                    ready_needs_docked = false;
                }
                _ => {}
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_schedule_makes_it_drive_in_the_zone_without_a_permit(doings in prop::collection::vec(doing(), 1..25)) {
        let mut world = World::new(&config(RouteShape::Waypoints));
        for doing in &doings {
            world.act(doing);
        }
        world.judge();
    }

    #[test]
    fn nor_does_any_on_smooth_paths(doings in prop::collection::vec(doing(), 1..25)) {
        let mut world = World::new(&config(RouteShape::Spline));
        // Most of these begin with what makes it drive.
        world.act(&Doing::Order(0, 0));
        for doing in &doings {
            world.act(doing);
        }
        world.judge();
    }
}

#[test]
fn a_permit_that_is_taken_back_stops_it_in_the_zone_at_once() {
    let mut world = World::new(&config(RouteShape::Waypoints));
    world.act(&Doing::Order(0, 0));
    world.act(&Doing::Message(true, 0));
    while world.core.touching.is_empty() {
        world.watched(1);
    }
    world.act(&Doing::Message(true, 2));
    let before = world.core.motion.pose();
    world.watched(500);
    assert_eq!(world.core.motion.pose(), before);
    world.act(&Doing::Message(true, 0));
    world.watched(2000);
    assert_eq!(world.core.state().phase, Some(Phase::Docked));
    world.judge();
}

#[test]
fn a_message_of_another_session_moves_nothing() {
    let mut world = World::new(&config(RouteShape::Waypoints));
    world.act(&Doing::Order(0, 0));
    world.act(&Doing::Message(false, 0));
    world.watched(3000);
    assert_eq!(world.core.state().phase, Some(Phase::Approach));
    assert!(world.core.touching.is_empty());
}

#[test]
fn an_hour_of_standing_still_is_soon_over() {
    // Not a benchmark: a robot that is simulated for an hour must not make a test wait for a minute.
    let mut world = World::new(&config(RouteShape::Waypoints));
    world.advance(Duration::from_hours(1));
    assert_eq!(world.core.now(), Duration::from_hours(1));
    assert!(world.taken.len() >= 3600);
}
