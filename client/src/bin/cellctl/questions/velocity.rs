//! `cellctl arm jacobian`, `arm rates` and `arm move-velocity`.

use api::arms::{
    ArmDescription, ArmJacobianBody, ArmJacobianResult, ArmMotionEnd, ArmRatesBody, ArmRatesResult,
    ArmTwist, ArmVelocityMotionBody, ArmVelocityMotionResult,
};
use clap::{Args, ValueEnum};
use plots::answers;

use super::desk::Desk;
use super::input::{AskArgs, Numbers, PostureArgs, Row, TaskArg, needed};
use super::show::{exit_if, finish, joints, point};
use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::finite;
use crate::report::{Exit, Report};
use crate::text::{self, Table, thousandths, word};

/// Calculate the Jacobians at given joint values: rank, manipulability, what is lost; --plot draws the velocities.
///
/// Examples:
///   cellctl arm jacobian fanuc-m20ia 0 20 -20 0 -70 0
///   cellctl arm jacobian scara 30 60 100 0 --task position --plot velocities.svg
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(super) struct JacobianArgs {
    #[command(flatten)]
    posture: PostureArgs,
    /// What of the tool's motion counts; what the model can do if absent.
    #[arg(long, value_enum)]
    task: Option<TaskArg>,
    #[command(flatten)]
    ask: AskArgs,
}

pub(super) async fn jacobian(args: JacobianArgs, context: &Context) -> Result<Report, Failure> {
    let JacobianArgs {
        posture: PostureArgs { model, joints },
        task,
        ask: AskArgs { frames, file, plot },
    } = args;
    let body = file.question(|| {
        Ok(ArmJacobianBody {
            joints_deg_mm: joints,
            task: task.map(Into::into),
            frames: frames.into(),
        })
    })?;
    let desk = Desk::of(context);
    let arm = desk.describe(&model).await?;
    let answer = desk.jacobian(&model, &body).await?;
    let drawing = match &plot.plot {
        None => None,
        Some(picture) => {
            let at = desk.at(&model, &body.joints_deg_mm, &body.frames).await?;
            let drawing = answers::velocities(&arm, &body.joints_deg_mm, &at, &answer)?;
            Some((picture, drawing))
        }
    };
    finish(context, Exit::Done, &answer, drawing, |answer| {
        jacobians(&arm, answer)
    })
}

fn jacobians(arm: &ArmDescription, answer: &ArmJacobianResult) -> String {
    let mut facts = vec![
        ("of the", word(answer.task)),
        ("rank", format!("{} of {}", answer.rank, answer.full_rank)),
        ("manipulability", format!("{:.6}", answer.manipulability)),
    ];
    if let Some(condition) = answer.condition {
        facts.push(("condition", format!("{condition:.3}")));
    }
    for lost in &answer.lost {
        facts.push(("lost", twist(lost)));
    }
    for free in &answer.free_deg_mm_s {
        facts.push(("moves nothing", joints(arm, free)));
    }
    let mut said = text::facts(&facts);
    let geometric = [
        "vx mm/s", "vy mm/s", "vz mm/s", "wx deg/s", "wy deg/s", "wz deg/s",
    ];
    let zyz = ["x", "y", "z", "phi", "theta", "psi"];
    let wpr = ["x", "y", "z", "W", "P", "R"];
    for (name, rows, matrix, absent) in [
        ("geometric", geometric, Some(&answer.geometric), None),
        (
            "analytic, ZYZ",
            zyz,
            answer.analytic_zyz.as_ref(),
            answer.zyz_singular.as_ref(),
        ),
        (
            "analytic, W P R",
            wpr,
            answer.analytic_wpr.as_ref(),
            answer.wpr_singular.as_ref(),
        ),
    ] {
        match (matrix, absent) {
            (Some(matrix), _) => {
                said.push_str(&format_matrix(arm, name, rows, matrix));
            }
            (None, why) => {
                let why = why.map_or("", String::as_str);
                said.push_str(&["\n", name, ": ", why, "\n"].concat());
            }
        }
    }
    said
}

fn format_matrix(arm: &ArmDescription, name: &str, rows: [&str; 6], matrix: &[Vec<f64>]) -> String {
    let names = arm.joints.iter().map(|joint| format!(">{}", joint.name));
    let mut table = Table::with_headings([name.to_owned()].into_iter().chain(names));
    for (row, entries) in rows.into_iter().zip(matrix) {
        let entries = entries.iter().map(|entry| thousandths(*entry));
        table.row([row.to_owned()].into_iter().chain(entries));
    }
    format!("\n{table}")
}

fn twist(twist: &ArmTwist) -> String {
    let [vx, vy, vz] = twist.linear_mm_s.map(thousandths);
    let [wx, wy, wz] = twist.angular_deg_s.map(thousandths);
    format!("{vx}, {vy}, {vz} mm/s  {wx}, {wy}, {wz} deg/s")
}

/// Calculate the joint rates of a velocity of the tool; --plot draws the arm now and a moment later.
///
/// Examples:
///   cellctl arm rates fanuc-m20ia 0 20 -20 0 -70 0 --linear 100,0,0
///   cellctl arm rates seven-joint 0 30 0 60 0 45 0 --linear 0,50,0 --null 10,0,0,0,0,0,0 --plot rates.svg
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(super) struct RatesArgs {
    #[command(flatten)]
    posture: PostureArgs,
    /// The tool's velocity in mm/s; 0 if absent.
    #[arg(long, value_name = "VX,VY,VZ", allow_hyphen_values = true)]
    linear: Option<Row<3>>,
    /// How the tool turns, in degrees a second; 0 if absent.
    #[arg(long, value_name = "WX,WY,WZ", allow_hyphen_values = true)]
    angular: Option<Row<3>>,
    /// Rates that the joints should have besides, as far as the tool does not feel them.
    #[arg(long, value_name = "J1,J2,..", allow_hyphen_values = true)]
    null: Option<Numbers>,
    /// What of the velocity counts; what the model can do if absent.
    #[arg(long, value_enum)]
    task: Option<TaskArg>,
    #[command(flatten)]
    ask: AskArgs,
}

pub(super) async fn rates(args: RatesArgs, context: &Context) -> Result<Report, Failure> {
    let still = Row([0.0; 3]);
    let PostureArgs { model, joints } = args.posture;
    let AskArgs { frames, file, plot } = args.ask;
    let body = file.question(|| {
        Ok(ArmRatesBody {
            joints_deg_mm: joints,
            velocity: ArmTwist {
                linear_mm_s: args.linear.unwrap_or(still).0,
                angular_deg_s: args.angular.unwrap_or(still).0,
            },
            null_motion_deg_mm_s: args.null.map(|Numbers(rates)| rates),
            task: args.task.map(Into::into),
            frames: frames.into(),
        })
    })?;
    let desk = Desk::of(context);
    let arm = desk.describe(&model).await?;
    let answer = desk.rates(&model, &body).await?;
    let drawing = match &plot.plot {
        None => None,
        Some(picture) => {
            let after_s = seen_after(&arm, &answer);
            let moved = body.joints_deg_mm.iter().zip(&answer.rates_deg_mm_s);
            let later: Vec<f64> = moved.map(|(at, rate)| at + rate * after_s).collect();
            let now = desk.at(&model, &body.joints_deg_mm, &body.frames).await?;
            let later = desk.at(&model, &later, &body.frames).await?;
            let drawing = answers::rates(&model, &answer, &body.velocity, after_s, (&now, &later))?;
            Some((picture, drawing))
        }
    };
    let exit = exit_if(answer.load <= 1.0);
    finish(context, exit, &answer, drawing, |answer| {
        turning(&arm, answer)
    })
}

/// After how many seconds the motion is seen: a joint has then gone a twelfth of its range. At most a second.
fn seen_after(arm: &ArmDescription, answer: &ArmRatesResult) -> f64 {
    let joints = arm.joints.iter().zip(&answer.rates_deg_mm_s);
    let times = joints
        .filter(|(_, rate)| **rate != 0.0)
        .map(|(joint, rate)| (joint.max_deg_mm - joint.min_deg_mm) / 12.0 / rate.abs());
    times.fold(1.0, f64::min)
}

fn turning(arm: &ArmDescription, answer: &ArmRatesResult) -> String {
    let mut table = Table::new(&["joint", ">rate", ">highest", "unit"]);
    for (joint, rate) in arm.joints.iter().zip(&answer.rates_deg_mm_s) {
        table.row([
            joint.name.clone(),
            thousandths(*rate),
            thousandths(joint.max_speed_deg_mm_s),
            format!("{}/s", super::show::unit(joint.kind)),
        ]);
    }
    let load = thousandths(answer.load * 100.0);
    let can = if answer.load <= 1.0 {
        "of what the joints can do"
    } else {
        "of what the joints can do: the arm cannot"
    };
    format!("{load} % {can}; rank {}\n\n{table}", answer.rank)
}

/// Move the tool with a constant velocity, calculated step by step: until its time is over, or a joint's range, speed or a
/// singular posture ends it.
///
/// Exit code 1 if it ended before its time; the answer says where and why.
///
/// Examples:
///   cellctl arm move-velocity five-link 0 45 -60 0 30 --velocity -30,5,-2 --time 2 --plot motion.svg
///   cellctl arm move-velocity five-link 0 45 -60 0 30 --along 20 --time 1
#[derive(Args, Debug)]
#[command(verbatim_doc_comment, mut_arg("joints", |joints| joints.help("The joint values at the start, base first")))]
pub(super) struct MotionArgs {
    #[command(flatten)]
    posture: PostureArgs,
    /// V, in mm/s.
    #[arg(
        long,
        value_name = "VX,VY,VZ",
        allow_hyphen_values = true,
        conflicts_with = "along"
    )]
    velocity: Option<Row<3>>,
    /// The speed along the tool's Z as it is at the start, in mm/s.
    #[arg(long, value_name = "MM_S", value_parser = finite, allow_hyphen_values = true)]
    along: Option<f64>,
    /// T, in seconds.
    #[arg(long, value_name = "S", value_parser = finite, allow_hyphen_values = true)]
    time: Option<f64>,
    /// In how many steps; 100 if absent.
    #[arg(long, value_name = "COUNT")]
    steps: Option<u32>,
    /// What of the tool's pose is kept; what the model can do if absent.
    #[arg(long, value_enum)]
    task: Option<TaskArg>,
    #[command(flatten)]
    ask: AskArgs,
    /// What to draw.
    #[arg(long, value_enum, default_value = "arm", requires = "plot")]
    view: MotionView,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MotionView {
    /// The arm at the start and at the end, in space and in three projections.
    Arm,
    /// The joints over time.
    Joints,
}

pub(super) async fn motion(args: MotionArgs, context: &Context) -> Result<Report, Failure> {
    let PostureArgs { model, joints } = args.posture;
    let AskArgs { frames, file, plot } = args.ask;
    let body = file.question(|| {
        Ok(ArmVelocityMotionBody {
            start_deg_mm: joints,
            velocity_mm_s: args.velocity.map(|Row(velocity)| velocity),
            along_tool_mm_s: args.along,
            time_s: needed(args.time, "--time")?,
            steps: args.steps,
            task: args.task.map(Into::into),
            frames: frames.into(),
        })
    })?;
    let desk = Desk::of(context);
    let arm = desk.describe(&model).await?;
    let answer = desk.velocity_motion(&model, &body).await?;
    let drawing = match (&plot.plot, args.view) {
        (None, _) => None,
        (Some(picture), MotionView::Joints) => {
            Some((picture, answers::velocity_motion_joints(&arm, &answer)?))
        }
        (Some(picture), MotionView::Arm) => {
            let last = answer.samples.last();
            let end = last.map_or(&body.start_deg_mm, |sample| &sample.joints_deg_mm);
            let start = desk.at(&model, &body.start_deg_mm, &body.frames).await?;
            let end = desk.at(&model, end, &body.frames).await?;
            let drawing = answers::velocity_motion(&arm.model, &answer, &start, &end)?;
            Some((picture, drawing))
        }
    };
    let exit = exit_if(answer.end == ArmMotionEnd::Completed);
    finish(context, exit, &answer, drawing, |answer| {
        moved(&arm, answer)
    })
}

fn moved(arm: &ArmDescription, answer: &ArmVelocityMotionResult) -> String {
    let mut facts = vec![
        ("moved", format!("{} s", thousandths(answer.moved_s))),
        ("ended", word(answer.end)),
    ];
    if let Some(detail) = &answer.detail {
        facts.push(("why", detail.clone()));
    }
    for (name, sample) in [
        ("start", answer.samples.first()),
        ("end", answer.samples.last()),
    ] {
        let Some(sample) = sample else { continue };
        facts.push((name, joints(arm, &sample.joints_deg_mm)));
        facts.push(("", point(sample.tcp_mm)));
    }
    text::facts(&facts)
}
