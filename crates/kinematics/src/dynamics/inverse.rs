//! The torques of an arm's joints, for one state or four side by side.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::dynamics::body::Body;
use crate::dynamics::inertia::LinkInertia;
use crate::dynamics::recursion::{Link, Room, forces};
use crate::dynamics::state::JointState;
use crate::lanes::{
    Instructions, LANES, Lane, Level, Number, One, Simd, SimdBase, SimdFrom, dispatch, for_one,
};
use crate::serial::{JointKind, SerialArm, SerialError};
use crate::trigonometry::sin_cos;

/// Standard gravity, in m/s^2.
pub const STANDARD_GRAVITY: f64 = 9.806_65;
/// Nothing on which an arm stands is accelerated more.
const MAX_GRAVITY: f64 = 1e4;
/// Room for the joints: of most arms, of some, and of the longest that a file may have. Each three times
/// something, since three angles go through the sine together.
const FEW: usize = 6;
const SOME: usize = 9;
const MANY: usize = 33;

/// States that go through the instructions' gate together.
const GROUPS: usize = 8;

/// Their torques.
type Torques<const K: usize> = [[[f64; K]; LANES]; GROUPS];

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
    /// Base first.
    couplings: Vec<Coupling>,
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
}

/// A displayed value that adds to another joint's variable, which is behind it.
#[derive(Clone, Copy, Debug)]
struct Coupling {
    from: usize,
    to: usize,
    /// Of the value, as a part of the other joint's displayed one.
    factor: f64,
    /// Of the force, back: as a part of the force of the first joint's variable.
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
            couplings: couplings(arm),
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
        self.check_count(state.0.len())?;
        let state = &state.0;
        let level = for_one(self.level);
        if self.joints.len() <= FEW {
            dispatch!(level, simd => one::<_, FEW>(simd, self, state, torques));
        } else if self.joints.len() <= SOME {
            dispatch!(level, simd => one::<_, SOME>(simd, self, state, torques));
        } else {
            dispatch!(level, simd => one::<_, MANY>(simd, self, state, torques));
        }
        Ok(())
    }

    /// The torques of each of `states`, given to `each` with its index, in order: four at a time.
    ///
    /// # Errors
    /// A state is another arm's; none was given to `each`.
    pub fn torques_batch(
        &self,
        states: &[JointState],
        each: impl FnMut(usize, &[f64]),
    ) -> Result<(), SerialError> {
        for state in states {
            self.check_count(state.0.len())?;
        }
        if self.joints.len() <= FEW {
            self.batch(states, few, each);
        } else if self.joints.len() <= SOME {
            self.batch(states, some, each);
        } else {
            self.batch(states, many, each);
        }
        Ok(())
    }

    fn batch<const K: usize>(
        &self,
        states: &[JointState],
        groups: fn(&Self, &[JointState], &mut Torques<K>),
        mut each: impl FnMut(usize, &[f64]),
    ) {
        let mut torques = [[[0.0; K]; LANES]; GROUPS];
        let mut index = 0;
        for states in states.chunks(LANES * GROUPS) {
            groups(self, states, &mut torques);
            for (_, torques) in states.iter().zip(torques.as_flattened()) {
                each(index, torques.get(..self.joints.len()).unwrap_or(torques));
                index += 1;
            }
        }
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
}

// Not generic, so that each is compiled here, whoever calls.
fn few(dynamics: &InverseDynamics, states: &[JointState], torques: &mut Torques<FEW>) {
    dispatch!(dynamics.level, simd => groups(simd, dynamics, states, torques));
}

fn some(dynamics: &InverseDynamics, states: &[JointState], torques: &mut Torques<SOME>) {
    dispatch!(dynamics.level, simd => groups(simd, dynamics, states, torques));
}

fn many(dynamics: &InverseDynamics, states: &[JointState], torques: &mut Torques<MANY>) {
    dispatch!(dynamics.level, simd => groups(simd, dynamics, states, torques));
}

/// Radians or meters in a joint's own unit.
fn unit(kind: JointKind) -> f64 {
    match kind {
        JointKind::Revolute => 1.0,
        JointKind::Prismatic => 1e-3,
    }
}

fn joints(arm: &SerialArm) -> Vec<Joint> {
    let joints = arm.joints.iter().map(|joint| Joint {
        kind: joint.kind,
        theta: joint.theta,
        sign: joint.sign,
        scale: joint.sign * unit(joint.kind),
        offset: joint.offset * unit(joint.kind),
    });
    joints.collect()
}

fn couplings(arm: &SerialArm) -> Vec<Coupling> {
    let mut couplings = Vec::new();
    for (to, joint) in arm.joints.iter().enumerate() {
        for (from, factor) in &joint.couplings {
            let Some(other) = arm.joints.get(*from) else {
                continue;
            };
            couplings.push(Coupling {
                from: *from,
                to,
                // The signs are 1 or -1, so multiplying divides.
                factor: factor * joint.sign,
                force: factor * unit(joint.kind) / unit(other.kind) * other.sign,
            });
        }
    }
    couplings
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

/// Each value adds to those it is coupled to, which are behind it and are done before it.
#[inline(always)]
fn couple<N: Number>(couplings: &[Coupling], values: &mut [[N; 3]]) {
    for coupling in couplings.iter().rev() {
        let Some((before, [value, ..])) = values.split_at_mut_checked(coupling.to) else {
            continue;
        };
        if let Some(shown) = before.get(coupling.from) {
            for (part, shown) in value.iter_mut().zip(shown) {
                *part = shown.scaled_plus(coupling.factor, *part);
            }
        }
    }
}

/// The forces of the table's variables become those of the displayed values.
#[inline(always)]
fn to_displayed<N: Number>(dynamics: &InverseDynamics, forces: &mut [N]) {
    for coupling in &dynamics.couplings {
        let Some((before, [force, ..])) = forces.split_at_mut_checked(coupling.to) else {
            continue;
        };
        if let Some(other) = before.get_mut(coupling.from) {
            *other = force.scaled_plus(coupling.force, *other);
        }
    }
    for (force, joint) in forces.iter_mut().zip(&dynamics.joints) {
        *force = *force * joint.sign;
    }
}

impl Joint {
    /// The variable of the table, its rate and its acceleration out of the displayed ones.
    #[inline(always)]
    fn variable<N: Number>(&self, [q, v, a]: [N; 3]) -> [N; 3] {
        [q * self.scale + self.offset, v * self.scale, a * self.scale]
    }
}

#[inline(always)]
fn one<S: Simd, const K: usize>(
    simd: S,
    dynamics: &InverseDynamics,
    state: &[[f64; 3]],
    torques: &mut [f64],
) {
    let mut room: Room<One<S>, K> = Room::new(One::new(simd, 0.0));
    for (motion, [q, v, a]) in room.motions.iter_mut().zip(state) {
        *motion = [One::new(simd, *q), One::new(simd, *v), One::new(simd, *a)];
    }
    couple(&dynamics.couplings, &mut room.motions);
    // Four angles in a vector, instead of one by one.
    let motions = room.motions.chunks_mut(LANES);
    let turns = room.turns.chunks_mut(LANES);
    for ((joints, motions), turns) in dynamics.joints.chunks(LANES).zip(motions).zip(turns) {
        let mut angles = [0.0; LANES];
        for ((angle, joint), motion) in angles.iter_mut().zip(joints).zip(motions) {
            *motion = joint.variable(*motion);
            *angle = match joint.kind {
                JointKind::Revolute => motion[0].value,
                JointKind::Prismatic => joint.theta,
            };
        }
        let [(sines, cosines)] = sin_cos([Lane::simd_from(simd, angles)]);
        let (sines, cosines): ([f64; LANES], [f64; LANES]) = (sines.into(), cosines.into());
        for ((turn, sine), cosine) in turns.iter_mut().zip(sines).zip(cosines) {
            *turn = (One::new(simd, sine), One::new(simd, cosine));
        }
    }
    forces(&dynamics.links, dynamics.lift, &mut room);
    to_displayed(dynamics, &mut room.forces);
    for (torque, found) in torques.iter_mut().zip(&room.forces) {
        *torque = found.value;
    }
}

#[inline(always)]
fn groups<S: Simd, const K: usize>(
    simd: S,
    dynamics: &InverseDynamics,
    states: &[JointState],
    torques: &mut Torques<K>,
) {
    let mut room: Room<Lane<S>, K> = Room::new(Lane::splat(simd, 0.0));
    for (states, torques) in states.chunks(LANES).zip(torques) {
        // What is missing in the last four is the last one again.
        let at = |lane: usize| states.get(lane).or(states.last());
        let (Some(a), Some(b), Some(c), Some(d)) = (at(0), at(1), at(2), at(3)) else {
            continue;
        };
        four(simd, dynamics, [&a.0, &b.0, &c.0, &d.0], &mut room);
        let [first, second, third, fourth] = torques;
        let cells = first.iter_mut().zip(second).zip(third).zip(fourth);
        for (found, (((a, b), c), d)) in room.forces.iter().zip(cells) {
            [*a, *b, *c, *d] = (*found).into();
        }
    }
}

#[inline(always)]
fn four<S: Simd, const K: usize>(
    simd: S,
    dynamics: &InverseDynamics,
    [a, b, c, d]: [&[[f64; 3]]; LANES],
    room: &mut Room<Lane<S>, K>,
) {
    for ((((motion, a), b), c), d) in room.motions.iter_mut().zip(a).zip(b).zip(c).zip(d) {
        let ([qa, va, aa], [qb, vb, ab], [qc, vc, ac], [qd, vd, ad]) = (*a, *b, *c, *d);
        *motion = [
            Lane::simd_from(simd, [qa, qb, qc, qd]),
            Lane::simd_from(simd, [va, vb, vc, vd]),
            Lane::simd_from(simd, [aa, ab, ac, ad]),
        ];
    }
    couple(&dynamics.couplings, &mut room.motions);
    let (turns, _) = room.turns.as_chunks_mut::<3>();
    let (motions, _) = room.motions.as_chunks_mut::<3>();
    for ((joints, motions), turns) in dynamics.joints.chunks(3).zip(motions).zip(turns) {
        let mut angles = [Lane::splat(simd, 0.0); 3];
        for ((angle, joint), motion) in angles.iter_mut().zip(joints).zip(motions) {
            *motion = joint.variable(*motion);
            *angle = match joint.kind {
                JointKind::Revolute => motion[0],
                JointKind::Prismatic => Lane::splat(simd, joint.theta),
            };
        }
        *turns = sin_cos(angles);
    }
    forces(&dynamics.links, dynamics.lift, room);
    to_displayed(dynamics, &mut room.forces);
}
