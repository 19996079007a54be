//! `cellctl plan trajectory`: joints in time.

use api::arms::{ArmDescription, ArmFrames};
use api::trajectory::{
    JointStates, TrajectoryBody, TrajectoryKind, TrajectoryPeaks, TrajectoryResult,
    TrajectorySample,
};
use clap::{Args, ValueEnum};
use plots::Drawing;
use plots::answers::{self, TrajectoryLook};

use super::desk::Desk;
use super::input::{AskArgs, Numbers, needed};
use super::show::{exit_if, finish, unit};
use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::finite;
use crate::report::Report;
use crate::text::{self, Table, thousandths, word};

/// Plan the joints from one set to another in time.
///
/// Exit code 1 if a joint would leave its range, or be faster than it can.
///
/// Examples:
///   cellctl plan trajectory fanuc-m20ia --kind jerk-limited --from 0,0,0,0,-90,0 --to 60,20,-20,0,-70,0 --plot joints.svg
///   cellctl plan trajectory fanuc-m20ia --kind quintic --from 0,0,0,0,-90,0 --to 60,20,-20,0,-70,0 --duration 2
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(super) struct TrajectoryArgs {
    /// The model.
    model: String,
    /// How.
    #[arg(long, value_enum, conflicts_with = "file")]
    kind: Option<KindArg>,
    /// The joints at the start.
    #[arg(long, value_name = "J1,J2,..", allow_hyphen_values = true)]
    from: Option<Numbers>,
    /// The joints at the goal.
    #[arg(long, value_name = "J1,J2,..", allow_hyphen_values = true)]
    to: Option<Numbers>,
    /// Their speeds at the start; at rest if absent.
    #[arg(long, value_name = "V1,V2,..", allow_hyphen_values = true)]
    from_velocity: Option<Numbers>,
    /// Their speeds at the goal; at rest if absent.
    #[arg(long, value_name = "V1,V2,..", allow_hyphen_values = true)]
    to_velocity: Option<Numbers>,
    /// Joints on the way, in their order: two for `4-3-4` and `3-5-3`, one or more for `blended`.
    #[arg(long, value_name = "J1,J2,..", allow_hyphen_values = true)]
    via: Vec<Numbers>,
    /// How long each polynomial lasts, in seconds: one for `quintic`, three for `4-3-4` and `3-5-3`.
    #[arg(long, value_name = "S,..", allow_hyphen_values = true)]
    duration: Option<Numbers>,
    /// Highest speeds of the joints; the model's if absent.
    #[arg(long, value_name = "V1,V2,..", allow_hyphen_values = true)]
    max_velocity: Option<Numbers>,
    /// Highest accelerations of the joints; the model's if absent.
    #[arg(long, value_name = "A1,A2,..", allow_hyphen_values = true)]
    max_acceleration: Option<Numbers>,
    /// Highest jerks of the joints; ten times the acceleration a second if absent.
    #[arg(long, value_name = "JERK1,JERK2,..", allow_hyphen_values = true)]
    max_jerk: Option<Numbers>,
    /// From sample to sample, in seconds; a hundredth of the whole time if absent.
    #[arg(long, value_name = "S", value_parser = finite, allow_hyphen_values = true)]
    period: Option<f64>,
    #[command(flatten)]
    ask: AskArgs,
    /// What to draw.
    #[arg(long, value_enum, default_value = "joints", requires = "plot")]
    view: View,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum KindArg {
    /// One polynomial of degree 5.
    Quintic,
    /// Polynomials of degree 4, 3 and 4.
    #[value(name = "4-3-4")]
    FourThreeFour,
    /// Polynomials of degree 3, 5 and 3.
    #[value(name = "3-5-3")]
    ThreeFiveThree,
    /// The shortest time within speed, acceleration and jerk.
    JerkLimited,
    /// Past via points with rounded corners.
    Blended,
}

/// What to draw of a movement in time.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum View {
    /// Positions, velocities, accelerations and jerks of the joints over time.
    Joints,
    /// Place and speed of the tool over time.
    Tool,
    /// The tool's way in space, with the arm at its start and end.
    Arm,
}

pub(super) async fn run(args: TrajectoryArgs, context: &Context) -> Result<Report, Failure> {
    let (model, ask, view) = (args.model.clone(), args.ask.clone(), args.view);
    let body = ask.file.question(|| of_options(args))?;
    let desk = Desk::of(context);
    let arm = desk.describe(&model).await?;
    let answer = desk.trajectory(&model, &body).await?;
    let drawing = match &ask.plot.plot {
        None => None,
        Some(picture) => {
            let via_s: Vec<f64> = answer.via.iter().map(|via| via.time_s).collect();
            let look = TrajectoryLook {
                title: &format!("{model}: {} trajectory of the joints", word(answer.kind)),
                note: &note(&arm, &answer),
                arm: &arm,
                samples: &answer.samples,
                peaks: &answer.peaks,
                via_s: &via_s,
                path_mm: &[],
                failure: None,
            };
            Some((picture, draw(&desk, &look, view, &body.frames).await?))
        }
    };
    let exit = exit_if(answer.within_limits);
    finish(context, exit, &answer, drawing, |answer| said(&arm, answer))
}

/// Draws a movement.
pub(super) async fn draw(
    desk: &Desk,
    look: &TrajectoryLook<'_>,
    view: View,
    frames: &ArmFrames,
) -> Result<Drawing, Failure> {
    let drawing = match view {
        View::Joints => answers::joints_in_time(look)?,
        View::Tool => answers::tool_in_time(look)?,
        View::Arm => match (look.samples.first(), look.samples.last()) {
            (Some(first), Some(last)) => {
                let model = &look.arm.model;
                let start = desk.at(model, &first.position_deg_mm, frames).await?;
                let end = desk.at(model, &last.position_deg_mm, frames).await?;
                answers::tool_in_space(look, Some(&start), Some(&end))?
            }
            (_, _) => answers::tool_in_space(look, None, None)?,
        },
    };
    Ok(drawing)
}

fn of_options(args: TrajectoryArgs) -> Result<TrajectoryBody, Failure> {
    let numbers = |given: Option<Numbers>| given.map(|Numbers(numbers)| numbers);
    Ok(TrajectoryBody {
        kind: match needed(args.kind, "--kind")? {
            KindArg::Quintic => TrajectoryKind::Quintic,
            KindArg::FourThreeFour => TrajectoryKind::FourThreeFour,
            KindArg::ThreeFiveThree => TrajectoryKind::ThreeFiveThree,
            KindArg::JerkLimited => TrajectoryKind::JerkLimited,
            KindArg::Blended => TrajectoryKind::Blended,
        },
        start: JointStates {
            position_deg_mm: needed(args.from, "--from")?.0,
            velocity_deg_mm_s: numbers(args.from_velocity),
            acceleration_deg_mm_s2: None,
        },
        goal: JointStates {
            position_deg_mm: needed(args.to, "--to")?.0,
            velocity_deg_mm_s: numbers(args.to_velocity),
            acceleration_deg_mm_s2: None,
        },
        via_deg_mm: args.via.into_iter().map(|Numbers(via)| via).collect(),
        durations_s: numbers(args.duration).unwrap_or_default(),
        max_velocity_deg_mm_s: numbers(args.max_velocity),
        max_acceleration_deg_mm_s2: numbers(args.max_acceleration),
        max_jerk_deg_mm_s3: numbers(args.max_jerk),
        period_s: args.period,
        frames: args.ask.frames.into(),
    })
}

fn note(arm: &ArmDescription, answer: &TrajectoryResult) -> String {
    let mut note = format!("{} s", thousandths(answer.duration_s));
    if let Some(slowest) = &answer.slowest {
        note = format!("{note}; the others wait for {slowest}");
    }
    let beyond = beyond(arm, &answer.peaks);
    if !beyond.is_empty() {
        note = format!("{note}\nBeyond what the arm can do: {}", beyond.join("; "));
    }
    note
}

fn said(arm: &ArmDescription, answer: &TrajectoryResult) -> String {
    let mut facts = vec![
        ("kind", word(answer.kind)),
        ("takes", format!("{} s", thousandths(answer.duration_s))),
        ("samples", answer.samples.len().to_string()),
    ];
    if let Some(slowest) = &answer.slowest {
        facts.push(("slowest", slowest.clone()));
    }
    for via in &answer.via {
        let deviations: Vec<String> = via
            .deviation_deg_mm
            .iter()
            .map(|v| thousandths(*v))
            .collect();
        let at = thousandths(via.time_s);
        facts.push((
            "via",
            format!("at {at} s, off by {}", deviations.join(", ")),
        ));
    }
    for beyond in beyond(arm, &answer.peaks) {
        facts.push(("beyond", beyond));
    }
    format!(
        "{}\n{}{}",
        text::facts(&facts),
        peaks(arm, &answer.peaks),
        tool(&answer.samples)
    )
}

/// What the joints are asked for beyond what they can do.
pub(super) fn beyond(arm: &ArmDescription, peaks: &[TrajectoryPeaks]) -> Vec<String> {
    let mut beyond = Vec::new();
    for (joint, peak) in arm.joints.iter().zip(peaks) {
        let [low, high] = peak.range_deg_mm;
        let unit = unit(joint.kind);
        let slack = 1e-6;
        if peak.min_deg_mm < low - slack || peak.max_deg_mm > high + slack {
            beyond.push(format!(
                "{} goes from {} to {} {unit}, its range is {} to {}",
                peak.joint,
                thousandths(peak.min_deg_mm),
                thousandths(peak.max_deg_mm),
                thousandths(low),
                thousandths(high)
            ));
        }
        for (what, per, value, limit) in [
            (
                "speed",
                "/s",
                peak.velocity_deg_mm_s,
                Some(peak.max_velocity_deg_mm_s),
            ),
            (
                "acceleration",
                "/s2",
                peak.acceleration_deg_mm_s2,
                Some(peak.max_acceleration_deg_mm_s2),
            ),
            ("jerk", "/s3", peak.jerk_deg_mm_s3, peak.max_jerk_deg_mm_s3),
        ] {
            if let Some(limit) = limit.filter(|limit| value > limit * (1.0 + slack)) {
                beyond.push(format!(
                    "{} {what} {} {unit}{per}, its limit is {}",
                    peak.joint,
                    thousandths(value),
                    thousandths(limit)
                ));
            }
        }
    }
    beyond
}

/// What the joints are asked for, beside what they can do.
pub(super) fn peaks(arm: &ArmDescription, peaks: &[TrajectoryPeaks]) -> String {
    let mut table = Table::new(&[
        "joint",
        ">least",
        ">most",
        ">speed /s",
        ">limit",
        ">acc. /s2",
        ">limit",
        ">jerk /s3",
        ">limit",
        "unit",
    ]);
    for (joint, peak) in arm.joints.iter().zip(peaks) {
        table.row([
            peak.joint.clone(),
            thousandths(peak.min_deg_mm),
            thousandths(peak.max_deg_mm),
            thousandths(peak.velocity_deg_mm_s),
            thousandths(peak.max_velocity_deg_mm_s),
            thousandths(peak.acceleration_deg_mm_s2),
            thousandths(peak.max_acceleration_deg_mm_s2),
            thousandths(peak.jerk_deg_mm_s3),
            peak.max_jerk_deg_mm_s3
                .map_or_else(String::new, thousandths),
            unit(joint.kind).to_owned(),
        ]);
    }
    table.to_string()
}

/// How fast the tool gets.
pub(super) fn tool(samples: &[TrajectorySample]) -> String {
    let fastest = samples
        .iter()
        .map(|sample| sample.tcp_speed_mm_s)
        .fold(0.0, f64::max);
    format!(
        "\nThe tool center point reaches {} mm/s.",
        thousandths(fastest)
    )
}
