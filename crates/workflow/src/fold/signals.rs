//! What mobile robots say, and what they are told.

use std::sync::Arc;

use crate::book::REMEMBERED;
use crate::cell::Cell;
use crate::ids::Millis;
use crate::session::Session;
use crate::signal::{Message, OutMessage, Signal, SignalAnswer, SignalKind};

impl Cell {
    pub(super) fn fold_signals_lost(&mut self, mobile_robot: &str, boot: u64, from: u64, to: u64) {
        self.mobile_mut(mobile_robot, |m| {
            if m.boot != boot {
                m.answers.clear();
                m.lost.clear();
                (m.boot, m.parked) = (boot, None);
                m.seq = 0;
            }
            if m.parked.as_ref().is_some_and(|p| p.seq <= to) {
                m.parked = None;
            }
            m.seq = m.seq.max(to);
            m.lost.push_back((from, to));
            if m.lost.len() > 64 {
                let _oldest = m.lost.pop_front();
            }
        });
    }

    pub(super) fn fold_signal(
        &mut self,
        now: Option<Millis>,
        signal: &Signal,
        answer: &SignalAnswer,
    ) {
        if matches!(answer, SignalAnswer::Late { .. }) {
            // What it tells was overtaken long ago: it is remembered, and that is all.
            self.mobile_mut(&signal.mobile_robot, |m| {
                m.remember(signal.seq, answer.clone());
            });
            return;
        }
        self.mobile_mut(&signal.mobile_robot, |m| {
            if m.boot != signal.boot {
                m.answers.clear();
                m.lost.clear();
                (m.boot, m.seq, m.parked) = (signal.boot, 0, None);
            }
            if matches!(answer, SignalAnswer::Parked) {
                m.parked = Some(signal.clone());
                return;
            }
            if m.parked.as_ref().is_some_and(|p| p.seq <= signal.seq) {
                m.parked = None;
            }
            m.seq = m.seq.max(signal.seq);
            m.remember(signal.seq, answer.clone());
        });
        if matches!(answer, SignalAnswer::Parked) {
            if let Some(live) = self.live.mobiles.get_mut(&signal.mobile_robot)
                && live.boot != signal.boot
            {
                let live = Arc::make_mut(live);
                (live.boot, live.seq) = (signal.boot, 0);
            }
            return;
        }
        self.see(now, signal);
        if !matches!(answer, SignalAnswer::Accepted { .. }) {
            return;
        }
        let Some(session) = self
            .book
            .open_session_of(&signal.mobile_robot)
            .map(|s| s.id)
        else {
            return;
        };
        self.session_mut(&session, |s| {
            s.echoes |= s.order.is_some() && signal.state.order == s.order;
            fold_said(s, signal);
        });
    }

    pub(super) fn see(&mut self, now: Option<Millis>, signal: &Signal) {
        let Some(now) = now else { return };
        let jump = self.jump_of(now, signal);
        let live = Arc::make_mut(
            self.live
                .mobiles
                .entry(signal.mobile_robot.clone())
                .or_default(),
        );
        live.jump = jump.or(live.jump.filter(|_| signal.kind != SignalKind::MrClear));
        live.state = Some(signal.state.clone());
        (live.seen_at, live.told_at) = (Some(now), signal.at_ms);
        (live.boot, live.seq) = (signal.boot, signal.seq);
        live.beats += 1;
        live.count += 1;
        live.lost &= live.beats < u64::from(self.setup.timers.heartbeats_to_resume);
        live.synced = true;
    }

    pub(super) fn put_out(
        &mut self,
        mobile_robot: &str,
        session: Option<uuid::Uuid>,
        message: &Message,
    ) -> OutMessage {
        let mut out = OutMessage {
            n: 0,
            session,
            message: message.clone(),
        };
        self.mobile_mut(mobile_robot, |m| {
            m.sent += 1;
            out.n = m.sent;
            if matches!(
                message,
                Message::MovePermit { granted: false } | Message::StartPause
            ) {
                // What was granted and not fetched yet must not be fetched before it is taken back.
                m.outbox.retain(|o| !o.message.grants());
            }
            if let Message::TransportOrder { order, .. } = message {
                // An order of the same hand-over that was not fetched yet is not driven to any more.
                m.outbox.retain(|o| {
                    let other = matches!(&o.message, Message::TransportOrder { order: earlier, .. } if earlier != order);
                    !(other && o.session == session && session.is_some())
                });
            }
            m.outbox.push_back(out.clone());
            if m.outbox.len() > REMEMBERED {
                drop(m.outbox.pop_front());
            }
        });
        out
    }
}

pub(super) fn fold_said(s: &mut Session, signal: &Signal) {
    match signal.kind {
        SignalKind::MrAssigned => s.assigned = true,
        SignalKind::MrArrived => s.arrived = true,
        SignalKind::MrDocked => (s.arrived, s.docked) = (true, Some(signal.state.pose)),
        SignalKind::MrReady => s.ready = true,
        SignalKind::MrClear => s.cleared = true,
        SignalKind::MrDockFailed => s.dock_tries = s.dock_tries.saturating_add(1),
        SignalKind::MrDelivered
        | SignalKind::LoadChanged
        | SignalKind::MrHeartbeat
        | SignalKind::MrFault
        | SignalKind::MrMode
        | SignalKind::MrRejected => {}
    }
}
