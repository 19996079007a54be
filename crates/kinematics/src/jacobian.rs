//! The geometric Jacobian of an ortho-parallel arm, for one set of joints or four side by side.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use nalgebra::Matrix6;

use crate::coupling::Coupling;
use crate::geometry::Geometry;
use crate::joints::PendantJoints;
use crate::lanes::{
    LANES, Lane, Number, Simd, SimdFrom, difference, dispatch, side_by_side, sum, transpose,
};
use crate::model::ArmModel;
use crate::trigonometry::sin_cos;

impl ArmModel {
    /// The geometric Jacobian at `joints`: the velocity of the flange's origin in the world, in
    /// millimeters, above its angular velocity in the world, for each radian of each of the
    /// pendant's joints.
    ///
    /// Textbook (1.81) with the closed form's axes: five angles are all there is to turn.
    #[must_use]
    pub fn jacobian(&self, joints: &PendantJoints) -> Matrix6<f64> {
        dispatch!(self.level, simd => one(simd, self, joints))
    }

    /// The Jacobian at each of `joints`, given to `each` with its index, in order.
    pub fn jacobian_batch(
        &self,
        joints: &[PendantJoints],
        mut each: impl FnMut(usize, &Matrix6<f64>),
    ) {
        let mut index = 0;
        for joints in joints.chunks(LANES) {
            let jacobians = group(self, joints);
            for (_, jacobian) in joints.iter().zip(&jacobians) {
                each(index, jacobian);
                index += 1;
            }
        }
    }
}

fn group(model: &ArmModel, joints: &[PendantJoints]) -> [Matrix6<f64>; LANES] {
    dispatch!(model.level, simd => four(simd, model, joints))
}

#[inline(always)]
fn one<S: Simd>(simd: S, model: &ArmModel, joints: &PendantJoints) -> Matrix6<f64> {
    let [q1, q2, q3, q4, q5, _] = model.coupling.chain(&joints.radians());
    let [(sines, cosines), (s5, c5)] = sin_cos([
        Lane::simd_from(simd, [q1, q2, q2 + q3, q4]),
        Lane::simd_from(simd, q5),
    ]);
    let [s1, s2, s23, s4]: [f64; 4] = sines.into();
    let [c1, c2, c23, c4]: [f64; 4] = cosines.into();
    let ([s5, ..], [c5, ..]): ([f64; 4], [f64; 4]) = (s5.into(), c5.into());
    let turns = [(s1, c1), (s2, c2), (s23, c23), (s4, c4), (s5, c5)];
    let columns = columns(&model.geometry, &model.coupling, turns);
    Matrix6::from_column_slice(columns.as_flattened())
}

#[inline(always)]
fn four<S: Simd>(simd: S, model: &ArmModel, joints: &[PendantJoints]) -> [Matrix6<f64>; LANES] {
    let [q1, q2, q3, q4, q5, _] = model.coupling.chain(&side_by_side(simd, joints));
    let [t1, t2, t23] = sin_cos([q1, q2, q2 + q3]);
    let [t4, t5] = sin_cos([q4, q5]);
    let columns = columns(&model.geometry, &model.coupling, [t1, t2, t23, t4, t5]);
    let mut jacobians = [Matrix6::zeros(); LANES];
    for (index, column) in columns.iter().enumerate() {
        for (jacobian, column) in jacobians.iter_mut().zip(transpose(column)) {
            jacobian.column_mut(index).copy_from_slice(&column);
        }
    }
    jacobians
}

/// Sine and cosine.
type Turn<N> = (N, N);

/// The six columns, out of q1, q2, q2 + q3, q4 and q5.
///
/// Written with the frames of the table: `z1` is the direction of axes 2 and 3, `x3` and `z3` are
/// the forearm's, `z4` and `z5` the directions of axes 5 and 6. The wrist center is on axes 4 to 6.
#[inline(always)]
fn columns<N: Number>(
    g: &Geometry,
    coupling: &Coupling,
    [(s1, c1), (s2, c2), (s23, c23), (s4, c4), (s5, c5)]: [Turn<N>; 5],
) -> [[N; 6]; 6] {
    let (zero, one) = (c1.like(0.0), c1.like(1.0));
    let z1 = (s1 * g.s1, c1 * -g.s1);
    let x3 = [c1 * c23, s1 * c23, s23 * g.s1];
    let side = s23 * g.s3;
    let z3 = [c1 * side, s1 * side, c23 * (-g.s1 * g.s3)];
    // Axis 2 is at right angles to the arm's plane: y3 = +-z1.
    let y3 = [z1.0 * g.s3, z1.1 * g.s3, zero];
    let z4 = along(x3, s4 * g.s4, y3, c4 * -g.s4);
    let x4 = along(x3, c4, y3, s4);
    // y4 = +-z3
    let z5 = along(x4, s5 * g.s5, z3, c5 * (-g.s4 * g.s5));

    // In the arm's plane, from axis 2: the elbow and the wrist center.
    let elbow = (c2 * g.a2, s2 * (g.a2 * g.s1));
    let (reach_x, reach_y) = (g.forearm * g.forearm_cos, g.forearm * g.forearm_sin);
    let forearm = (
        s23.scaled_plus(-reach_y, c23 * reach_x),
        c23.scaled_plus(reach_y, s23 * reach_x) * g.s1,
    );
    let hand = [z5[0] * g.d6, z5[1] * g.d6, z5[2] * g.d6];
    // From axis 3 and axis 2 to the flange, but for what is along these axes.
    let from_3 = [
        c1.times_plus(forearm.0, hand[0]),
        s1.times_plus(forearm.0, hand[1]),
        forearm.1 + hand[2],
    ];
    let from_2 = [
        c1.times_plus(elbow.0, from_3[0]),
        s1.times_plus(elbow.0, from_3[1]),
        from_3[2] + elbow.1,
    ];
    // The flange from axis 1, with the offset of the arm's plane.
    let lateral = -g.s1 * g.lateral;
    let x = s1.scaled_plus(-lateral, c1.scaled_plus(g.a1, from_2[0]));
    let y = c1.scaled_plus(lateral, s1.scaled_plus(g.a1, from_2[1]));

    let column_2 = about(z1, from_2);
    let column_3 = about(z1, from_3);
    let [k1, k2, k3, k4, k5, k6] = coupling.signs;
    // J2 turns the third angle as well.
    let both = k2 + coupling.j2_in_q3;
    let [vx, vy, vz] = column_2;
    let [wx, wy, wz] = column_3;
    let (vx, vy, vz) = (
        wx.scaled_plus(coupling.j2_in_q3, vx * k2),
        wy.scaled_plus(coupling.j2_in_q3, vy * k2),
        wz.scaled_plus(coupling.j2_in_q3, vz * k2),
    );
    [
        [y * -k1, x * k1, zero, zero, zero, one * k1],
        [vx, vy, vz, z1.0 * both, z1.1 * both, zero],
        signed([wx, wy, wz, z1.0, z1.1, zero], k3),
        signed(turning(z3, hand), k4),
        signed(turning(z4, hand), k5),
        signed([zero, zero, zero, z5[0], z5[1], z5[2]], k6),
    ]
}

/// `a * by_a + b * by_b`
#[inline(always)]
fn along<N: Number>(a: [N; 3], by_a: N, b: [N; 3], by_b: N) -> [N; 3] {
    [
        sum((a[0], by_a), (b[0], by_b)),
        sum((a[1], by_a), (b[1], by_b)),
        sum((a[2], by_a), (b[2], by_b)),
    ]
}

/// The velocity at `way` from a level axis.
#[inline(always)]
fn about<N: Number>((x, y): (N, N), way: [N; 3]) -> [N; 3] {
    [
        y * way[2],
        -(x * way[2]),
        difference((x, way[1]), (y, way[0])),
    ]
}

/// The velocity at `way` from an axis, and the angular velocity.
#[inline(always)]
fn turning<N: Number>(axis: [N; 3], way: [N; 3]) -> [N; 6] {
    let ([x, y, z], [wx, wy, wz]) = (axis, way);
    [
        difference((y, wz), (z, wy)),
        difference((z, wx), (x, wz)),
        difference((x, wy), (y, wx)),
        x,
        y,
        z,
    ]
}

#[inline(always)]
fn signed<N: Number>([a, b, c, d, e, f]: [N; 6], sign: f64) -> [N; 6] {
    [a * sign, b * sign, c * sign, d * sign, e * sign, f * sign]
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix4, Vector3};
    use proptest::prelude::*;
    use units::Radians;

    use super::*;
    use crate::forward::tests::any_table;
    use crate::joints::Axis;

    proptest! {
        /// (1.80) with the frames of the table.
        #[test]
        fn the_closed_form_is_the_cross_products_of_the_links(
            links in any_table(),
            q in prop::array::uniform6(-7.0..7.0_f64),
        ) {
            let plain = Coupling { signs: [1.0; 6], offsets: [0.0; 6], j2_in_q3: 0.0 };
            let mut frames = vec![Matrix4::identity()];
            for axis in Axis::ALL {
                let last = *frames.last().unwrap();
                frames.push(last * axis.of(&links).transform(Radians(axis.of(&q))));
            }
            let point = |frame: &Matrix4<f64>| Vector3::new(frame[(0, 3)], frame[(1, 3)], frame[(2, 3)]);
            let flange = point(&frames[6]);
            let [q1, q2, q3, q4, q5, _] = q;
            let turns = [q1, q2, q2 + q3, q4, q5].map(f64::sin_cos);
            let found = columns(&Geometry::try_from_dh(&links).unwrap(), &plain, turns);
            for (frame, column) in frames.iter().zip(&found) {
                let z = Vector3::new(frame[(0, 2)], frame[(1, 2)], frame[(2, 2)]);
                let v = z.cross(&(flange - point(frame)));
                for (found, wanted) in column.iter().zip(v.iter().chain(z.iter())) {
                    prop_assert!((found - wanted).abs() < 1e-10, "{} {}", found, wanted);
                }
            }
        }
    }
}
