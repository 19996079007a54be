//! `cellctl route`: a mobile robot among obstacles.

use api::paths::{
    CellRouteBody, FloorBody, PlanRouteBody, PlanRouteResult, PolygonBody, RouteMethod, RouteSearch,
};
use clap::{Args, Subcommand, ValueEnum};
use plots::answers;

use super::desk::Desk;
use super::drive::{self, BaseArgs};
use super::input::{FileArgs, Numbers, Row, needed};
use super::show::{PlotArgs, finish};
use crate::context::Context;
use crate::failure::Failure;
use crate::numbers::finite;
use crate::report::{Exit, Report};
use crate::text::{self, Table, thousandths, word};

/// Plan routes of a mobile robot. Nothing moves.
#[derive(Args, Debug)]
pub(crate) struct RouteArgs {
    #[command(subcommand)]
    command: RouteCommand,
}

#[derive(Debug, Subcommand)]
enum RouteCommand {
    Plan(Box<PlanRouteArgs>),
}

/// Find a route for a disc among polygons.
///
/// With --mobile-robot a server is asked, which knows the cell: where the robot is, how large it is, its keep-out zones.
///
/// Examples:
///   cellctl route plan --floor 0,0,6000,4000 --radius 300 --start 500,500 --goal 5500,3500 \
///     --obstacle 2000,0,2500,0,2500,2800,2000,2800 --plot route.svg
///   cellctl route plan --file hall.toml --method roadmap --seed 3
///   cellctl route plan --mobile-robot mr1 --to handover/front --plot route.svg
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
struct PlanRouteArgs {
    /// The floor: its least x and y and its greatest, in mm.
    #[arg(
        long,
        value_name = "X,Y,X,Y",
        allow_hyphen_values = true,
        conflicts_with = "file"
    )]
    floor: Option<Row<4>>,
    /// The disc around the robot, in mm.
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true, conflicts_with = "file")]
    radius: Option<f64>,
    /// The robot's middle at the start.
    #[arg(
        long,
        value_name = "X,Y",
        allow_hyphen_values = true,
        conflicts_with = "file"
    )]
    start: Option<Row<2>>,
    /// The robot's middle at the goal.
    #[arg(
        long,
        value_name = "X,Y",
        allow_hyphen_values = true,
        conflicts_with = "file"
    )]
    goal: Option<Row<2>>,
    /// The corners of an obstacle, one after the other. As often as there are obstacles.
    #[arg(
        long,
        value_name = "X,Y,X,Y,X,Y,..",
        allow_hyphen_values = true,
        conflicts_with = "file"
    )]
    obstacle: Vec<Numbers>,
    /// A mobile robot of the cell: its route among what the cell's set-up has.
    #[arg(long, value_name = "ID")]
    mobile_robot: Option<String>,
    /// The point where it is to dock, in the place of --goal.
    #[arg(long, value_name = "STATION/POINT", requires = "mobile_robot", conflicts_with_all = ["goal", "file"])]
    to: Option<String>,
    /// How to look; this and what follows also over a file's.
    #[arg(long, value_enum)]
    method: Option<MethodArg>,
    /// The same seed gives the same route.
    #[arg(long)]
    seed: Option<u64>,
    /// The smallest cell of the quadtree, in mm.
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    resolution: Option<f64>,
    /// Samples of the roadmap after which it is given up.
    #[arg(long, value_name = "COUNT")]
    samples: Option<u32>,
    /// Steps in the potential field after which it is given up.
    #[arg(long, value_name = "COUNT")]
    steps: Option<u32>,
    /// From how near an obstacle is felt in the potential field, in mm.
    #[arg(long, value_name = "MM", value_parser = finite, allow_hyphen_values = true)]
    influence: Option<f64>,
    #[command(flatten)]
    file: FileArgs,
    #[command(flatten)]
    plot: PlotArgs,
    /// What to draw.
    #[arg(long, value_enum, default_value = "map", requires = "plot")]
    view: View,
    #[command(flatten)]
    base: BaseArgs,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum MethodArg {
    /// Exact cell decomposition.
    Trapezoidal,
    /// Approximate cell decomposition.
    Quadtree,
    /// Descent in a potential field, with random walks out of its minima.
    PotentialField,
    /// A probabilistic roadmap.
    Roadmap,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum View {
    /// The route among the obstacles, and what was looked at.
    Map,
    /// The wheels of a mecanum base that drives it.
    Wheels,
}

impl RouteArgs {
    /// Whether only a server knows the answer.
    pub(crate) fn asks_a_server(&self) -> bool {
        let RouteCommand::Plan(args) = &self.command;
        args.mobile_robot.is_some()
    }
}

pub(crate) async fn run(args: RouteArgs, context: &Context) -> Result<Report, Failure> {
    let RouteCommand::Plan(args) = args.command;
    let answer = match &args.mobile_robot {
        None => {
            let body = question(&args)?;
            Desk::of(context).plan_route(&body).await?
        }
        Some(mobile_robot) => {
            let body = question_in_cell(&args)?;
            let cell = context.cell().await?;
            let arms = context.client.arms();
            arms.plan_mobile_robot_route(&cell, mobile_robot, &body)
                .await?
        }
    };
    let drawing = match (&args.plot.plot, args.view) {
        (None, _) => None,
        (Some(picture), View::Map) => Some((picture, answers::route(&answer)?)),
        (Some(picture), View::Wheels) => {
            let (title, drive) = drive::along(&answer, &args.base)?;
            Some((picture, answers::wheels(&title, &drive)?))
        }
    };
    finish(context, Exit::Done, &answer, drawing, said)
}

fn question(args: &PlanRouteArgs) -> Result<PlanRouteBody, Failure> {
    let mut body = args.file.question(|| from_options(args))?;
    args.refine(&mut body.search);
    Ok(body)
}

/// What is not said is what the cell knows.
fn question_in_cell(args: &PlanRouteArgs) -> Result<CellRouteBody, Failure> {
    let mut body = args.file.question(|| {
        Ok(CellRouteBody {
            goal: args.to.clone(),
            goal_mm: args.goal.map(|Row(goal)| goal),
            start_mm: args.start.map(|Row(start)| start),
            radius_mm: args.radius,
            floor: args.floor.map(floor),
            obstacles: obstacles(&args.obstacle)?,
            search: RouteSearch::default(),
        })
    })?;
    args.refine(&mut body.search);
    Ok(body)
}

impl PlanRouteArgs {
    /// What the options say of the search holds, over a file's.
    fn refine(&self, search: &mut RouteSearch) {
        search.method = self.method.map(RouteMethod::from).or(search.method);
        search.seed = self.seed.or(search.seed);
        search.resolution_mm = self.resolution.or(search.resolution_mm);
        search.samples = self.samples.or(search.samples);
        search.steps = self.steps.or(search.steps);
        search.influence_mm = self.influence.or(search.influence_mm);
    }
}

impl From<MethodArg> for RouteMethod {
    fn from(method: MethodArg) -> Self {
        match method {
            MethodArg::Trapezoidal => Self::Trapezoidal,
            MethodArg::Quadtree => Self::Quadtree,
            MethodArg::PotentialField => Self::PotentialField,
            MethodArg::Roadmap => Self::Roadmap,
        }
    }
}

fn from_options(args: &PlanRouteArgs) -> Result<PlanRouteBody, Failure> {
    Ok(PlanRouteBody {
        floor: floor(needed(args.floor, "--floor")?),
        obstacles: obstacles(&args.obstacle)?,
        radius_mm: needed(args.radius, "--radius")?,
        start_mm: needed(args.start, "--start")?.0,
        goal_mm: needed(args.goal, "--goal")?.0,
        search: RouteSearch::default(),
    })
}

fn floor(Row([x0, y0, x1, y1]): Row<4>) -> FloorBody {
    FloorBody {
        min_mm: [x0, y0],
        max_mm: [x1, y1],
    }
}

fn obstacles(given: &[Numbers]) -> Result<Vec<PolygonBody>, Failure> {
    let mut obstacles = Vec::new();
    for (index, Numbers(numbers)) in given.iter().enumerate() {
        let (pairs, rest) = numbers.as_chunks::<2>();
        if !rest.is_empty() {
            return Err(Failure::Usage(format!(
                "obstacle {} has {} numbers; each corner is an x and a y",
                index + 1,
                numbers.len()
            )));
        }
        obstacles.push(PolygonBody {
            name: None,
            corners_mm: pairs.to_vec(),
        });
    }
    Ok(obstacles)
}

fn said(answer: &PlanRouteResult) -> String {
    let mut facts = vec![
        ("by", word(answer.method)),
        ("length", format!("{} mm", thousandths(answer.length_mm))),
        (
            "clear",
            format!(
                "{} mm at the narrowest place",
                thousandths(answer.clearance_mm)
            ),
        ),
    ];
    if !answer.cells.is_empty() {
        let free = answer.cells.iter().filter(|cell| cell.free).count();
        facts.push((
            "cells",
            format!("{}, {free} of them free", answer.cells.len()),
        ));
    }
    if !answer.graph_mm.is_empty() {
        facts.push(("looked at", format!("{} pieces", answer.graph_mm.len())));
    }
    let mut table = Table::new(&[">#", ">x mm", ">y mm"]);
    for (index, [x, y]) in answer.points_mm.iter().enumerate() {
        table.row([(index + 1).to_string(), thousandths(*x), thousandths(*y)]);
    }
    format!("{}\n{table}", text::facts(&facts))
}
