//! Slows down whoever presents tokens that are not valid.
//!
//! A valid token is never refused for what others at its address did: behind a proxy everybody has one address, and a
//! cell must not be closed to its operators by one forgotten device. Guessing gains nothing from that, because a
//! secret has 256 random bits; what is limited is the noise and the work.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::time::Duration;

use tokio::time::Instant;

/// So many failures in a row cost nothing.
const FREE: u32 = 5;
/// The first wait after them; each further failure doubles it.
const FIRST_WAIT: Duration = Duration::from_secs(1);
/// The longest wait.
const LONGEST_WAIT: Duration = Duration::from_mins(1);
/// An address without a failure for this long starts anew.
const FORGOTTEN_AFTER: Duration = Duration::from_mins(5);
/// The most addresses remembered.
const MAX_ADDRESSES: usize = 1024;

/// The failures of each address.
#[derive(Debug, Default)]
pub(crate) struct Throttle(HashMap<Option<IpAddr>, Failures>);

#[derive(Debug)]
struct Failures {
    count: u32,
    last: Instant,
    closed_until: Instant,
}

impl Throttle {
    /// Counts a failure of an address; `None` is a caller whose address is not known.
    ///
    /// # Errors
    /// How long the address has still to wait; this attempt is not counted then.
    pub(crate) fn failed(&mut self, now: Instant, address: Option<IpAddr>) -> Result<(), Duration> {
        let address = address.map(subscriber);
        self.make_room(now, address);
        let failures = self.0.entry(address).or_insert(Failures {
            count: 0,
            last: now,
            closed_until: now,
        });
        let wait = failures.closed_until.saturating_duration_since(now);
        if !wait.is_zero() {
            return Err(wait);
        }
        if now.saturating_duration_since(failures.last) >= FORGOTTEN_AFTER {
            failures.count = 0;
        }
        failures.count = failures.count.saturating_add(1);
        failures.last = now;
        if failures.count > FREE {
            let doubled = 2_u32.saturating_pow(failures.count - FREE - 1);
            failures.closed_until = now + FIRST_WAIT.saturating_mul(doubled).min(LONGEST_WAIT);
        }
        Ok(())
    }

    fn make_room(&mut self, now: Instant, address: Option<IpAddr>) {
        if self.0.len() < MAX_ADDRESSES || self.0.contains_key(&address) {
            return;
        }
        self.0
            .retain(|_, failures| now.saturating_duration_since(failures.last) < FORGOTTEN_AFTER);
        if self.0.len() >= MAX_ADDRESSES {
            let oldest = self.0.iter().min_by_key(|(_, failures)| failures.last);
            if let Some(oldest) = oldest.map(|(address, _)| *address) {
                let _gone = self.0.remove(&oldest);
            }
        }
    }
}

/// One subscriber has a whole /64 of IPv6 addresses.
fn subscriber(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V4(address) => address.into(),
        IpAddr::V6(address) => {
            let [a, b, c, d, ..] = address.segments();
            Ipv6Addr::new(a, b, c, d, 0, 0, 0, 0).into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: Option<IpAddr> = Some(IpAddr::V4(std::net::Ipv4Addr::LOCALHOST));

    /// X12.
    #[test]
    fn the_waits_double_up_to_a_minute_and_are_forgotten() {
        let mut throttle = Throttle::default();
        let mut now = Instant::now();
        for _ in 0..FREE {
            assert_eq!(throttle.failed(now, HERE), Ok(()));
        }
        for seconds in [1, 2, 4, 8, 16, 32, 60, 60] {
            assert_eq!(throttle.failed(now, HERE), Ok(()));
            let wait = Duration::from_secs(seconds);
            assert_eq!(throttle.failed(now, HERE), Err(wait));
            now += wait;
        }
        now += FORGOTTEN_AFTER;
        for _ in 0..=FREE {
            assert_eq!(throttle.failed(now, HERE), Ok(()));
        }
    }

    #[test]
    fn one_address_does_not_close_another() {
        let mut throttle = Throttle::default();
        let now = Instant::now();
        for _ in 0..=FREE {
            let _counted = throttle.failed(now, HERE);
        }
        assert!(throttle.failed(now, HERE).is_err());
        assert_eq!(throttle.failed(now, None), Ok(()));
        assert_eq!(throttle.failed(now, "10.0.0.1".parse().ok()), Ok(()));
    }

    #[test]
    fn what_is_remembered_is_bounded() {
        let mut throttle = Throttle::default();
        let now = Instant::now();
        for number in 0..3_000_u32 {
            let address = Some(IpAddr::V4(number.into()));
            let _counted = throttle.failed(now + Duration::from_millis(number.into()), address);
        }
        assert!(throttle.0.len() <= MAX_ADDRESSES);
        let [one, other] = ["2001:db8::1", "2001:db8::2"].map(|text| text.parse().unwrap());
        assert_eq!(subscriber(one), subscriber(other));
    }
}
