//! `cellctl arm fk` and `arm ik`.

use api::arms::{
    ArmBranch, ArmDescription, ArmForwardBody, ArmForwardResult, ArmInverseBody, ArmInverseResult,
    FiveLinkPoints,
};
use clap::Args;
use plots::answers::{self, Labeled};

use super::desk::Desk;
use super::input::{AskArgs, Numbers, PostureArgs, Row, SolverArgs, needed};
use super::show::{exit_if, finish, outside, point, unit};
use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::finite;
use crate::report::{Exit, Report};
use crate::text::{self, Table, thousandths, word};

/// Calculate where the tool is at given joint values.
///
/// Examples:
///   cellctl arm fk fanuc-m20ia 0 0 0 0 -90 0
///   cellctl arm fk five-link 0 45 -60 0 30 --plot arm.svg
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(super) struct FkArgs {
    #[command(flatten)]
    posture: PostureArgs,
    #[command(flatten)]
    ask: AskArgs,
}

pub(super) async fn forward(args: FkArgs, context: &Context) -> Result<Report, Failure> {
    let FkArgs {
        posture: PostureArgs { model, joints },
        ask: AskArgs { frames, file, plot },
    } = args;
    let body = file.question(|| {
        Ok(ArmForwardBody {
            joints_deg_mm: joints,
            frames: frames.into(),
        })
    })?;
    let answer = Desk::of(context).forward(&model, &body).await?;
    let drawing = match &plot.plot {
        None => None,
        Some(picture) => Some((
            picture,
            answers::posture(&model, &body.joints_deg_mm, &answer)?,
        )),
    };
    finish(context, Exit::Done, &answer, drawing, stands)
}

fn stands(answer: &ArmForwardResult) -> String {
    let zyz = answer.tcp_zyz;
    let [phi, theta, psi] = [zyz.phi_deg, zyz.theta_deg, zyz.psi_deg].map(thousandths);
    let free = if zyz.regular {
        ""
    } else {
        "; only the sum or the difference of phi and psi is determined"
    };
    let mut facts = vec![
        ("tool", text::pose(&answer.tcp)),
        (
            "ZYZ",
            format!("phi {phi}  theta {theta}  psi {psi} deg{free}"),
        ),
        ("flange", text::pose(&answer.flange)),
    ];
    if let Some(configuration) = &answer.configuration {
        facts.push(("configuration", configuration.clone()));
    }
    for named in &answer.points {
        facts.push((&named.name, point(named.at_mm)));
    }
    let ranges = if answer.outside.is_empty() {
        "Every joint is inside its range.".to_owned()
    } else {
        outside(&answer.outside).join("\n")
    };
    format!("{}\n{ranges}", text::facts(&facts))
}

/// Calculate the joint values that reach a pose: every branch, where there is a formula.
///
/// Exit code 1 if none is inside the ranges; the answer says why.
///
/// Examples:
///   cellctl arm ik fanuc-m20ia 985 0 940 180 0 0
///   cellctl arm ik scara 400 200 100 0 0 30 --method damped-least-squares
///   cellctl arm ik five-link --e 350,0,-300 --f 350,0,-400
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(super) struct IkArgs {
    /// The model.
    model: String,
    /// X, Y, Z in mm and W, P, R in degrees.
    #[arg(allow_negative_numbers = true, value_parser = finite, num_args = 6,
        value_names = ["X", "Y", "Z", "W", "P", "R"], conflicts_with_all = ["e", "file"])]
    pose: Option<Vec<f64>>,
    /// E of the five-link arm, with --f in the place of a pose.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "f")]
    e: Option<Row<3>>,
    /// F of the five-link arm.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, requires = "e")]
    f: Option<Row<3>>,
    #[command(flatten)]
    solver: SolverArgs,
    /// The present joints: branches are ordered by the distance from them. Home if absent.
    #[arg(long, value_name = "J1,J2,..", allow_hyphen_values = true)]
    near: Option<Numbers>,
    #[command(flatten)]
    ask: AskArgs,
}

pub(super) async fn inverse(args: IkArgs, context: &Context) -> Result<Report, Failure> {
    let (model, plot) = (args.model.clone(), args.ask.plot.clone());
    let file = args.ask.file.clone();
    let body = file.question(|| of_options(args))?;
    let desk = Desk::of(context);
    let arm = desk.describe(&model).await?;
    let answer = desk.inverse(&model, &body).await?;
    let drawing = match &plot.plot {
        // Nothing reaches the pose: there is nothing to draw, and the answer says so.
        Some(picture) if !answer.branches.is_empty() => {
            let mut found = Vec::new();
            for (index, branch) in answer.branches.iter().enumerate() {
                found.push(Labeled {
                    name: label(index, branch),
                    within_ranges: branch.within_ranges,
                    at: desk.at(&model, &branch.joints_deg_mm, &body.frames).await?,
                });
            }
            let note = answer.reason.clone().unwrap_or_default();
            Some((picture, answers::branches(&model, &note, &found)?))
        }
        Some(_) | None => None,
    };
    let exit = exit_if(answer.nearest.is_some());
    finish(context, exit, &answer, drawing, |answer| {
        reached(&arm, answer)
    })
}

/// As the table numbers them.
fn label(index: usize, branch: &ArmBranch) -> String {
    match &branch.configuration {
        Some(configuration) => format!("{}: {configuration}", index + 1),
        None => (index + 1).to_string(),
    }
}

fn of_options(args: IkArgs) -> Result<ArmInverseBody, Failure> {
    let points = match (args.e, args.f) {
        (Some(Row(e_mm)), Some(Row(f_mm))) => Some(FiveLinkPoints { e_mm, f_mm }),
        (_, _) => None,
    };
    let pose = match (&points, args.pose) {
        (Some(_), _) => None,
        (None, pose) => {
            let pose = needed(pose, "the pose X Y Z W P R")?;
            let row: Result<[f64; 6], _> = pose.try_into();
            row.ok().map(|row| Row(row).into())
        }
    };
    Ok(ArmInverseBody {
        pose,
        points,
        method: args.solver.method(),
        task: args.solver.task(),
        near_deg_mm: args.near.map(|Numbers(joints)| joints),
        search: None,
        frames: args.ask.frames.into(),
    })
}

fn reached(arm: &ArmDescription, answer: &ArmInverseResult) -> String {
    let headings = [">#".to_owned(), "configuration".to_owned()]
        .into_iter()
        .chain(
            arm.joints
                .iter()
                .map(|joint| format!(">{} {}", joint.name, unit(joint.kind))),
        )
        .chain([">distance", ">off mm", ">off deg", ""].map(str::to_owned));
    let mut table = Table::with_headings(headings);
    for (index, branch) in answer.branches.iter().enumerate() {
        let ends = [
            thousandths(branch.distance_deg_mm),
            format!("{:.1e}", branch.position_error_mm),
            format!("{:.1e}", branch.rotation_error_deg),
            remarks(answer, index, branch),
        ];
        let begin = [
            (index + 1).to_string(),
            branch.configuration.clone().unwrap_or_default(),
        ];
        let joints = branch.joints_deg_mm.iter().map(|value| thousandths(*value));
        table.row(begin.into_iter().chain(joints).chain(ends));
    }
    let count = answer.branches.len();
    let sets = if count == 1 {
        "joint set"
    } else {
        "joint sets"
    };
    let mut said = format!(
        "{count} {sets} by {}, of the {}",
        word(answer.method),
        word(answer.task)
    );
    if let Some(reason) = &answer.reason {
        said = format!("{said}; none is inside the ranges: {reason}");
    }
    if answer.branches.is_empty() {
        said
    } else {
        format!("{said}\n\n{table}")
    }
}

fn remarks(answer: &ArmInverseResult, index: usize, branch: &ArmBranch) -> String {
    let mut remarks = Vec::new();
    if answer.nearest == Some(index) {
        remarks.push("nearest".to_owned());
    }
    remarks.extend(
        branch
            .singular
            .iter()
            .map(|name| format!("singular: {name}")),
    );
    if let Some(steps) = branch.steps {
        remarks.push(format!("{steps} steps"));
    }
    remarks.extend(outside(&branch.outside));
    remarks.join(", ")
}
