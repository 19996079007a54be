//! Which HTTP request is behind a TCP peer.
//!
//! The wire carries no request id: a real controller would not read it. Where the server and the emulator share one
//! process, the server notes the id under the local address of its connection, and the emulator looks it up when
//! bytes arrive, so that one id runs from the HTTP log to the ledger.

use std::collections::{HashMap, VecDeque};
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// How many labels are kept; the oldest makes room.
const CAPACITY: usize = 4096;

/// A bounded map from peer address to request id. Clones share it.
#[derive(Clone, Debug, Default)]
pub struct PeerLabels {
    shared: Arc<Mutex<Labels>>,
}

#[derive(Debug, Default)]
struct Labels {
    by_peer: HashMap<SocketAddr, String>,
    oldest_first: VecDeque<SocketAddr>,
}

impl PeerLabels {
    /// An empty map.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Notes that the bytes from `peer` belong to `request_id`. Call it before the first byte is sent.
    pub fn set(&self, peer: SocketAddr, request_id: impl Into<String>) {
        let mut labels = self.lock();
        if labels.by_peer.insert(peer, request_id.into()).is_some() {
            return;
        }
        labels.oldest_first.push_back(peer);
        if labels.oldest_first.len() > CAPACITY
            && let Some(oldest) = labels.oldest_first.pop_front()
        {
            let _label = labels.by_peer.remove(&oldest);
        }
    }

    /// The request behind `peer`.
    #[must_use]
    pub fn get(&self, peer: SocketAddr) -> Option<String> {
        self.lock().by_peer.get(&peer).cloned()
    }

    fn lock(&self) -> MutexGuard<'_, Labels> {
        // Every write leaves the map whole, so a panic elsewhere does not spoil it.
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn peer(port: u16) -> SocketAddr {
        SocketAddr::from(([127, 0, 0, 1], port))
    }

    #[test]
    fn clones_share_the_labels_and_the_newest_wins() {
        let labels = PeerLabels::new();
        labels.clone().set(peer(1), "first");
        labels.set(peer(1), "second");
        assert_eq!(labels.get(peer(1)).as_deref(), Some("second"));
        assert_eq!(labels.get(peer(2)), None);
    }

    #[test]
    fn the_map_stays_bounded() {
        let labels = PeerLabels::new();
        for port in 0..=4096 {
            labels.set(peer(port), "x");
        }
        assert_eq!(labels.lock().by_peer.len(), CAPACITY);
        assert_eq!(labels.get(peer(0)), None, "the oldest made room");
    }
}
