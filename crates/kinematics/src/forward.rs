//! Forward kinematics: the flange's pose of the chain's joints, for one set of joints or for
//! several side by side.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it, and a call a lane would undo the point of lanes"
)]

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::geometry::Geometry;
use crate::joints::ChainJoints;
use crate::lanes::Lanes;
use crate::pose::Pose;
use crate::trigonometry::sin_cos;

/// `X_WF` of the chain's joints.
#[multiversion::multiversion(targets("x86_64+avx2+fma"))]
pub(crate) fn flange(geometry: &Geometry, joints: &ChainJoints) -> Pose {
    let [q1, q2, q3, q4, q5, q6] = joints.radians().map(|q| Lanes([q]));
    // One call for six angles, instead of six calls for one.
    let [a, b, c] = Arm::angles(q1, q2, q3);
    let [d, e, f] = Wrist::angles(q4, q5, q6);
    let angles = Lanes([a, b, c, d, e, f].map(|Lanes([angle])| angle));
    let (Lanes(sines), Lanes(cosines)) = sin_cos(angles);
    let [sa, sb, sc, sd, se, sf] = sines.map(|sine| Lanes([sine]));
    let [ca, cb, cc, cd, ce, cf] = cosines.map(|cosine| Lanes([cosine]));
    let arm = Arm::compose(geometry, (sa, ca), (sb, cb), (sc, cc));
    let wrist = Wrist::compose(geometry, (sd, cd), (se, ce), (sf, cf));
    let Flange { position, rotation } = Flange::of(geometry, &arm, &wrist);
    let [x, y, z] = position.map(|Lanes([value])| value);
    let [w, i, j, k] = rotation.map(|Lanes([value])| value);
    Pose::from_parts(
        Vector3::new(x, y, z),
        UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k)),
    )
}

/// Sine and cosine.
type Turn<const N: usize> = (Lanes<N>, Lanes<N>);

/// What axes 1, 2 and 3 do: the wrist center, and the forearm's rotation with the twist of link 3.
///
/// Rotations are multiplied as quaternions, real part first. With right angles between the axes
/// each factor is short, a and b being half angles: `Z(a) X(±90) Z(b) = (cos(a+b), ±cos(a-b),
/// ±sin(a-b), sin(a+b)) / sqrt 2`. The factors of `1 / sqrt 2` are left to the end.
#[derive(Clone, Copy)]
pub(crate) struct Arm<const N: usize> {
    wrist_center: [Lanes<N>; 3],
    rotation: [Lanes<N>; 4],
}

impl<const N: usize> Arm<N> {
    /// Of the chain's first three joints.
    #[inline(always)]
    pub(crate) fn of(g: &Geometry, q1: Lanes<N>, q2: Lanes<N>, q3: Lanes<N>) -> Self {
        let [a, b, c] = Self::angles(q1, q2, q3);
        Self::compose(g, sin_cos(a), sin_cos(b), sin_cos(c))
    }

    /// The angles whose sines and cosines are needed.
    #[inline(always)]
    fn angles(q1: Lanes<N>, q2: Lanes<N>, q3: Lanes<N>) -> [Lanes<N>; 3] {
        let q23 = q2 + q3;
        [q2, (q1 + q23) * 0.5, (q1 - q23) * 0.5]
    }

    #[inline(always)]
    fn compose(g: &Geometry, (s2, c2): Turn<N>, (sp, cp): Turn<N>, (sm, cm): Turn<N>) -> Self {
        let (s1, c1) = (sp * cm + cp * sm, cp * cm - sp * sm);
        let (s23, c23) = (sp * cm - cp * sm, cp * cm + sp * sm);
        let (reach_x, reach_y) = (g.forearm * g.forearm_cos, g.forearm * g.forearm_sin);
        let forward = c2 * g.a2 + c23 * reach_x - s23 * reach_y + g.a1;
        let up = s2 * g.a2 + s23 * reach_x + c23 * reach_y;
        let lateral = -g.s1 * g.lateral;
        Self {
            wrist_center: [
                c1 * forward - s1 * lateral,
                s1 * forward + c1 * lateral,
                up * g.s1 + g.d1,
            ],
            rotation: twisted([cp, cm * g.s1, sm * g.s1, sp], g.s3),
        }
    }
}

/// What axes 4, 5 and 6 do: the flange's rotation against the forearm.
#[derive(Clone, Copy)]
pub(crate) struct Wrist<const N: usize> {
    rotation: [Lanes<N>; 4],
}

impl<const N: usize> Wrist<N> {
    /// Of the chain's last three joints.
    #[inline(always)]
    pub(crate) fn of(g: &Geometry, q4: Lanes<N>, q5: Lanes<N>, q6: Lanes<N>) -> Self {
        let [a, b, c] = Self::angles(q4, q5, q6);
        Self::compose(g, sin_cos(a), sin_cos(b), sin_cos(c))
    }

    /// The angles whose sines and cosines are needed.
    #[inline(always)]
    fn angles(q4: Lanes<N>, q5: Lanes<N>, q6: Lanes<N>) -> [Lanes<N>; 3] {
        [(q4 + q5) * 0.5, (q4 - q5) * 0.5, q6 * 0.5]
    }

    #[inline(always)]
    fn compose(g: &Geometry, (sp, cp): Turn<N>, (sm, cm): Turn<N>, (s6, c6): Turn<N>) -> Self {
        let [w, x, y, z] = twisted([cp, cm * g.s4, sm * g.s4, sp], g.s5);
        Self {
            rotation: [
                w * c6 - z * s6,
                x * c6 + y * s6,
                y * c6 - x * s6,
                z * c6 + w * s6,
            ],
        }
    }
}

/// Position in millimeters, and rotation as a unit quaternion, real part first.
#[derive(Clone, Copy)]
pub(crate) struct Flange<const N: usize> {
    pub(crate) position: [Lanes<N>; 3],
    pub(crate) rotation: [Lanes<N>; 4],
}

impl<const N: usize> Flange<N> {
    #[inline(always)]
    pub(crate) fn of(g: &Geometry, arm: &Arm<N>, wrist: &Wrist<N>) -> Self {
        let [w, x, y, z] = product(arm.rotation, wrist.rotation);
        // Four factors of 1 / sqrt 2 were left out.
        let (w, x, y, z) = (w * 0.25, x * 0.25, y * 0.25, z * 0.25);
        let [x_WC, y_WC, z_WC] = arm.wrist_center;
        // Along the flange's axis, the third column of the rotation.
        let (along_x, along_y) = (
            (x * z + w * y) * (2.0 * g.d6),
            (y * z - w * x) * (2.0 * g.d6),
        );
        let along_z = (x * x + y * y) * (-2.0 * g.d6) + g.d6;
        Self {
            position: [x_WC + along_x, y_WC + along_y, z_WC + along_z],
            rotation: [w, x, y, z],
        }
    }
}

/// A quaternion times `1 + sine * i`: a twist of ±90 degrees about X, but for the length.
#[inline(always)]
fn twisted<const N: usize>([w, x, y, z]: [Lanes<N>; 4], sine: f64) -> [Lanes<N>; 4] {
    [w - x * sine, x + w * sine, y + z * sine, z - y * sine]
}

/// The product of two quaternions, real part first.
#[inline(always)]
fn product<const N: usize>(
    [aw, ax, ay, az]: [Lanes<N>; 4],
    [bw, bx, by, bz]: [Lanes<N>; 4],
) -> [Lanes<N>; 4] {
    [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix4;
    use proptest::prelude::*;

    use super::*;
    use crate::dh::DhLink;
    use crate::joints::Axis;
    use units::{Degrees, Millimeters, Radians};

    /// Any arm the closed form covers: every mix of twists, with a lateral offset.
    fn any_table() -> impl Strategy<Value = [DhLink; 6]> {
        let sign = prop::array::uniform4(prop::sample::select(vec![-1.0, 1.0]));
        let length = prop::array::uniform8(-900.0..900.0_f64);
        (sign, length).prop_map(|([s1, s3, s4, s5], [d1, d2, d3, d4, d6, a1, a2, a3])| {
            let row = |d, a, sine: f64| DhLink {
                d: Millimeters(d),
                a: Millimeters(a),
                alpha: Radians::from(Degrees(90.0 * sine)),
            };
            [
                row(d1, a1, s1),
                row(d2, a2.abs() + 1.0, 0.0),
                row(d3, a3, s3),
                row(d4, 0.0, s4),
                row(0.0, 0.0, s5),
                row(d6, 0.0, 0.0),
            ]
        })
    }

    proptest! {
        #[test]
        fn the_closed_form_is_the_product_of_the_links(
            links in any_table(),
            q in prop::array::uniform6(-7.0..7.0_f64),
        ) {
            let joints = ChainJoints::from_radians(q);
            let product = Axis::ALL.into_iter().fold(Matrix4::identity(), |so_far, axis| {
                so_far * axis.of(&links).transform(Radians(axis.of(&q)))
            });
            let flange = flange(&Geometry::try_from_dh(&links).unwrap(), &joints);
            let difference = flange.isometry().to_homogeneous() - product;
            prop_assert!(difference.amax() < 1e-11, "{}", difference);
        }
    }
}
