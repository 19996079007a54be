//! The FANUC M-20iA for both implementations, and random poses it reaches.

use std::f64::consts::{FRAC_PI_2, PI};

use kinematics::{ArmModel, Axis, PendantJoints, Pose};
use rs_opw_kinematics::kinematics_impl::OPWKinematics;
use rs_opw_kinematics::parameters::opw_kinematics::Parameters;

/// Our arm.
///
/// # Panics
/// The model comes with the kinematics crate; without it there is nothing to measure.
#[must_use]
pub fn arm() -> &'static ArmModel {
    ArmModel::builtin("fanuc-m20ia").expect("the M-20iA is built in")
}

/// The same arm for rs-opw-kinematics, in meters. The pendant's J3 + J2 is its J3.
#[must_use]
pub fn peer() -> OPWKinematics {
    OPWKinematics::new(Parameters {
        a1: 0.150,
        a2: -0.250,
        b: 0.0,
        c1: 0.0,
        c2: 0.790,
        c3: 0.835,
        c4: 0.100,
        offsets: [0.0, 0.0, -FRAC_PI_2, 0.0, 0.0, PI],
        sign_corrections: [1, 1, -1, -1, -1, -1],
        dof: 6,
    })
}

/// One pose, as each side wants it.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Our joints.
    pub joints: PendantJoints,
    /// The flange at these joints.
    pub pose: Pose,
    /// The peer's joints.
    pub peer_joints: [f64; 6],
    /// The peer's pose.
    pub peer_pose: rs_opw_kinematics::pose::Pose,
}

impl Case {
    /// The pose at these joints.
    #[must_use]
    pub fn of(joints: PendantJoints) -> Self {
        let pose = arm().forward(&joints);
        let [j1, j2, j3, j4, j5, j6] = joints.radians();
        let peer_joints = [j1, j2, j3 + j2, j4, j5, j6];
        Self {
            joints,
            pose,
            peer_joints,
            peer_pose: peer_pose(&pose),
        }
    }
}

/// Poses made of random joints inside the limits; the same ones in every run.
#[must_use]
pub fn cases(count: usize) -> Vec<Case> {
    let mut random = Random(20_260_722);
    let case = |_| {
        Case::of(PendantJoints::from_degrees(Axis::ALL.map(|axis| {
            let limits = arm().limits(axis);
            limits.min.0 + random.part() * (limits.max.0 - limits.min.0)
        })))
    };
    (0..count).map(case).collect()
}

/// The Jacobian as one writes it down: the links of the table one after the other, cross products.
#[derive(Clone, Debug)]
pub struct Straight {
    arm: ArmModel,
    /// a, d, sine and cosine of the twist.
    links: [[f64; 4]; 6],
}

impl Straight {
    /// For this arm.
    #[must_use]
    pub fn of(arm: &ArmModel) -> Self {
        let links = arm.dh().map(|link| {
            let (sine, cosine) = link.alpha.0.sin_cos();
            [link.a.0, link.d.0, sine, cosine]
        });
        let arm = arm.clone();
        Self { arm, links }
    }

    /// Columns for the pendant's joints: linear above angular velocity.
    #[must_use]
    pub fn jacobian(&self, joints: &PendantJoints) -> [[f64; 6]; 6] {
        let (mut x, mut y, mut z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
        let mut p = [0.0; 3];
        let mut axes = [([0.0; 3], [0.0; 3]); 6];
        let angles = self.arm.chain(joints).radians();
        for ((axis, [a, d, sa, ca]), q) in axes.iter_mut().zip(self.links).zip(angles) {
            *axis = (z, p);
            let (s, c) = q.sin_cos();
            let turned = mix(x, c, y, s);
            let side = mix(y, c, x, -s);
            p = mix(mix(p, 1.0, turned, a), 1.0, z, d);
            (x, y, z) = (turned, mix(side, ca, z, sa), mix(z, ca, side, -sa));
        }
        let column = |(axis, point): ([f64; 3], [f64; 3])| {
            let [rx, ry, rz] = mix(p, 1.0, point, -1.0);
            let [zx, zy, zz] = axis;
            [
                zy * rz - zz * ry,
                zz * rx - zx * rz,
                zx * ry - zy * rx,
                zx,
                zy,
                zz,
            ]
        };
        let [j1, j2, j3, j4, j5, j6] = axes.map(column);
        // The M-20iA: which way each joint counts, and J2 turns the third angle as well.
        let [mut two, three] = [j2.map(|v| -v), j3];
        for (two, three) in two.iter_mut().zip(three) {
            *two += three;
        }
        [j1, two, three, j4.map(|v| -v), j5, j6.map(|v| -v)]
    }
}

fn mix([ax, ay, az]: [f64; 3], by_a: f64, [bx, by, bz]: [f64; 3], by_b: f64) -> [f64; 3] {
    [
        ax * by_a + bx * by_b,
        ay * by_a + by * by_b,
        az * by_a + bz * by_b,
    ]
}

fn peer_pose(pose: &Pose) -> rs_opw_kinematics::pose::Pose {
    let isometry = pose.isometry();
    let (p, q) = (
        isometry.translation.vector / 1000.0,
        isometry.rotation.coords,
    );
    let mut pose = rs_opw_kinematics::pose::Pose::IDENTITY;
    pose.translation = [p.x, p.y, p.z].into();
    (pose.rotation.x, pose.rotation.y) = (q.x, q.y);
    (pose.rotation.z, pose.rotation.w) = (q.z, q.w);
    pose
}

/// A linear congruential generator (Knuth, MMIX): good enough to spread joints, and the same
/// everywhere.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    /// From 0 to 1.
    pub(crate) fn part(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        f64::from(u32::try_from(self.0 >> 32).unwrap_or(0)) / f64::from(u32::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_straight_jacobian_is_the_arms() {
        for case in cases(100) {
            let straight = Straight::of(arm()).jacobian(&case.joints);
            let ours = arm().jacobian(&case.joints);
            for (ours, straight) in ours.iter().zip(straight.as_flattened()) {
                assert!((ours - straight).abs() < 1e-10, "{}", case.joints);
            }
        }
    }
}
