use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::time::Duration;

const FIRST: Duration = Duration::from_millis(250);
const LONGEST: Duration = Duration::from_secs(8);

/// The pauses between attempts to connect: 0.25 s, doubling to 8 s, each a quarter longer or shorter by chance, so that
/// many links do not knock in step. Seeded by the robot's name: a run can be repeated.
#[derive(Debug)]
pub(super) struct Backoff {
    attempts: u32,
    random: u64,
}

impl Backoff {
    pub(super) fn new(cell: &str, robot: &str) -> Self {
        let mut hasher = DefaultHasher::new();
        (cell, robot).hash(&mut hasher);
        Self {
            attempts: 0,
            random: hasher.finish(),
        }
    }

    /// The connection proved good: begin again with the shortest pause.
    pub(super) fn reset(&mut self) {
        self.attempts = 0;
    }

    pub(super) fn next(&mut self) -> Duration {
        let doubled = FIRST.saturating_mul(1 << self.attempts.min(5));
        self.attempts = self.attempts.saturating_add(1);
        // SplitMix64.
        self.random = self.random.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.random;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^= mixed >> 31;
        let share = f64::from(u32::try_from(mixed >> 32).unwrap_or(0)) / f64::from(u32::MAX);
        doubled.min(LONGEST).mul_f64(0.75 + 0.5 * share)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pauses_double_from_a_quarter_of_a_second_to_eight_seconds_give_or_take_a_quarter() {
        let mut backoff = Backoff::new("c1", "r1");
        for expected in [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 8.0, 8.0] {
            let pause = backoff.next().as_secs_f64();
            assert!((0.75..=1.25).contains(&(pause / expected)), "{pause} s");
        }
        backoff.reset();
        assert!(backoff.next() < Duration::from_millis(313));
    }

    #[test]
    fn two_robots_do_not_knock_in_step() {
        let pauses = |robot| {
            let mut backoff = Backoff::new("c1", robot);
            [(); 4].map(|()| backoff.next())
        };
        assert_ne!(pauses("r1"), pauses("r2"));
        assert_eq!(pauses("r1"), pauses("r1"));
    }
}
