//! Polynomials of degree up to five in normalised time.

use crate::state::State;

/// The largest magnitudes along a curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extremes {
    /// Of the position.
    pub position: f64,
    /// Of the velocity.
    pub velocity: f64,
    /// Of the acceleration.
    pub acceleration: f64,
}

impl Extremes {
    pub(crate) fn join(self, other: Extremes) -> Extremes {
        Extremes {
            position: larger(self.position, other.position),
            velocity: larger(self.velocity, other.velocity),
            acceleration: larger(self.acceleration, other.acceleration),
        }
    }
}

/// Not `f64::max`, which would drop a NaN.
fn larger(a: f64, b: f64) -> f64 {
    if a >= b || a.is_nan() { a } else { b }
}

/// `sum of c_i tau^i`, tau from 0 to 1 over `duration` seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Polynomial {
    pub(crate) c: [f64; 6],
    pub(crate) duration: f64,
}

impl Polynomial {
    /// At `t` seconds after its start. (2.12)-(2.14) of the textbook, the derivatives divided by the
    /// duration and its square.
    pub(crate) fn at(&self, t: f64) -> State {
        let tau = t / self.duration;
        let [value, first, second] = derivatives(&self.c, tau);
        State {
            position: value,
            velocity: first / self.duration,
            acceleration: second / (self.duration * self.duration),
        }
    }

    /// The largest magnitudes between its ends, exact: each is at an end or where the next
    /// derivative is zero.
    pub(crate) fn extremes(&self) -> Extremes {
        let zero_of = |order: usize| roots_in_unit(&derived(&self.c, order));
        let at = |tau: f64| self.at(tau * self.duration);
        let largest = |order: usize, part: fn(&State) -> f64| {
            zero_of(order)
                .into_iter()
                .chain([0.0, 1.0])
                .map(|tau| part(&at(tau)).abs())
                .fold(0.0, larger)
        };
        Extremes {
            position: largest(1, |state| state.position),
            velocity: largest(2, |state| state.velocity),
            acceleration: largest(3, |state| state.acceleration),
        }
    }
}

/// Value, first and second derivative in tau, by Horner's rule.
fn derivatives(c: &[f64; 6], tau: f64) -> [f64; 3] {
    let rows = c.iter().rev();
    let [value, first, half_second] = rows.fold([0.0; 3], |[value, first, half_second], &c| {
        [
            value * tau + c,
            first * tau + value,
            half_second * tau + first,
        ]
    });
    [value, first, 2.0 * half_second]
}

fn value(c: &[f64], x: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, &c| sum * x + c)
}

/// The coefficients of the derivative of this order.
fn derived(c: &[f64], order: usize) -> Vec<f64> {
    (0..order).fold(c.to_vec(), |c, _| {
        c.iter()
            .zip(0_u8..)
            .skip(1)
            .map(|(c, power)| c * f64::from(power))
            .collect()
    })
}

/// The real roots from 0 to 1: between two neighboring extremes there is at most one.
fn roots_in_unit(c: &[f64]) -> Vec<f64> {
    if c.len() < 2 {
        return Vec::new();
    }
    let mut edges = vec![0.0];
    edges.extend(roots_in_unit(&derived(c, 1)));
    edges.push(1.0);
    let pairs = edges.iter().zip(edges.iter().skip(1));
    pairs
        .filter_map(|(&from, &to)| bisected(c, from, to))
        .collect()
}

fn bisected(c: &[f64], mut from: f64, mut to: f64) -> Option<f64> {
    let (at_from, at_to) = (value(c, from), value(c, to));
    if at_from == 0.0 {
        return Some(from);
    }
    if (at_from < 0.0) == (at_to < 0.0) || at_to == 0.0 {
        return (at_to == 0.0).then_some(to);
    }
    for _ in 0..60 {
        let middle = 0.5 * (from + to);
        if value(c, middle) * at_from > 0.0 {
            from = middle;
        } else {
            to = middle;
        }
    }
    Some(0.5 * (from + to))
}
