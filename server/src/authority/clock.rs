//! Time for leases: monotonic, and going on while the machine sleeps.

use std::sync::Arc;
use std::time::Duration;

use jiff::{SignedDuration, Timestamp};
use tokio::time::Instant;

use super::machine::Moment;
use crate::clock::WallClock;

/// Time since the server started.
#[derive(Debug)]
pub(crate) struct LeaseClock {
    wall: Arc<dyn WallClock>,
    started: Instant,
    /// What [`WallClock::since_boot`] said then.
    booted: Option<Duration>,
}

impl LeaseClock {
    pub(crate) fn new(wall: Arc<dyn WallClock>) -> Self {
        Self {
            started: Instant::now(),
            booted: wall.since_boot(),
            wall,
        }
    }

    /// The time now. The runtime's own clock stands still while the machine is suspended, so the later of the two
    /// counts: a lease does not survive a suspend that is longer than it.
    pub(crate) fn now(&self) -> Moment {
        let awake = self.started.elapsed();
        let with_sleep = self
            .wall
            .since_boot()
            .zip(self.booted)
            .map(|(now, booted)| now.saturating_sub(booted));
        with_sleep.map_or(awake, |with_sleep| with_sleep.max(awake))
    }

    /// What the wall clock says of a moment, for people.
    pub(crate) fn wall(&self, moment: Moment) -> Timestamp {
        let (here, now) = (self.now(), self.wall.now());
        let signed = |span: Duration| SignedDuration::try_from(span).unwrap_or_default();
        let (ahead, ago) = (moment.saturating_sub(here), here.saturating_sub(moment));
        let at = now
            .checked_add(signed(ahead))
            .and_then(|at| at.checked_sub(signed(ago)));
        at.unwrap_or(now)
    }
}
