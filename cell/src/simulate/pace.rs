//! Time of a simulation: it stands while anything is being done, and goes on in steps when nothing is.
//!
//! Every part of a cell waits on the runtime's clock, and the runtime of a simulation is one thread with that clock
//! paused. So a simulated second is one for all parts alike, however slow the machine is; only the pace differs. The
//! runtime's own way of passing paused time would not do: it also passes while bytes wait in a socket.

use std::sync::Arc;
use std::time::Duration;

use jiff::{SignedDuration, Timestamp};
use server::WallClock;
use tokio::task::yield_now;
use tokio::time::{Instant, advance};

use super::task::Limits;

/// What passes at a time. Timers of the runtime have this resolution.
const STEP: Duration = Duration::from_millis(1);
/// How often everything that can go on does so within a step. Bytes that are passed on more often than that, from
/// socket to socket, take a step longer: about what they take between real machines.
const ROUNDS: usize = 4;
/// How many steps pass between two looks at the real clock.
const LOOK: usize = 16;

/// Which limit ended it.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) enum Reached {
    Wall,
    Simulated,
}

/// Lets time pass until a limit is reached.
pub(super) async fn pace(limits: Limits) -> Reached {
    let (began, real) = (Instant::now(), std::time::Instant::now());
    loop {
        for _ in 0..LOOK {
            for _ in 0..ROUNDS {
                // The runtime looks at its sockets, and runs all that is ready, before this goes on.
                yield_now().await;
            }
            advance(STEP).await;
        }
        if began.elapsed() >= limits.simulated {
            return Reached::Simulated;
        }
        if real.elapsed() >= limits.wall {
            return Reached::Wall;
        }
    }
}

/// The wall clock of the simulated world: the real time at the beginning, and the runtime's from there.
#[derive(Clone, Copy, Debug)]
pub(super) struct SimulatedClock {
    started: Instant,
    started_at: Timestamp,
}

impl SimulatedClock {
    pub(super) fn from(started_at: Timestamp) -> Arc<Self> {
        Arc::new(Self {
            started: Instant::now(),
            started_at,
        })
    }
}

impl WallClock for SimulatedClock {
    fn now(&self) -> Timestamp {
        let passed = SignedDuration::try_from(self.started.elapsed());
        let passed = passed.unwrap_or(SignedDuration::MAX);
        self.started_at
            .saturating_add(passed)
            .unwrap_or(Timestamp::MAX)
    }

    fn since_boot(&self) -> Option<Duration> {
        Some(self.started.elapsed())
    }
}
