//! The M-20iA with links that weigh something, and its random motions.

use anyhow::{Context as _, Result};
use kinematics::dynamics::{JointState, LinkInertia};
use kinematics::serial::SerialArm;

use crate::arms::{Case, Random, arm};
use crate::pinocchio::ChainState;

/// Mass, center of mass, principal moments and a product of inertia of each link. Made up: FANUC
/// publishes none, and a benchmark needs only that both sides have the same.
const MADE_UP: [(f64, [f64; 3], [f64; 3], f64); 6] = [
    (80.0, [-0.10, -0.15, 0.02], [1.9, 1.5, 1.7], 0.10),
    (45.0, [-0.40, 0.03, 0.05], [0.3, 2.4, 2.5], 0.05),
    (50.0, [-0.12, 0.02, 0.10], [1.1, 1.3, 0.8], -0.04),
    (18.0, [0.01, 0.25, -0.02], [0.9, 0.2, 0.8], 0.03),
    (6.0, [0.00, 0.01, 0.04], [0.05, 0.04, 0.03], 0.002),
    (1.5, [0.01, 0.00, -0.02], [0.004, 0.003, 0.005], -0.0005),
];

/// The M-20iA with these.
///
/// # Errors
/// The arm or its numbers are none.
pub fn heavy_arm() -> Result<SerialArm> {
    let arm = SerialArm::builtin(arm().name()).context("the arm is in the catalog")?;
    let links = MADE_UP.map(|(mass, center, [xx, yy, zz], product)| {
        let moments = [
            [xx, product, product],
            [product, yy, product],
            [product, product, zz],
        ];
        LinkInertia::try_new(mass, center, moments)
    });
    let links: Vec<LinkInertia> = links.into_iter().collect::<Result<_, _>>()?;
    Ok(arm.with_inertias(&links)?)
}

/// Each case with random rates and accelerations; the same ones in every run.
///
/// # Errors
/// The cases are another arm's.
pub fn states(arm: &SerialArm, cases: &[Case]) -> Result<Vec<JointState>> {
    let mut random = Random(19_800_615);
    let mut some = |most: f64| -> Vec<f64> {
        let numbers = std::iter::repeat_with(|| (2.0 * random.part() - 1.0) * most);
        numbers.take(arm.degrees_of_freedom()).collect()
    };
    cases
        .iter()
        .map(|case| {
            let joints = arm.joints_from_radians(&case.joints.radians())?;
            Ok(arm.state(&joints, &some(3.0), &some(10.0))?)
        })
        .collect()
}

/// How much of each displayed value is in each of the table's variables: rows of the variables.
#[must_use]
pub fn coupling(arm: &SerialArm) -> Vec<Vec<f64>> {
    let joints = arm.joint_list().iter().enumerate();
    let rows = joints.map(|(index, joint)| {
        let mut row = vec![0.0; arm.degrees_of_freedom()];
        let own = std::iter::once((index, joint.sign));
        for (displayed, factor) in own.chain(joint.couplings.iter().copied()) {
            if let Some(cell) = row.get_mut(displayed) {
                *cell += factor;
            }
        }
        row
    });
    rows.collect()
}

/// The states of the table's variables.
#[must_use]
pub fn chain_states(arm: &SerialArm, states: &[JointState]) -> Vec<ChainState> {
    let coupling = coupling(arm);
    let offsets: Vec<f64> = arm.joint_list().iter().map(|joint| joint.offset).collect();
    let zero = vec![0.0; offsets.len()];
    let variables = |state: &JointState, part: fn(&[f64; 3]) -> f64, offsets: &[f64]| {
        let rows = coupling.iter().zip(offsets);
        rows.map(|(row, offset)| {
            let parts = row.iter().zip(state.as_slice());
            offset
                + parts
                    .map(|(factor, joint)| factor * part(joint))
                    .sum::<f64>()
        })
        .collect::<Vec<f64>>()
    };
    states
        .iter()
        .map(|state| {
            [
                variables(state, |[q, ..]| *q, &offsets),
                variables(state, |[_, v, _]| *v, &zero),
                variables(state, |[.., a]| *a, &zero),
            ]
        })
        .collect()
}
