//! What is seen of the arms, and the waits that end: in memory only, gone with the process.

use crate::book::ArmLive;
use crate::cell::Cell;
use crate::effect::Effect;
use crate::input::ArmSeen;
use crate::timers::TimerKey;

impl Cell {
    pub(super) fn see_arm(&mut self, fresh: bool, seen: &ArmSeen) {
        if !fresh {
            return;
        }
        let before = self.live.arms.get(&seen.arm);
        let count = before.map_or(0, |b| b.count) + 1;
        let stopping = before.is_some_and(|b| b.stopping) && !seen.still;
        let live = ArmLive {
            seen: seen.clone(),
            count,
            stopping,
        };
        drop(self.live.arms.insert(seen.arm.clone(), live));
    }

    pub(super) fn fold_expired(&mut self, timer: &TimerKey) -> Option<Effect> {
        if let Some(wait) = self.live.timers.get_mut(timer) {
            wait.fired = true;
        }
        if let TimerKey::Safe { arm } = timer {
            let _one = self.live.safe.remove(arm);
        }
        if matches!(
            timer,
            TimerKey::Queue { .. }
                | TimerKey::State { .. }
                | TimerKey::Step { .. }
                | TimerKey::Question { .. }
        ) {
            let _armed_anew = self.live.timers.remove(timer);
        }
        let TimerKey::Question { intervention } = timer else {
            return None;
        };
        Some(Effect::Remind {
            intervention: *intervention,
        })
    }
}
