//! X, Y, Z, W, P, R: a pose as the pendant writes it.

use std::fmt;

use nalgebra::{Matrix3, Rotation3};
use units::{Degrees, Millimeters};

/// A pose as the pendant writes it: X, Y, Z in millimeters, W, P, R in degrees.
///
/// W, P and R turn about the fixed X, Y and Z axes: `R = Rz(r) * Ry(p) * Rx(w)`. Plain data:
/// [`crate::Pose`] is the checked form.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[expect(missing_docs, reason = "the pendant's own letters, explained above")]
pub struct Xyzwpr {
    pub x: Millimeters,
    pub y: Millimeters,
    pub z: Millimeters,
    pub w: Degrees,
    pub p: Degrees,
    pub r: Degrees,
}

impl Xyzwpr {
    /// A pose from `[x, y, z]` and `[w, p, r]`.
    #[must_use]
    pub fn new([x, y, z]: [Millimeters; 3], [w, p, r]: [Degrees; 3]) -> Self {
        Self { x, y, z, w, p, r }
    }
}

/// `X 985.000 mm, Y 0.000 mm, Z 940.000 mm, W 180.000°, P 0.000°, R 0.000°`
impl fmt::Display for Xyzwpr {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let n = f.precision().unwrap_or(3);
        let Self { x, y, z, w, p, r } = self;
        write!(
            f,
            "X {x:.n$}, Y {y:.n$}, Z {z:.n$}, W {w:.n$}, P {p:.n$}, R {r:.n$}"
        )
    }
}

/// Below this cosine of P only W + R (or W - R) is determined, and R is shown as 0.
///
/// Setting R to 0 turns the pose by less than this many radians times R.
const GIMBAL: f64 = 1e-10;

/// The rotation of `[w, p, r]`: `Rz(r) * Ry(p) * Rx(w)`.
///
/// The thesis prints the product in the opposite order in its equation (16); FANUC controllers turn
/// about fixed axes.
pub(crate) fn rotation_of([w, p, r]: [Degrees; 3]) -> Rotation3<f64> {
    let (sw, cw) = w.0.to_radians().sin_cos();
    let (sp, cp) = p.0.to_radians().sin_cos();
    let (sr, cr) = r.0.to_radians().sin_cos();
    #[rustfmt::skip]
    let matrix = Matrix3::new(
        cr * cp, cr * sp * sw - sr * cw, cr * sp * cw + sr * sw,
        sr * cp, sr * sp * sw + cr * cw, sr * sp * cw - cr * sw,
        -sp,     cp * sw,                cp * cw,
    );
    Rotation3::from_matrix_unchecked(matrix)
}

/// `[w, p, r]` of a rotation, each in (-180, 180], P in [-90, 90].
///
/// At P = ±90 the three angles are not unique; R is 0 there, as pendants show it: an M-20iA with
/// all joints at zero shows W 180, P -90, R 0.
pub(crate) fn angles_of(rotation: &Matrix3<f64>) -> [Degrees; 3] {
    let m = rotation;
    let cos_p = m[(0, 0)].hypot(m[(1, 0)]);
    let (sr, cr, r) = if cos_p < GIMBAL {
        (0.0, 1.0, 0.0)
    } else {
        let (sr, cr) = (m[(1, 0)] / cos_p, m[(0, 0)] / cos_p);
        (sr, cr, sr.atan2(cr))
    };
    // W is taken from the rotation that is left after R: near the gimbal W and R are each poorly
    // determined, but this way their errors cancel and the pose stays exact.
    let w = (sr * m[(0, 2)] - cr * m[(1, 2)]).atan2(cr * m[(1, 1)] - sr * m[(0, 1)]);
    let p = (-m[(2, 0)]).atan2(cr * m[(0, 0)] + sr * m[(1, 0)]);
    [w, p, r].map(|angle| Degrees(half_open(angle.to_degrees())))
}

/// -180 and 180 are the same angle; the pendant shows 180. Negative zero becomes zero.
fn half_open(degrees: f64) -> f64 {
    if degrees <= -180.0 {
        degrees + 360.0
    } else {
        degrees + 0.0
    }
}
