//! Forward kinematics: the flange's pose of the chain's joints, for one set of joints or for several side by side.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::geometry::Geometry;
use crate::joints::ChainJoints;
use crate::lanes::Lanes;
use crate::pose::Pose;
use crate::trigonometry::sin_cos;

/// `X_WF` of the chain's joints.
pub(crate) fn flange(geometry: &Geometry, joints: &ChainJoints) -> Pose {
    let chain = joints.radians().map(|q| Lanes([q]));
    // One call for six angles, instead of six calls for one.
    let (sines, cosines) = sin_cos(Lanes(angles(&chain).map(|Lanes([angle])| angle)));
    let [a, b, c, d, e, f] = sines.0.map(|sine| Lanes([sine]));
    let [k, l, m, n, o, p] = cosines.0.map(|cosine| Lanes([cosine]));
    let turned = [(a, k), (b, l), (c, m), (d, n), (e, o), (f, p)];
    let Flange { position, rotation } = compose(geometry, &turned);
    let [x, y, z] = position.map(|Lanes([value])| value);
    let [w, i, j, k] = rotation.map(|Lanes([value])| value);
    Pose::from_parts(
        Vector3::new(x, y, z),
        UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k)),
    )
}

/// Position in millimeters, and rotation as a unit quaternion, real part first.
#[derive(Clone, Copy)]
pub(crate) struct Flange<const N: usize> {
    pub(crate) position: [Lanes<N>; 3],
    pub(crate) rotation: [Lanes<N>; 4],
}

/// The flanges of several sets of chain joints.
#[inline]
pub(crate) fn flanges<const N: usize>(geometry: &Geometry, chain: &[Lanes<N>; 6]) -> Flange<N> {
    compose(geometry, &angles(chain).map(sin_cos))
}

/// The angles whose sines and cosines the flange is made of: the wrist center needs q2, and the quaternions of two
/// axes at right angles need half the sum and half the difference of their angles.
#[inline]
fn angles<const N: usize>(&[q1, q2, q3, q4, q5, q6]: &[Lanes<N>; 6]) -> [Lanes<N>; 6] {
    let q23 = q2 + q3;
    [
        q2,
        (q1 + q23) * 0.5,
        (q1 - q23) * 0.5,
        (q4 + q5) * 0.5,
        (q4 - q5) * 0.5,
        q6 * 0.5,
    ]
}

/// The product of the six transforms, from sines and cosines of [`angles`].
///
/// Rotations are multiplied as quaternions. With right angles between the axes each factor is short:
/// `Z(a) X(±90) Z(b) = (cos(a+b), ±cos(a-b), ±sin(a-b), sin(a+b)) / sqrt 2`, a and b being half angles.
#[inline]
fn compose<const N: usize>(
    g: &Geometry,
    &[
        (s2, c2),
        (sp1, cp1),
        (sm1, cm1),
        (sp4, cp4),
        (sm4, cm4),
        (s6, c6),
    ]: &[(Lanes<N>, Lanes<N>); 6],
) -> Flange<N> {
    // Axes 1 and 2 + 3, then the twist of link 3.
    let arm = twisted([cp1, cm1 * g.s1, sm1 * g.s1, sp1], g.s3);
    // Axes 4 and 5, then the twist of link 5, then axis 6.
    let [w, x, y, z] = twisted([cp4, cm4 * g.s4, sm4 * g.s4, sp4], g.s5);
    let wrist = [
        w * c6 - z * s6,
        x * c6 + y * s6,
        y * c6 - x * s6,
        z * c6 + w * s6,
    ];
    // Four factors of 1 / sqrt 2 were left out.
    let [w, x, y, z] = product(arm, wrist).map(|part| part * 0.25);

    let (s1, c1) = (sp1 * cm1 + cp1 * sm1, cp1 * cm1 - sp1 * sm1);
    let (s23, c23) = (sp1 * cm1 - cp1 * sm1, cp1 * cm1 + sp1 * sm1);
    let forearm_x = c23 * (g.forearm * g.forearm_cos) - s23 * (g.forearm * g.forearm_sin);
    let forearm_y = s23 * (g.forearm * g.forearm_cos) + c23 * (g.forearm * g.forearm_sin);
    let forward = c2 * g.a2 + forearm_x + g.a1;
    let up = (s2 * g.a2 + forearm_y) * g.s1 + g.d1;
    let lateral = -g.s1 * g.lateral;
    // The flange's axis, out of the quaternion.
    let (axis_x, axis_y) = ((x * z + w * y) * 2.0, (y * z - w * x) * 2.0);
    let axis_z = (x * x + y * y) * -2.0 + 1.0;
    Flange {
        position: [
            c1 * forward - s1 * lateral + axis_x * g.d6,
            s1 * forward + c1 * lateral + axis_y * g.d6,
            up + axis_z * g.d6,
        ],
        rotation: [w, x, y, z],
    }
}

/// A quaternion times `1 + sine * i`: a twist of ±90 degrees about X, but for the length.
#[inline]
fn twisted<const N: usize>([w, x, y, z]: [Lanes<N>; 4], sine: f64) -> [Lanes<N>; 4] {
    [w - x * sine, x + w * sine, y + z * sine, z - y * sine]
}

/// The product of two quaternions, real part first.
#[inline]
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
