//! Sine, cosine and arc tangent of several angles at once.
//!
//! The standard library's are as exact, but one call an angle, and the kinematics is mostly angles.
//! The polynomials interpolate at the Chebyshev nodes of the reduced range, computed with 50
//! digits; each is off by less than 2e-17 before rounding. Tests compare with the standard library.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it, and a call a lane would undo the point of lanes"
)]

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, FRAC_PI_4, PI};

use crate::lanes::Lanes;

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

/// Sine and cosine of each lane.
#[inline(always)]
pub(crate) fn sin_cos<const N: usize>(angles: Lanes<N>) -> (Lanes<N>, Lanes<N>) {
    // A NaN is not below the bound either.
    if angles.0.iter().all(|angle| angle.abs() < MAX_ANGLE) {
        sin_cos_reduced(angles)
    } else {
        (angles.map(f64::sin), angles.map(f64::cos))
    }
}

#[inline(always)]
fn sin_cos_reduced<const N: usize>(angles: Lanes<N>) -> (Lanes<N>, Lanes<N>) {
    let shifted = angles.map(|angle| angle * FRAC_2_PI + ROUND);
    let quarters = shifted - ROUND;
    let x = angles - quarters * HALF_PI_HIGH - quarters * HALF_PI_MIDDLE - quarters * HALF_PI_LOW;
    let z = x * x;
    let sine = x + x * z * polynomial(z, &SINE);
    let half = z * 0.5;
    let one_minus_half = half.map(|half| 1.0 - half);
    // What the subtraction from 1 rounded away comes back.
    let cosine = one_minus_half
        + (one_minus_half.map(|rounded| 1.0 - rounded) - half + z * z * polynomial(z, &COSINE));
    let mut result = (sine, cosine);
    for ((s, c), shifted) in result.0.0.iter_mut().zip(&mut result.1.0).zip(shifted.0) {
        let quadrant = shifted.to_bits();
        // Odd quarter turns exchange sine and cosine; the second bit is their sign. All without a
        // branch.
        let exchange = (quadrant & 1).wrapping_neg();
        let (sine_bits, cosine_bits) = (s.to_bits(), c.to_bits());
        let difference = (sine_bits ^ cosine_bits) & exchange;
        let sine_sign = (quadrant & 2) << 62;
        let cosine_sign = (quadrant.wrapping_add(1) & 2) << 62;
        *s = f64::from_bits(sine_bits ^ difference ^ sine_sign);
        *c = f64::from_bits(cosine_bits ^ difference ^ cosine_sign);
    }
    result
}

/// The angle of each lane's direction, from -pi to pi; the length does not matter. 0 if there is no
/// direction.
#[inline(always)]
pub(crate) fn atan2<const N: usize>(y: Lanes<N>, x: Lanes<N>) -> Lanes<N> {
    let (tall, wide) = (y.map(f64::abs), x.map(f64::abs));
    let small = tall.zip(wide, |a, b| if a < b { a } else { b });
    let large = tall.zip(wide, |a, b| if a < b { b } else { a });
    // Above pi / 8 the tangent of the difference to pi / 4.
    let threshold = large * TAN_PI_8;
    let beyond = small.zip(threshold, |a, b| if a > b { 1.0 } else { 0.0 });
    let numerator = small - large * beyond;
    let denominator = (large + small * beyond).map(|d| d + f64::MIN_POSITIVE);
    let t = numerator * denominator.recip();
    let z = t * t;
    let angle = t - t * z * polynomial(z, &ARC_TANGENT) + beyond * FRAC_PI_4;
    let steep = tall.zip(wide, |a, b| if a > b { 1.0 } else { 0.0 });
    let angle = steep * FRAC_PI_2 + angle * steep.map(|s| 1.0 - 2.0 * s);
    let behind = x.map(|x| if x < 0.0 { 1.0 } else { 0.0 });
    let angle = behind * PI + angle * behind.map(|b| 1.0 - 2.0 * b);
    angle.zip(y, f64::copysign)
}

/// By Horner.
#[inline(always)]
fn polynomial<const N: usize, const TERMS: usize>(z: Lanes<N>, terms: &[f64; TERMS]) -> Lanes<N> {
    terms
        .iter()
        .rev()
        .fold(Lanes::all(0.0), |sum, term| sum * z + *term)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Two roundings of a number near 1.
    const CLOSE: f64 = 2.5e-16;

    fn assert_sin_cos(angle: f64) {
        let (sine, cosine) = sin_cos(Lanes([angle]));
        let (s, c) = angle.sin_cos();
        assert!(
            (sine.0[0] - s).abs() <= CLOSE && (cosine.0[0] - c).abs() <= CLOSE,
            "{angle}"
        );
    }

    fn assert_atan2(y: f64, x: f64) {
        let angle = atan2(Lanes([y]), Lanes([x])).0[0];
        assert!(
            (angle - y.atan2(x)).abs() <= 4.0 * CLOSE,
            "{y} {x}: {angle} {}",
            y.atan2(x)
        );
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
        assert_eq!(atan2(Lanes([0.0]), Lanes([0.0])), Lanes([0.0]));
    }

    #[test]
    fn what_is_not_a_number_stays_so() {
        assert!(sin_cos(Lanes([f64::NAN])).0.0[0].is_nan());
        assert!(sin_cos(Lanes([f64::INFINITY])).1.0[0].is_nan());
        assert!(atan2(Lanes([f64::NAN]), Lanes([1.0])).0[0].is_nan());
        assert!(atan2(Lanes([1.0]), Lanes([f64::NAN])).0[0].is_nan());
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
