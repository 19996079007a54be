use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::{Notify, Semaphore};
use tokio::time::{Instant, MissedTickBehavior, interval, timeout};

use super::choice::{Candidate, Dispensable, Host, choose};
use super::descriptors;
use super::standing::{Phase, Seen, Standing, millis_since};
use crate::config::ServerPlan;

/// How often somebody is looked for who can make room, where there was nobody.
const LOOKING_AGAIN: Duration = Duration::from_millis(10);
/// How many connections may be closing while others have their places.
pub(super) const CLOSING: usize = 64;
/// How often the log says that connections are being closed.
const REPORTED_EVERY: Duration = Duration::from_secs(10);

/// The connections there are.
#[derive(Debug)]
pub(crate) struct Table {
    epoch: Instant,
    /// How many connections may be open, those not counted that are closing, or are streams.
    places: usize,
    /// As many as that, and a few that are closing.
    sockets: Arc<Semaphore>,
    /// A connection has ended.
    ended: Notify,
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
            places,
            sockets: Arc::new(Semaphore::new(places + CLOSING)),
            ended: Notify::new(),
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
        while self.live() >= self.places && !self.make_room() {
            let _ended = timeout(LOOKING_AGAIN, self.ended.notified()).await;
        }
        // Nobody closes the semaphore: it only waits until enough of those that are closing have ended.
        let place = Arc::clone(&self.sockets).acquire_owned().await.ok();
        let id = self.next.fetch_add(1, Ordering::Relaxed);
        let standing = Arc::new(Standing::new(host, self.epoch, place));
        let _none = self.entries().insert(id, Arc::clone(&standing));
        Seat {
            table: Arc::clone(self),
            id,
            standing,
        }
    }

    /// The connections that hold a place.
    fn live(&self) -> usize {
        let counts = |standing: &&Arc<Standing>| {
            !standing.is_closing() && standing.phase() != Phase::Streaming
        };
        self.entries().values().filter(counts).count()
    }

    /// Closes the most dispensable connection; false where none is.
    pub(crate) fn make_room(&self) -> bool {
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
        let Some(standing) = choose(&mut candidates).and_then(|id| entries.get(&id)) else {
            return false;
        };
        standing.close();
        let _before = self.closed_for_room.fetch_add(1, Ordering::Relaxed);
        true
    }

    /// Closes the oldest connection of a host that keeps the server waiting, where the host has enough of them.
    fn relieve(&self, host: Host) {
        let now = millis_since(self.epoch);
        let entries = self.entries();
        let mut waiting = 0;
        let mut oldest: Option<(Seen, &Arc<Standing>)> = None;
        for standing in entries.values() {
            if standing.host != host || standing.is_closing() {
                continue;
            }
            let seen = standing.seen();
            let kind = seen.dispensable(now);
            if matches!(kind, Some(Dispensable::Waiting | Dispensable::Fresh)) {
                waiting += 1;
                if oldest.is_none_or(|(oldest, _)| seen.since < oldest.since) {
                    oldest = Some((seen, standing));
                }
            }
        }
        let Some((seen, standing)) = oldest else {
            return;
        };
        // Many who arrive at the same moment behind one address are not yet slow.
        let share = match seen.dispensable(now) {
            Some(Dispensable::Fresh) => self.places / 2,
            _ => 0,
        }
        .max(self.limits.max_waiting_per_address);
        if waiting >= share {
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
        let entries = self.entries();
        let mut waiting = Vec::new();
        for standing in entries.values().filter(|standing| !standing.is_closing()) {
            let seen = standing.seen();
            if self.is_late(seen, now) {
                standing.close();
                let _before = self.closed_late.fetch_add(1, Ordering::Relaxed);
            } else if seen.dispensable(now) == Some(Dispensable::Waiting) {
                waiting.push((standing.host, Reverse(seen.since), standing));
            }
        }
        // Those who all came in the same moment and turned out to be slow: the newest of each host stay.
        waiting.sort_unstable_by_key(|(host, since, _)| (*host, *since));
        for of_host in waiting.chunk_by(|one, next| one.0 == next.0) {
            for (_, _, standing) in of_host.iter().skip(self.limits.max_waiting_per_address) {
                standing.close();
                let _before = self.closed_for_room.fetch_add(1, Ordering::Relaxed);
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
            Phase::Accepted | Phase::Arriving | Phase::Head => {
                over(seen.since, limits.header_timeout)
            }
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
        self.table.ended.notify_one();
    }
}
