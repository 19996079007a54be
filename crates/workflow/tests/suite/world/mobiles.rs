//! The mobile robots: what they are told, what they do, and what they see.

use workflow::{BasePose, Location, Message, OutMessage, SignalKind, SlotLoad};

use super::{DOCK, Do, POINT, World};

impl World {
    /// The mobile robot reads a message.
    pub(super) fn obey(&mut self, id: &str, out: OutMessage) {
        if self.chance.hits(self.odds.dock_off) {
            self.mobiles.get_mut(id).unwrap().dock_errors += 1;
        }
        let inside = self.arms.values().any(|a| self.arm_inside(a));
        let now = self.now;
        let m = self.mobiles.get_mut(id).unwrap();
        self.log
            .push(format!("{now:>7} tell {id} {:?}", out.message));
        m.session = out.session.or(m.session);
        if out.n <= m.read {
            return;
        }
        m.read = out.n;
        m.got.push(out.message.clone());
        match out.message {
            Message::TransportOrder {
                order,
                update,
                goal,
                ..
            } => {
                if goal != POINT {
                    m.onward = true;
                    if !m.docked && m.state.at_point.is_none() && m.delivers {
                        m.plan.push_back((now + 500, Do::Deliver));
                    }
                    return;
                }
                let same = m.state.order == Some(order) && update == 1;
                if !same && m.acks && !m.state.driving {
                    m.state.order = Some(order);
                    m.plan.clear();
                    m.plan.push_back((
                        now + 100,
                        if m.rejects {
                            Do::Rejected
                        } else {
                            Do::Assigned
                        },
                    ));
                }
            }
            Message::MovePermit { granted } => {
                m.permit = granted;
                if granted && m.arrives {
                    m.plan.push_back((now + 200, Do::Depart));
                } else if !granted && m.docked && m.says_ready {
                    m.plan.push_back((now + 100, Do::Ready));
                }
                if !granted {
                    m.plan.retain(|(_, d)| !matches!(d, Do::Depart));
                }
            }
            Message::ExitGranted => {
                assert!(!inside, "exit granted with an arm in the zone");
                m.permit = true;
                if m.leaves && m.state.at_point.is_some() {
                    m.plan.clear();
                    m.plan.push_back((now + 300, Do::Leave));
                } else if m.state.at_point.is_none() && m.leaves {
                    m.plan.push_back((now + 300, Do::Clear));
                }
            }
            Message::CancelOrder { order } => {
                if m.state.order == Some(order) {
                    m.plan.clear();
                    m.state.order = None;
                    if m.leaves {
                        let first = if m.state.at_point.is_some() {
                            Do::Leave
                        } else {
                            Do::Clear
                        };
                        m.plan.push_back((now + 300, first));
                    }
                }
            }
            Message::Retry if !m.obeys_retry => {}
            Message::Retry => m.plan.push_back((now + 500, Do::Dock)),
            Message::StartPause => (m.paused, m.state.driving) = (true, false),
            Message::StopPause => m.paused = false,
            Message::SkipRetry => {
                m.plan.clear();
                m.plan.push_back((now + 300, Do::Leave));
            }
            Message::CellReady
            | Message::TransferDone
            | Message::TransferFailed { .. }
            | Message::StateRequest => {}
        }
    }

    /// What the slots really hold, or what it is made to say.
    pub(super) fn report(&self, id: &str) -> Option<Vec<SlotLoad>> {
        let m = &self.mobiles[id];
        if !m.reports_loads {
            return None;
        }
        let mut all: Vec<_> = self
            .loads
            .iter()
            .filter_map(|(load, at)| match at {
                Location::MobileRobot { mobile_robot, slot } if mobile_robot == id => {
                    Some(SlotLoad {
                        slot: slot.clone(),
                        load: Some(load.clone()),
                    })
                }
                _ => None,
            })
            .collect();
        if let Some((slot, lie)) = &m.lies_slot {
            all.retain(|l| l.slot != *slot);
            if let Some(lie) = lie {
                all.push(SlotLoad {
                    slot: slot.clone(),
                    load: Some(lie.clone()),
                });
            }
        }
        Some(all)
    }

    pub(super) fn act(&mut self, id: &str, what: Do) {
        let arm_inside = self.arms.values().any(|a| self.arm_inside(a));
        let rogue = self.rogue;
        let now = self.now;
        let m = self.mobiles.get_mut(id).unwrap();
        match what {
            Do::Assigned => self.say(id, SignalKind::MrAssigned),
            Do::Rejected => {
                m.state.order = None;
                self.say(id, SignalKind::MrRejected);
            }
            Do::Depart => {
                if m.permit && m.state.order.is_some() && m.state.at_point.is_none() {
                    m.state.driving = true;
                    m.plan.push_back((now + 3_000, Do::Arrive));
                } else if m.docked && m.permit {
                    // It is there already: it says so again.
                    m.plan.push_back((now + 100, Do::Arrive));
                }
            }
            Do::Arrive => {
                assert!(
                    rogue || !arm_inside || !m.state.driving,
                    "a mobile robot drives in with an arm in the zone"
                );
                (m.state.driving, m.state.at_point) = (false, Some(POINT.into()));
                if !m.docked {
                    m.state.pose = BasePose {
                        x_mm: DOCK.x_mm - 300.0,
                        ..DOCK
                    };
                }
                self.say(id, SignalKind::MrArrived);
                if self.mobiles[id].docks {
                    self.mobiles
                        .get_mut(id)
                        .unwrap()
                        .plan
                        .push_back((now + 1_000, Do::Dock));
                }
            }
            Do::Dock => {
                let off = if m.dock_errors > 0 {
                    50.0
                } else {
                    m.dock_error_mm
                };
                m.dock_errors = m.dock_errors.saturating_sub(1);
                m.state.pose = BasePose {
                    x_mm: DOCK.x_mm + off,
                    ..DOCK
                };
                m.docked = true;
                self.say(id, SignalKind::MrDocked);
            }
            Do::Ready => {
                if m.docked && !m.permit {
                    self.say(id, SignalKind::MrReady);
                }
            }
            Do::Leave => {
                assert!(
                    rogue || !arm_inside,
                    "a mobile robot leaves with an arm in the zone\n{}",
                    self.story()
                );
                let m = self.mobiles.get_mut(id).unwrap();
                (m.state.driving, m.docked) = (true, false);
                m.plan.push_back((now + 2_000, Do::Clear));
            }
            Do::Clear => {
                (m.state.driving, m.permit) = (false, false);
                m.docked = false;
                m.state.at_point = None;
                m.state.pose = BasePose::default();
                self.say(id, SignalKind::MrClear);
                let m = self.mobiles.get_mut(id).unwrap();
                m.state.order = None;
                if std::mem::take(&mut m.onward) && m.delivers {
                    m.plan.push_back((now + 3_000, Do::Deliver));
                }
            }
            Do::Deliver => {
                for (load, at) in &mut self.loads {
                    if load.starts_with('P')
                        && matches!(at, Location::MobileRobot { mobile_robot, .. } if mobile_robot == id)
                    {
                        *at = Location::Delivered {
                            destination: "warehouse".into(),
                        };
                    }
                }
                self.say(id, SignalKind::MrDelivered);
            }
        }
    }
}
