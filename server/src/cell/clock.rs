use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use tokio::time::Instant;
use workflow::Millis;

use crate::clock::WallClock;

/// The time of a cell: milliseconds since the Unix epoch at the start, and monotonic from there. A wall clock that is
/// set later moves no timer.
#[derive(Clone, Debug)]
pub(crate) struct CellClock {
    started: Instant,
    started_at: Millis,
    /// How much faster than the world's time the cell's runs: 1, or more where all its parts are virtual.
    scale: f64,
}

impl CellClock {
    pub(crate) fn new(wall: &Arc<dyn WallClock>, scale: f64) -> Self {
        Self {
            started: Instant::now(),
            started_at: Millis::try_from(wall.now().as_millisecond()).unwrap_or(0),
            scale,
        }
    }

    /// The cell's time at a time of the world, given the world's present time.
    ///
    /// The two clocks are compared now, so that a wall clock that was set since the start does no harm. What is
    /// before the cell's beginning is 0.
    pub(crate) fn at(&self, wall_now: Timestamp, then: Timestamp) -> Millis {
        let ahead = then.duration_since(wall_now).as_secs_f64() * 1_000.0 * self.scale;
        #[expect(
            clippy::cast_precision_loss,
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "milliseconds since 1970 fit many times, and a cast saturates"
        )]
        let at = (self.now() as f64 + ahead).round() as Millis;
        at
    }

    /// The world's time at a time of the cell, to the second: the clocks are compared anew each time.
    pub(crate) fn wall_at(&self, wall_now: Timestamp, then: Millis) -> Timestamp {
        #[expect(
            clippy::cast_precision_loss,
            reason = "milliseconds since 1970 fit many times"
        )]
        let ahead = (then as f64 - self.now() as f64) / self.scale;
        #[expect(clippy::cast_possible_truncation, reason = "a cast saturates")]
        let at = wall_now.as_millisecond().saturating_add(ahead as i64);
        let seconds = at.saturating_add(500).div_euclid(1_000);
        Timestamp::from_second(seconds).unwrap_or(if seconds < 0 {
            Timestamp::MIN
        } else {
            Timestamp::MAX
        })
    }

    pub(crate) fn now(&self) -> Millis {
        let passed = self.started.elapsed().mul_f64(self.scale);
        let passed = Millis::try_from(passed.as_millis()).unwrap_or(Millis::MAX);
        self.started_at.saturating_add(passed)
    }

    /// When it will be `at`, on the runtime's clock. Never before `at`: a timer that fires early would find nothing
    /// to do, and fire again.
    pub(crate) fn instant(&self, at: Millis) -> Instant {
        let ahead = Duration::from_millis(at.saturating_sub(self.started_at).saturating_add(1));
        self.started + ahead.div_f64(self.scale)
    }
}

#[cfg(test)]
mod tests {
    use jiff::Timestamp;

    use super::*;

    #[derive(Debug)]
    struct At(i64);

    impl WallClock for At {
        fn now(&self) -> Timestamp {
            Timestamp::from_millisecond(self.0).unwrap()
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_deadline_of_the_world_comes_back_as_it_was_said() {
        let wall: Arc<dyn WallClock> = Arc::new(At(1_000_000));
        for (scale, times) in [(1.0, 1), (7.0, 7)] {
            let clock = CellClock::new(&wall, scale);
            tokio::time::advance(Duration::from_millis(12_345)).await;
            // Meanwhile somebody has set the wall clock an hour ahead.
            let now = Timestamp::from_millisecond(1_000_000 + 12_345 + 3_600_000).unwrap();
            let deadline = Timestamp::from_second(now.as_second() + 90).unwrap();
            let at = clock.at(now, deadline);
            let ahead = (at - clock.now()).abs_diff(90_000 * times);
            assert!(ahead <= 1_000 * times, "{ahead} ms at scale {scale}");
            assert_eq!(clock.wall_at(now, at), deadline);
            assert_eq!(clock.at(now, Timestamp::MIN), 0);
            assert!(clock.at(now, Timestamp::MAX) > at);
            assert_eq!(clock.wall_at(now, Millis::MAX), Timestamp::MAX);
        }
    }

    #[tokio::test(start_paused = true)]
    async fn a_timer_fires_when_its_time_has_come_and_not_before() {
        for scale in [1.0, 100.0] {
            let wall: Arc<dyn WallClock> = Arc::new(At(1_000_000));
            let clock = CellClock::new(&wall, scale);
            let due = clock.now() + 12_345;
            tokio::time::sleep_until(clock.instant(due)).await;
            let late = clock.now() - due;
            assert!(late <= 200, "{late} ms late at scale {scale}");
        }
    }
}
