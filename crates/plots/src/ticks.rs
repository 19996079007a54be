//! Numbers on axes: round ones, written as short as they are.

/// The largest round step (1, 2 or 5 times a power of ten) that gives at least `least` intervals over `span`.
pub(crate) fn step(span: f64, least: f64) -> f64 {
    let raw = span / least;
    if !(raw.is_finite() && raw > 0.0) {
        return 1.0;
    }
    let power = 10f64.powf(raw.log10().floor());
    let factor = [5.0, 2.0]
        .into_iter()
        .find(|factor| factor * power <= raw)
        .unwrap_or(1.0);
    factor * power
}

/// The multiples of `step` from `low` to `high`.
pub(crate) fn multiples(low: f64, high: f64, step: f64) -> Vec<f64> {
    let mut found = Vec::new();
    let mut count = (low / step - 1e-9).ceil();
    while count * step <= high + 1e-9 * step && found.len() < 200 {
        found.push(count * step);
        count += 1.0;
    }
    found
}

/// A number without needless digits: at most six that count.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 || value.abs() < 1e-9 {
        return "0".to_owned();
    }
    let size = value.abs().log10().floor();
    if !(-4.0..=6.0).contains(&size) {
        return format!("{value:.1e}");
    }
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "0 to 9 by the check above"
    )]
    let digits = (5.0 - size).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.digits$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// The least and the greatest of `numbers`; `None` without any.
pub(crate) fn extent(numbers: impl IntoIterator<Item = f64>) -> Option<(f64, f64)> {
    numbers.into_iter().fold(None, |extent, number| {
        let (low, high) = extent.unwrap_or((number, number));
        Some((low.min(number), high.max(number)))
    })
}

/// `low` to `high` with a margin of `share` of it on both sides; a range of no width gets one.
pub(crate) fn widened((low, high): (f64, f64), share: f64) -> (f64, f64) {
    let span = high - low;
    // Rounding noise of a value that stands still is no curve.
    let tiny = (low.abs().max(high.abs()) * 1e-6).max(1e-6);
    if span <= tiny {
        let half = (low.abs() * 0.1).max(1.0);
        return (low - half, high + half);
    }
    (low - span * share, high + span * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (0.1 + 0.2, "0.3"),
            (-120.0, "-120"),
            (0.05, "0.05"),
            (1500.0, "1500"),
            (1e9, "1.0e9"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn steps_are_round() {
        assert!((step(10.0, 4.0) - 2.0).abs() < 1e-12);
        assert!((step(1.0, 4.0) - 0.2).abs() < 1e-12);
        assert!((step(730.0, 5.0) - 100.0).abs() < 1e-12);
        assert!((step(0.0, 5.0) - 1.0).abs() < 1e-12);
        assert_eq!(multiples(-0.5, 1.0, 0.5), [-0.5, 0.0, 0.5, 1.0]);
    }

    #[test]
    fn what_stands_still_still_has_an_axis() {
        assert_eq!(widened((5.0, 5.0), 0.1), (4.0, 6.0));
        assert_eq!(widened((0.0, 10.0), 0.1), (-1.0, 11.0));
    }
}
