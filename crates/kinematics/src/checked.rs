//! Candidates become solutions if the forward kinematics agrees.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it, and a call a lane would undo the point of lanes"
)]

use std::f64::consts::TAU;

use units::Degrees;

use crate::branches::{Branches, Solution};
use crate::configuration::turns_of;
use crate::forward::{Arm, Flange, Wrist};
use crate::joints::{Axis, PendantJoints};
use crate::lanes::{Lanes, transpose};
use crate::model::ArmModel;
use crate::pose::Pose;
use crate::posture::Posture;

/// How far the flange of a returned solution may be from the wanted pose: 1 nm, in millimeters
/// squared.
const MAX_POSITION_ERROR_SQUARED: f64 = 1e-6 * 1e-6;
/// The same for the rotation, 1e-9 rad: two unit quaternions are half the angle apart.
const MAX_ROTATION_ERROR_SQUARED: f64 = 5e-10 * 5e-10;

/// The arm postures that should reach a pose, a lane each: front up, front down, back up, back
/// down.
#[derive(Clone, Copy)]
pub(crate) struct Postures {
    /// q1, q2, q3 of the chain.
    pub(crate) arm: [Lanes<4>; 3],
    pub(crate) front: Lanes<4>,
    pub(crate) elbow: Lanes<4>,
}

/// q4, q5, q6 of the chain that go with them.
#[derive(Clone, Copy)]
pub(crate) struct Wrists {
    pub(crate) wrist: [Lanes<4>; 3],
    pub(crate) sin_q5: Lanes<4>,
    /// Which lanes are branches of their own.
    pub(crate) wanted: [bool; 4],
}

/// Adds the postures whose joints, as they are returned, put the flange at `X_WF`.
#[inline(always)]
pub(crate) fn push_checked(
    model: &ArmModel,
    X_WF: &Pose,
    postures: &Postures,
    wrists: &[Wrists; 2],
    branches: &mut Branches,
) {
    let g = &model.geometry;
    let [q1, q2, q3] = postures.arm;
    // The same J1, J2 and J3 carry both wrists.
    let [.., q5, q6] = wrists[0].wrist;
    let shown = on_shown_turns(
        model,
        model
            .coupling
            .pendant(&[q1, q2, q3, wrists[0].wrist[0], q5, q6]),
    );
    let [c1, c2, c3, ..] = model.coupling.chain(&shown);
    let arm = Arm::of(g, c1, c2, c3);
    for &Wrists {
        wrist: [q4, q5, q6],
        sin_q5,
        wanted,
    } in wrists
    {
        let joints = on_shown_turns(model, model.coupling.pendant(&[q1, q2, q3, q4, q5, q6]));
        let [.., q4, q5, q6] = model.coupling.chain(&joints);
        let reaches = reaches(X_WF, &Flange::of(g, &arm, &Wrist::of(g, q4, q5, q6)));
        let signs = [sin_q5, postures.front, postures.elbow];
        push(model, &joints, &signs, both(wanted, reaches), branches);
    }
}

/// Lane by lane.
#[inline(always)]
pub(crate) fn both(mut these: [bool; 4], those: [bool; 4]) -> [bool; 4] {
    for (this, that) in these.iter_mut().zip(those) {
        *this &= that;
    }
    these
}

/// The lanes that are `wanted`, with all there is to know about them.
#[inline(always)]
fn push(
    model: &ArmModel,
    joints: &[Lanes<4>; 6],
    signs: &[Lanes<4>; 3],
    wanted: [bool; 4],
    branches: &mut Branches,
) {
    let lanes = transpose(joints)
        .into_iter()
        .zip(transpose(&margins(model, joints)));
    for (((joints, margins), signs), wanted) in lanes.zip(transpose(signs)).zip(wanted) {
        if !wanted {
            continue;
        }
        let [sin_q5, front, elbow] = signs;
        let posture = Posture::from_parts(sin_q5, front, elbow);
        let joints = PendantJoints::from_radians(joints);
        branches.push(Solution {
            joints,
            configuration: model.configuration_of(&posture, turns_of(&joints)),
            margins: margins.map(Degrees),
            singularity: posture.singularity(&model.geometry),
        });
    }
}

/// Is the flange at `X_WF`? A NaN is nowhere.
#[inline(always)]
fn reaches(X_WF: &Pose, flange: &Flange<4>) -> [bool; 4] {
    let isometry = X_WF.isometry();
    let (p, q) = (isometry.translation.vector, isometry.rotation.coords);
    let [x, y, z] = flange.position;
    let [w, i, j, k] = flange.rotation;
    let (x, y, z) = (x - p.x, y - p.y, z - p.z);
    let position = x * x + y * y + z * z;
    // A quaternion and its negative are the same rotation.
    let side = (w * q.w + i * q.x + j * q.y + k * q.z).map(|dot| 1.0_f64.copysign(dot));
    let (w, i, j, k) = (
        w - side * q.w,
        i - side * q.x,
        j - side * q.y,
        k - side * q.z,
    );
    let rotation = w * w + i * i + j * j + k * k;
    let mut reaches = [false; 4];
    for ((reaches, position), rotation) in reaches.iter_mut().zip(position.0).zip(rotation.0) {
        *reaches = position <= MAX_POSITION_ERROR_SQUARED && rotation <= MAX_ROTATION_ERROR_SQUARED;
    }
    reaches
}

/// J1, J2, J3 on the turn nearest to the middle of their range, J4, J5, J6 on the one nearest to
/// zero.
#[inline(always)]
fn on_shown_turns(model: &ArmModel, joints: [Lanes<4>; 6]) -> [Lanes<4>; 6] {
    // Adding and subtracting it rounds to a whole number.
    const ROUND: f64 = 6_755_399_441_055_744.0;
    let mut shown = joints;
    for (joint, middle) in shown.iter_mut().zip(model.shown_middles) {
        let turns = (*joint - middle) * (1.0 / TAU) + ROUND - ROUND;
        // The last term turns a negative zero into zero.
        *joint = *joint - turns * TAU + 0.0;
    }
    shown
}

/// The distances to the nearest limits, in degrees.
#[inline(always)]
fn margins(model: &ArmModel, joints: &[Lanes<4>; 6]) -> [Lanes<4>; 6] {
    let mut margins = *joints;
    for (margin, axis) in margins.iter_mut().zip(Axis::ALL) {
        let limits = model.limits(axis);
        let degrees = margin.map(f64::to_degrees);
        *margin = (degrees - limits.min.0).zip(degrees * -1.0 + limits.max.0, |below, above| {
            if below < above { below } else { above }
        });
    }
    margins
}
