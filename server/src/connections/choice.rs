//! Which connection is closed for one that has no place. Pure, so that the rule can be tested by itself.

use std::net::{IpAddr, Ipv6Addr};

use super::standing::{Phase, Seen};

/// How long a request is worked on before its connection may have to go, in milliseconds.
const PATIENCE_MS: u64 = 1_000;

/// How long a peer may keep the server waiting before it counts as slow, in milliseconds: a round trip, and the time a
/// busy machine takes to look at what has come.
const GRACE_MS: u64 = 100;

/// Whom a connection is counted for: an IPv4 address, or the first 64 bits of an IPv6 address, which one caller has
/// for itself.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub(crate) struct Host(IpAddr);

impl Host {
    pub(crate) fn of(address: IpAddr) -> Self {
        Self(match address.to_canonical() {
            IpAddr::V6(address) => {
                let network = u128::from(address) >> 64 << 64;
                IpAddr::V6(Ipv6Addr::from(network))
            }
            address @ IpAddr::V4(_) => address,
        })
    }
}

/// Why a connection can be closed for another one; the later kinds go first.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub(crate) enum Dispensable {
    /// Its request takes long, which need not be its peer's fault.
    Slow,
    /// It is between two requests.
    Idle,
    /// Its peer has just begun to keep the server waiting.
    Fresh,
    /// Its peer keeps the server waiting.
    Waiting,
}

impl Seen {
    /// Whether the connection can be closed for another one at `now`, in milliseconds since the epoch.
    pub(super) fn dispensable(&self, now: u64) -> Option<Dispensable> {
        let age = now.saturating_sub(self.since);
        let waiting = if age > GRACE_MS {
            Dispensable::Waiting
        } else {
            Dispensable::Fresh
        };
        match self.phase {
            Phase::Arriving | Phase::Head | Phase::Body => Some(waiting),
            Phase::Answering | Phase::Sent => self.blocked_since.map(|_| waiting),
            Phase::Idle => Some(Dispensable::Idle),
            Phase::Handling => (age > PATIENCE_MS).then_some(Dispensable::Slow),
            // The one is about to be looked at, the other holds none of the places.
            Phase::Accepted | Phase::Streaming => None,
        }
    }
}

/// A connection that can be closed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub(super) id: u64,
    pub(super) host: Host,
    pub(super) kind: Dispensable,
    /// Milliseconds since the epoch.
    pub(super) since: u64,
}

/// The one to close: of the most dispensable kind, of the host that has most of that kind, the oldest.
pub(super) fn choose(candidates: &mut Vec<Candidate>) -> Option<u64> {
    let kind = candidates.iter().map(|candidate| candidate.kind).max()?;
    candidates.retain(|candidate| candidate.kind == kind);
    candidates.sort_unstable_by_key(|candidate| (candidate.host, candidate.since, candidate.id));
    candidates
        .chunk_by(|one, next| one.host == next.host)
        .filter_map(|of_host| of_host.first().map(|oldest| (of_host.len(), oldest)))
        // Among hosts with as many, the oldest of all.
        .max_by_key(|(count, oldest)| (*count, std::cmp::Reverse((oldest.since, oldest.id))))
        .map(|(_, oldest)| oldest.id)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn host(last: u8) -> Host {
        Host::of(IpAddr::from([192, 0, 2, last]))
    }

    fn candidate(id: u64, last: u8, kind: Dispensable, since: u64) -> Candidate {
        Candidate {
            id,
            host: host(last),
            kind,
            since,
        }
    }

    #[test]
    fn whoever_keeps_the_server_waiting_goes_before_whoever_is_idle_or_slow() {
        use Dispensable::{Idle, Slow, Waiting};
        let mut all = vec![
            candidate(1, 1, Slow, 0),
            candidate(2, 1, Idle, 1),
            candidate(3, 1, Idle, 2),
            candidate(4, 2, Waiting, 9_999),
        ];
        assert_eq!(choose(&mut all.clone()), Some(4));
        all.truncate(3);
        assert_eq!(choose(&mut all.clone()), Some(2));
        all.truncate(1);
        assert_eq!(choose(&mut all), Some(1));
        assert_eq!(choose(&mut Vec::new()), None);
    }

    #[test]
    fn the_host_with_most_pays_and_among_equals_the_oldest() {
        use Dispensable::Waiting;
        let mut all = vec![
            candidate(1, 1, Waiting, 0),
            candidate(2, 2, Waiting, 50),
            candidate(3, 2, Waiting, 40),
        ];
        assert_eq!(choose(&mut all.clone()), Some(3), "the oldest of host 2");
        all.push(candidate(4, 1, Waiting, 60));
        assert_eq!(choose(&mut all), Some(1), "both have two");
    }

    #[test]
    fn a_request_that_is_worked_on_is_left_alone_for_a_second() {
        let seen = |phase, blocked_since| Seen {
            phase,
            since: 1_000,
            blocked_since,
        };
        let handling = seen(Phase::Handling, None);
        assert_eq!(handling.dispensable(2_000), None);
        assert_eq!(handling.dispensable(2_001), Some(Dispensable::Slow));
        assert_eq!(seen(Phase::Answering, None).dispensable(9_000), None);
        let slow_reader = seen(Phase::Answering, Some(1_500));
        assert_eq!(slow_reader.dispensable(1_501), Some(Dispensable::Waiting));
        assert_eq!(seen(Phase::Accepted, None).dispensable(9_000), None);
        assert_eq!(seen(Phase::Streaming, Some(1)).dispensable(9_000), None);
    }

    #[test]
    fn a_peer_has_a_moment_before_it_counts_as_slow() {
        let arriving = Seen {
            phase: Phase::Arriving,
            since: 1_000,
            blocked_since: None,
        };
        assert_eq!(arriving.dispensable(1_100), Some(Dispensable::Fresh));
        assert_eq!(arriving.dispensable(1_101), Some(Dispensable::Waiting));
        let mut all = vec![
            candidate(1, 1, Dispensable::Fresh, 1_000),
            candidate(2, 1, Dispensable::Fresh, 1_001),
            candidate(3, 2, Dispensable::Waiting, 1_050),
            candidate(4, 2, Dispensable::Idle, 0),
        ];
        assert_eq!(choose(&mut all.clone()), Some(3));
        let _slow = all.remove(2);
        assert_eq!(choose(&mut all), Some(1), "the idle one stays");
    }

    #[test]
    fn a_caller_with_a_whole_ipv6_network_is_one_host() {
        let of = |text: &str| Host::of(text.parse().unwrap());
        assert_eq!(of("2001:db8:0:1::1"), of("2001:db8:0:1:ffff::2"));
        assert_ne!(of("2001:db8:0:1::1"), of("2001:db8:0:2::1"));
        assert_eq!(of("::ffff:192.0.2.1"), of("192.0.2.1"));
        assert_ne!(of("192.0.2.1"), of("192.0.2.2"));
    }
}
