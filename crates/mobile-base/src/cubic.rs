//! Cubic interpolation in one coordinate.

/// A cubic polynomial of the parameter from the start of its segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Cubic {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
}

impl Cubic {
    pub(crate) fn value(&self, t: f64) -> f64 {
        self.a + t * (self.b + t * (self.c + t * self.d))
    }

    /// First derivative.
    pub(crate) fn slope(&self, t: f64) -> f64 {
        self.b + t * (2.0 * self.c + 3.0 * t * self.d)
    }

    /// Second derivative.
    pub(crate) fn bend(&self, t: f64) -> f64 {
        2.0 * self.c + 6.0 * t * self.d
    }
}

/// The cubic spline through `values` over segments of these positive `lengths`, one segment fewer
/// than values; with the slopes at its ends, or without curvature there.
///
/// The second derivatives at the knots solve a tridiagonal system, [de Boor, A Practical Guide to
/// Splines, ch. IV], which is diagonally dominant: elimination needs no pivots.
pub(crate) fn interpolate(
    values: &[f64],
    lengths: &[f64],
    end_slopes: Option<(f64, f64)>,
) -> Vec<Cubic> {
    let chords: Vec<Chord> = values
        .iter()
        .zip(values.iter().skip(1))
        .zip(lengths)
        .map(|((&from, &to), &length)| Chord {
            from,
            length,
            slope: (to - from) / length,
        })
        .collect();
    let bends = bends(&chords, end_slopes);
    let pairs = bends.iter().zip(bends.iter().skip(1));
    chords
        .iter()
        .zip(pairs)
        .map(|(chord, (before, after))| Cubic {
            a: chord.from,
            b: chord.slope - chord.length * (2.0 * before + after) / 6.0,
            c: 0.5 * before,
            d: (after - before) / (6.0 * chord.length),
        })
        .collect()
}

struct Chord {
    from: f64,
    length: f64,
    slope: f64,
}

/// A row of the system: `below * m[i-1] + diagonal * m[i] + above * m[i+1] = right`.
struct Row {
    below: f64,
    diagonal: f64,
    above: f64,
    right: f64,
}

/// Second derivatives at the knots.
fn bends(chords: &[Chord], end_slopes: Option<(f64, f64)>) -> Vec<f64> {
    let (Some(first), Some(last)) = (chords.first(), chords.last()) else {
        return Vec::new();
    };
    let flat = || Row {
        below: 0.0,
        diagonal: 1.0,
        above: 0.0,
        right: 0.0,
    };
    let inner = chords
        .iter()
        .zip(chords.iter().skip(1))
        .map(|(left, right)| Row {
            below: left.length,
            diagonal: 2.0 * (left.length + right.length),
            above: right.length,
            right: 6.0 * (right.slope - left.slope),
        });
    let (start, end) = end_slopes.map_or_else(
        || (flat(), flat()),
        |(start, end)| {
            let start = Row {
                below: 0.0,
                diagonal: 2.0 * first.length,
                above: first.length,
                right: 6.0 * (first.slope - start),
            };
            let end = Row {
                below: last.length,
                diagonal: 2.0 * last.length,
                above: 0.0,
                right: 6.0 * (end - last.slope),
            };
            (start, end)
        },
    );
    solve([start].into_iter().chain(inner).chain([end]))
}

/// Gaussian elimination for a tridiagonal system.
fn solve(rows: impl Iterator<Item = Row>) -> Vec<f64> {
    let (mut above, mut right) = (0.0, 0.0);
    let mut reduced: Vec<(f64, f64)> = rows
        .map(|row| {
            let diagonal = row.diagonal - row.below * above;
            right = (row.right - row.below * right) / diagonal;
            above = row.above / diagonal;
            (above, right)
        })
        .collect();
    let mut after = 0.0;
    for (above, right) in reduced.iter_mut().rev() {
        *right -= *above * after;
        after = *right;
    }
    reduced.into_iter().map(|(_, solution)| solution).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_natural_spline_through_a_tent_is_as_by_hand() {
        // Values 0, 1, 0 at 0, 1, 2: m1 solves 2 (1 + 1) m1 = 6 (-1 - 1), m1 = -3. The first segment
        // is then 1.5 t - 0.5 t^3.
        let cubics = interpolate(&[0.0, 1.0, 0.0], &[1.0, 1.0], None);
        let wanted = Cubic {
            a: 0.0,
            b: 1.5,
            c: 0.0,
            d: -0.5,
        };
        assert_eq!(cubics[0], wanted);
        assert!((cubics[0].value(0.5) - 0.6875).abs() < 1e-15);
    }

    #[test]
    fn a_clamped_spline_reproduces_a_cubic() {
        // y = x^3 - x at 0, 1, 3, 4: slopes -1 and 47.
        let cubics = interpolate(
            &[0.0, 0.0, 24.0, 60.0],
            &[1.0, 2.0, 1.0],
            Some((-1.0, 47.0)),
        );
        let middle = cubics[1];
        // At x = 2: 6, slope 11, second derivative 12.
        assert!((middle.value(1.0) - 6.0).abs() < 1e-12);
        assert!((middle.slope(1.0) - 11.0).abs() < 1e-12);
        assert!((middle.bend(1.0) - 12.0).abs() < 1e-12);
    }

    #[test]
    fn segments_meet_with_the_same_slope_and_bend() {
        let lengths = [3.0, 1.0, 2.5, 0.7];
        let cubics = interpolate(&[1.0, -2.0, 5.0, 4.0, 4.5], &lengths, None);
        for ((left, right), length) in cubics.iter().zip(&cubics[1..]).zip(lengths) {
            assert!((left.value(length) - right.value(0.0)).abs() < 1e-12);
            assert!((left.slope(length) - right.slope(0.0)).abs() < 1e-12);
            assert!((left.bend(length) - right.bend(0.0)).abs() < 1e-12);
        }
    }
}
