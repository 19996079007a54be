//! What the robot tells the cell: signals, errors, and what it says of itself.

use api::{FloorPoseBody, MobileErrorBody, MobileErrorLevel, SignalData, SignalName, SlotLoadBody};
use uuid::Uuid;

use super::Core;
use crate::fault::Fault;
use crate::floor::{body_of, shifted};
use crate::ledger::LedgerEvent;
use crate::outbound::{Dispatch, SendOutcome};

impl Core {
    /// What came of the signal that was sent last.
    pub(crate) fn outcome(&mut self, sent: &api::SignalBody, outcome: SendOutcome) {
        if sent.boot != self.boot {
            // Of the time before a crash.
            return;
        }
        let (signal, boot, seq) = (sent.signal, sent.boot, sent.seq);
        if let SendOutcome::Gap { expected } = outcome {
            self.note(LedgerEvent::Resynchronized { boot, expected });
            self.cell_is(None);
            let (at, data) = (self.wall_time(), self.data());
            self.outbound.resync(at, self.now, data);
            self.pump();
            return;
        }
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
            SendOutcome::Gap { .. } => return,
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

    pub(super) fn write(&mut self, name: SignalName, session: Option<Uuid>, data: SignalData) {
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
    pub(super) fn data(&self) -> SignalData {
        SignalData {
            pose: self.told_pose(),
            driving: self.driving(),
            localized: !self
                .faults
                .any(|fault| matches!(fault, Fault::Unlocalized { .. })),
            battery_percent: self.charge,
            mode: self.mode,
            loads: self.plan.detects_loads.then(|| self.told_loads()),
            // An order that is given up is over when it has ended, as in VDA 5050: until then no other is taken.
            order: self.mission.as_ref().map(|mission| mission.order.order),
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
pub(super) fn shortened(text: String) -> String {
    if text.len() <= 400 {
        return text;
    }
    text.chars().take(400).collect()
}
