//! The solvers behind one call.

use api::arms::ArmSolver;
use kinematics::serial::{
    DlsError, DlsOptions, FiveLinkError, FiveLinkSolutions, JointValues, SerialArm, Task,
    TextbookBranch, TextbookError, WristError,
};
use kinematics::{Elbow, Flip, Frames, Front, IkError, Pose, Seed, Solution};
use nalgebra::{Point3, Vector3};

use super::{flange, out_of_reach, singular_name};
use crate::arm::Arm;
use crate::refusal::Refusal;

/// Two joint sets nearer than this, in degrees or millimeters, are one.
const SAME: f64 = 1e-6;

/// What is wanted.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Target {
    /// `X_UT`.
    Pose(Pose),
    /// The five-link arm's E and F in the user frame.
    Points([f64; 3], [f64; 3]),
}

/// Of whom it is wanted, and how.
#[derive(Clone, Debug)]
pub(crate) struct Question {
    pub(crate) arm: Arm,
    /// The arm from the user frame to the tool.
    pub(crate) framed: SerialArm,
    pub(crate) frames: Frames,
    pub(crate) task: Task,
    pub(crate) search: DlsOptions,
}

/// A joint set.
#[derive(Clone, Debug)]
pub(crate) struct Found {
    pub(crate) joints: JointValues,
    pub(crate) singular: Vec<String>,
    pub(crate) steps: Option<usize>,
}

/// The joint sets for a target; at least one.
pub(crate) fn solve(
    question: &Question,
    method: ArmSolver,
    target: &Target,
    near: &JointValues,
) -> Result<Vec<Found>, Refusal> {
    let X_UT = match target {
        Target::Pose(pose) => pose,
        Target::Points(e, f) => return five_link(question, e, f),
    };
    match method {
        ArmSolver::ClosedForm => closed_form(question, X_UT, near),
        ArmSolver::Quartic => quartic(question, X_UT, near),
        ArmSolver::Textbook => textbook(question, X_UT),
        ArmSolver::FiveLink => {
            let (e, f) = ends(question, X_UT);
            five_link(question, &e, &f)
        }
        ArmSolver::DampedLeastSquares => search(question, X_UT, near),
    }
}

fn values(arm: &Arm, degrees: &[f64]) -> Result<JointValues, Refusal> {
    arm.joints("joints_deg_mm", degrees)
}

fn closed_form(
    question: &Question,
    X_UT: &Pose,
    near: &JointValues,
) -> Result<Vec<Found>, Refusal> {
    let arm = &question.arm;
    let (Some(model), Some(seed)) = (arm.closed, Arm::pendant(&arm.shown(near))) else {
        return Err(Refusal::invalid(
            "method",
            "the closed form does not cover this arm",
        ));
    };
    let X_WF = flange(&question.frames, X_UT);
    let all = model
        .inverse_all(&X_WF)
        .map_err(|error: IkError| out_of_reach("pose", error))?;
    // The nearest one may lie a turn away from the branch as `inverse_all` writes it.
    let nearest = model.inverse(&X_WF, Seed::Near(seed)).ok();
    let mut found: Vec<Found> = Vec::new();
    for solution in nearest.iter().chain(all.iter()) {
        let joints = values(arm, &solution.joints.degrees())?;
        push(
            &mut found,
            Found {
                joints,
                singular: near_singular(solution),
                steps: None,
            },
        );
    }
    Ok(found)
}

fn near_singular(solution: &Solution) -> Vec<String> {
    solution.singularity.near().map(singular_name).collect()
}

fn push(found: &mut Vec<Found>, new: Found) {
    let same = |a: &Found| {
        let pairs = a.joints.as_slice().iter().zip(new.joints.as_slice());
        pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) < SAME
    };
    if !found.iter().any(same) {
        found.push(new);
    }
}

fn quartic(question: &Question, X_UT: &Pose, near: &JointValues) -> Result<Vec<Found>, Refusal> {
    let solved = question.framed.inverse_spherical(X_UT, near);
    let solutions = solved.map_err(|error| match error {
        WristError::Joints(error) => Refusal::invalid("near_deg_mm", error),
        WristError::NotCovered { .. } => Refusal::invalid("method", error),
        WristError::WristCenterOutOfReach { .. } | WristError::RotationOutOfReach { .. } => {
            out_of_reach("pose", error)
        }
    })?;
    Ok(solutions
        .into_iter()
        .map(|solution| Found {
            joints: solution.joints,
            singular: solution.singular.into_iter().map(singular_name).collect(),
            steps: None,
        })
        .collect())
}

fn textbook(question: &Question, X_UT: &Pose) -> Result<Vec<Found>, Refusal> {
    let arm = &question.arm;
    let Some(textbook) = arm.textbook() else {
        return Err(Refusal::invalid(
            "method",
            "the textbook's solution is of its own arm",
        ));
    };
    let X_WF = flange(&question.frames, X_UT);
    let mut found = Vec::new();
    let mut refused: Option<TextbookError> = None;
    for front in [Front::Toward, Front::Back] {
        for elbow in [Elbow::Up, Elbow::Down] {
            for flip in [Flip::NoFlip, Flip::Flip] {
                let branch = TextbookBranch { front, elbow, flip };
                let solution = match textbook.inverse(&X_WF, branch) {
                    Ok(solution) => solution,
                    Err(error) => {
                        refused = refused.or(Some(error));
                        continue;
                    }
                };
                let turned = arm.serial.joint_list().iter().zip(solution.joints);
                let turned: Vec<f64> = turned
                    .map(|(joint, angle)| {
                        // The formulas give -180 to 180; the range may want another turn.
                        let turns = [angle.0, angle.0 + 360.0, angle.0 - 360.0];
                        let fits = turns.iter().find(|turn| joint.contains(turn.to_radians()));
                        fits.copied().unwrap_or(angle.0)
                    })
                    .collect();
                let new = Found {
                    joints: values(arm, &turned)?,
                    singular: solution.singular.into_iter().map(singular_name).collect(),
                    steps: None,
                };
                push(&mut found, new);
            }
        }
    }
    match refused {
        Some(error) if found.is_empty() => Err(out_of_reach("pose", error)),
        Some(_) | None => Ok(found),
    }
}

/// E and F in the user frame of a flange: F its origin, E one link back along its Z.
fn ends(question: &Question, X_UT: &Pose) -> ([f64; 3], [f64; 3]) {
    let X_UF = *X_UT * question.frames.tool.inverse();
    let length = question.arm.serial.joint_list().last();
    let back = Point3::new(0.0, 0.0, -length.map_or(0.0, |joint| joint.a));
    let (e, f) = (X_UF.isometry() * back, X_UF.isometry() * Point3::origin());
    ([e.x, e.y, e.z], [f.x, f.y, f.z])
}

fn five_link(question: &Question, e: &[f64; 3], f: &[f64; 3]) -> Result<Vec<Found>, Refusal> {
    let arm = &question.arm;
    let Some(five) = arm.five_link() else {
        return Err(Refusal::invalid(
            "method",
            "the paper's solution is of its five-link arm",
        ));
    };
    let in_world = |p: &[f64; 3]| -> Vector3<f64> {
        (question.frames.user_frame.isometry() * Point3::from(*p)).coords
    };
    let solved = five.inverse(&in_world(e), &in_world(f));
    let solutions = solved.map_err(|error| match error {
        FiveLinkError::Length { .. }
        | FiveLinkError::NotANumber { .. }
        | FiveLinkError::LinkLength { .. } => Refusal::invalid("points", error),
        FiveLinkError::OnAxisA
        | FiveLinkError::BeyondA(_)
        | FiveLinkError::TooFar(_)
        | FiveLinkError::TooNear(_)
        | FiveLinkError::BeyondC(_)
        | FiveLinkError::BeyondB(_)
        | FiveLinkError::BeyondE(_) => out_of_reach("pose", error),
    })?;
    let (sets, singular) = match solutions {
        FiveLinkSolutions::One(set) => (vec![set], Vec::new()),
        FiveLinkSolutions::Two(sets) => (sets.to_vec(), Vec::new()),
        FiveLinkSolutions::AnyD(set) => (vec![set], vec!["any-d".to_owned()]),
    };
    sets.into_iter()
        .map(|set| {
            Ok(Found {
                joints: values(arm, &set.map(|joint| joint.0))?,
                singular: singular.clone(),
                steps: None,
            })
        })
        .collect()
}

/// How far E and F are off, in millimeters and as an angle of the last link.
pub(super) fn point_errors(
    question: &Question,
    joints: &JointValues,
    e: &[f64; 3],
    f: &[f64; 3],
) -> (f64, f64) {
    let to_flange = Frames {
        tool: Pose::identity(),
        ..question.frames
    };
    let Ok(X_UF) = question.arm.serial.with_frames(&to_flange).forward(joints) else {
        return (f64::MAX, f64::MAX);
    };
    let (e, f) = (Vector3::from(*e), Vector3::from(*f));
    let (z, wanted) = (X_UF.isometry().rotation * Vector3::z(), (f - e).normalize());
    let off = (X_UF.isometry().translation.vector - f).norm();
    (off, z.cross(&wanted).norm().atan2(z.dot(&wanted)))
}

fn search(question: &Question, X_UT: &Pose, near: &JointValues) -> Result<Vec<Found>, Refusal> {
    let solved = question
        .framed
        .solve(X_UT, question.task, near, &question.search);
    let solution = solved.map_err(|error| match error {
        DlsError::Joints(error) => Refusal::invalid("near_deg_mm", error),
        DlsError::StartOutside(outside) => question
            .arm
            .outside_refusal("near_deg_mm", &crate::convert::outside_body(&outside)),
        DlsError::Option { .. } => Refusal::invalid("search", error),
        DlsError::NotReached { .. } => out_of_reach("pose", error),
    })?;
    Ok(vec![Found {
        joints: solution.joints,
        singular: Vec::new(),
        steps: Some(solution.steps),
    }])
}
