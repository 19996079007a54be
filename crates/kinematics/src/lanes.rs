//! Several numbers at once: the four arm postures of a pose go through the same arithmetic side by
//! side.
//!
//! Plain arrays and loops of a fixed length, which the compiler turns into vector instructions.
//! There are no branches: what a posture does not have is computed all the same and discarded at
//! the end.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it, and a call a lane would undo the point of lanes"
)]

use std::ops::{Add, Mul, Neg, Sub};

/// `N` numbers, each in its own lane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(transparent)]
pub(crate) struct Lanes<const N: usize>(pub(crate) [f64; N]);

impl<const N: usize> Lanes<N> {
    /// The same number in every lane.
    #[inline(always)]
    pub(crate) fn all(value: f64) -> Self {
        Self([value; N])
    }

    #[inline(always)]
    pub(crate) fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        // Not the array's own `map`, which is not always inlined.
        for a in &mut self.0 {
            *a = f(*a);
        }
        self
    }

    /// Which lanes are so.
    #[inline(always)]
    pub(crate) fn test(self, f: impl Fn(f64) -> bool) -> [bool; N] {
        let mut which = [false; N];
        for (which, a) in which.iter_mut().zip(self.0) {
            *which = f(a);
        }
        which
    }

    #[inline(always)]
    pub(crate) fn zip(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a = f(*a, b);
        }
        self
    }

    /// With the lanes that are `which` taken from `other`.
    #[inline(always)]
    pub(crate) fn replaced(mut self, which: [bool; N], other: Self) -> Self {
        for ((lane, which), other) in self.0.iter_mut().zip(which).zip(other.0) {
            if which {
                *lane = other;
            }
        }
        self
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        self.map(f64::sqrt)
    }

    /// `1 / self`
    #[inline(always)]
    pub(crate) fn recip(self) -> Self {
        self.map(|a| 1.0 / a)
    }
}

impl<const N: usize> Add for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<const N: usize> Sub for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<const N: usize> Mul for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl<const N: usize> Neg for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

/// A number is the same in every lane.
impl<const N: usize> Add<f64> for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: f64) -> Self {
        self.map(|a| a + other)
    }
}

impl<const N: usize> Sub<f64> for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: f64) -> Self {
        self.map(|a| a - other)
    }
}

impl<const N: usize> Mul<f64> for Lanes<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: f64) -> Self {
        self.map(|a| a * other)
    }
}

/// Rows become columns: what belongs to one lane, side by side.
#[inline(always)]
pub(crate) fn transpose<const ROWS: usize, const N: usize>(
    rows: &[Lanes<N>; ROWS],
) -> [[f64; ROWS]; N] {
    let mut columns = [[0.0; ROWS]; N];
    let mut index = 0;
    while index < ROWS {
        if let Some(row) = rows.get(index) {
            for (column, value) in columns.iter_mut().zip(row.0) {
                if let Some(cell) = column.get_mut(index) {
                    *cell = value;
                }
            }
        }
        index += 1;
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_columns() {
        let rows = [Lanes([1.0, 2.0, 3.0]), Lanes([4.0, 5.0, 6.0])];
        assert_eq!(transpose(&rows), [[1.0, 4.0], [2.0, 5.0], [3.0, 6.0]]);
    }
}
