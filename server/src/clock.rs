use std::fmt;
use std::time::Duration;

use jiff::Timestamp;

/// What time it is, for the records people read. Deadlines are tokio's; only the end of a token is by this clock.
pub trait WallClock: fmt::Debug + Send + Sync + 'static {
    /// The present time.
    fn now(&self) -> Timestamp;

    /// Time since the machine started, going on while it is suspended, where there is such a clock. Control of a cell
    /// ends by it: whoever slept is not in control.
    fn since_boot(&self) -> Option<Duration> {
        None
    }
}

/// The machine's own clock.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemClock;

impl WallClock for SystemClock {
    fn now(&self) -> Timestamp {
        Timestamp::now()
    }

    #[cfg(target_os = "linux")]
    fn since_boot(&self) -> Option<Duration> {
        use rustix::time::{ClockId, clock_gettime};
        clock_gettime(ClockId::Boottime).try_into().ok()
    }
}
