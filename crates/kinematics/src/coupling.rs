//! From the pendant's joints to the chain's and back.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use units::Degrees;

use crate::joints::Axis;
use crate::lanes::Number;

/// How the chain's angles follow from the pendant's: `q = sign * J + offset`, and J2 adds to q3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Coupling {
    /// Each 1 or -1.
    pub(crate) signs: [f64; 6],
    /// Radians.
    pub(crate) offsets: [f64; 6],
    pub(crate) j2_in_q3: f64,
}

impl Coupling {
    #[inline(always)]
    pub(crate) fn chain<N: Number>(&self, &[j1, j2, j3, j4, j5, j6]: &[N; 6]) -> [N; 6] {
        let [s1, s2, s3, s4, s5, s6] = self.signs;
        let [o1, o2, o3, o4, o5, o6] = self.offsets;
        [
            j1 * s1 + o1,
            j2 * s2 + o2,
            j3 * s3 + j2 * self.j2_in_q3 + o3,
            j4 * s4 + o4,
            j5 * s5 + o5,
            j6 * s6 + o6,
        ]
    }

    /// The chain's fourth angle at J4.
    pub(crate) fn q4(&self, j4: Degrees) -> f64 {
        j4.0.to_radians() * Axis::J4.of(&self.signs) + Axis::J4.of(&self.offsets)
    }

    /// The inverse of [`Self::chain`]. The signs are 1 or -1, so multiplying divides.
    #[inline(always)]
    pub(crate) fn pendant<N: Number>(&self, &[q1, q2, q3, q4, q5, q6]: &[N; 6]) -> [N; 6] {
        let [s1, s2, s3, s4, s5, s6] = self.signs;
        let [o1, o2, o3, o4, o5, o6] = self.offsets;
        let j2 = (q2 - o2) * s2;
        [
            (q1 - o1) * s1,
            j2,
            (q3 - o3 - j2 * self.j2_in_q3) * s3,
            (q4 - o4) * s4,
            (q5 - o5) * s5,
            (q6 - o6) * s6,
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_way_back_undoes_the_way_there() {
        let coupling = Coupling {
            signs: [1.0, -1.0, 1.0, -1.0, 1.0, -1.0],
            offsets: [0.1, 0.2, 0.3, 0.4, 0.5, 0.6],
            j2_in_q3: 1.0,
        };
        let joints: [f64; 6] = [1.0, 2.0, 3.0, -1.0, -2.0, -3.0];
        let back = coupling.pendant(&coupling.chain(&joints));
        for (back, there) in back.into_iter().zip(joints) {
            assert!((back - there).abs() < 1e-15);
        }
    }
}
