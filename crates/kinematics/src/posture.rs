//! What tells the branches of an arm apart, and how far a posture is from where two of them meet.

use crate::geometry::Geometry;
use crate::joints::ChainJoints;
use crate::singularity::Singularity;

/// Three numbers whose signs name the branch; each is 0 at its singularity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Posture {
    pub(crate) sin_q5: f64,
    /// How far the wrist center is in front of axis 1, in millimeters.
    pub(crate) front: f64,
    /// The sine between upper arm and forearm; positive with the elbow up.
    pub(crate) elbow: f64,
}

impl Posture {
    // Below these a posture is singular: two branches are one, and the sign of what is left is
    // noise. Calling it singular moves the flange by less than the inverse kinematics may be off.
    pub(crate) const SINGULAR_WRIST: f64 = 5e-10;
    pub(crate) const SINGULAR_DISTANCE: f64 = 1e-7;
    pub(crate) const SINGULAR_SINE: f64 = 1e-7;

    /// The posture of the chain's joints.
    pub(crate) fn of(g: &Geometry, joints: &ChainJoints) -> Self {
        let [_, q2, q3, _, q5, _] = joints.radians();
        let (s23, c23) = (q2 + q3).sin_cos();
        let (s3, c3) = q3.sin_cos();
        let forearm = g.forearm * (g.forearm_cos * c23 - g.forearm_sin * s23);
        // The forearm turned clockwise from the upper arm means elbow up, if frame 1's second axis
        // points up.
        let elbow = -g.s1 * (s3 * g.forearm_cos + c3 * g.forearm_sin);
        Self::from_parts(q5.sin(), g.a1 + g.a2 * q2.cos() + forearm, elbow)
    }

    #[inline]
    pub(crate) fn from_parts(sin_q5: f64, front: f64, elbow: f64) -> Self {
        let unless_noise = |value: f64, noise| if value.abs() < noise { 0.0 } else { value };
        Self {
            sin_q5: unless_noise(sin_q5, Self::SINGULAR_WRIST),
            front: unless_noise(front, Self::SINGULAR_DISTANCE),
            elbow: unless_noise(elbow, Self::SINGULAR_SINE),
        }
    }

    #[inline]
    pub(crate) fn singularity(&self, g: &Geometry) -> Singularity {
        Singularity {
            wrist: self.sin_q5.abs(),
            shoulder: self.front.abs() / g.reach,
            elbow: self.elbow.abs(),
        }
    }
}
