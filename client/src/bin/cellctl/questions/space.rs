//! `cellctl arm reach`: where an arm reaches.

use api::arms::{ReachBody, ReachGrid, ReachPlane, ReachResult};
use clap::{Args, ValueEnum};
use plots::answers;

use super::desk::Desk;
use super::input::{AskArgs, Row, SolverArgs, needed};
use super::show::{exit_if, finish};
use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::finite;
use crate::report::Report;
use crate::text::{self, thousandths, word};

/// Count the joint sets that reach each point of a slice of space, with the tool turned alike everywhere.
///
/// Exit code 1 if no pose is reached.
///
/// Example:
///   cellctl arm reach fanuc-m20ia --plane XZ --u 0,1800 --v -800,1800 --step 50 --turn 180,0,0 --plot reach.svg
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(super) struct ReachArgs {
    /// The model.
    model: String,
    /// The plane of the user frame; its axes are u and v.
    #[arg(long, value_enum, ignore_case = true, conflicts_with = "file")]
    plane: Option<PlaneArg>,
    /// Where the plane is on the third axis, in mm.
    #[arg(long, value_name = "MM", value_parser = finite, default_value_t = 0.0, allow_hyphen_values = true)]
    across: f64,
    /// The least and the greatest u, in mm.
    #[arg(long, value_name = "MIN,MAX", allow_hyphen_values = true)]
    u: Option<Row<2>>,
    /// The least and the greatest v, in mm.
    #[arg(long, value_name = "MIN,MAX", allow_hyphen_values = true)]
    v: Option<Row<2>>,
    /// From point to point, in mm.
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    step: Option<f64>,
    /// The tool's W, P and R in degrees; 0 if absent.
    #[arg(long, value_name = "W,P,R", allow_hyphen_values = true)]
    turn: Option<Row<3>>,
    #[command(flatten)]
    solver: SolverArgs,
    #[command(flatten)]
    ask: AskArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
#[value(rename_all = "UPPER")]
enum PlaneArg {
    Xy,
    Xz,
    Yz,
}

pub(super) async fn run(args: ReachArgs, context: &Context) -> Result<Report, Failure> {
    let (model, plot) = (&args.model, &args.ask.plot);
    let body = args.ask.file.question(|| of_options(&args))?;
    if plot.plot.is_some() && body.grid.is_none() {
        return Err(Failure::Usage(
            "a list of poses has no map: --plot needs a grid".to_owned(),
        ));
    }
    let answer = Desk::of(context).reach(model, &body).await?;
    let drawing = match (&plot.plot, &body.grid) {
        (Some(picture), Some(grid)) => Some((picture, answers::reach(model, grid, &answer)?)),
        (_, _) => None,
    };
    let exit = exit_if(answer.reachable > 0);
    finish(context, exit, &answer, drawing, counted)
}

fn of_options(args: &ReachArgs) -> Result<ReachBody, Failure> {
    let Row([w_deg, p_deg, r_deg]) = args.turn.unwrap_or(Row([0.0; 3]));
    let grid = ReachGrid {
        plane: match needed(args.plane, "--plane")? {
            PlaneArg::Xy => ReachPlane::Xy,
            PlaneArg::Xz => ReachPlane::Xz,
            PlaneArg::Yz => ReachPlane::Yz,
        },
        across_mm: args.across,
        u_mm: needed(args.u, "--u")?.0,
        v_mm: needed(args.v, "--v")?.0,
        step_mm: needed(args.step, "--step")?,
        w_deg,
        p_deg,
        r_deg,
    };
    Ok(ReachBody {
        poses: None,
        grid: Some(grid),
        method: args.solver.method(),
        task: args.solver.task(),
        frames: args.ask.frames.into(),
    })
}

fn counted(answer: &ReachResult) -> String {
    let poses = answer.inside.len();
    let share = if poses == 0 {
        0.0
    } else {
        100.0 * as_number(answer.reachable) / as_number(poses)
    };
    let mut facts = vec![
        ("by", word(answer.method)),
        ("of the", word(answer.task)),
        (
            "reached",
            format!(
                "{} of {poses} poses, {} %",
                answer.reachable,
                thousandths(share)
            ),
        ),
    ];
    let counts = || answer.inside.iter().copied().map(u32::from);
    let most = counts().max().unwrap_or(0);
    for sets in 1..=most {
        let count = counts().filter(|inside| *inside == sets).count();
        if count > 0 {
            facts.push(("", format!("{count} by {sets} joint sets")));
        }
    }
    let only_outside = answer.inside.iter().zip(&answer.solutions);
    let beyond = only_outside
        .filter(|(inside, all)| **inside == 0 && **all > 0)
        .count();
    if beyond > 0 {
        facts.push(("", format!("{beyond} only outside the ranges")));
    }
    text::facts(&facts)
}

#[expect(
    clippy::cast_precision_loss,
    reason = "a question has at most 250,000 poses"
)]
fn as_number(count: usize) -> f64 {
    count as f64
}
