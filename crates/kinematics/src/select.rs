//! Choosing one joint set among the branches.

use crate::branches::{Branches, Solution};
use crate::configuration::{Configuration, has_turn, turns_of};
use crate::ik_error::{IkError, Obstacle};
use crate::inverse;
use crate::joints::{Axis, PendantJoints};
use crate::limits::{LimitViolations, ROUNDING_DEG};
use crate::model::ArmModel;
use crate::pose::Pose;

/// Which of the joint sets is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seed {
    /// The one nearest to these joints (root of the sum of squares), on whatever turn.
    Near(PendantJoints),
    /// The one in this configuration, on exactly these turns of J4, J5 and J6: what a FANUC position means.
    InConfiguration(Configuration),
    /// The one whose most cramped joint has the largest margin.
    Centered,
}

/// A whole turn; joint values are shown in degrees.
const TURN: f64 = 360.0;

pub(crate) fn select(model: &ArmModel, X_WF: &Pose, seed: Seed) -> Result<Solution, IkError> {
    match seed {
        Seed::Near(joints) => {
            let branches = inverse::branches(model, X_WF, &joints)?;
            let near = |solution: &Solution| nearest_turns(model, solution, &joints);
            branches
                .iter()
                .filter_map(near)
                .min_by(|a, b| {
                    distance(&a.joints, &joints).total_cmp(&distance(&b.joints, &joints))
                })
                .ok_or_else(|| joint_limit(model, &branches))
        }
        Seed::Centered => {
            let branches = inverse::branches(model, X_WF, &model.home())?;
            branches
                .iter()
                .map(|solution| most_central_turns(model, solution))
                .filter(Solution::within_limits)
                .max_by(|a, b| a.smallest_margin().0.total_cmp(&b.smallest_margin().0))
                .ok_or_else(|| joint_limit(model, &branches))
        }
        Seed::InConfiguration(wanted) => {
            let branches = inverse::branches(model, X_WF, &model.home())?;
            in_configuration(model, &branches, wanted)
        }
    }
}

/// The distance in joint space, in degrees.
fn distance(a: &PendantJoints, b: &PendantJoints) -> f64 {
    a.degrees()
        .into_iter()
        .zip(b.degrees())
        .map(|(a, b)| (a - b) * (a - b))
        .sum::<f64>()
        .sqrt()
}

/// The solution with every joint on the turn inside its limits nearest to `joints`, if there is one.
fn nearest_turns(
    model: &ArmModel,
    solution: &Solution,
    joints: &PendantJoints,
) -> Option<Solution> {
    let mut turned = [0.0; 6];
    for (axis, turned) in Axis::ALL.into_iter().zip(&mut turned) {
        let (value, limits) = (solution.joints.of(axis).0, model.limits(axis));
        // The turns inside the limits are a range; the nearest of it is the nearest of all, brought into it.
        let lowest = ((limits.min.0 - ROUNDING_DEG - value) / TURN).ceil();
        let highest = ((limits.max.0 + ROUNDING_DEG - value) / TURN).floor();
        if lowest > highest {
            return None;
        }
        let nearest = ((joints.of(axis).0 - value) / TURN).round();
        *turned = value + TURN * nearest.clamp(lowest, highest);
    }
    Some(on_turns(model, solution, turned))
}

/// The solution with every joint on the turn nearest to the middle of its range.
fn most_central_turns(model: &ArmModel, solution: &Solution) -> Solution {
    let turned = Axis::ALL.map(|axis| {
        let (value, limits) = (solution.joints.of(axis).0, model.limits(axis));
        let middle = f64::midpoint(limits.min.0, limits.max.0);
        value - TURN * ((value - middle) / TURN).round()
    });
    on_turns(model, solution, turned)
}

/// The same branch with its joints on other turns; the flange does not notice.
fn on_turns(model: &ArmModel, solution: &Solution, degrees: [f64; 6]) -> Solution {
    let joints = PendantJoints::from_degrees(degrees);
    Solution {
        joints,
        configuration: Configuration {
            turns: turns_of(&joints),
            ..solution.configuration
        },
        margins: model.margins(&joints),
        singularity: solution.singularity,
    }
}

fn in_configuration(
    model: &ArmModel,
    branches: &Branches,
    wanted: Configuration,
) -> Result<Solution, IkError> {
    let in_branch = branches
        .iter()
        .find(|solution| solution.configuration.same_branch(&wanted));
    let obstacle = match in_branch.map(|solution| on_wanted_turns(model, solution, wanted.turns)) {
        Some(solution) if solution.within_limits() => return Ok(solution),
        Some(solution) => Obstacle::Limits(solution.violations(model)),
        None => Obstacle::OutOfReach,
    };
    let available = branches
        .iter()
        .map(|solution| most_central_turns(model, solution))
        .filter(Solution::within_limits)
        .map(|solution| solution.configuration)
        .collect();
    Err(IkError::NoSolutionInConfiguration {
        wanted,
        obstacle,
        available,
    })
}

/// J4, J5 and J6 on the turns wanted; the configuration is given as wanted, because a joint within rounding of half a
/// turn belongs to both.
fn on_wanted_turns(model: &ArmModel, solution: &Solution, turns: [i8; 3]) -> Solution {
    let [j1, j2, j3, wrist @ ..] = solution.joints.degrees();
    let [j4, j5, j6] = wrist;
    let [t4, t5, t6] = turns;
    let turned = [(j4, t4), (j5, t5), (j6, t6)].map(|(value, turn)| {
        let straight = value + TURN * f64::from(turn);
        // Within rounding of half a turn the next turn may be meant.
        [straight, straight - TURN, straight + TURN]
            .into_iter()
            .find(|candidate| has_turn(*candidate, turn))
            .unwrap_or(straight)
    });
    let [j4, j5, j6] = turned;
    let solution = on_turns(model, solution, [j1, j2, j3, j4, j5, j6]);
    Solution {
        configuration: Configuration {
            turns,
            ..solution.configuration
        },
        ..solution
    }
}

/// The branch that misses its limits by the least, turns considered.
fn joint_limit(model: &ArmModel, branches: &Branches) -> IkError {
    let best = branches
        .iter()
        .map(|solution| most_central_turns(model, solution))
        .max_by(|a, b| a.smallest_margin().0.total_cmp(&b.smallest_margin().0));
    match best {
        Some(best) => IkError::JointLimit {
            violations: best.violations(model),
            branch: best.configuration,
            branches: branches.len(),
        },
        // No branch at all is `OutOfReach`, reported before.
        None => IkError::JointLimit {
            violations: LimitViolations::of(model, &model.home()),
            branch: model.configuration(&model.home()),
            branches: 0,
        },
    }
}
