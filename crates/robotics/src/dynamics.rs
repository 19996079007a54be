//! Torques of the joints for a motion.

use api::arms::{ArmInertia, ArmInverseDynamicsBody, ArmInverseDynamicsResult};
use kinematics::dynamics::{
    DynamicsError, InertiaError, InverseDynamics, LinkInertia, Load, STANDARD_GRAVITY,
};
use kinematics::serial::{JointKind, JointValues};
use nalgebra::Vector3;

use crate::arm::Arm;
use crate::convert::shown;
use crate::refusal::{Refusal, length};

/// The joints' torques for a motion, and what gravity, velocities and accelerations have in them.
///
/// Recursive Newton-Euler: Luh, Walker and Paul (1980). Friction and motors are not in it.
///
/// # Errors
/// No such model, a model without inertias if the question has none either, or an item that is none.
pub fn inverse_dynamics(
    model: &str,
    body: &ArmInverseDynamicsBody,
) -> Result<ArmInverseDynamicsResult, Refusal> {
    let arm = Arm::named(model)?;
    let joints = arm.joints("joints_deg_mm", &body.joints_deg_mm)?;
    let still = arm.joints("joints_deg_mm", &vec![0.0; joints.len()])?;
    // Degrees a second become radians a second as degrees become radians.
    let values = |path: &str, values: &Option<Vec<f64>>| match values {
        Some(values) => arm.joints(path, values),
        None => Ok(still.clone()),
    };
    let velocities = values("velocities_deg_mm_s", &body.velocities_deg_mm_s)?;
    let accelerations = values("accelerations_deg_mm_s2", &body.accelerations_deg_mm_s2)?;
    let dynamics = dynamics(&arm, body)?;
    let torques = |velocities: &JointValues, accelerations: &JointValues| {
        let (rates, accelerations) = (velocities.as_slice(), accelerations.as_slice());
        let state = arm.serial.state(&joints, rates, accelerations);
        state
            .and_then(|state| dynamics.torques(&state))
            .map_err(|error| Refusal::invalid("joints_deg_mm", error))
    };
    let all = torques(&velocities, &accelerations)?;
    let moving = torques(&velocities, &still)?;
    let held = torques(&still, &still)?;
    let less = |all: &[f64], part: &[f64]| -> Vec<f64> {
        let pairs = all.iter().zip(part);
        pairs.map(|(all, part)| shown(all - part)).collect()
    };
    let kinds = arm.serial.joint_list().iter().map(|joint| joint.kind);
    let power = kinds.zip(&all).zip(velocities.as_slice());
    let power = power.map(|((kind, torque), rate)| match kind {
        JointKind::Revolute => torque * rate,
        JointKind::Prismatic => torque * rate / 1000.0,
    });
    Ok(ArmInverseDynamicsResult {
        power_w: shown(power.sum()),
        velocity_nm_n: less(&moving, &held),
        acceleration_nm_n: less(&all, &moving),
        gravity_nm_n: held.into_iter().map(shown).collect(),
        torques_nm_n: all.into_iter().map(shown).collect(),
    })
}

/// Of the model's own links, or of those of the question.
fn dynamics(arm: &Arm, body: &ArmInverseDynamicsBody) -> Result<InverseDynamics, Refusal> {
    let weighed = match &body.links {
        None => None,
        Some(links) => {
            let joints = arm.serial.degrees_of_freedom();
            length("links", links.len(), [joints; 2], "links")?;
            let links = links.iter().enumerate().map(|(index, link)| {
                let path = format!("links[{index}]");
                if link.inertia_kg_m2.is_none() {
                    let path = format!("{path}.inertia_kg_m2");
                    return Err(Refusal::invalid(path, "it is missing; a link needs it"));
                }
                inertia(&path, link)
            });
            let links = links.collect::<Result<Vec<LinkInertia>, Refusal>>()?;
            let weighed = arm.serial.with_inertias(&links);
            Some(weighed.map_err(|error| Refusal::invalid("links", error))?)
        }
    };
    let payload = body.payload.as_ref();
    let load = Load {
        gravity_m_s2: body
            .gravity_m_s2
            .map_or(Vector3::new(0.0, 0.0, -STANDARD_GRAVITY), Vector3::from),
        payload: payload
            .map(|payload| inertia("payload", payload))
            .transpose()?,
    };
    let serial = weighed.as_ref().unwrap_or(arm.serial);
    InverseDynamics::of(serial, &load).map_err(|error| match error {
        DynamicsError::NoInertia { .. } => Refusal::invalid("links", error),
        DynamicsError::Gravity { .. } => Refusal::invalid("gravity_m_s2", error),
    })
}

fn inertia(path: &str, body: &ArmInertia) -> Result<LinkInertia, Refusal> {
    let read = match body.inertia_kg_m2 {
        Some(inertia) => LinkInertia::try_new(body.mass_kg, body.center_of_mass_m, inertia),
        None => LinkInertia::point(body.mass_kg, body.center_of_mass_m),
    };
    read.map_err(|error| {
        let key = match &error {
            InertiaError::Mass { .. } => "mass_kg",
            InertiaError::Center { .. } => "center_of_mass_m",
            InertiaError::Entry { .. }
            | InertiaError::NotSymmetric { .. }
            | InertiaError::NotPositive { .. }
            | InertiaError::Triangle { .. } => "inertia_kg_m2",
        };
        Refusal::invalid(format!("{path}.{key}"), error)
    })
}

/// As the API has it.
pub(crate) fn inertia_body(inertia: &LinkInertia) -> ArmInertia {
    let rows = inertia.inertia_kg_m2().transpose().data.0;
    ArmInertia {
        mass_kg: shown(inertia.mass_kg()),
        center_of_mass_m: inertia.center_of_mass_m().map(shown).into(),
        inertia_kg_m2: Some(rows.map(|row| row.map(shown))),
    }
}
