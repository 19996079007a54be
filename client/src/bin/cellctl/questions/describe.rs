//! `cellctl arm list` and `arm describe`.

use api::arms::{ArmDescription, ArmFrames, ArmJoint, ArmList};
use clap::Args;
use plots::answers;

use super::desk::Desk;
use super::show::{PlotArgs, finish, joints, unit};
use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{self, Table, thousandths, word};

/// Show a model's Denavit-Hartenberg table, ranges and speeds; --plot draws it at home.
///
/// Example:
///   cellctl arm describe fanuc-m20ia --plot home.svg
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(super) struct DescribeArgs {
    /// The model; see `cellctl arm list`.
    model: String,
    #[command(flatten)]
    plot: PlotArgs,
}

pub(super) async fn list(context: &Context) -> Result<Report, Failure> {
    let models = Desk::of(context).models().await?;
    Ok(context.report(Exit::Done, &models, |ArmList { arms }| {
        let mut table = Table::new(&["model", ">joints", "inverse kinematics", "from"]);
        for arm in arms {
            let solvers: Vec<String> = arm.solvers.iter().map(word).collect();
            table.row([
                arm.model.clone(),
                arm.degrees_of_freedom.to_string(),
                solvers.join(", "),
                arm.manufacturer.clone(),
            ]);
        }
        table.to_string()
    }))
}

pub(super) async fn run(args: DescribeArgs, context: &Context) -> Result<Report, Failure> {
    let DescribeArgs { model, plot } = args;
    let desk = Desk::of(context);
    let arm = desk.describe(&model).await?;
    let drawing = match &plot.plot {
        None => None,
        Some(picture) => {
            let home = &arm.home_deg_mm;
            let at = desk.at(&model, home, &ArmFrames::default()).await?;
            Some((picture, answers::posture(&arm.model, home, &at)?))
        }
    };
    finish(context, Exit::Done, &arm, drawing, described)
}

fn described(arm: &ArmDescription) -> String {
    let solvers: Vec<String> = arm.solvers.iter().map(word).collect();
    let facts = [
        ("model", format!("{}, {}", arm.model, arm.manufacturer)),
        ("joints", arm.degrees_of_freedom.to_string()),
        ("solved by", solvers.join(", ")),
        ("of a pose", word(arm.task)),
        ("span", format!("{} mm", thousandths(arm.span_mm))),
        ("home", joints(arm, &arm.home_deg_mm)),
        ("base", text::pose(&arm.base)),
        ("flange", text::pose(&arm.flange)),
    ];
    let mut table = Table::new(&[
        "joint",
        "",
        ">a mm",
        ">alpha deg",
        ">d mm",
        ">theta deg",
        ">sign",
        ">offset",
        "coupled",
        ">min",
        ">max",
        ">speed /s",
        ">acc. /s2",
        "unit",
    ]);
    for joint in &arm.joints {
        table.row(row(joint));
    }
    format!(
        "{}\nq = sign * J + offset + coupled joints; theta + q of a joint that turns, d + q of one that slides\n\n{table}",
        text::facts(&facts)
    )
}

fn row(joint: &ArmJoint) -> [String; 14] {
    let couplings = joint.couplings.iter();
    let coupled: Vec<String> = couplings
        .map(|other| format!("{} * {}", other.factor, other.joint))
        .collect();
    let number = thousandths;
    [
        joint.name.clone(),
        word(joint.kind),
        number(joint.a_mm),
        number(joint.alpha_deg),
        number(joint.d_mm),
        number(joint.theta_deg),
        joint.sign.to_string(),
        number(joint.offset_deg_mm),
        coupled.join(" + "),
        number(joint.min_deg_mm),
        number(joint.max_deg_mm),
        number(joint.max_speed_deg_mm_s),
        number(joint.max_acceleration_deg_mm_s2),
        unit(joint.kind).to_owned(),
    ]
}
