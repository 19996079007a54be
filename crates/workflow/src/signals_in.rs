//! Signals: numbered, answered once, acted on once (F23, M1 to M4).

use uuid::Uuid;

use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::{Refusal, Reply};
use crate::job::phase::Phase;
use crate::session::{Session, SessionState};
use crate::signal::{Signal, SignalAnswer, SignalKind};
use crate::work::Work;

impl Work<'_> {
    pub(crate) fn signal(&mut self, signal: Signal) -> Result<Reply, Refusal> {
        let id = signal.mobile_robot.clone();
        if self.cell.setup.mobile_robot(&id).is_none() {
            return Err(Refusal::Unknown {
                what: "mobile robot",
                id,
            });
        }
        let pose = signal.state.pose;
        let values = [
            pose.x_mm,
            pose.y_mm,
            pose.heading_deg,
            signal.state.battery_percent,
        ];
        if values.iter().any(|v| !v.is_finite()) {
            return Err(Refusal::Invalid {
                item: "data.pose".into(),
                problem: "every value has to be finite".into(),
            });
        }
        if signal.seq == 0 {
            return Err(Refusal::Invalid {
                item: "seq".into(),
                problem: "0; the first signal of a boot has number 1".into(),
            });
        }
        let known = self.cell.book.mobiles.get(&id).cloned().unwrap_or_default();
        let got = || format!("boot {} seq {}", signal.boot, signal.seq);
        if signal.resync && signal.kind != SignalKind::MrHeartbeat {
            return Err(Refusal::Invalid {
                item: "resync".into(),
                problem: "only MR_HEARTBEAT, which says all that is so now, may give numbers up"
                    .into(),
            });
        }
        // Heartbeats are not kept, so after a restart of this process the next number is not known.
        let live = self.cell.live.mobiles.get(&id).filter(|m| m.synced);
        let synced = live.is_some();
        let (boot, seq) = live.map_or((known.boot, known.seq), |m| (m.boot, m.seq));
        if signal.boot < boot {
            return Ok(Reply::Signal(SignalAnswer::Conflict {
                expected: format!("boot {boot}"),
                got: got(),
                duplicate: false,
            }));
        }
        let last = if signal.boot == boot { seq } else { 0 };
        if signal.seq <= last {
            let stored = known.answers.iter().find(|(seq, _)| *seq == signal.seq);
            let given_up = known.boot == signal.boot
                && known
                    .lost
                    .iter()
                    .any(|(from, to)| (*from..=*to).contains(&signal.seq));
            if stored.is_none() && given_up {
                return Ok(Reply::Signal(self.too_late(signal)));
            }
            let answer = stored.map_or(SignalAnswer::Accepted { duplicate: true }, |(_, a)| {
                a.clone().for_duplicate()
            });
            return Ok(Reply::Signal(answer));
        }
        let follows = signal.seq == last + 1 || (!synced && signal.boot == boot);
        if !follows && signal.resync {
            self.give_up(&signal, last, known.parked.clone());
        } else if !follows {
            if signal.seq == last + 2 {
                if known.parked.as_ref() != Some(&signal) {
                    let answer = SignalAnswer::Parked;
                    self.emit(Fact::Signaled {
                        signal: Box::new(signal),
                        answer,
                    });
                }
                return Ok(Reply::Signal(SignalAnswer::Parked));
            }
            return Ok(Reply::Signal(SignalAnswer::Gap {
                boot: signal.boot,
                expected: last + 1,
                got: signal.seq,
            }));
        }
        let parked = known
            .parked
            .clone()
            .filter(|p| p.boot == signal.boot && p.seq == signal.seq + 1);
        let answer = self.act_on(signal);
        if let Some(parked) = parked {
            self.settle();
            let _answer = self.act_on(parked);
        }
        Ok(Reply::Signal(answer))
    }

    /// The mobile robot has lost what is missing before this heartbeat: nobody waits for it any longer. What is parked
    /// has its turn now.
    fn give_up(&mut self, signal: &Signal, last: u64, parked: Option<Signal>) {
        let boot = signal.boot;
        let mut from = last + 1;
        if let Some(parked) = parked.filter(|p| p.boot == boot && p.seq < signal.seq) {
            let seq = parked.seq;
            self.lose(&signal.mobile_robot, boot, from, seq.saturating_sub(1));
            let _answer = self.act_on(parked);
            self.settle();
            from = seq + 1;
        }
        self.lose(
            &signal.mobile_robot,
            boot,
            from,
            signal.seq.saturating_sub(1),
        );
    }

    fn lose(&mut self, mobile_robot: &str, boot: u64, from: u64, to: u64) {
        if from > to {
            return;
        }
        if let Some(session) = self.cell.book.open_session_of(mobile_robot) {
            let job = session.job;
            self.note(
                job,
                Fault::StaleSignal,
                format!("signals {from} to {to} of boot {boot} are lost"),
            );
        }
        self.emit(Fact::SignalsLost {
            mobile_robot: mobile_robot.to_owned(),
            boot,
            from,
            to,
        });
    }

    /// It was given up as lost: what it says was true once.
    fn too_late(&mut self, signal: Signal) -> SignalAnswer {
        let answer = SignalAnswer::Late { duplicate: false };
        if let Some(session) = self.cell.book.open_session_of(&signal.mobile_robot) {
            let (job, kind) = (session.job, signal.kind);
            self.note(
                job,
                Fault::StaleSignal,
                format!("{kind:?} came after it was given up, and was not acted on"),
            );
        }
        self.emit(Fact::Signaled {
            signal: Box::new(signal),
            answer: answer.clone(),
        });
        answer
    }

    /// A signal whose turn it is.
    pub(crate) fn act_on(&mut self, signal: Signal) -> SignalAnswer {
        let answer = self.judge(&signal);
        let nothing_but_alive = signal.kind == SignalKind::MrHeartbeat
            && answer == SignalAnswer::Accepted { duplicate: false }
            && self
                .cell
                .book
                .mobiles
                .get(&signal.mobile_robot)
                .is_some_and(|m| m.boot == signal.boot && m.parked.is_none());
        if nothing_but_alive {
            self.emit(Fact::Beat {
                signal: Box::new(signal),
            });
            return answer;
        }
        if !matches!(answer, SignalAnswer::Accepted { .. })
            && let Some(session) = self.cell.book.open_session_of(&signal.mobile_robot)
        {
            let (job, kind) = (session.job, signal.kind);
            self.note(
                job,
                Fault::StaleSignal,
                format!("{kind:?} was not acted on"),
            );
        }
        self.emit(Fact::Signaled {
            signal: Box::new(signal.clone()),
            answer: answer.clone(),
        });
        if matches!(answer, SignalAnswer::Accepted { .. }) {
            self.consequences(&signal);
        }
        answer
    }

    /// Legal now, closed, or in conflict.
    fn judge(&self, signal: &Signal) -> SignalAnswer {
        let accepted = SignalAnswer::Accepted { duplicate: false };
        let open = self.cell.book.open_session_of(&signal.mobile_robot);
        // The order outlives its hand-over: until the loads are delivered, it is answered and reported.
        let of_transport = open.is_none() && self.is_of_transport(signal);
        if let Some(named) = signal.session
            && !of_transport
        {
            match self.cell.book.sessions.get(&named) {
                Some(s) if s.state.is_closed() && signal.kind != SignalKind::MrDelivered => {
                    return SignalAnswer::Closed {
                        session: named,
                        duplicate: false,
                    };
                }
                Some(_) => {}
                None => {
                    return SignalAnswer::Closed {
                        session: named,
                        duplicate: false,
                    };
                }
            }
            // A step of an earlier session must not be advanced by a late signal (M2).
            if open.is_some_and(|s| s.id != named) && signal.kind != SignalKind::MrDelivered {
                return SignalAnswer::Conflict {
                    expected: open.map(|s| s.id.to_string()).unwrap_or_default(),
                    got: named.to_string(),
                    duplicate: false,
                };
            }
        }
        let Some(session) = open else { return accepted };
        let expected = expected(session, signal.state.order, signal.kind);
        if let Some(expected) = expected {
            return SignalAnswer::Conflict {
                expected,
                got: format!("{:?}", signal.kind),
                duplicate: false,
            };
        }
        accepted
    }

    fn consequences(&mut self, signal: &Signal) {
        let session = self
            .cell
            .book
            .open_session_of(&signal.mobile_robot)
            .cloned();
        match signal.kind {
            SignalKind::MrRejected if session.is_none() && self.is_of_transport(signal) => {
                self.transport_stuck(&signal.mobile_robot, "it refused its order");
            }
            SignalKind::MrRejected => {
                if let Some(job) = session.and_then(|s| self.job(s.job))
                    && job
                        .find(Phase::Call)
                        .is_some_and(|s| !job.step(s).is_some_and(|s| s.state.is_done()))
                {
                    self.not_acknowledged(&job, "it refused its order");
                }
            }
            SignalKind::MrDockFailed => {
                if let Some(session) = session.filter(|s| s.state == SessionState::Positioned) {
                    self.dock_failed(&session, "it reports that docking failed");
                }
            }
            SignalKind::MrDelivered => self.delivered(&signal.mobile_robot),
            SignalKind::LoadChanged => self.loads_gone(signal),
            SignalKind::MrFault if session.is_none() => self.fault_under_way(signal),
            SignalKind::MrAssigned
            | SignalKind::MrArrived
            | SignalKind::MrDocked
            | SignalKind::MrReady
            | SignalKind::MrClear
            | SignalKind::MrHeartbeat
            | SignalKind::MrFault
            | SignalKind::MrMode => {}
        }
        self.trigger(signal);
    }

    /// F20: it failed after departure.
    fn fault_under_way(&mut self, signal: &Signal) {
        if !signal.state.errors.iter().any(|e| e.fatal) {
            return;
        }
        self.transport_stuck(&signal.mobile_robot, "it reports a fatal error");
    }
}

/// What would have been legal instead; `None`: this is.
fn expected(session: &Session, order: Option<Uuid>, kind: SignalKind) -> Option<String> {
    let state = session.state;
    let faulted = state == SessionState::Faulted;
    let other_order = order.is_some() && session.order.is_some() && order != session.order;
    let legal = match kind {
        SignalKind::MrAssigned => {
            state == SessionState::Reserved && session.order.is_some() && !other_order
        }
        SignalKind::MrArrived => {
            faulted
                || matches!(
                    state,
                    SessionState::AccessGranted | SessionState::AccessPending
                ) && !other_order
        }
        SignalKind::MrDocked | SignalKind::MrDockFailed => {
            faulted || state == SessionState::Positioned
        }
        SignalKind::MrReady => faulted || state == SessionState::Docked,
        SignalKind::MrClear => {
            faulted
                || matches!(
                    state,
                    SessionState::ExitGranted | SessionState::Exited | SessionState::Canceling
                )
                || state == SessionState::Positioned && session.backs_out
        }
        SignalKind::MrRejected => state == SessionState::Reserved && session.order.is_some(),
        SignalKind::MrDelivered
        | SignalKind::LoadChanged
        | SignalKind::MrHeartbeat
        | SignalKind::MrFault
        | SignalKind::MrMode => true,
    };
    (!legal).then(|| format!("session {:?}", session.state))
}
