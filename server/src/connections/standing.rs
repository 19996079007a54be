use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use tokio::sync::{Notify, OwnedSemaphorePermit};
use tokio::time::Instant;

use super::choice::Host;

/// What a connection is doing.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Phase {
    /// Accepted, and not looked at yet.
    Accepted,
    /// Nothing has come, or a part of a head; a whole one never has.
    Arriving,
    /// A head of a later request has begun.
    Head,
    /// The head is here, the body is not.
    Body,
    /// The request is here; the server works on it.
    Handling,
    /// The answer is on its way.
    Answering,
    /// The whole answer was handed over, but it may still be in the buffer.
    Sent,
    /// Between two requests.
    Idle,
    /// The answer is a stream of events.
    Streaming,
}

/// How a connection stands: its phase and since when. Written by the connection's own task, read by those who look
/// for room; a moment's disagreement between them does no harm, so nothing here is ordered.
#[derive(Debug)]
pub(crate) struct Standing {
    pub(super) host: Host,
    epoch: Instant,
    /// Milliseconds since the epoch, times sixteen, and the phase.
    word: AtomicU64,
    /// Since when the peer has taken nothing; zero while it does.
    blocked_since: AtomicU64,
    closing: AtomicBool,
    close: Notify,
    place: Mutex<Option<OwnedSemaphorePermit>>,
}

/// A standing at a moment, in milliseconds since the epoch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) phase: Phase,
    pub(crate) since: u64,
    pub(crate) blocked_since: Option<u64>,
}

impl Standing {
    pub(super) fn new(host: Host, epoch: Instant, place: Option<OwnedSemaphorePermit>) -> Self {
        let this = Self {
            host,
            epoch,
            word: AtomicU64::new(0),
            blocked_since: AtomicU64::new(0),
            closing: AtomicBool::new(false),
            close: Notify::new(),
            place: Mutex::new(place),
        };
        this.enter(Phase::Accepted);
        this
    }

    pub(super) fn phase(&self) -> Phase {
        phase_of(self.word.load(Ordering::Relaxed))
    }

    pub(super) fn enter(&self, phase: Phase) {
        let word = millis_since(self.epoch) << 4 | phase as u64;
        self.word.store(word, Ordering::Relaxed);
    }

    /// Goes on to `then` if the phase is `from`.
    pub(super) fn pass(&self, from: Phase, then: Phase) {
        if self.phase() == from {
            self.enter(then);
        }
    }

    /// The peer takes nothing.
    pub(super) fn block(&self) {
        // Never zero, which means the opposite.
        let now = millis_since(self.epoch).max(1);
        self.blocked_since.store(now, Ordering::Relaxed);
    }

    /// The peer takes what it is sent.
    pub(super) fn unblock(&self) {
        self.blocked_since.store(0, Ordering::Relaxed);
    }

    /// Gives the place back: the connection holds one of another kind.
    pub(super) fn give_back(&self) {
        let mut place = self.place.lock().unwrap_or_else(PoisonError::into_inner);
        drop(place.take());
    }

    pub(super) fn seen(&self) -> Seen {
        let word = self.word.load(Ordering::Relaxed);
        let blocked = self.blocked_since.load(Ordering::Relaxed);
        Seen {
            phase: phase_of(word),
            since: word >> 4,
            blocked_since: (blocked != 0).then_some(blocked),
        }
    }

    pub(super) fn is_closing(&self) -> bool {
        self.closing.load(Ordering::Relaxed)
    }

    /// Asks the connection to end at once.
    pub(super) fn close(&self) {
        self.closing.store(true, Ordering::Relaxed);
        self.close.notify_one();
    }

    /// Until the connection was asked to end.
    pub(crate) async fn closed(&self) {
        self.close.notified().await;
    }
}

/// Milliseconds since `epoch`.
pub(super) fn millis_since(epoch: Instant) -> u64 {
    u64::try_from(epoch.elapsed().as_millis()).unwrap_or(u64::MAX)
}

fn phase_of(word: u64) -> Phase {
    match word & 15 {
        0 => Phase::Accepted,
        1 => Phase::Arriving,
        2 => Phase::Head,
        3 => Phase::Body,
        4 => Phase::Handling,
        5 => Phase::Answering,
        6 => Phase::Sent,
        7 => Phase::Idle,
        _ => Phase::Streaming,
    }
}
