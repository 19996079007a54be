use std::sync::Arc;
use std::time::Duration;

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
