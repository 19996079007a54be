//! Denavit-Hartenberg transforms of any chain.

use nalgebra::Matrix4;
use units::{Millimeters, Radians};

/// One row of a Denavit-Hartenberg table (standard convention), without the joint angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DhLink {
    /// Along the joint's axis.
    pub d: Millimeters,
    /// Along the common normal.
    pub a: Millimeters,
    /// From this joint's axis to the next one's, about the common normal.
    pub alpha: Radians,
}

impl DhLink {
    /// The transform from frame i to frame i - 1 at the joint angle `q`, translation in
    /// millimeters.
    ///
    /// The matrix of the thesis, section 2.2.1.
    #[must_use]
    pub fn transform(&self, q: Radians) -> Matrix4<f64> {
        let (sq, cq) = q.0.sin_cos();
        let (sa, ca) = self.alpha.0.sin_cos();
        let (a, d) = (self.a.0, self.d.0);
        #[rustfmt::skip]
        let matrix = Matrix4::new(
            cq,  -ca * sq, sa * sq,  a * cq,
            sq,  ca * cq,  -sa * cq, a * sq,
            0.0, sa,       ca,       d,
            0.0, 0.0,      0.0,      1.0,
        );
        matrix
    }
}
