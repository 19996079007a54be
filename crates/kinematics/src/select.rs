//! Choosing one joint set among the branches.

use units::Degrees;

use crate::branches::{Branches, Solution};
use crate::configuration::{Configuration, has_turn, turns_of};
use crate::ik_error::{IkError, Obstacle};
use crate::inverse;
use crate::joints::{Axis, PendantJoints};
use crate::limits::ROUNDING_DEG;
use crate::model::ArmModel;
use crate::pose::Pose;

/// Which of the joint sets is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Seed {
    /// The one nearest to these joints (root of the sum of squares), on whatever turn.
    Near(PendantJoints),
    /// The one in this configuration, on exactly these turns of J4, J5 and J6: what a FANUC
    /// position means.
    InConfiguration(Configuration),
    /// The one whose most cramped joint has the largest margin.
    Centered,
}

/// A whole turn; joint values are shown in degrees.
const TURN: f64 = 360.0;
/// Excesses closer than this are the same.
const SAME_DEG: f64 = 1e-6;

pub(crate) fn select(model: &ArmModel, X_WF: &Pose, seed: Seed) -> Result<Solution, IkError> {
    match seed {
        Seed::Near(joints) => {
            let joints = PendantJoints::try_from_degrees(joints.degrees())?;
            let branches = inverse::branches(model, X_WF, &joints)?;
            let seed = joints.degrees();
            branches
                .iter()
                .filter_map(|solution| {
                    let turned = nearest_turns(model, solution, &seed)?;
                    Some((solution, turned, distance_squared(&turned, &seed)))
                })
                .min_by(|(_, _, a), (_, _, b)| a.total_cmp(b))
                .map(|(solution, turned, _)| on_turns(model, solution, turned))
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

/// The squared distance in joint space, in degrees.
fn distance_squared(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

/// Every joint, in degrees, on the turn inside its limits nearest to `seed`; `None` if a joint has
/// none.
fn nearest_turns(model: &ArmModel, solution: &Solution, seed: &[f64; 6]) -> Option<[f64; 6]> {
    let mut turned = solution.joints.degrees();
    for (axis, value) in Axis::ALL.into_iter().zip(&mut turned) {
        let (limits, wish) = (model.limits(axis), axis.of(seed));
        if limits.contains(Degrees(*value)) && (wish - *value).abs() <= TURN / 2.0 {
            continue;
        }
        // The turns inside the limits are a range; the nearest of it is the nearest of all, brought
        // into it.
        let lowest = ((limits.min.0 - ROUNDING_DEG - *value) / TURN).ceil();
        let highest = ((limits.max.0 + ROUNDING_DEG - *value) / TURN).floor();
        if lowest > highest {
            return None;
        }
        *value += TURN * ((wish - *value) / TURN).round().clamp(lowest, highest);
    }
    Some(turned)
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
        .find(|solution| is_in_branch(solution, wanted));
    let obstacle = match in_branch.map(|solution| on_wanted_turns(model, solution, wanted)) {
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

/// Is the solution in the branch wanted? At a singularity two branches are one, and it is in both.
fn is_in_branch(solution: &Solution, wanted: Configuration) -> bool {
    let (is, singular) = (&solution.configuration, &solution.singularity);
    (is.flip == wanted.flip || singular.wrist == 0.0)
        && (is.elbow == wanted.elbow || singular.elbow == 0.0)
        && (is.front == wanted.front || singular.shoulder == 0.0)
}

/// J4, J5 and J6 on the turns wanted. The configuration is given as wanted: a joint within rounding
/// of half a turn belongs to two turns, as a singular posture does to two branches.
fn on_wanted_turns(model: &ArmModel, solution: &Solution, wanted: Configuration) -> Solution {
    let [j1, j2, j3, j4, j5, j6] = solution.joints.degrees();
    let [t4, t5, t6] = wanted.turns;
    let turned = |axis: Axis, value: f64, turn: i8| {
        let straight = value + TURN * f64::from(turn);
        let margin = |degrees: &f64| model.limits(axis).margin(Degrees(*degrees)).0;
        // Within rounding of half a turn the next turn may be meant.
        [straight, straight - TURN, straight + TURN]
            .into_iter()
            .filter(|degrees| has_turn(*degrees, turn))
            .max_by(|a, b| margin(a).total_cmp(&margin(b)))
            .unwrap_or(straight)
    };
    let degrees = [
        j1,
        j2,
        j3,
        turned(Axis::J4, j4, t4),
        turned(Axis::J5, j5, t5),
        turned(Axis::J6, j6, t6),
    ];
    Solution {
        configuration: wanted,
        ..on_turns(model, solution, degrees)
    }
}

/// The branch that misses its limits by the least, turns considered.
fn joint_limit(model: &ArmModel, branches: &Branches) -> IkError {
    let best = branches
        .iter()
        .map(|solution| most_central_turns(model, solution))
        .reduce(|best, other| {
            if is_nearer_to_limits(&other, &best) {
                other
            } else {
                best
            }
        })
        .expect("a pose without any branch is out of reach, which was reported before");
    IkError::JointLimit {
        violations: best.violations(model),
        branch: best.configuration,
        branches: branches.len(),
    }
}

/// Does `a` miss the limits by less than `b`: by its worst joint, or if that is the same, by the
/// sum of all?
fn is_nearer_to_limits(a: &Solution, b: &Solution) -> bool {
    let gain = a.smallest_margin().0 - b.smallest_margin().0;
    let total = |solution: &Solution| -> f64 {
        solution
            .margins
            .iter()
            .map(|margin| margin.0.min(0.0))
            .sum()
    };
    if gain.abs() > SAME_DEG {
        gain > 0.0
    } else {
        total(a) > total(b) + SAME_DEG
    }
}
