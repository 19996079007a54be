//! The real roots of a polynomial of degree four, multiple ones too.

/// A value below this part of the sum of its terms' magnitudes is zero.
const ZERO: f64 = 1e-13;

/// A real root.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Root {
    pub(crate) at: f64,
    /// The polynomial touches zero without crossing it: a root of even multiplicity.
    pub(crate) double: bool,
}

/// The real roots of `c0 + c1 t + .. + c4 t^4`, in ascending order, each once.
///
/// Between two neighboring extremes a polynomial crosses zero at most once, and its extremes are
/// the roots of its derivative; so the roots are found from the line upwards. An extreme whose
/// value is zero within rounding is a double root: where a formula with radicals, or an
/// eigenvalue, would give a pair of complex numbers.
pub(crate) fn real_roots(coefficients: &[f64; 5]) -> Vec<Root> {
    let largest = coefficients.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    if largest == 0.0 || !largest.is_finite() {
        return Vec::new();
    }
    let mut terms: Vec<f64> = coefficients.iter().map(|c| c / largest).collect();
    while terms.last().is_some_and(|c| c.abs() < 1e-15) {
        let _ = terms.pop();
    }
    roots_of(&terms)
}

fn roots_of(c: &[f64]) -> Vec<Root> {
    let single = |at| Root { at, double: false };
    let degree = c.len().saturating_sub(1);
    let (Some(&constant), Some(&leading)) = (c.first(), c.last()) else {
        return Vec::new();
    };
    match degree {
        0 => return Vec::new(),
        1 => return vec![single(-constant / leading)],
        _ => {}
    }
    let derivative: Vec<f64> = c
        .iter()
        .zip(0_u32..)
        .skip(1)
        .map(|(c, power)| c * f64::from(power))
        .collect();
    let extremes = roots_of(&derivative);
    // All roots are inside (Cauchy).
    let bound = 1.0 + c.iter().fold(0.0_f64, |m, c| m.max((c / leading).abs()));
    let mut ends = vec![-bound];
    ends.extend(extremes.iter().map(|root| root.at));
    ends.push(bound);
    let mut roots: Vec<Root> = Vec::new();
    let mut add = |root: Root| {
        let close = 1e-14 * (1.0 + root.at.abs());
        if roots.last().is_none_or(|last| root.at - last.at > close) {
            roots.push(root);
        }
    };
    for (index, (&low, &high)) in ends.iter().zip(ends.iter().skip(1)).enumerate() {
        if index > 0 && is_zero(c, low) {
            add(Root {
                at: low,
                double: true,
            });
        }
        let zero_at_end =
            (index > 0 && is_zero(c, low)) || (index + 2 < ends.len() && is_zero(c, high));
        let (at_low, at_high) = (value(c, low), value(c, high));
        if at_low * at_high < 0.0 && !(zero_at_end && is_flat(c, low, high)) {
            add(single(bisect(c, low, high)));
        }
    }
    roots
}

/// Is the polynomial zero within rounding on all of a short interval?
fn is_flat(c: &[f64], low: f64, high: f64) -> bool {
    high - low < 1e-6 * (1.0 + low.abs()) && is_zero(c, f64::midpoint(low, high))
}

fn value(c: &[f64], t: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

fn is_zero(c: &[f64], t: f64) -> bool {
    let size = c.iter().rev().fold(0.0, |sum, c| sum * t.abs() + c.abs());
    value(c, t).abs() <= ZERO * size
}

/// The one crossing between `low` and `high`: Newton's steps, and halving where they leave the
/// interval.
fn bisect(c: &[f64], mut low: f64, mut high: f64) -> f64 {
    let rising = value(c, high) > 0.0;
    let slope = |t: f64| {
        let mut slope = 0.0;
        let mut value = 0.0;
        for c in c.iter().rev() {
            slope = slope * t + value;
            value = value * t + c;
        }
        (value, slope)
    };
    let mut t = f64::midpoint(low, high);
    for _ in 0..200 {
        let (f, df) = slope(t);
        if f == 0.0 {
            return t;
        }
        if (f > 0.0) == rising {
            high = t;
        } else {
            low = t;
        }
        let newton = t - f / df;
        let next = if newton > low && newton < high {
            newton
        } else {
            f64::midpoint(low, high)
        };
        if (next - t).abs() <= 1e-16 * (1.0 + t.abs()) {
            return next;
        }
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The coefficients of (t - a)(t - b)(t - c)(t - d).
    fn of_roots(roots: [f64; 4]) -> [f64; 5] {
        let mut c = [1.0, 0.0, 0.0, 0.0, 0.0];
        for (degree, root) in roots.into_iter().enumerate() {
            for k in (0..=degree + 1).rev() {
                c[k] = if k == 0 { 0.0 } else { c[k - 1] } - root * c[k];
            }
        }
        c
    }

    fn assert_roots(c: &[f64; 5], wanted: &[(f64, bool)], close: f64) {
        let found = real_roots(c);
        assert_eq!(found.len(), wanted.len(), "{found:?} {wanted:?}");
        for (root, (at, double)) in found.iter().zip(wanted) {
            assert!((root.at - at).abs() < close, "{found:?} {wanted:?}");
            assert_eq!(root.double, *double, "{found:?}");
        }
    }

    #[test]
    fn single_roots_are_found_to_the_last_digits() {
        let wanted = [-2.0, -0.5, 1.0, 3.0].map(|at| (at, false));
        assert_roots(&of_roots([-2.0, -0.5, 1.0, 3.0]), &wanted, 1e-13);
        // t^4 + 1 has none; t^4 - 1 has two.
        assert_roots(&[1.0, 0.0, 0.0, 0.0, 1.0], &[], 1e-14);
        let two = [(-1.0, false), (1.0, false)];
        assert_roots(&[-1.0, 0.0, 0.0, 0.0, 1.0], &two, 1e-14);
    }

    #[test]
    fn double_roots_are_found_though_nothing_changes_sign() {
        // (t - 1)^2 (t + 2)^2, and (t - 1)^2 (t^2 + 1).
        assert_roots(
            &of_roots([1.0, 1.0, -2.0, -2.0]),
            &[(-2.0, true), (1.0, true)],
            1e-9,
        );
        assert_roots(&[1.0, -2.0, 2.0, -2.0, 1.0], &[(1.0, true)], 1e-9);
        // A triple root crosses zero, and is one of its own derivative.
        let found = real_roots(&of_roots([0.5, 0.5, 0.5, -1.0]));
        assert!(found.iter().any(|root| (root.at - 0.5).abs() < 1e-4));
        assert!(found.iter().any(|root| (root.at + 1.0).abs() < 1e-12));
    }

    #[test]
    fn a_vanishing_leading_term_lowers_the_degree() {
        assert_roots(
            &[-6.0, 5.0, -1.0, 0.0, 0.0],
            &[(2.0, false), (3.0, false)],
            1e-13,
        );
        assert_roots(&[-6.0, 2.0, 0.0, 0.0, 0.0], &[(3.0, false)], 1e-14);
        assert!(real_roots(&[0.0; 5]).is_empty());
        assert!(real_roots(&[f64::NAN; 5]).is_empty());
    }
}
