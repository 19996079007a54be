//! Frames and vectors: the little geometry that the language itself computes.
//!
//! `R = Rz(r) Ry(p) Rx(w)`; millimeters and degrees at the edge, 64 bits inside.

use crate::position::XyzwprExt;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Vector(pub(crate) [f64; 3]);

impl Vector {
    pub(crate) fn plus(self, other: Vector) -> Vector {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Vector([a + x, b + y, c + z])
    }

    pub(crate) fn times(self, factor: f64) -> Vector {
        Vector(self.0.map(|component| component * factor))
    }

    pub(crate) fn dot(self, other: Vector) -> f64 {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        a * x + b * y + c * z
    }

    pub(crate) fn cross(self, other: Vector) -> Vector {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        Vector([b * z - c * y, c * x - a * z, a * y - b * x])
    }

    pub(crate) fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// The same direction with length 1; `None` if it has none.
    pub(crate) fn unit(self) -> Option<Vector> {
        let length = self.length();
        (length > 1e-9).then(|| self.times(1.0 / length))
    }
}

/// A rotation by its columns, and an origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    axes: [Vector; 3],
    origin: Vector,
}

impl From<&XyzwprExt> for Frame {
    fn from(position: &XyzwprExt) -> Frame {
        let angle = |degrees: f32| f64::from(degrees).to_radians().sin_cos();
        let ((sw, cw), (sp, cp), (sr, cr)) =
            (angle(position.w), angle(position.p), angle(position.r));
        let XyzwprExt { x, y, z, .. } = *position;
        Frame {
            axes: [
                Vector([cr * cp, sr * cp, -sp]),
                Vector([cr * sp * sw - sr * cw, sr * sp * sw + cr * cw, cp * sw]),
                Vector([cr * sp * cw + sr * sw, sr * sp * cw - cr * sw, cp * cw]),
            ],
            origin: Vector([f64::from(x), f64::from(y), f64::from(z)]),
        }
    }
}

impl Frame {
    pub(crate) fn from_axes(x: Vector, y: Vector, z: Vector, origin: Vector) -> Frame {
        Frame {
            axes: [x, y, z],
            origin,
        }
    }

    pub(crate) fn origin(&self) -> Vector {
        self.origin
    }

    pub(crate) fn axis(&self, number: usize) -> Vector {
        self.axes.get(number).copied().unwrap_or(self.origin)
    }

    fn turn(&self, v: Vector) -> Vector {
        let ([a, b, c], [x, y, z]) = (v.0, self.axes);
        x.times(a).plus(y.times(b)).plus(z.times(c))
    }

    /// A point of this frame.
    pub(crate) fn point(&self, v: Vector) -> Vector {
        self.turn(v).plus(self.origin)
    }

    pub(crate) fn times(&self, other: &Frame) -> Frame {
        Frame {
            axes: other.axes.map(|axis| self.turn(axis)),
            origin: self.point(other.origin),
        }
    }

    /// The same orientation elsewhere.
    pub(crate) fn moved(&self, by: Vector) -> Frame {
        Frame {
            axes: self.axes,
            origin: self.origin.plus(by),
        }
    }

    /// Turned in its origin by an angle in degrees about a direction of length 1.
    pub(crate) fn turned(&self, about: Vector, angle_deg: f64) -> Frame {
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        Frame {
            axes: self.axes.map(|axis| {
                let along = about.times(about.dot(axis) * (1.0 - cos));
                axis.times(cos)
                    .plus(about.cross(axis).times(sin))
                    .plus(along)
            }),
            origin: self.origin,
        }
    }

    pub(crate) fn inverse(&self) -> Frame {
        let [x, y, z] = self.axes;
        let column = |n: usize| {
            let component = |v: Vector| v.0.get(n).copied().unwrap_or(0.0);
            Vector([component(x), component(y), component(z)])
        };
        let back = self.origin.times(-1.0);
        Frame {
            axes: [column(0), column(1), column(2)],
            origin: Vector([x.dot(back), y.dot(back), z.dot(back)]),
        }
    }

    pub(crate) fn distance(&self, other: &Frame) -> f64 {
        self.origin.plus(other.origin.times(-1.0)).length()
    }

    /// The angle between two orientations.
    pub(crate) fn angle_deg(&self, other: &Frame) -> f64 {
        let trace: f64 = self
            .axes
            .iter()
            .zip(other.axes)
            .map(|(a, b)| a.dot(b))
            .sum();
        ((trace - 1.0) / 2.0).clamp(-1.0, 1.0).acos().to_degrees()
    }

    /// x, y, z in millimeters and w, p, r in degrees.
    ///
    /// ASSUMPTION: with P at +90 or -90 degrees, where W and R turn about one axis, R is 0.
    pub(crate) fn components(&self) -> [f64; 6] {
        let [x, y, z] = self.axes.map(|axis| axis.0);
        let [x0, x1, x2] = x;
        let flat = x0.hypot(x1);
        let p = (-x2).atan2(flat);
        let (w, r) = if flat > 1e-9 {
            let ([_, _, y2], [_, _, z2]) = (y, z);
            (y2.atan2(z2), x1.atan2(x0))
        } else {
            let ([_, y1, _], [_, z1, _]) = (y, z);
            ((-z1).atan2(y1), 0.0)
        };
        let [a, b, c] = self.origin.0;
        [a, b, c, w.to_degrees(), p.to_degrees(), r.to_degrees()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::position::Xyzwpr;

    fn frame(components: [f32; 6]) -> Frame {
        Frame::from(&XyzwprExt::from(Xyzwpr::from_components(components)))
    }

    fn near(a: &Frame, b: &Frame) -> bool {
        a.distance(b) < 1e-6 && a.angle_deg(b) < 1e-5
    }

    #[test]
    fn components_give_the_frame_back_also_at_right_angles() {
        for components in [
            [1.0, 2.0, 3.0, 10.0, 20.0, 30.0],
            [0.0, 0.0, 0.0, -170.0, 80.0, -100.0],
            [0.0, 0.0, 0.0, 30.0, 90.0, 40.0],
            [0.0, 0.0, 0.0, 30.0, -90.0, 40.0],
        ] {
            let original = frame(components);
            let [x, y, z, w, p, r] = original.components();
            #[expect(clippy::cast_possible_truncation, reason = "a test's own angles")]
            let back = frame([x as f32, y as f32, z as f32, w as f32, p as f32, r as f32]);
            assert!(
                near(&original, &back) || original.angle_deg(&back) < 1e-2,
                "{components:?}"
            );
        }
    }

    #[test]
    fn a_frame_and_its_inverse_are_nothing() {
        let a = frame([100.0, -50.0, 30.0, 15.0, -40.0, 120.0]);
        let nothing = frame([0.0; 6]);
        assert!(near(&a.times(&a.inverse()), &nothing));
        assert!(near(&a.inverse().times(&a), &nothing));
    }
}
