//! Several numbers at once: the four arm postures of a pose, or four poses, go through the same
//! arithmetic side by side.
//!
//! A [`Lane`] is a vector register of four numbers, with whatever instructions the machine has: the
//! crate `fearless_simd` picks them at run time. There are no branches: what a posture does not
//! have is computed all the same and discarded at the end.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use std::ops::{Add, Mul, Neg, Sub};

use crate::joints::PendantJoints;

pub(crate) use fearless_simd::prelude::*;
pub(crate) use fearless_simd::{Level, dispatch, mask64x4};

/// Which instructions a model's functions are made of; see [`crate::ArmModel::with`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Instructions {
    /// What every machine of this kind has.
    Portable,
    /// AVX2 with fused multiplication and addition, of x86 processors.
    Avx2,
    /// The best of this machine.
    Best,
}

impl Instructions {
    pub(crate) fn level(self) -> Option<Level> {
        match self {
            Instructions::Portable => Some(Level::baseline()),
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Instructions::Avx2 => Level::new().as_avx2().map(Level::Avx2),
            #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
            Instructions::Avx2 => None,
            Instructions::Best => Some(Level::new()),
        }
    }
}

/// The instructions for one pose: its registers are four numbers wide in any case, and AVX2 is
/// faster with them than AVX-512, whose masks take longer.
pub(crate) fn for_one(level: Level) -> Level {
    #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
    if let Some(avx2) = level.as_avx2() {
        return Level::Avx2(avx2);
    }
    level
}

/// Four numbers.
pub(crate) type Lane<S> = fearless_simd::f64x4<S>;

/// How many numbers a [`Lane`] has.
pub(crate) const LANES: usize = 4;

/// A number, or four of them.
pub(crate) trait Number:
    Copy
    + Neg<Output = Self>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Add<f64, Output = Self>
    + Sub<f64, Output = Self>
    + Mul<f64, Output = Self>
{
    /// `self * factor + summand`, rounded once where the machine can.
    fn times_plus(self, factor: Self, summand: Self) -> Self;

    /// The same with a factor for all lanes.
    fn scaled_plus(self, factor: f64, summand: Self) -> Self;

    /// A number in as many lanes as this one has.
    fn like(self, value: f64) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn times_plus(self, factor: Self, summand: Self) -> Self {
        // Not mul_add, which is a call into the C library where the machine does not have it.
        self * factor + summand
    }

    #[inline(always)]
    fn scaled_plus(self, factor: f64, summand: Self) -> Self {
        self * factor + summand
    }

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        value
    }
}

/// One number, which is multiplied and added in one rounding where four would be.
#[derive(Clone, Copy)]
pub(crate) struct One<S> {
    pub(crate) value: f64,
    simd: S,
}

impl<S: Simd> One<S> {
    #[inline(always)]
    pub(crate) fn new(simd: S, value: f64) -> Self {
        Self { value, simd }
    }

    /// `mul_add` is a call into the C library where the machine does not have it.
    #[inline(always)]
    fn fuses(self) -> bool {
        match self.simd.level() {
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Sse2(_) | Level::Sse4_2(_) => false,
            #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
            Level::Avx2(_) | Level::Avx512(_) => true,
            #[cfg(target_arch = "aarch64")]
            Level::Neon(_) => true,
            _ => false,
        }
    }
}

macro_rules! one {
    ($($trait:ident $method:ident $operator:tt),*) => {$(
        impl<S: Simd> $trait for One<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self::new(self.simd, self.value $operator other.value)
            }
        }

        impl<S: Simd> $trait<f64> for One<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                Self::new(self.simd, self.value $operator other)
            }
        }
    )*};
}

one!(Add add +, Sub sub -, Mul mul *);

impl<S: Simd> Neg for One<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(self.simd, -self.value)
    }
}

impl<S: Simd> Number for One<S> {
    #[inline(always)]
    fn times_plus(self, factor: Self, summand: Self) -> Self {
        self.scaled_plus(factor.value, summand)
    }

    #[inline(always)]
    fn scaled_plus(self, factor: f64, summand: Self) -> Self {
        let value = if self.fuses() {
            self.value.mul_add(factor, summand.value)
        } else {
            self.value * factor + summand.value
        };
        Self::new(self.simd, value)
    }

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        Self::new(self.simd, value)
    }
}

impl<S: Simd> Number for Lane<S> {
    #[inline(always)]
    fn times_plus(self, factor: Self, summand: Self) -> Self {
        self.mul_add(factor, summand)
    }

    #[inline(always)]
    fn scaled_plus(self, factor: f64, summand: Self) -> Self {
        self.mul_add(factor, summand)
    }

    #[inline(always)]
    fn like(self, value: f64) -> Self {
        Lane::splat(self.simd, value)
    }
}

/// `a * b + c * d`
#[inline(always)]
pub(crate) fn sum<N: Number>((a, b): (N, N), (c, d): (N, N)) -> N {
    a.times_plus(b, c * d)
}

/// `a * b - c * d`
#[inline(always)]
pub(crate) fn difference<N: Number>((a, b): (N, N), (c, d): (N, N)) -> N {
    a.times_plus(b, -(c * d))
}

/// The joints of up to four sets, a lane each; lanes beyond them are 0.
#[inline(always)]
pub(crate) fn side_by_side<S: Simd>(simd: S, joints: &[PendantJoints]) -> [Lane<S>; 6] {
    let mut rows = [[0.0; LANES]; 6];
    for (lane, joints) in joints.iter().enumerate().take(LANES) {
        for (row, value) in rows.iter_mut().zip(joints.radians()) {
            if let Some(cell) = row.get_mut(lane) {
                *cell = value;
            }
        }
    }
    let [a, b, c, d, e, f] = rows;
    [
        Lane::simd_from(simd, a),
        Lane::simd_from(simd, b),
        Lane::simd_from(simd, c),
        Lane::simd_from(simd, d),
        Lane::simd_from(simd, e),
        Lane::simd_from(simd, f),
    ]
}

/// Rows become columns: what belongs to one lane, side by side.
#[inline(always)]
pub(crate) fn transpose<S: Simd, const ROWS: usize>(
    rows: &[Lane<S>; ROWS],
) -> [[f64; ROWS]; LANES] {
    let mut columns = [[0.0; ROWS]; LANES];
    let [first, second, third, fourth] = &mut columns;
    let cells = first.iter_mut().zip(second).zip(third).zip(fourth);
    for (row, (((a, b), c), d)) in rows.iter().zip(cells) {
        [*a, *b, *c, *d] = (*row).into();
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_become_columns() {
        let columns = dispatch!(Level::new(), simd => {
            let row = |numbers: [f64; 4]| Lane::simd_from(simd, numbers);
            transpose(&[row([1.0, 2.0, 3.0, 4.0]), row([5.0, 6.0, 7.0, 8.0])])
        });
        assert_eq!(columns, [[1.0, 5.0], [2.0, 6.0], [3.0, 7.0], [4.0, 8.0]]);
    }
}
