//! Time passes, and things go wrong by chance.

use workflow::{Input, Location, MobileMode, OpResult, Safety, SignalKind};

use super::World;

/// A deterministic source of chance.
#[derive(Debug, Clone)]
pub struct Chance(pub u64);

impl Chance {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n.max(1)
    }

    pub fn hits(&mut self, permille: u64) -> bool {
        permille > 0 && self.below(1000) < permille
    }
}

/// What goes wrong by chance, in thousandths.
#[derive(Debug, Clone, Default)]
pub struct Odds {
    pub lost: u64,
    pub duplicated: u64,
    pub reordered: u64,
    pub grip_fails: u64,
    pub motion_doubt: u64,
    pub motion_alarm: u64,
    pub not_executed: u64,
    pub part_dropped: u64,
    pub crash: u64,
    pub controller_forgets: u64,
    pub mode_change: u64,
    pub heartbeat_gap: u64,
    pub dock_off: u64,
    pub command: u64,
    pub protective_stop: u64,
}

impl World {
    /// One step of time.
    pub fn tick(&mut self) {
        self.now += 50;
        let now = self.now;
        self.misfortune();
        for name in self.setup.arms.clone() {
            let arm = self.arms.get_mut(&name).unwrap();
            if let Some((op, target, until)) = arm.moving.clone()
                && until <= now
            {
                arm.moving = None;
                arm.at = Some(target);
                let _old = arm.done.insert(op, OpResult::Arrived);
                if !arm.doubt_for_good {
                    self.results.push((now, op, OpResult::Arrived));
                }
            }
        }
        if now >= self.next_look {
            self.look();
        }
        let due: Vec<_> = self
            .results
            .iter()
            .filter(|(at, ..)| *at <= now)
            .cloned()
            .collect();
        self.results.retain(|(at, ..)| *at > now);
        for (_, op, result) in due {
            let linked = !self.arms.values().any(|a| !a.link && a.asked.contains(&op));
            if linked {
                let _reply = self.input(Input::OperationEnded { op, result });
            }
        }
        for id in self.mobiles.keys().cloned().collect::<Vec<_>>() {
            let m = self.mobiles.get_mut(&id).unwrap();
            if m.beats && now >= m.next_beat {
                m.next_beat = now + 1_000;
                self.say(&id, SignalKind::MrHeartbeat);
            }
            let m = self.mobiles.get_mut(&id).unwrap();
            let due: Vec<_> = m
                .plan
                .iter()
                .filter(|(at, _)| *at <= now && !m.paused)
                .copied()
                .collect();
            m.plan.retain(|(at, _)| *at > now || m.paused);
            for (_, what) in due {
                self.act(&id, what);
            }
            if self.mobiles[&id].beats {
                self.send(&id);
            }
        }
        if self.cell.next_deadline().is_some_and(|at| at <= now) {
            let _reply = self.input(Input::Tick).unwrap();
        }
    }

    pub(super) fn misfortune(&mut self) {
        if !self.rogue {
            return;
        }
        let odds = self.odds.clone();
        if self.chance.hits(odds.mode_change) {
            let m = self.mobiles.get_mut("m1").unwrap();
            let auto = m.state.mode.is_automatic();
            m.state.mode = if auto {
                MobileMode::Manual
            } else {
                MobileMode::Automatic
            };
            self.say("m1", SignalKind::MrMode);
        } else if !self.mobiles["m1"].state.mode.is_automatic() && self.chance.hits(20) {
            self.mobiles.get_mut("m1").unwrap().state.mode = MobileMode::Automatic;
            self.say("m1", SignalKind::MrMode);
        }
        if self.chance.hits(odds.heartbeat_gap) {
            self.mobiles.get_mut("m1").unwrap().beats = false;
        } else if !self.mobiles["m1"].beats && self.chance.hits(10) {
            self.mobiles.get_mut("m1").unwrap().beats = true;
        }
        if self.chance.hits(odds.controller_forgets) {
            let arm = self.arms.get_mut("r1").unwrap();
            arm.done.clear();
            arm.forgot = true;
        }
        if self.chance.hits(odds.part_dropped)
            && let Some(load) = self.arms.get_mut("r1").unwrap().holds.take()
        {
            let _old = self.loads.insert(load, Location::Unknown { arm: None });
        }
        if self.chance.hits(odds.protective_stop) {
            let arm = self.arms.get_mut("r1").unwrap();
            arm.safety = Safety::ProtectiveStop;
        } else if self.arms["r1"].safety == Safety::ProtectiveStop && self.chance.hits(20) {
            self.arms.get_mut("r1").unwrap().safety = Safety::Normal;
        }
    }

    /// Runs until `done` or for `most_ms`.
    pub fn run(&mut self, most_ms: u64, done: impl Fn(&Self) -> bool) -> bool {
        let end = self.now + most_ms;
        while self.now < end {
            if done(self) {
                return true;
            }
            self.tick();
        }
        done(self)
    }
}
