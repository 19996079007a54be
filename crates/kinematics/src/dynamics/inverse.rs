//! The torques of an arm's joints, for one state or four side by side.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::dynamics::body::Body;
use crate::dynamics::inertia::LinkInertia;
use crate::dynamics::recursion::{Link, Turn, forces};
use crate::dynamics::state::JointState;
use crate::lanes::{
    Instructions, LANES, Lane, Level, Number, One, Simd, SimdBase, SimdFrom, dispatch, for_one,
    transpose,
};
use crate::serial::{JointKind, SerialArm, SerialError};
use crate::trigonometry::sin_cos;

/// Standard gravity, in m/s^2.
pub const STANDARD_GRAVITY: f64 = 9.806_65;
/// Nothing on which an arm stands is accelerated more.
const MAX_GRAVITY: f64 = 1e4;
/// Room for the joints: most arms, and the longest that a file may have.
const FEW: usize = 9;
const MANY: usize = 33;

/// What acts on an arm from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// The free fall in the world, in m/s^2.
    pub gravity_m_s2: Vector3<f64>,
    /// What is fixed to the flange, in the flange's frame.
    pub payload: Option<LinkInertia>,
}

/// Standard gravity along -Z of the world, and no payload.
impl Default for Load {
    fn default() -> Self {
        Self {
            gravity_m_s2: Vector3::new(0.0, 0.0, -STANDARD_GRAVITY),
            payload: None,
        }
    }
}

/// Why there are no dynamics of an arm.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DynamicsError {
    /// The model does not say what its links weigh.
    #[error(
        "{arm} has no mass_kg, center_of_mass_m and inertia_kg_m2 of {}; every link needs them",
        .links.join(", ")
    )]
    NoInertia {
        /// The arm.
        arm: String,
        /// The joints whose links have none.
        links: Vec<String>,
    },
    /// A part of the gravity is no number, or beyond any.
    #[error("gravity has {value} m/s^2 along {axis}; it must be a number from -{max} to {max}")]
    Gravity {
        /// `x`, `y` or `z`.
        axis: &'static str,
        /// What was given.
        value: f64,
        /// The largest magnitude that is taken.
        max: f64,
    },
}

/// The inverse dynamics of an arm with its load.
#[derive(Clone, Debug)]
pub struct InverseDynamics {
    name: String,
    joints: Vec<Joint>,
    links: Vec<Link>,
    /// The acceleration of the base that gravity is like, in the frame 0.
    lift: [f64; 3],
    level: Level,
}

/// From the displayed values to the table's variables, in radians and meters.
#[derive(Clone, Debug)]
struct Joint {
    kind: JointKind,
    /// About the axis of a joint that slides, in radians.
    theta: f64,
    sign: f64,
    /// Sign and unit.
    scale: f64,
    offset: f64,
    couplings: Vec<Coupled>,
}

/// A displayed value that adds to a variable.
#[derive(Clone, Copy, Debug)]
struct Coupled {
    joint: usize,
    /// Of the value.
    factor: f64,
    /// Of the force, back.
    force: f64,
}

impl InverseDynamics {
    /// Of an arm whose links all have inertias.
    ///
    /// # Errors
    /// Names the links that have none; or the gravity is none.
    pub fn of(arm: &SerialArm, load: &Load) -> Result<Self, DynamicsError> {
        for (axis, value) in ["x", "y", "z"].into_iter().zip(load.gravity_m_s2.iter()) {
            // NaN is in no range.
            if !(-MAX_GRAVITY..=MAX_GRAVITY).contains(value) {
                let (value, max) = (*value, MAX_GRAVITY);
                return Err(DynamicsError::Gravity { axis, value, max });
            }
        }
        let without = arm.joints.iter().filter(|joint| joint.inertia.is_none());
        let links: Vec<String> = without.map(|joint| joint.name.clone()).collect();
        if !links.is_empty() {
            let arm = arm.name.clone();
            return Err(DynamicsError::NoInertia { arm, links });
        }
        Ok(Self {
            name: arm.name.clone(),
            joints: joints(arm),
            links: links_of(arm, load),
            lift: (arm.base.rotation.inverse() * -load.gravity_m_s2).into(),
            level: Level::new(),
        })
    }

    /// The same, computed with other instructions; `None` if this machine does not have them. The
    /// results are the same but for rounding.
    #[must_use]
    pub fn with(&self, instructions: Instructions) -> Option<Self> {
        let level = instructions.level()?;
        Some(Self {
            level,
            ..self.clone()
        })
    }

    /// The torques and forces of the joints, base first: what the drives have to give so that the
    /// arm moves as `state` says, in N m of a joint that turns and in N of one that slides.
    ///
    /// They belong to the displayed values: where a joint's value adds to another's variable, its
    /// drive gives both, and the sum of `torque * rate` is the power.
    ///
    /// # Errors
    /// The state is another arm's.
    pub fn torques(&self, state: &JointState) -> Result<Vec<f64>, SerialError> {
        let mut torques = vec![0.0; self.joints.len()];
        self.torques_into(state, &mut torques)?;
        Ok(torques)
    }

    /// The same into `torques`, which has a place for each joint.
    ///
    /// # Errors
    /// The state is another arm's, or there are not as many places as joints.
    pub fn torques_into(&self, state: &JointState, torques: &mut [f64]) -> Result<(), SerialError> {
        self.check_count(torques.len())?;
        let state = self.expect_own(state)?;
        if self.joints.len() <= FEW {
            torques.copy_from_slice(part(&self.one::<FEW>(state), torques.len()));
        } else {
            torques.copy_from_slice(part(&self.one::<MANY>(state), torques.len()));
        }
        Ok(())
    }

    /// The torques of each of `states`, given to `each` with its index, in order: four at a time.
    ///
    /// # Errors
    /// A state is another arm's; those before it were given to `each`.
    pub fn torques_batch(
        &self,
        states: &[JointState],
        each: impl FnMut(usize, &[f64]),
    ) -> Result<(), SerialError> {
        if self.joints.len() <= FEW {
            self.batch::<FEW>(states, each)
        } else {
            self.batch::<MANY>(states, each)
        }
    }

    fn batch<const K: usize>(
        &self,
        states: &[JointState],
        mut each: impl FnMut(usize, &[f64]),
    ) -> Result<(), SerialError> {
        let mut index = 0;
        for states in states.chunks(LANES) {
            // What is missing in the last four is the last one again.
            let at = |lane: usize| states.get(lane).or(states.last());
            let (Some(a), Some(b), Some(c), Some(d)) = (at(0), at(1), at(2), at(3)) else {
                continue;
            };
            let four = [
                self.expect_own(a)?,
                self.expect_own(b)?,
                self.expect_own(c)?,
                self.expect_own(d)?,
            ];
            let torques = self.four::<K>(four);
            for (_, torques) in states.iter().zip(&torques) {
                each(index, part(torques, self.joints.len()));
                index += 1;
            }
        }
        Ok(())
    }

    fn expect_own<'a>(&self, state: &'a JointState) -> Result<&'a [[f64; 3]], SerialError> {
        self.check_count(state.0.len())?;
        Ok(&state.0)
    }

    fn check_count(&self, given: usize) -> Result<(), SerialError> {
        if given == self.joints.len() {
            return Ok(());
        }
        Err(SerialError::JointCount {
            arm: self.name.clone(),
            wanted: self.joints.len(),
            given,
        })
    }

    fn one<const K: usize>(&self, state: &[[f64; 3]]) -> [f64; K] {
        dispatch!(for_one(self.level), simd => one(simd, self, state))
    }

    fn four<const K: usize>(&self, states: [&[[f64; 3]]; LANES]) -> [[f64; K]; LANES] {
        dispatch!(self.level, simd => four(simd, self, states))
    }
}

fn part(values: &[f64], count: usize) -> &[f64] {
    values.get(..count).unwrap_or(values)
}

fn joints(arm: &SerialArm) -> Vec<Joint> {
    let unit = |kind: JointKind| match kind {
        JointKind::Revolute => 1.0,
        JointKind::Prismatic => 1e-3,
    };
    let unit_of = |index: usize| arm.joints.get(index).map_or(1.0, |other| unit(other.kind));
    let joints = arm.joints.iter().map(|joint| {
        let own = unit(joint.kind);
        Joint {
            kind: joint.kind,
            theta: joint.theta,
            sign: joint.sign,
            scale: joint.sign * own,
            offset: joint.offset * own,
            couplings: joint
                .couplings
                .iter()
                .map(|(other, factor)| Coupled {
                    joint: *other,
                    factor: factor * own,
                    force: factor * own / unit_of(*other),
                })
                .collect(),
        }
    });
    joints.collect()
}

/// From the flange to the base: what is on a joint's axis goes to the link before.
fn links_of(arm: &SerialArm, load: &Load) -> Vec<Link> {
    let mut links = Vec::new();
    let mut from_behind = Body::nothing();
    if let Some(payload) = &load.payload {
        let at = Isometry3::from_parts(
            (arm.flange.translation.vector / 1000.0).into(),
            arm.flange.rotation,
        );
        from_behind = Body::of(payload).seen_from(&at);
    }
    let ways: Vec<[f64; 3]> = arm
        .joints
        .iter()
        .map(|joint| [joint.a / 1000.0, joint.d / 1000.0, joint.alpha])
        .collect();
    for (index, (joint, own)) in arm.joints.iter().zip(&ways).enumerate().rev() {
        let inertia = joint.inertia.as_ref();
        let body = inertia.map_or_else(Body::nothing, Body::of);
        // `from_behind` is in the link's frame of the table as well, as the next joint's axis is.
        let mut body = body.plus(&from_behind).seen_from(&way(*own));
        from_behind = Body::nothing();
        if joint.kind == JointKind::Revolute {
            (body, from_behind) = body.without_axis();
        }
        let before = index.checked_sub(1).and_then(|before| ways.get(before));
        links.push(Link::new(
            joint.kind,
            before.copied().unwrap_or_default(),
            &body,
        ));
    }
    links.reverse();
    links
}

/// From a joint's frame to its link's frame of the table.
fn way([a, d, alpha]: [f64; 3]) -> Isometry3<f64> {
    Isometry3::from_parts(
        Translation3::new(a, 0.0, d),
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), alpha),
    )
}

/// The variables of the table with their rates and accelerations.
#[inline(always)]
fn variables<N: Number, const K: usize>(joints: &[Joint], shown: &[[N; 3]; K]) -> [[N; 3]; K] {
    let mut variables = *shown;
    for (variable, joint) in variables.iter_mut().zip(joints) {
        for part in variable.iter_mut() {
            *part = *part * joint.scale;
        }
        for coupled in &joint.couplings {
            if let Some(shown) = shown.get(coupled.joint) {
                for (part, shown) in variable.iter_mut().zip(shown) {
                    *part = shown.scaled_plus(coupled.factor, *part);
                }
            }
        }
        variable[0] = variable[0] + joint.offset;
    }
    variables
}

/// The forces of the displayed values from those of the variables.
#[inline(always)]
fn displayed<N: Number, const K: usize>(joints: &[Joint], forces: &[N; K]) -> [N; K] {
    let mut displayed = *forces;
    for (displayed, joint) in displayed.iter_mut().zip(joints) {
        *displayed = *displayed * joint.sign;
    }
    for (force, joint) in forces.iter().zip(joints) {
        for coupled in &joint.couplings {
            if let Some(displayed) = displayed.get_mut(coupled.joint) {
                *displayed = force.scaled_plus(coupled.force, *displayed);
            }
        }
    }
    displayed
}

#[inline(always)]
fn one<S: Simd, const K: usize>(
    simd: S,
    dynamics: &InverseDynamics,
    state: &[[f64; 3]],
) -> [f64; K] {
    let zero = One::new(simd, 0.0);
    let mut shown = [[zero; 3]; K];
    for (shown, [q, v, a]) in shown.iter_mut().zip(state) {
        *shown = [One::new(simd, *q), One::new(simd, *v), One::new(simd, *a)];
    }
    let motions = variables(&dynamics.joints, &shown);
    // Four angles in a vector, instead of one by one.
    let mut turns = [(zero, zero); K];
    let angles = dynamics.joints.chunks(LANES).zip(motions.chunks(LANES));
    for ((joints, motions), turns) in angles.zip(turns.chunks_mut(LANES)) {
        let mut angles = [0.0; LANES];
        for ((angle, joint), [q, ..]) in angles.iter_mut().zip(joints).zip(motions) {
            *angle = match joint.kind {
                JointKind::Revolute => q.value,
                JointKind::Prismatic => joint.theta,
            };
        }
        let [(sines, cosines)] = sin_cos([Lane::simd_from(simd, angles)]);
        let (sines, cosines): ([f64; LANES], [f64; LANES]) = (sines.into(), cosines.into());
        for ((turn, sine), cosine) in turns.iter_mut().zip(sines).zip(cosines) {
            *turn = (One::new(simd, sine), One::new(simd, cosine));
        }
    }
    let found: [One<S>; K] = forces(&dynamics.links, &turns, &motions, dynamics.lift, zero);
    let found = displayed(&dynamics.joints, &found);
    let mut torques = [0.0; K];
    for (torque, found) in torques.iter_mut().zip(found) {
        *torque = found.value;
    }
    torques
}

#[inline(always)]
fn four<S: Simd, const K: usize>(
    simd: S,
    dynamics: &InverseDynamics,
    [a, b, c, d]: [&[[f64; 3]]; LANES],
) -> [[f64; K]; LANES] {
    let zero = Lane::splat(simd, 0.0);
    let mut shown = [[zero; 3]; K];
    for ((((shown, a), b), c), d) in shown.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        let ([qa, va, aa], [qb, vb, ab], [qc, vc, ac], [qd, vd, ad]) = (*a, *b, *c, *d);
        *shown = [
            Lane::simd_from(simd, [qa, qb, qc, qd]),
            Lane::simd_from(simd, [va, vb, vc, vd]),
            Lane::simd_from(simd, [aa, ab, ac, ad]),
        ];
    }
    let motions = variables(&dynamics.joints, &shown);
    let mut angles = [zero; K];
    for ((angle, joint), [q, ..]) in angles.iter_mut().zip(&dynamics.joints).zip(&motions) {
        *angle = match joint.kind {
            JointKind::Revolute => *q,
            JointKind::Prismatic => Lane::splat(simd, joint.theta),
        };
    }
    let mut turns: [Turn<Lane<S>>; K] = [(zero, zero); K];
    // K is a multiple of three.
    let (turn_groups, _) = turns.as_chunks_mut::<3>();
    let (angle_groups, _) = angles.as_chunks::<3>();
    let groups = turn_groups.iter_mut().zip(angle_groups);
    for (turns, angles) in groups.take(dynamics.joints.len().div_ceil(3)) {
        *turns = sin_cos(*angles);
    }
    let found: [Lane<S>; K] = forces(&dynamics.links, &turns, &motions, dynamics.lift, zero);
    transpose(&displayed(&dynamics.joints, &found))
}
