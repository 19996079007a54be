//! Sine, cosine and arc tangent of several angles at once.
//!
//! The standard library's are as exact, but one call an angle, and the kinematics is mostly angles.
//! The polynomials interpolate at the Chebyshev nodes of the reduced range, computed with 50
//! digits; each is off by less than 2e-17 before rounding. Tests compare with the standard library.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

use fearless_simd::u64x4;

use crate::lanes::{Lane, Number, Select, Simd, SimdBase, SimdFloat, SimdMask};

/// Sine and cosine.
pub(crate) type Turn<S> = (Lane<S>, Lane<S>);

/// Beyond this many radians the reduction loses digits, and the standard library takes over.
const MAX_ANGLE: f64 = 1e5;

/// Half pi in three parts: multiples of the first two are exact up to 2^20.
const HALF_PI_HIGH: f64 = 1.570_796_326_734_125_6;
const HALF_PI_MIDDLE: f64 = 6.077_100_506_303_966e-11;
const HALF_PI_LOW: f64 = 2.022_266_248_795_950_6e-21;

/// Adding it rounds to a whole number, which is then in the low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// `(sin x / x - 1) / x^2` by powers of `x^2`, up to pi / 4.
const SINE: [f64; 6] = [
    -0.166_666_666_666_666_66,
    0.008_333_333_333_330_946,
    -0.000_198_412_698_367_549_7,
    2.755_731_610_068_303e-6,
    -2.505_113_145_542_794_6e-8,
    1.591_810_123_027_412e-10,
];

/// `(cos x - 1 + x^2 / 2) / x^4` by powers of `x^2`, up to pi / 4.
const COSINE: [f64; 6] = [
    0.041_666_666_666_666_664,
    -0.001_388_888_888_888_739_5,
    2.480_158_729_876_343_3e-5,
    -2.755_731_727_056_032_6e-7,
    2.087_614_602_468_974_7e-9,
    -1.138_261_486_855_632_5e-11,
];

/// `(1 - arctan x / x) / x^2` by powers of `x^2`, up to tan(pi / 8).
const ARC_TANGENT: [f64; 11] = [
    0.333_333_333_333_333_3,
    -0.199_999_999_999_955_13,
    0.142_857_142_846_651_8,
    -0.111_111_110_151_467_14,
    0.090_909_045_736_690_6,
    -0.076_921_830_873_420_26,
    0.066_645_099_898_180_45,
    -0.058_581_362_519_061_465,
    0.050_853_834_888_428_31,
    -0.039_229_744_536_612_23,
    0.019_174_543_572_021_332,
];

/// tan(pi / 8): above it the arc tangent is taken from pi / 4.
const TAN_PI_8: f64 = 0.414_213_562_373_095_03;

/// Sine and cosine of each lane of each vector.
#[inline(always)]
pub(crate) fn sin_cos<S: Simd, const K: usize>(angles: [Lane<S>; K]) -> [Turn<S>; K] {
    let Some(first) = angles.first() else {
        return angles.map(|angle| (angle, angle));
    };
    // A NaN is not below the bound either.
    let mut small = first.abs().simd_lt(MAX_ANGLE);
    for angle in angles {
        small &= angle.abs().simd_lt(MAX_ANGLE);
    }
    if small.all_true() {
        sin_cos_of_small(angles)
    } else {
        sin_cos_of_any(angles)
    }
}

/// One by one, by the standard library.
#[cold]
fn sin_cos_of_any<S: Simd, const K: usize>(angles: [Lane<S>; K]) -> [Turn<S>; K] {
    angles.map(|angle| {
        let (mut sines, mut cosines) = (angle, angle);
        for (sine, cosine) in sines.iter_mut().zip(cosines.iter_mut()) {
            (*sine, *cosine) = sine.sin_cos();
        }
        (sines, cosines)
    })
}

/// The same for angles known to be small: beyond 1e5 radians digits are lost.
#[inline(always)]
pub(crate) fn sin_cos_of_small<S: Simd, const K: usize>(angles: [Lane<S>; K]) -> [Turn<S>; K] {
    let mut reduced = angles;
    let mut squares = angles;
    let mut quadrants = angles;
    let each = reduced.iter_mut().zip(&mut squares).zip(&mut quadrants);
    for ((x, z), shifted) in each {
        let angle = *x;
        *shifted = angle.mul_add(FRAC_2_PI, ROUND);
        let quarters = *shifted - ROUND;
        *x = quarters.scaled_plus(-HALF_PI_HIGH, angle);
        *x = quarters.scaled_plus(-HALF_PI_MIDDLE, *x);
        *x = quarters.scaled_plus(-HALF_PI_LOW, *x);
        *z = *x * *x;
    }
    let mut sines = polynomial(squares, &SINE);
    let mut cosines = polynomial(squares, &COSINE);
    let turns = sines.iter_mut().zip(&mut cosines);
    for ((sine, cosine), (x, z)) in turns.zip(reduced.into_iter().zip(squares)) {
        let one_minus_half = z.mul_add(-0.5, 1.0);
        // What the subtraction from 1 rounded away comes back.
        let rounded_away = z.scaled_plus(-0.5, -one_minus_half + 1.0);
        *sine = (x * z).times_plus(*sine, x);
        *cosine = one_minus_half + (z * z).times_plus(*cosine, rounded_away);
    }
    let mut turns = angles.map(|angle| (angle, angle));
    for ((turn, shifted), (sine, cosine)) in turns
        .iter_mut()
        .zip(quadrants)
        .zip(sines.into_iter().zip(cosines))
    {
        *turn = in_quadrant(shifted.to_bits(), sine, cosine);
    }
    turns
}

/// Odd quarter turns exchange sine and cosine; the second bit is their sign. All without a branch.
#[inline(always)]
fn in_quadrant<S: Simd>(quadrant: u64x4<S>, sine: Lane<S>, cosine: Lane<S>) -> Turn<S> {
    let exchange = u64x4::splat(quadrant.simd, 0) - (quadrant & 1);
    let (sine, cosine) = (sine.to_bits(), cosine.to_bits());
    let difference = (sine ^ cosine) & exchange;
    let sine_sign = (quadrant & 2) << 62;
    let cosine_sign = ((quadrant + 1) & 2) << 62;
    (
        Lane::from_bits(sine ^ difference ^ sine_sign),
        Lane::from_bits(cosine ^ difference ^ cosine_sign),
    )
}

/// The angle of each lane's direction, given as sine and cosine, from -pi to pi; the length does
/// not matter. 0 if there is no direction.
#[inline(always)]
pub(crate) fn angles<S: Simd, const K: usize>(directions: [Turn<S>; K]) -> [Lane<S>; K] {
    let mut tangents = directions.map(|(y, _)| y);
    let mut squares = tangents;
    let mut offsets = tangents;
    let each = tangents.iter_mut().zip(&mut squares).zip(&mut offsets);
    for (((t, z), offset), (y, x)) in each.zip(directions) {
        let zero = Lane::splat(y.simd, 0.0);
        let (tall, wide) = (y.abs(), x.abs());
        // With a NaN the comparison fails, and the NaN stays on either side.
        let steep = tall.simd_gt(wide);
        let (small, large) = (steep.select(wide, tall), steep.select(tall, wide));
        // Above pi / 8 the tangent of the difference to pi / 4.
        let beyond = small.simd_gt(large * TAN_PI_8);
        let numerator = small - beyond.select(large, zero);
        let denominator = large + beyond.select(small, zero) + f64::MIN_POSITIVE;
        *t = numerator / denominator;
        *z = *t * *t;
        *offset = beyond.select(Lane::splat(y.simd, FRAC_PI_4), zero);
    }
    let mut angles = polynomial(squares, &ARC_TANGENT);
    let parts = tangents.into_iter().zip(squares).zip(offsets);
    for ((angle, ((t, z), offset)), (y, x)) in angles.iter_mut().zip(parts).zip(directions) {
        let octant = (t * z).times_plus(-*angle, t) + offset;
        let steep = y.abs().simd_gt(x.abs());
        let quarter = steep.select(-octant + FRAC_PI_2, octant);
        let half = x.simd_lt(0.0).select(-quarter + PI, quarter);
        *angle = half.copysign(y);
    }
    angles
}

/// The even and the odd powers by themselves, which is half the wait of Horner's rule; a factor is
/// loaded once for all vectors.
#[inline(always)]
fn polynomial<S: Simd, const TERMS: usize, const K: usize>(
    z: [Lane<S>; K],
    terms: &[f64; TERMS],
) -> [Lane<S>; K] {
    let (pairs, last) = terms.as_chunks::<2>();
    let (mut even, mut odd, mut square) = (z, z, z);
    for square in &mut square {
        *square = *square * *square;
    }
    let Some(([a, b], pairs)) = pairs.split_last() else {
        return z;
    };
    for ((even, odd), square) in even.iter_mut().zip(&mut odd).zip(square) {
        let simd = square.simd;
        *odd = Lane::splat(simd, *b);
        *even = match last {
            [c] => Lane::splat(simd, *c).mul_add(square, *a),
            _ => Lane::splat(simd, *a),
        };
    }
    for [a, b] in pairs.iter().rev() {
        for ((even, odd), square) in even.iter_mut().zip(&mut odd).zip(square) {
            *even = even.mul_add(square, *a);
            *odd = odd.mul_add(square, *b);
        }
    }
    for ((even, odd), z) in even.iter_mut().zip(odd).zip(z) {
        *even = odd.times_plus(z, *even);
    }
    even
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::lanes::{Level, dispatch};

    /// The best instructions of this machine, and those of every machine of its kind.
    const LEVELS: [fn() -> Level; 2] = [Level::new, Level::baseline];

    /// Two roundings of a number near 1.
    const CLOSE: f64 = 2.5e-16;

    fn assert_sin_cos(angle: f64) {
        for level in LEVELS {
            let (sine, cosine) = sin_cos_at(level(), angle);
            let (s, c) = angle.sin_cos();
            assert!(
                (sine - s).abs() <= CLOSE && (cosine - c).abs() <= CLOSE,
                "{angle}"
            );
        }
    }

    fn assert_atan2(y: f64, x: f64) {
        for level in LEVELS {
            let angle = atan2_at(level(), y, x);
            assert!(
                (angle - y.atan2(x)).abs() <= 4.0 * CLOSE,
                "{y} {x}: {angle} {}",
                y.atan2(x)
            );
        }
    }

    fn sin_cos_at(level: Level, angle: f64) -> (f64, f64) {
        dispatch!(level, simd => {
            let [(sine, cosine)] = sin_cos([Lane::splat(simd, angle)]);
            (sine[0], cosine[0])
        })
    }

    fn atan2_at(level: Level, y: f64, x: f64) -> f64 {
        dispatch!(level, simd => {
            let [angle] = angles([(Lane::splat(simd, y), Lane::splat(simd, x))]);
            angle[0]
        })
    }

    #[test]
    fn the_eighths_of_a_turn_are_exact_enough() {
        for eighths in -64..=64_i32 {
            let angle = f64::from(eighths) * FRAC_PI_4;
            for angle in [angle, angle.next_up(), angle.next_down(), angle + 1e-9] {
                assert_sin_cos(angle);
                let (s, c) = angle.sin_cos();
                assert_atan2(s, c);
                assert_atan2(1e6 * s, 1e6 * c);
            }
        }
    }

    #[test]
    fn the_arc_tangent_knows_the_axes_and_the_origin() {
        for y in [0.0, 1.0, -1.0, 1e-300, -1e-300] {
            for x in [1.0, -1.0, 0.0, 1e-300] {
                if (y, x) != (0.0, 0.0) && f64::abs(y) + f64::abs(x) > 1e-200 {
                    assert_atan2(y, x);
                }
            }
        }
        for level in LEVELS {
            assert_eq!(atan2_at(level(), 0.0, 0.0).to_bits(), 0.0_f64.to_bits());
        }
    }

    #[test]
    fn what_is_not_a_number_stays_so() {
        for level in LEVELS {
            assert!(sin_cos_at(level(), f64::NAN).0.is_nan());
            assert!(sin_cos_at(level(), f64::INFINITY).1.is_nan());
            assert!(atan2_at(level(), f64::NAN, 1.0).is_nan());
            assert!(atan2_at(level(), 1.0, f64::NAN).is_nan());
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(50_000))]

        #[test]
        fn sines_agree_with_the_standard_library(angle in -30.0..30.0) {
            assert_sin_cos(angle);
        }

        #[test]
        fn sines_of_large_angles_agree_too(angle in -2e5..2e5) {
            assert_sin_cos(angle);
        }

        #[test]
        fn arc_tangents_agree_with_the_standard_library(y in -2.0..2.0, x in -2.0..2.0) {
            assert_atan2(y, x);
        }
    }
}
