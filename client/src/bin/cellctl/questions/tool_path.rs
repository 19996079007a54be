//! `cellctl plan tool-path`: the tool along a path.

use api::PoseBody;
use api::arms::{ArmDescription, ArmForwardResult, ArmInverseBody};
use api::trajectory::{ToolPathBody, ToolPathFailure, ToolPathKind, ToolPathResult};
use clap::{Args, ValueEnum};
use plots::answers::{self, TrajectoryLook};

use super::desk::Desk;
use super::input::{AskArgs, Numbers, Row, TaskArg, needed};
use super::show::{exit_if, finish};
use super::trajectory::{View, draw, peaks, tool};
use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::finite;
use crate::report::Report;
use crate::text::{self, thousandths, word};

/// Plan the tool along a line, an arc, a circle or a spline, with inverse kinematics at each step.
///
/// Exit code 1 if the arm cannot follow it; the answer says where and why.
///
/// Examples:
///   cellctl plan tool-path fanuc-m20ia --kind line --pose 985,0,940,180,0,0 --pose 985,300,700,180,0,0 --speed 300
///   cellctl plan tool-path scara --kind line --pose 400,-200,300,180,0,0 --pose 400,200,300,180,0,90 --speed 500
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(super) struct ToolPathArgs {
    /// The model.
    model: String,
    /// The path's shape.
    #[arg(long, value_enum, conflicts_with = "file")]
    kind: Option<KindArg>,
    /// A pose of the tool: two for a line, three for an arc or a circle, two or more for a spline.
    #[arg(long, value_name = "X,Y,Z,W,P,R", allow_hyphen_values = true)]
    pose: Vec<Row<6>>,
    /// The tool's highest speed, in mm/s.
    #[arg(long, value_name = "MM_S", value_parser = finite, allow_hyphen_values = true)]
    speed: Option<f64>,
    /// Its highest acceleration, in mm/s2; five times the speed a second if absent.
    #[arg(long, value_name = "MM_S2", value_parser = finite, allow_hyphen_values = true)]
    acceleration: Option<f64>,
    /// Its highest jerk, in mm/s3; ten times the acceleration a second if absent.
    #[arg(long, value_name = "MM_S3", value_parser = finite, allow_hyphen_values = true)]
    jerk: Option<f64>,
    /// How fast it turns at most, in degrees a second; 90 if absent.
    #[arg(long, value_name = "DEG_S", value_parser = finite, allow_hyphen_values = true)]
    turning: Option<f64>,
    /// The joints at the first pose; those nearest to home if absent.
    #[arg(long, value_name = "J1,J2,..", allow_hyphen_values = true)]
    start: Option<Numbers>,
    /// What of the poses counts; what the model can do if absent. Less than the pose is searched for.
    #[arg(long, value_enum)]
    task: Option<TaskArg>,
    /// From sample to sample, in seconds; 0.02 if absent.
    #[arg(long, value_name = "S", value_parser = finite, allow_hyphen_values = true)]
    period: Option<f64>,
    #[command(flatten)]
    ask: AskArgs,
    /// What to draw; the way in space where the arm cannot follow.
    #[arg(long, value_enum, default_value = "joints", requires = "plot")]
    view: View,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum KindArg {
    /// Straight from the first pose to the second.
    Line,
    /// From the first through the second to the third.
    Arc,
    /// The whole circle through three poses.
    Circle,
    /// A smooth curve through all poses.
    Spline,
}

pub(super) async fn run(args: ToolPathArgs, context: &Context) -> Result<Report, Failure> {
    let (model, ask, view) = (args.model.clone(), args.ask.clone(), args.view);
    let body = ask.file.question(|| of_options(args))?;
    let desk = Desk::of(context);
    let arm = desk.describe(&model).await?;
    let answer = desk.tool_path(&model, &body).await?;
    let drawing = match &ask.plot.plot {
        None => None,
        Some(picture) => {
            let look = TrajectoryLook {
                title: &format!(
                    "{model}: the tool along a {} at {} mm/s",
                    word(body.kind),
                    body.speed_mm_s
                ),
                note: &note(&answer),
                arm: &arm,
                samples: &answer.samples,
                peaks: &answer.peaks,
                via_s: &[],
                path_mm: &answer.path_mm,
                failure: answer.failure.as_ref(),
            };
            let drawing = if answer.samples.is_empty() {
                // There is nothing over time: where the arm stands at the beginning, and where it cannot go.
                let start = at_start(&desk, &model, &body).await?;
                answers::tool_in_space(&look, start.as_ref(), None)?
            } else {
                draw(&desk, &look, view, &body.frames).await?
            };
            Some((picture, drawing))
        }
    };
    let exit = exit_if(answer.feasible);
    finish(context, exit, &answer, drawing, |answer| said(&arm, answer))
}

/// The arm at the first pose, if it can be there.
async fn at_start(
    desk: &Desk,
    model: &str,
    body: &ToolPathBody,
) -> Result<Option<ArmForwardResult>, Failure> {
    if let Some(joints) = &body.start_deg_mm {
        return desk.at(model, joints, &body.frames).await.map(Some);
    }
    let question = ArmInverseBody {
        pose: body.poses.first().copied(),
        frames: body.frames.clone(),
        ..ArmInverseBody::default()
    };
    let Ok(found) = desk.inverse(model, &question).await else {
        return Ok(None);
    };
    let nearest = found.nearest.and_then(|index| found.branches.get(index));
    match nearest {
        Some(branch) => {
            let at = desk.at(model, &branch.joints_deg_mm, &body.frames).await?;
            Ok(Some(at))
        }
        None => Ok(None),
    }
}

fn of_options(args: ToolPathArgs) -> Result<ToolPathBody, Failure> {
    Ok(ToolPathBody {
        kind: match needed(args.kind, "--kind")? {
            KindArg::Line => ToolPathKind::Line,
            KindArg::Arc => ToolPathKind::Arc,
            KindArg::Circle => ToolPathKind::Circle,
            KindArg::Spline => ToolPathKind::Spline,
        },
        poses: args.pose.into_iter().map(PoseBody::from).collect(),
        start_deg_mm: args.start.map(|Numbers(joints)| joints),
        task: args.task.map(Into::into),
        speed_mm_s: needed(args.speed, "--speed")?,
        acceleration_mm_s2: args.acceleration,
        jerk_mm_s3: args.jerk,
        turning_deg_s: args.turning,
        period_s: args.period,
        frames: args.ask.frames.into(),
    })
}

fn stops(failure: &ToolPathFailure) -> String {
    let share = thousandths(failure.parameter * 100.0);
    format!("after {share} % of the path: {}", failure.reason)
}

fn note(answer: &ToolPathResult) -> String {
    match (&answer.failure, &answer.limited_by) {
        (Some(failure), _) => format!("The arm cannot follow, {}", stops(failure)),
        (None, Some(joint)) => format!(
            "{} s, {} times as long because of {joint}",
            thousandths(answer.duration_s),
            thousandths(answer.slowed)
        ),
        (None, None) => format!("{} s", thousandths(answer.duration_s)),
    }
}

fn said(arm: &ArmDescription, answer: &ToolPathResult) -> String {
    if let Some(failure) = &answer.failure {
        let mut facts = vec![("cannot", stops(failure))];
        if let Some(pose) = &failure.pose {
            facts.push(("there", text::pose(pose)));
        }
        for line in super::show::outside(&failure.outside) {
            facts.push(("", line));
        }
        return text::facts(&facts);
    }
    let mut facts = vec![
        ("takes", format!("{} s", thousandths(answer.duration_s))),
        ("samples", answer.samples.len().to_string()),
    ];
    if let Some(joint) = &answer.limited_by {
        let slowed = thousandths(answer.slowed);
        facts.push((
            "slowed",
            format!("{slowed} times as long because of {joint}"),
        ));
    }
    format!(
        "{}\n{}{}",
        text::facts(&facts),
        peaks(arm, &answer.peaks),
        tool(&answer.samples)
    )
}
