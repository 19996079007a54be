//! Forward kinematics: the flange's pose and the posture, of the chain's joints.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::geometry::Geometry;
use crate::joints::ChainJoints;
use crate::pose::Pose;
use crate::singularity::Singularity;

/// Sines and cosines that the forward kinematics is made of.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turned {
    pub(crate) q1: (f64, f64),
    pub(crate) q2: (f64, f64),
    pub(crate) q23: (f64, f64),
    pub(crate) q4: (f64, f64),
    pub(crate) q5: (f64, f64),
    pub(crate) q6: (f64, f64),
}

impl Turned {
    pub(crate) fn of(joints: &ChainJoints) -> Self {
        let [q1, q2, q3, q4, q5, q6] = joints.radians();
        Self {
            q1: q1.sin_cos(),
            q2: q2.sin_cos(),
            q23: (q2 + q3).sin_cos(),
            q4: q4.sin_cos(),
            q5: q5.sin_cos(),
            q6: q6.sin_cos(),
        }
    }
}

/// `X_WF` of the chain's joints.
pub(crate) fn flange(geometry: &Geometry, joints: &ChainJoints) -> Pose {
    let (p_WF, R_WF) = flange_of(geometry, &Turned::of(joints));
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(R_WF));
    Pose::from_parts(p_WF, rotation)
}

/// Position and rotation of the flange: the product of the six transforms, with the right angles put in.
pub(crate) fn flange_of(geometry: &Geometry, turned: &Turned) -> (Vector3<f64>, Matrix3<f64>) {
    let g = geometry;
    let R_W3 = arm_rotation(g, turned);
    let (s4, c4) = turned.q4;
    let (s5, c5) = turned.q5;
    let (s6, c6) = turned.q6;
    let t = -g.s4 * g.s5;
    #[rustfmt::skip]
    let R_3F = Matrix3::new(
        c4 * c5 * c6 - t * s4 * s6, -c4 * c5 * s6 - t * s4 * c6, g.s5 * c4 * s5,
        s4 * c5 * c6 + t * c4 * s6, -s4 * c5 * s6 + t * c4 * c6, g.s5 * s4 * s5,
        g.s4 * s5 * c6,             -g.s4 * s5 * s6,             t * c5,
    );
    let R_WF = R_W3 * R_3F;
    (wrist_center(g, turned) + g.d6 * R_WF.column(2), R_WF)
}

/// The rotation of frame 3, the forearm.
pub(crate) fn arm_rotation(g: &Geometry, turned: &Turned) -> Matrix3<f64> {
    let (s1, c1) = turned.q1;
    let (s23, c23) = turned.q23;
    let t = g.s1 * g.s3;
    #[rustfmt::skip]
    let R_W3 = Matrix3::new(
        c1 * c23,   t * s1,  g.s3 * s23 * c1,
        s1 * c23,   -t * c1, g.s3 * s23 * s1,
        g.s1 * s23, 0.0,     -t * c23,
    );
    R_W3
}

/// The wrist center in the world.
fn wrist_center(g: &Geometry, turned: &Turned) -> Vector3<f64> {
    let (s1, c1) = turned.q1;
    let (u, v) = arm_plane(g, turned);
    let forward = g.a1 + u;
    let lateral = -g.s1 * g.lateral;
    Vector3::new(
        c1 * forward - s1 * lateral,
        s1 * forward + c1 * lateral,
        g.d1 + g.s1 * v,
    )
}

/// The wrist center in the arm's plane, from the shoulder.
fn arm_plane(g: &Geometry, turned: &Turned) -> (f64, f64) {
    let (s2, c2) = turned.q2;
    let (s23, c23) = turned.q23;
    let forearm_cos = g.forearm_cos * c23 - g.forearm_sin * s23;
    let forearm_sin = g.forearm_cos * s23 + g.forearm_sin * c23;
    (
        g.a2 * c2 + g.forearm * forearm_cos,
        g.a2 * s2 + g.forearm * forearm_sin,
    )
}

/// What tells the branches and the singularities apart; each is 0 at its singularity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Posture {
    pub(crate) sin_q5: f64,
    /// How far the wrist center is in front of axis 1, in millimeters.
    pub(crate) front: f64,
    /// The sine between forearm and upper arm; positive with the elbow up.
    pub(crate) elbow: f64,
}

impl Posture {
    // Below these a posture is singular: two branches are one, and the sign of what is left is noise. Calling it
    // singular moves the flange by less than the inverse kinematics may be off.
    pub(crate) const SINGULAR_WRIST: f64 = 5e-10;
    pub(crate) const SINGULAR_DISTANCE: f64 = 1e-7;
    pub(crate) const SINGULAR_SINE: f64 = 1e-7;

    pub(crate) fn of(g: &Geometry, joints: &ChainJoints) -> Self {
        let [_, q2, q3, _, q5, _] = joints.radians();
        let c2 = q2.cos();
        let (s23, c23) = (q2 + q3).sin_cos();
        let (s3, c3) = q3.sin_cos();
        let forward = g.a1 + g.a2 * c2 + g.forearm * (g.forearm_cos * c23 - g.forearm_sin * s23);
        let sine = s3 * g.forearm_cos + c3 * g.forearm_sin;
        // The forearm turned clockwise from the upper arm means that the elbow is up, if frame 1's second axis is.
        Self::from_parts(q5.sin(), forward, -g.s1 * sine)
    }

    pub(crate) fn from_parts(sin_q5: f64, front: f64, elbow: f64) -> Self {
        let unless_noise = |value: f64, noise| if value.abs() < noise { 0.0 } else { value };
        Self {
            sin_q5: unless_noise(sin_q5, Self::SINGULAR_WRIST),
            front: unless_noise(front, Self::SINGULAR_DISTANCE),
            elbow: unless_noise(elbow, Self::SINGULAR_SINE),
        }
    }

    pub(crate) fn singularity(&self, g: &Geometry) -> Singularity {
        Singularity {
            wrist: self.sin_q5.abs(),
            shoulder: self.front.abs() / g.reach(),
            elbow: self.elbow.abs(),
        }
    }
}
