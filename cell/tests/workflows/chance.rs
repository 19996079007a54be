//! Random moments that come again with the same seed.

/// How many plugs are pulled: `ROBOCELL_KILLS`, or 200, which takes about a minute and a half of one core.
pub(crate) fn kills() -> usize {
    std::env::var("ROBOCELL_KILLS").map_or(200, |text| {
        text.parse().expect("ROBOCELL_KILLS is a number")
    })
}

/// A small generator of random numbers (SplitMix64): the same seed, the same moments.
pub(crate) struct Chance(pub(crate) u64);

impl Chance {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub(crate) fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }
}
