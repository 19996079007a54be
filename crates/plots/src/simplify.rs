//! Fewer points for the same curve.

/// The points of `line` that make a difference of more than `tolerance` (in the units of the points), ends included:
/// the method of Ramer (1972) and of Douglas and Peucker (1973).
pub(crate) fn simplified(line: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let Some(last) = line.len().checked_sub(1).filter(|last| *last > 1) else {
        return line.to_vec();
    };
    let mut keep = vec![false; line.len()];
    let mut open = vec![(0, last)];
    while let Some((from, to)) = open.pop() {
        for end in [from, to] {
            if let Some(kept) = keep.get_mut(end) {
                *kept = true;
            }
        }
        let (Some(&a), Some(&b), Some(between)) =
            (line.get(from), line.get(to), line.get(from + 1..to))
        else {
            continue;
        };
        let farthest = between
            .iter()
            .enumerate()
            .map(|(index, &point)| (from + 1 + index, distance(point, a, b)))
            .max_by(|one, other| one.1.total_cmp(&other.1));
        if let Some((index, off)) = farthest
            && off > tolerance
        {
            open.extend([(from, index), (index, to)]);
        }
    }
    line.iter()
        .zip(keep)
        .filter_map(|(&point, kept)| kept.then_some(point))
        .collect()
}

/// From `point` to the segment from `a` to `b`.
fn distance(point: (f64, f64), a: (f64, f64), b: (f64, f64)) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length = dx * dx + dy * dy;
    let along = if length > 0.0 {
        (((point.0 - a.0) * dx + (point.1 - a.1) * dy) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (point.0 - a.0 - along * dx).hypot(point.1 - a.1 - along * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_needs_two_points_and_a_corner_a_third() {
        let straight: Vec<_> = (0..100)
            .map(|n| (f64::from(n), 2.0 * f64::from(n)))
            .collect();
        assert_eq!(simplified(&straight, 0.01), [(0.0, 0.0), (99.0, 198.0)]);
        let corner = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (2.0, 2.0)];
        assert_eq!(
            simplified(&corner, 0.01),
            [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)]
        );
    }

    #[test]
    fn what_is_left_is_nowhere_farther_than_the_tolerance() {
        let wave: Vec<_> = (0..=1000)
            .map(|n| (f64::from(n), 100.0 * (f64::from(n) / 100.0).sin()))
            .collect();
        let few = simplified(&wave, 0.25);
        assert!(few.len() < 200, "{}", few.len());
        for &point in &wave {
            let off = few
                .windows(2)
                .map(|pair| distance(point, pair[0], pair[1]))
                .fold(f64::INFINITY, f64::min);
            assert!(off <= 0.25, "{point:?}: {off}");
        }
    }
}
