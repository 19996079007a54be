//! What mobile robots say, over a network that loses things.

use workflow::{ArmSeen, Input, Reply, Signal, SignalAnswer, SignalKind};

use super::{World, ZONE};

impl World {
    pub fn say(&mut self, id: &str, kind: SignalKind) {
        let loads = self.report(id);
        let m = self.mobiles.get_mut(id).unwrap();
        m.seq += 1;
        m.state.loads = loads;
        m.sending.push_back(Signal {
            mobile_robot: id.into(),
            session: m.session.filter(|_| m.state.order.is_some()),
            boot: m.boot,
            seq: m.seq,
            kind,
            at_ms: None,
            resync: false,
            state: m.state.clone(),
        });
    }

    pub(super) fn send(&mut self, id: &str) {
        let Some(m) = self.mobiles.get_mut(id) else {
            return;
        };
        if m.sending.is_empty() || self.now < m.next_send {
            return;
        }
        m.next_send = self.now + 300;
        let swap = m.sending.len() > 1 && self.chance.hits(self.odds.reordered);
        let signal = m.sending[usize::from(swap)].clone();
        if self.chance.hits(self.odds.lost) {
            return;
        }
        let copies = if self.chance.hits(self.odds.duplicated) {
            2
        } else {
            1
        };
        for _copy in 0..copies {
            let (boot, seq, kind) = (signal.boot, signal.seq, signal.kind);
            let before = self.crashes;
            let reply = self.input(Input::Signal(Box::new(signal.clone())));
            if self.crashes != before {
                // The answer died with the process: it is sent again.
                return;
            }
            let answer = match reply {
                Ok(Reply::Signal(answer)) => answer,
                other => panic!("{other:?}"),
            };
            if kind != SignalKind::MrHeartbeat {
                self.log
                    .push(format!("{:>7} {id} says {kind:?} -> {answer:?}", self.now));
            }
            self.answers.push((kind, answer.clone()));
            let m = self.mobiles.get_mut(id).unwrap();
            let again = matches!(&answer, SignalAnswer::Conflict { expected, .. } if expected.starts_with("boot"))
                || matches!(&answer, SignalAnswer::Gap { .. });
            if !again && m.boot == boot {
                m.sending.retain(|s| s.seq != seq);
                m.next_send = self.now + 20;
            }
        }
    }

    pub(super) fn look(&mut self) {
        for name in self.setup.arms.clone() {
            let arm = &self.arms[&name];
            let seen = ArmSeen {
                arm: name.clone(),
                link: arm.link,
                ready: arm.link && arm.ready,
                still: arm.link && arm.moving.is_none(),
                manual: arm.manual,
                displaced: arm.displaced,
                safety: arm.safety,
                zones: if self.arm_inside(arm) || arm.at.is_none() && self.was_inside(arm) {
                    vec![ZONE.into()]
                } else {
                    vec![]
                },
                part_present: Some(arm.holds.is_some()),
            };
            let _reply = self.input(Input::ArmObserved(seen)).unwrap();
        }
        self.next_look = self.now + 200;
    }
}
