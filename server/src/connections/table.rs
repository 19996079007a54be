use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::Semaphore;
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

use super::choice::{Candidate, Dispensable, Host, choose};
use super::descriptors;
use super::standing::{Phase, Seen, Standing, millis_since};
use crate::config::ServerPlan;

/// How long the one that was asked to make room is waited for, before another is asked.
const MAKING_ROOM: Duration = Duration::from_millis(10);
/// How often the log says that connections are being closed.
const REPORTED_EVERY: Duration = Duration::from_secs(10);

/// The connections there are.
#[derive(Debug)]
pub(crate) struct Table {
    epoch: Instant,
    places: Arc<Semaphore>,
    limits: ServerPlan,
    entries: Mutex<BTreeMap<u64, Arc<Standing>>>,
    next: AtomicU64,
    closed_for_room: AtomicU64,
    closed_late: AtomicU64,
}

/// A connection's place in the table, until it is dropped.
#[derive(Debug)]
pub(crate) struct Seat {
    table: Arc<Table>,
    id: u64,
    pub(crate) standing: Arc<Standing>,
}

impl Table {
    /// A table with as many places as configured, or as the process may have open files.
    pub(crate) fn new(limits: &ServerPlan, robots: usize) -> Self {
        let places = descriptors::places(limits, robots);
        Self {
            epoch: Instant::now(),
            places: Arc::new(Semaphore::new(places)),
            limits: limits.clone(),
            entries: Mutex::new(BTreeMap::new()),
            next: AtomicU64::new(0),
            closed_for_room: AtomicU64::new(0),
            closed_late: AtomicU64::new(0),
        }
    }

    /// A place for a caller, at once where there is one or can be made; else when there is.
    pub(crate) async fn seat(self: &Arc<Self>, peer: IpAddr) -> Seat {
        let host = Host::of(peer);
        self.relieve(host);
        let place = loop {
            if let Ok(place) = Arc::clone(&self.places).try_acquire_owned() {
                break place;
            }
            self.make_room();
            // Nobody closes the semaphore, so that the only other end is the time limit.
            if let Ok(Ok(place)) =
                timeout(MAKING_ROOM, Arc::clone(&self.places).acquire_owned()).await
            {
                break place;
            }
        };
        let id = self.next.fetch_add(1, Ordering::Relaxed);
        let standing = Arc::new(Standing::new(host, self.epoch, place));
        let _none = self.entries().insert(id, Arc::clone(&standing));
        Seat {
            table: Arc::clone(self),
            id,
            standing,
        }
    }

    /// Closes the most dispensable connection, if there is one.
    pub(crate) fn make_room(&self) {
        let now = millis_since(self.epoch);
        let entries = self.entries();
        let mut candidates: Vec<_> = entries
            .iter()
            .filter(|(_, standing)| !standing.is_closing())
            .filter_map(|(id, standing)| {
                let seen = standing.seen();
                Some(Candidate {
                    id: *id,
                    host: standing.host,
                    kind: seen.dispensable(now)?,
                    since: seen.since,
                })
            })
            .collect();
        if let Some(standing) = choose(&mut candidates).and_then(|id| entries.get(&id)) {
            standing.close();
            let _before = self.closed_for_room.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Closes the oldest connection of a host that keeps the server waiting, where the host has enough of them.
    fn relieve(&self, host: Host) {
        let now = millis_since(self.epoch);
        let entries = self.entries();
        let mut waiting = 0;
        let mut oldest: Option<(u64, &Arc<Standing>)> = None;
        for standing in entries.values() {
            if standing.host != host || standing.is_closing() {
                continue;
            }
            let seen = standing.seen();
            if seen.dispensable(now) == Some(Dispensable::Waiting) {
                waiting += 1;
                if oldest.is_none_or(|(since, _)| seen.since < since) {
                    oldest = Some((seen.since, standing));
                }
            }
        }
        if let Some((_, standing)) = oldest
            && waiting >= self.limits.max_waiting_per_address
        {
            standing.close();
            let _before = self.closed_for_room.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Closes what takes too long, again and again, for as long as it is polled.
    pub(crate) async fn sweep(&self) {
        let limits = &self.limits;
        let shortest = limits
            .header_timeout
            .min(limits.idle_timeout)
            .min(limits.write_timeout);
        let every = (shortest / 4).clamp(Duration::from_millis(1), Duration::from_millis(250));
        let mut ticks = interval(every);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut reported = Instant::now();
        loop {
            let _at = ticks.tick().await;
            self.close_late();
            if reported.elapsed() >= REPORTED_EVERY {
                reported = Instant::now();
                self.report();
            }
        }
    }

    fn close_late(&self) {
        let now = millis_since(self.epoch);
        for standing in self.entries().values() {
            if !standing.is_closing() && self.is_late(standing.seen(), now) {
                standing.close();
                let _before = self.closed_late.fetch_add(1, Ordering::Relaxed);
            }
        }
    }

    fn is_late(&self, seen: Seen, now: u64) -> bool {
        let limits = &self.limits;
        let over = |since: u64, limit: Duration| {
            u128::from(now.saturating_sub(since)) >= limit.as_millis()
        };
        let takes_nothing = seen
            .blocked_since
            .is_some_and(|since| over(since, limits.write_timeout));
        match seen.phase {
            Phase::Arriving | Phase::Head => over(seen.since, limits.header_timeout),
            Phase::Idle => over(seen.since, limits.idle_timeout),
            // What takes a byte now and then is not stalled, but has no more time than any request.
            Phase::Answering | Phase::Sent => {
                takes_nothing || over(seen.since, limits.request_timeout)
            }
            Phase::Streaming => takes_nothing,
            // Bodies and handlers have limits of their own, which are answered.
            Phase::Body | Phase::Handling => false,
        }
    }

    fn report(&self) {
        let for_room = self.closed_for_room.swap(0, Ordering::Relaxed);
        let late = self.closed_late.swap(0, Ordering::Relaxed);
        if for_room > 0 {
            tracing::warn!(
                closed = for_room,
                late,
                seconds = REPORTED_EVERY.as_secs(),
                "connections were closed to make room for others"
            );
        }
    }

    fn entries(&self) -> MutexGuard<'_, BTreeMap<u64, Arc<Standing>>> {
        // Every change is one call of the map.
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for Seat {
    fn drop(&mut self) {
        drop(self.table.entries().remove(&self.id));
    }
}
