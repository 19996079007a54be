//! Forward kinematics: the flange's pose of the chain's joints, for one set of joints or for
//! several side by side.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use crate::geometry::Geometry;
use crate::joints::{ChainJoints, PendantJoints};
use crate::lanes::{
    LANES, Lane, Level, Number, One, Simd, SimdFrom, difference, dispatch, side_by_side, sum,
    transpose,
};
use crate::model::ArmModel;
use crate::pose::Pose;
use crate::trigonometry::{sin_cos, sin_cos_of_small};

impl ArmModel {
    /// `X_WF` at each of `joints`, given to `each` with its index, in order: [`Self::forward`] for
    /// four joint sets at a time.
    pub fn forward_batch(&self, joints: &[PendantJoints], mut each: impl FnMut(usize, &Pose)) {
        let mut index = 0;
        for joints in joints.chunks(LANES) {
            let poses = group(self, joints);
            for (_, pose) in joints.iter().zip(&poses) {
                each(index, pose);
                index += 1;
            }
        }
    }
}

fn group(model: &ArmModel, joints: &[PendantJoints]) -> [Pose; LANES] {
    dispatch!(model.level, simd => four(simd, model, joints))
}

#[inline(always)]
fn four<S: Simd>(simd: S, model: &ArmModel, joints: &[PendantJoints]) -> [Pose; LANES] {
    let g = &model.geometry;
    let [q1, q2, q3, q4, q5, q6] = model.coupling.chain(&side_by_side(simd, joints));
    let [a, b, c] = sin_cos(Arm::angles(q1, q2, q3));
    let arm = Arm::compose(g, a, b, c);
    let [a, b, c] = sin_cos(Wrist::angles(q4, q5, q6));
    let wrist = Wrist::compose(g, a, b, c);
    let Flange {
        position: [x, y, z],
        rotation: [w, i, j, k],
    } = Flange::of(g, &arm, &wrist);
    let [first, second, third, fourth] = transpose(&[x, y, z, w, i, j, k]);
    [pose(first), pose(second), pose(third), pose(fourth)]
}

/// Of position and rotation, real part first.
#[inline(always)]
fn pose([x, y, z, w, i, j, k]: [f64; 7]) -> Pose {
    Pose::from_parts(
        Vector3::new(x, y, z),
        UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k)),
    )
}

/// `X_WF` of the chain's joints.
pub(crate) fn flange(level: Level, geometry: &Geometry, joints: &ChainJoints) -> Pose {
    dispatch!(level, simd => flange_with(simd, geometry, joints))
}

#[inline(always)]
fn flange_with<S: Simd>(simd: S, geometry: &Geometry, joints: &ChainJoints) -> Pose {
    let [q1, q2, q3, q4, q5, q6] = joints.radians();
    // The six angles in two vectors, instead of one by one.
    let [a, b, c] = Arm::angles(q1, q2, q3);
    let [d, e, f] = Wrist::angles(q4, q5, q6);
    let [(sines, cosines), more] = sin_cos([
        Lane::simd_from(simd, [a, b, c, f]),
        Lane::simd_from(simd, [d, e, d, e]),
    ]);
    let [sa, sb, sc, sf]: [f64; 4] = sines.into();
    let [ca, cb, cc, cf]: [f64; 4] = cosines.into();
    let [sd, se, ..]: [f64; 4] = more.0.into();
    let [cd, ce, ..]: [f64; 4] = more.1.into();
    let turn = |sine, cosine| (One::new(simd, sine), One::new(simd, cosine));
    let arm = Arm::compose(geometry, turn(sa, ca), turn(sb, cb), turn(sc, cc));
    let wrist = Wrist::compose(geometry, turn(sd, cd), turn(se, ce), turn(sf, cf));
    let Flange {
        position: [x, y, z],
        rotation: [w, i, j, k],
    } = Flange::of(geometry, &arm, &wrist);
    pose([x, y, z, w, i, j, k].map(|number| number.value))
}

/// Sine and cosine.
type Turn<N> = (N, N);

/// What axes 1, 2 and 3 do: the wrist center, and the forearm's rotation with the twist of link 3.
///
/// Rotations are multiplied as quaternions, real part first. With right angles between the axes
/// each factor is short, a and b being half angles: `Z(a) X(±90) Z(b) = (cos(a+b), ±cos(a-b),
/// ±sin(a-b), sin(a+b)) / sqrt 2`. The factors of `1 / sqrt 2` are left to the end.
#[derive(Clone, Copy)]
pub(crate) struct Arm<N> {
    wrist_center: [N; 3],
    rotation: [N; 4],
}

impl<S: Simd> Arm<Lane<S>> {
    /// Of the chain's first three joints, none of them many turns away.
    #[inline(always)]
    pub(crate) fn of(g: &Geometry, q1: Lane<S>, q2: Lane<S>, q3: Lane<S>) -> Self {
        let [a, b, c] = sin_cos_of_small(Self::angles(q1, q2, q3));
        Self::compose(g, a, b, c)
    }
}

impl<N: Number> Arm<N> {
    /// The angles whose sines and cosines are needed.
    #[inline(always)]
    fn angles(q1: N, q2: N, q3: N) -> [N; 3] {
        let q23 = q2 + q3;
        [q2, (q1 + q23) * 0.5, (q1 - q23) * 0.5]
    }

    #[inline(always)]
    fn compose(g: &Geometry, (s2, c2): Turn<N>, (sp, cp): Turn<N>, (sm, cm): Turn<N>) -> Self {
        let (sp_cm, cp_cm) = (sp * cm, cp * cm);
        let (s1, c1) = (cp.times_plus(sm, sp_cm), sp.times_plus(-sm, cp_cm));
        let (s23, c23) = (cp.times_plus(-sm, sp_cm), sp.times_plus(sm, cp_cm));
        let (reach_x, reach_y) = (g.forearm * g.forearm_cos, g.forearm * g.forearm_sin);
        let forward = s23.scaled_plus(-reach_y, c23.scaled_plus(reach_x, c2 * g.a2 + g.a1));
        let up = c23.scaled_plus(reach_y, s23.scaled_plus(reach_x, s2 * g.a2));
        let lateral = -g.s1 * g.lateral;
        Self {
            wrist_center: [
                s1.scaled_plus(-lateral, c1 * forward),
                c1.scaled_plus(lateral, s1 * forward),
                up * g.s1 + g.d1,
            ],
            rotation: twisted([cp, cm * g.s1, sm * g.s1, sp], g.s3),
        }
    }
}

/// What axes 4, 5 and 6 do: the flange's rotation against the forearm.
#[derive(Clone, Copy)]
pub(crate) struct Wrist<N> {
    rotation: [N; 4],
}

impl<S: Simd> Wrist<Lane<S>> {
    /// Of the chain's last three joints, none of them many turns away.
    #[inline(always)]
    pub(crate) fn of(g: &Geometry, q4: Lane<S>, q5: Lane<S>, q6: Lane<S>) -> Self {
        let [a, b, c] = sin_cos_of_small(Self::angles(q4, q5, q6));
        Self::compose(g, a, b, c)
    }
}

impl<N: Number> Wrist<N> {
    /// The angles whose sines and cosines are needed.
    #[inline(always)]
    fn angles(q4: N, q5: N, q6: N) -> [N; 3] {
        [(q4 + q5) * 0.5, (q4 - q5) * 0.5, q6 * 0.5]
    }

    #[inline(always)]
    fn compose(g: &Geometry, (sp, cp): Turn<N>, (sm, cm): Turn<N>, (s6, c6): Turn<N>) -> Self {
        let [w, x, y, z] = twisted([cp, cm * g.s4, sm * g.s4, sp], g.s5);
        Self {
            rotation: [
                difference((w, c6), (z, s6)),
                sum((x, c6), (y, s6)),
                difference((y, c6), (x, s6)),
                sum((z, c6), (w, s6)),
            ],
        }
    }
}

/// Position in millimeters, and rotation as a unit quaternion, real part first.
#[derive(Clone, Copy)]
pub(crate) struct Flange<N> {
    pub(crate) position: [N; 3],
    pub(crate) rotation: [N; 4],
}

impl<N: Number> Flange<N> {
    #[inline(always)]
    pub(crate) fn of(g: &Geometry, arm: &Arm<N>, wrist: &Wrist<N>) -> Self {
        let [w, x, y, z] = product(arm.rotation, wrist.rotation);
        // Four factors of 1 / sqrt 2 were left out.
        let (w, x, y, z) = (w * 0.25, x * 0.25, y * 0.25, z * 0.25);
        let [x_WC, y_WC, z_WC] = arm.wrist_center;
        // Along the flange's axis, the third column of the rotation.
        let twice = 2.0 * g.d6;
        Self {
            position: [
                sum((x, z), (w, y)).scaled_plus(twice, x_WC),
                difference((y, z), (w, x)).scaled_plus(twice, y_WC),
                sum((x, x), (y, y)).scaled_plus(-twice, z_WC + g.d6),
            ],
            rotation: [w, x, y, z],
        }
    }
}

/// A quaternion times `1 + sine * i`: a twist of ±90 degrees about X, but for the length.
#[inline(always)]
fn twisted<N: Number>([w, x, y, z]: [N; 4], sine: f64) -> [N; 4] {
    [
        x.scaled_plus(-sine, w),
        w.scaled_plus(sine, x),
        z.scaled_plus(sine, y),
        y.scaled_plus(-sine, z),
    ]
}

/// The product of two quaternions, real part first.
#[inline(always)]
fn product<N: Number>([aw, ax, ay, az]: [N; 4], [bw, bx, by, bz]: [N; 4]) -> [N; 4] {
    [
        plus((-az, bz), plus((-ay, by), difference((aw, bw), (ax, bx)))),
        plus((-az, by), plus((ay, bz), sum((aw, bx), (ax, bw)))),
        plus((az, bx), plus((ay, bw), difference((aw, by), (ax, bz)))),
        plus((az, bw), plus((-ay, bx), sum((aw, bz), (ax, by)))),
    ]
}

#[inline(always)]
fn plus<N: Number>((a, b): (N, N), rest: N) -> N {
    a.times_plus(b, rest)
}

#[cfg(test)]
pub(crate) mod tests {
    use nalgebra::Matrix4;
    use proptest::prelude::*;

    use super::*;
    use crate::dh::DhLink;
    use crate::joints::Axis;
    use units::{Degrees, Millimeters, Radians};

    /// Any arm the closed form covers: every mix of twists, with a lateral offset.
    pub(crate) fn any_table() -> impl Strategy<Value = [DhLink; 6]> {
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
            for level in [Level::new(), Level::baseline()] {
                let flange = flange(level, &Geometry::try_from_dh(&links).unwrap(), &joints);
                let difference = flange.isometry().to_homogeneous() - product;
                prop_assert!(difference.amax() < 1e-11, "{}", difference);
            }
        }
    }
}
