//! M5: a mobile robot's place is its own word, but a way that nobody can have driven is not believed.

use std::sync::Arc;

use crate::book::Jump;
use crate::cell::Cell;
use crate::ids::Millis;
use crate::signal::Signal;

/// What a mobile robot that finds itself anew may correct its pose by.
const JUMP_SLACK_MM: f64 = 300.0;

impl Cell {
    /// Whether the pose is farther from the one before than can be driven meanwhile. Signals that waited for a network
    /// arrive closer together than they were sent, so the longer of both times counts. Another boot may find itself
    /// anywhere.
    pub(super) fn jump_of(&self, now: Millis, signal: &Signal) -> Option<Jump> {
        let setup = self.setup.mobile_robot(&signal.mobile_robot)?;
        let max_speed_mm_s = setup.max_speed_mm_s?;
        let live = self.live.mobiles.get(&signal.mobile_robot)?;
        let before = live.state.as_ref().filter(|_| live.boot == signal.boot)?;
        let arrived = now.saturating_sub(live.seen_at?);
        let told = signal.at_ms.zip(live.told_at);
        let told = told.and_then(|(at, before)| u64::try_from(at.saturating_sub(before)).ok());
        let within_ms = arrived.max(told.unwrap_or(0));
        let (from, to) = (before.pose, signal.state.pose);
        let distance_mm = (to.x_mm - from.x_mm).hypot(to.y_mm - from.y_mm);
        #[expect(
            clippy::cast_precision_loss,
            reason = "times of one run: far below the integers that a float has"
        )]
        let possible = f64::from(max_speed_mm_s) * within_ms as f64 / 1_000.0 + JUMP_SLACK_MM;
        (distance_mm > possible).then_some(Jump {
            distance_mm,
            within_ms,
            max_speed_mm_s,
        })
    }

    /// What it claimed of its way before counts no more: it is to dock, for the first time or anew.
    pub(super) fn forget_jump(&mut self, mobile_robot: &str) {
        if let Some(live) = self.live.mobiles.get_mut(mobile_robot) {
            Arc::make_mut(live).jump = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::{BasePose, MobileRobotSetup, Setup};
    use crate::signal::{MobileState, SignalKind};

    fn signal(boot: u64, x_mm: f64, at_ms: Option<i64>) -> Signal {
        Signal {
            mobile_robot: "m1".into(),
            session: None,
            boot,
            seq: 1,
            kind: SignalKind::MrHeartbeat,
            at_ms,
            resync: false,
            state: MobileState {
                pose: BasePose {
                    x_mm,
                    ..BasePose::default()
                },
                ..MobileState::default()
            },
        }
    }

    fn seen(max_speed_mm_s: Option<u32>) -> Cell {
        let mut cell = Cell::new(Setup {
            mobile_robots: vec![MobileRobotSetup {
                id: "m1".into(),
                slots: Vec::new(),
                max_speed_mm_s,
            }],
            ..Setup::default()
        });
        cell.see(Some(10_000), &signal(1, 0.0, Some(0)));
        cell
    }

    #[test]
    fn m5_a_pose_goes_no_farther_than_its_robot_drives_in_the_longer_of_both_times() {
        let cell = seen(Some(1_000));
        let jump = |now, signal| cell.jump_of(now, &signal).map(|jump| jump.within_ms);
        assert_eq!(jump(11_000, signal(1, 1_300.0, None)), None);
        assert_eq!(jump(11_000, signal(1, 1_301.0, None)), Some(1_000));
        assert_eq!(jump(11_000, signal(1, -1_301.0, Some(500))), Some(1_000));
        // Three signals that waited for the network arrive together, and were sent a second apart.
        assert_eq!(jump(10_001, signal(1, 5_000.0, Some(5_000))), None);
        // A clock that was set back takes nothing from the time that passed here.
        assert_eq!(jump(15_000, signal(1, 5_000.0, Some(-9_000))), None);
        // After its start it may find itself anywhere.
        assert_eq!(jump(10_001, signal(2, 5_000.0, None)), None);
        let anyhow = seen(None);
        assert_eq!(anyhow.jump_of(10_001, &signal(1, 5_000.0, None)), None);
    }

    #[test]
    fn m5_a_jump_is_remembered_until_the_robot_is_told_to_dock_anew_or_is_clear() {
        let mut cell = seen(Some(1_000));
        let jumped = |cell: &Cell| cell.live.mobiles["m1"].jump.is_some();
        cell.see(Some(10_100), &signal(1, 5_000.0, None));
        assert!(jumped(&cell));
        cell.see(Some(10_200), &signal(1, 5_000.0, None));
        assert!(jumped(&cell), "standing still afterwards proves nothing");
        let mut clear = signal(1, 5_000.0, None);
        clear.kind = SignalKind::MrClear;
        cell.see(Some(10_300), &clear);
        assert!(!jumped(&cell));
        cell.see(Some(10_400), &signal(1, 0.0, None));
        cell.forget_jump("m1");
        assert!(!jumped(&cell));
    }
}
