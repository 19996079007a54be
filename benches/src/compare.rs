//! Running variants in turn, and the median of what comes out.

use std::hint::black_box;

use rustix::time::{ClockId, clock_gettime};

/// What one comparison came to.
#[derive(Clone, Copy, Debug)]
pub struct Comparison {
    /// Nanoseconds an item, median over the repeats.
    pub ours_ns: f64,
    /// The same for the peer.
    pub peer_ns: f64,
    /// How many times faster ours is: the median of the repeats' ratios, not the ratio of the
    /// medians.
    pub ratio: f64,
}

/// Runs `ours` and `peer` over all items, in turn, `repeats` times, and throws away one round to
/// warm up.
pub fn compare<T, A, B>(
    items: &[T],
    repeats: usize,
    mut ours: impl FnMut(&T) -> A,
    mut peer: impl FnMut(&T) -> B,
) -> Comparison {
    in_turn(
        repeats,
        || time(items, &mut ours),
        || time(items, &mut peer),
    )
}

/// The same for variants that say themselves how many nanoseconds an item took, as a peer in
/// another process does.
pub fn in_turn(
    repeats: usize,
    mut ours: impl FnMut() -> f64,
    mut peer: impl FnMut() -> f64,
) -> Comparison {
    let _ = (ours(), peer());
    let rounds: Vec<(f64, f64)> = (0..repeats).map(|_| (ours(), peer())).collect();
    Comparison {
        ours_ns: median(rounds.iter().map(|(ours, _)| *ours).collect()),
        peer_ns: median(rounds.iter().map(|(_, peer)| *peer).collect()),
        ratio: median(rounds.iter().map(|(ours, peer)| peer / ours).collect()),
    }
}

/// Nanoseconds an item, of this thread's CPU time.
pub fn time<T, A>(items: &[T], run: &mut impl FnMut(&T) -> A) -> f64 {
    let start = cpu_seconds();
    for item in items {
        // By reference: a result is looked at where it is, not copied.
        let _ = black_box(&run(black_box(item)));
    }
    let items = u32::try_from(items.len()).map_or(f64::MAX, f64::from);
    (cpu_seconds() - start) * 1e9 / items
}

/// What this thread has used of a processor: whoever else wants it does not count.
#[must_use]
pub fn cpu_seconds() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    std::time::Duration::try_from(time).map_or(f64::NAN, |time| time.as_secs_f64())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
