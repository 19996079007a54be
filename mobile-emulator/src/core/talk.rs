//! What the robot tells the cell, and what the cell tells the robot.

use api::{
    FloorPoseBody, MobileErrorBody, MobileErrorLevel, MobileMessage, OperatingMode, OutboxMessage,
    SignalData, SignalName, SlotLoadBody, TransportOrderBody,
};
use uuid::Uuid;

use super::{Core, KNOWN_ORDERS, KNOWN_ZONES};
use crate::error::Refusal;
use crate::fault::Fault;
use crate::fault_book::one_less;
use crate::floor::{body_of, shifted};
use crate::ledger::{LedgerEvent, OrderOutcome, Purpose};
use crate::mission::{Aborted, Mission, Phase};
use crate::motion::Manner;
use crate::outbound::{Dispatch, SendOutcome};
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
            MobileMessage::Retry => self.retry(session),
            MobileMessage::SkipRetry => {
                let mission = self.failed_docking(session)?;
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

    fn failed_docking(&mut self, session: Option<Uuid>) -> Result<&mut Mission, String> {
        let mission = self.of_session(session)?;
        if mission.phase == Phase::DockFailed {
            Ok(mission)
        } else {
            Err(format!("docking has not failed: {:?}", mission.phase))
        }
    }

    fn retry(&mut self, session: Option<Uuid>) -> Result<(), String> {
        let mission = self.failed_docking(session)?;
        mission.phase = Phase::Approach;
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
        let approach = mission.approach;
        let legs = route::legs(&self.plan, from, &mission.order.route, approach)?;
        self.at_point = None;
        self.learn(&mission);
        self.mission = Some(mission);
        self.refresh_obstacles();
        if let Err(reason) = self.set_out(legs, approach, Purpose::Approach, Manner::Driving) {
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

    /// What came of the signal that was sent last.
    pub(crate) fn outcome(&mut self, sent: &api::SignalBody, outcome: SendOutcome) {
        if sent.boot != self.boot {
            // Of the time before a crash.
            return;
        }
        let (signal, boot, seq) = (sent.signal, sent.boot, sent.seq);
        let answered = matches!(outcome, SendOutcome::Answered { .. });
        let away = (!answered).then(|| outcome.clone());
        let event = match outcome {
            SendOutcome::Answered { status, answer } => LedgerEvent::SignalAnswered {
                signal,
                boot,
                seq,
                status,
                answer,
            },
            SendOutcome::Unanswered { reason } => LedgerEvent::SignalUnanswered {
                signal,
                boot,
                seq,
                reason,
            },
        };
        self.note(event);
        if let Some(SendOutcome::Unanswered { reason }) = away {
            self.cell_is(Some(reason));
        } else {
            self.cell_is(None);
        }
        let _done = self.outbound.outcome(answered, self.now);
        self.pump();
    }

    /// Whether the cell can be reached, from whoever tried last.
    pub(crate) fn cell_is(&mut self, away: Option<String>) {
        match (away, self.cell_away) {
            (Some(reason), false) => {
                self.cell_away = true;
                self.note(LedgerEvent::CellAway { reason });
            }
            (None, true) => {
                self.cell_away = false;
                self.note(LedgerEvent::CellBack);
            }
            (Some(_), true) | (None, false) => {}
        }
    }

    /// Hands signals over that are to be sent.
    pub(super) fn pump(&mut self) {
        while let Some(dispatch) = self.outbound.dispatch(self.now) {
            match dispatch {
                Dispatch::Lost(signal, seq) => self.note(LedgerEvent::SignalLost { signal, seq }),
                Dispatch::Send(sending) => {
                    self.note(LedgerEvent::SignalSent {
                        signal: sending.signal.signal,
                        boot: sending.signal.boot,
                        seq: sending.signal.seq,
                        attempt: sending.attempt,
                    });
                    self.sends.push_back(*sending);
                }
            }
        }
    }

    pub(super) fn heartbeat_stopped(&self) -> bool {
        self.faults
            .any(|fault| matches!(fault, Fault::HeartbeatStops { .. }))
    }

    pub(super) fn heartbeat(&mut self) {
        if self.now < self.next_heartbeat || self.heartbeat_stopped() {
            return;
        }
        self.next_heartbeat = self.now.saturating_add(self.plan.heartbeat);
        let data = self.data();
        // ASSUMPTION: a heartbeat concerns no hand-over, so that it gets through when a session is closed.
        self.write(SignalName::MrHeartbeat, None, data);
    }

    pub(super) fn signal(&mut self, name: SignalName) {
        let session = self.mission.as_ref().and_then(|mission| mission.session);
        let data = self.data();
        self.write(name, session, data);
    }

    fn write(&mut self, name: SignalName, session: Option<Uuid>, data: SignalData) {
        let at = (self.wall_time(), self.now);
        if !self
            .outbound
            .write(name, session, at, data, &mut self.faults)
        {
            self.note(LedgerEvent::SignalLost {
                signal: name,
                seq: None,
            });
        }
    }

    /// What it tells of itself.
    fn data(&self) -> SignalData {
        SignalData {
            pose: self.told_pose(),
            driving: self.driving(),
            localized: !self
                .faults
                .any(|fault| matches!(fault, Fault::Unlocalized { .. })),
            battery_percent: self.charge,
            mode: self.mode,
            loads: self.told_loads(),
            order: self
                .mission
                .as_ref()
                .filter(|mission| mission.aborted.is_none())
                .map(|mission| mission.order.order),
            at_point: self.at_point.clone(),
            errors: self.errors.clone(),
        }
    }

    /// Where it says it is.
    pub(super) fn told_pose(&self) -> FloorPoseBody {
        let mut pose = self.motion.believed();
        for fault in self.faults.iter() {
            if let Fault::Lie {
                x_mm,
                y_mm,
                heading_deg,
                ..
            } = fault
            {
                pose = shifted(pose, (*x_mm, *y_mm, *heading_deg));
            }
        }
        body_of(pose)
    }

    /// What it says lies in its slots.
    fn told_loads(&self) -> Vec<SlotLoadBody> {
        let mut loads = self.slots.list().to_vec();
        for fault in self.faults.iter() {
            if let Fault::MisreportLoad { slot, load, .. } = fault {
                for one in loads.iter_mut().filter(|one| one.slot == *slot) {
                    one.load.clone_from(load);
                }
            }
        }
        loads
    }

    /// An error, told at once if it is new.
    pub(super) fn raise(&mut self, level: MobileErrorLevel, kind: &str, description: &str) {
        if self.errors.iter().any(|error| error.error_type == kind) {
            return;
        }
        self.write_error(level, kind, description);
        self.signal(SignalName::MrFault);
    }

    pub(super) fn write_error(&mut self, level: MobileErrorLevel, kind: &str, description: &str) {
        self.errors.retain(|error| error.error_type != kind);
        self.errors.push(MobileErrorBody {
            level,
            error_type: kind.to_owned(),
            description: shortened(description.to_owned()),
        });
        let error = format!("{kind}: {description}");
        self.note(LedgerEvent::Error { error });
    }

    pub(super) fn clear_error(&mut self, kind: &str) {
        self.errors.retain(|error| error.error_type != kind);
    }
}

/// As much of a sentence as a signal may carry.
fn shortened(text: String) -> String {
    if text.len() <= 400 {
        return text;
    }
    text.chars().take(400).collect()
}
