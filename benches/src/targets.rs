//! A table of what was measured beside what was wanted.

use crate::compare::Comparison;

/// Prints its rows as they come.
#[derive(Debug)]
pub struct Table(());

#[expect(
    clippy::print_stdout,
    reason = "the table is what these programs are for"
)]
impl Table {
    /// Begins a table of ratios.
    #[must_use]
    pub fn new(title: &str) -> Self {
        println!(
            "\n{title:<46} {:>9} {:>9} {:>9} {:>9}",
            "ours, ns", "peer, ns", "ratio", "target"
        );
        Self(())
    }

    /// A row; the ratio is to reach `target`, if there is one.
    pub fn ratio(&self, name: &str, found: Comparison, target: Option<f64>) {
        let Comparison {
            ours_ns,
            peer_ns,
            ratio,
        } = found;
        let (wanted, verdict) = target.map_or((String::new(), ""), |target| {
            (format!("{target:.1}x"), verdict(ratio >= target))
        });
        println!("{name:<46} {ours_ns:>9.0} {peer_ns:>9.0} {ratio:>8.2}x {wanted:>9} {verdict}");
    }

    /// A row of one number that is to stay at or below `target`.
    pub fn at_most(&self, name: &str, found: f64, target: f64) {
        let verdict = verdict(found <= target);
        let short = |value: f64| {
            if value == 0.0 || value.abs() >= 1e-3 {
                format!("{value:.3}")
            } else {
                format!("{value:.1e}")
            }
        };
        println!(
            "{name:<46} {:>9} {:>9} {:>9} {:>9} {verdict}",
            short(found),
            "",
            "",
            short(target)
        );
    }
}

fn verdict(met: bool) -> &'static str {
    if met { "met" } else { "MISSED" }
}
