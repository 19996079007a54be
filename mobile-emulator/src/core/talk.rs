//! What the cell tells the robot.

use api::{
    MobileErrorBody, MobileErrorLevel, MobileMessage, OperatingMode, OutboxMessage, SignalName,
    TransportOrderBody,
};
use uuid::Uuid;

use super::tell::shortened;
use super::{Core, KNOWN_ORDERS, KNOWN_ZONES};
use crate::error::Refusal;
use crate::fault::Fault;
use crate::fault_book::one_less;
use crate::ledger::{LedgerEvent, OrderOutcome, Purpose};
use crate::mission::{Aborted, Mission, Phase};
use crate::motion::Manner;
use crate::route;

impl Core {
    /// A message that was pushed. It must be the next one, unless the robot only takes what is pushed.
    pub(crate) fn pushed(&mut self, message: OutboxMessage, polls: bool) -> Result<(), Refusal> {
        let Some(seen) = self.after() else {
            return Err(Refusal::Down);
        };
        if polls && message.n > seen + 1 {
            return Err(Refusal::Gap {
                expected: seen + 1,
                got: message.n,
            });
        }
        self.message(message);
        Ok(())
    }

    /// Takes a message, if it is a new one.
    pub(crate) fn message(&mut self, message: OutboxMessage) {
        let OutboxMessage {
            n,
            session,
            message,
            ..
        } = message;
        if self.down_until.is_some() {
            return;
        }
        if n <= self.seen {
            let reason = format!("message {} was the last", self.seen);
            self.note(LedgerEvent::MessageIgnored { n, reason });
            return;
        }
        self.seen = n;
        let kind = message.kind();
        self.note(LedgerEvent::Message { n, kind, session });
        if let Err(reason) = self.obey(session, message) {
            self.note(LedgerEvent::MessageIgnored { n, reason });
        }
        self.refresh_obstacles();
        self.step_phase();
        self.pump();
    }

    /// Does what a message says, or says why not.
    fn obey(&mut self, session: Option<Uuid>, message: MobileMessage) -> Result<(), String> {
        match message {
            MobileMessage::TransportOrder(order) => self.take_order(*order, session),
            MobileMessage::CancelOrder { order } => self.cancel(order),
            MobileMessage::StartPause => {
                self.paused = true;
                Ok(())
            }
            MobileMessage::StopPause => {
                self.paused = false;
                Ok(())
            }
            MobileMessage::MovePermit { granted } => {
                let mission = self.of_session(session)?;
                mission.permit = granted;
                self.note(LedgerEvent::Permit { granted, session });
                Ok(())
            }
            MobileMessage::ExitGranted => {
                let mission = self.of_session(session)?;
                match mission.phase {
                    Phase::Docked | Phase::Ready => {
                        mission.exit = true;
                        Ok(())
                    }
                    Phase::Approach
                    | Phase::AtEntry
                    | Phase::Docking
                    | Phase::DockFailed
                    | Phase::Leaving
                    | Phase::Delivering
                    | Phase::Unloading => Err(format!("it is not docked: {:?}", mission.phase)),
                }
            }
            MobileMessage::CellReady
            | MobileMessage::TransferDone
            | MobileMessage::TransferFailed => self.of_session(session).map(drop),
            MobileMessage::StateRequest => {
                self.next_heartbeat = self.now;
                self.heartbeat();
                Ok(())
            }
            MobileMessage::Retry => self.retry(session),
            MobileMessage::SkipRetry => {
                let mission = self.may_dock_again(session)?;
                mission.aborted = Some(Aborted::Failed);
                mission.exit = true;
                mission.phase = Phase::Ready;
                Ok(())
            }
        }
    }

    /// The order that a message of a session is about.
    fn of_session(&mut self, session: Option<Uuid>) -> Result<&mut Mission, String> {
        match &mut self.mission {
            None => Err("there is no order".to_owned()),
            Some(mission) if mission.clear_told => Err("the hand-over is over".to_owned()),
            Some(mission) if mission.session != session => {
                Err("it is of another hand-over session".to_owned())
            }
            Some(mission) => Ok(mission),
        }
    }

    /// The order whose docking is over and may be done again: it failed, or it went well as far as the robot knows, the
    /// cell says otherwise, and the robot may still move.
    fn may_dock_again(&mut self, session: Option<Uuid>) -> Result<&mut Mission, String> {
        let mission = self.of_session(session)?;
        match mission.phase {
            Phase::DockFailed => Ok(mission),
            Phase::Docked | Phase::Ready if mission.permit => Ok(mission),
            Phase::Docked | Phase::Ready => Err("it is docked, and may not move".to_owned()),
            Phase::Approach
            | Phase::AtEntry
            | Phase::Docking
            | Phase::Leaving
            | Phase::Delivering
            | Phase::Unloading => Err(format!("docking has not failed: {:?}", mission.phase)),
        }
    }

    fn retry(&mut self, session: Option<Uuid>) -> Result<(), String> {
        let mission = self.may_dock_again(session)?;
        mission.phase = Phase::Approach;
        // Wherever it thought the dock was: it looks for it anew.
        mission.dock = mission.ordered_dock;
        mission.docked_at = None;
        let approach = mission.approach;
        self.clear_error("DOCKING_FAILED");
        self.motion.measure();
        let legs = route::legs(&self.plan, self.motion.believed(), &[], approach)?;
        self.set_out(legs, approach, Purpose::Approach, Manner::Docking)
    }

    fn take_order(
        &mut self,
        order: TransportOrderBody,
        session: Option<Uuid>,
    ) -> Result<(), String> {
        let ignores = self.faults.use_first(|fault| {
            if let Fault::OrderUnacknowledged { times } = fault {
                Some(((), one_less(times)))
            } else {
                None
            }
        });
        if ignores.is_some() {
            return Err("a fault: it takes no notice of the order".to_owned());
        }
        let (id, update) = (order.order, order.update);
        let same = self
            .mission
            .as_ref()
            .filter(|mission| mission.order.order == id)
            .map(|mission| mission.order.update);
        if self.known.contains(&id) || same.is_some_and(|current| update <= current) {
            self.note(LedgerEvent::OrderRepeated { order: id, update });
            // The state shows the order, or that it is over.
            self.next_heartbeat = self.now;
            return Ok(());
        }
        let taken = match same {
            Some(_) => self.update_order(order),
            None => self.begin_order(order, session),
        };
        if let Err(reason) = taken {
            self.refuse_order(id, session, reason);
        }
        Ok(())
    }

    fn update_order(&mut self, order: TransportOrderBody) -> Result<(), String> {
        let Some(mission) = &mut self.mission else {
            return Ok(());
        };
        let (id, update, goal) = (order.order, order.update, order.goal.clone());
        mission.update(&self.plan, order)?;
        let session = mission.session;
        self.note(LedgerEvent::OrderTaken {
            order: id,
            update,
            goal,
            session,
        });
        self.next_heartbeat = self.now;
        Ok(())
    }

    fn begin_order(
        &mut self,
        order: TransportOrderBody,
        session: Option<Uuid>,
    ) -> Result<(), String> {
        let refuses = self.faults.use_first(|fault| {
            if let Fault::OrderRefused { times } = fault {
                Some(((), one_less(times)))
            } else {
                None
            }
        });
        if refuses.is_some() {
            return Err("a fault: it refuses the order".to_owned());
        }
        self.finish_what_only_drives_out();
        if let Some(mission) = &self.mission {
            return Err(format!("it works on order {}", mission.order.order));
        }
        match self.mode {
            OperatingMode::Automatic | OperatingMode::Semiautomatic => {}
            OperatingMode::Intervened | OperatingMode::Manual | OperatingMode::Service => {
                return Err(format!("its mode is {:?}; it must be AUTOMATIC", self.mode));
            }
        }
        if self.charge <= self.plan.battery.empty_percent {
            return Err(format!("its battery is at {:.1} %", self.charge));
        }
        let (id, update, goal) = (order.order, order.update, order.goal.clone());
        let wrong = self.faults.use_first(|fault| {
            if let Fault::WrongDock { dock } = fault {
                Some((*dock, crate::fault_book::Used::Up))
            } else {
                None
            }
        });
        let from = self.motion.believed();
        let mission = Mission::try_new(&self.plan, order, session, from, wrong)?;
        // Without a hand-over it drives to where it gives its loads, and not only before a dock.
        let (to, purpose) = match &mission.destination {
            Some(destination) if mission.phase == Phase::Delivering => {
                (destination.pose, Purpose::Deliver)
            }
            Some(_) | None => (mission.approach, Purpose::Approach),
        };
        let legs = route::legs(&self.plan, from, &mission.order.route, to)?;
        self.visits = None;
        self.at_point = None;
        if mission.phase == Phase::Approach {
            self.learn(&mission);
        }
        self.mission = Some(mission);
        self.refresh_obstacles();
        if let Err(reason) = self.set_out(legs, to, purpose, Manner::Driving) {
            self.mission = None;
            self.refresh_obstacles();
            return Err(reason);
        }
        self.note(LedgerEvent::OrderTaken {
            order: id,
            update,
            goal,
            session,
        });
        self.signal(SignalName::MrAssigned);
        Ok(())
    }

    /// An order whose hand-over is over, and that leads nowhere else, is over when another comes: what is left of it is
    /// a way out of the way.
    fn finish_what_only_drives_out(&mut self) {
        let over = self
            .mission
            .as_ref()
            .is_some_and(|m| m.clear_told && (m.destination.is_none() || m.aborted.is_some()));
        if over {
            self.end_order(OrderOutcome::Finished);
        }
    }

    /// Remembers the zone of an order's point.
    fn learn(&mut self, mission: &Mission) {
        let name = &mission.order.goal;
        if self.known_zones.len() < KNOWN_ZONES || self.known_zones.contains_key(name) {
            let zone = mission.zone.clone();
            let _before = self.known_zones.insert(name.clone(), zone);
        }
    }

    fn refuse_order(&mut self, order: Uuid, session: Option<Uuid>, reason: String) {
        self.note(LedgerEvent::OrderRefused {
            order,
            reason: reason.clone(),
        });
        let mut data = self.data();
        // The signal is about this order, whatever the robot works on.
        data.order = Some(order);
        data.errors.push(MobileErrorBody {
            level: MobileErrorLevel::Warning,
            error_type: "ORDER_REFUSED".to_owned(),
            description: shortened(reason),
        });
        self.write(SignalName::MrRejected, session, data);
    }

    fn cancel(&mut self, order: Uuid) -> Result<(), String> {
        let Some(mission) = &mut self.mission else {
            return Err("there is no order".to_owned());
        };
        if mission.order.order != order {
            return Err(format!("it works on order {}", mission.order.order));
        }
        let inside = mission
            .zone
            .clearance(&self.plan.footprint, self.motion.believed())
            .0
            <= 0.0;
        match mission.phase {
            Phase::Approach | Phase::AtEntry if !inside => self.end_order(OrderOutcome::Cancelled),
            Phase::Delivering | Phase::Unloading => self.end_order(OrderOutcome::Cancelled),
            Phase::Leaving => mission.aborted = Some(Aborted::Cancelled),
            Phase::Docked | Phase::Ready => {
                // The arm may be at work: it stays until it may leave.
                mission.aborted = Some(Aborted::Cancelled);
                self.next_heartbeat = self.now;
            }
            Phase::Approach | Phase::AtEntry | Phase::Docking | Phase::DockFailed => {
                mission.aborted = Some(Aborted::Cancelled);
                mission.exit = true;
                mission.phase = Phase::Ready;
                self.end_drive(crate::ledger::DriveEnd::GivenUp);
                self.next_heartbeat = self.now;
            }
        }
        Ok(())
    }

    pub(super) fn remember(&mut self, order: Uuid) {
        if self.known.len() >= KNOWN_ORDERS {
            let _oldest = self.known.pop_front();
        }
        self.known.push_back(order);
    }
}
