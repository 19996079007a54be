//! `cellctl mobile-robot`: the mobile robots, and what they are to do at once.

use api::{
    InstantActionAnswer, InstantActionBody, InstantActionName, MobileRobotState, MobileRobotSummary,
};
use clap::builder::NonEmptyStringValueParser;
use clap::{Args, Subcommand, ValueEnum};
use client::Ask;
use uuid::Uuid;

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{Table, facts, word};

/// List the mobile robots, show one, or have one do something at once.
///
/// Examples:
///   cellctl mobile-robot
///   cellctl mobile-robot show mr1
///   cellctl mobile-robot action mr1 start-pause --reason "a person is in the aisle"
///   cellctl mobile-robot action mr1 cancel-order
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct MobileRobotArgs {
    #[command(subcommand)]
    command: Option<MobileRobotCommand>,
}

#[derive(Debug, Subcommand)]
enum MobileRobotCommand {
    /// List the mobile robots.
    List,
    /// Show what a mobile robot last told, and what it has been told.
    Show {
        /// The mobile robot's id.
        id: String,
    },
    /// Have a mobile robot do something at once. What a job has begun, the job ends.
    Action(ActionArgs),
}

#[derive(Args, Debug)]
struct ActionArgs {
    /// The mobile robot's id.
    id: String,
    /// What.
    action: Word,
    /// For `cancel-order`: which; the one the robot reports where absent.
    #[arg(long, value_name = "ID")]
    order: Option<Uuid>,
    /// Why, for the record.
    #[arg(long, value_name = "TEXT", value_parser = NonEmptyStringValueParser::new())]
    reason: Option<String>,
}

/// An instant action, as it is typed.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Word {
    /// Stand still.
    StartPause,
    /// Go on.
    StopPause,
    /// Give an order up that is of no job.
    CancelOrder,
    /// Do again what failed.
    Retry,
    /// Give up what failed.
    SkipRetry,
    /// Say all that is so now.
    StateRequest,
}

impl From<Word> for InstantActionName {
    fn from(word: Word) -> Self {
        match word {
            Word::StartPause => Self::StartPause,
            Word::StopPause => Self::StopPause,
            Word::CancelOrder => Self::CancelOrder,
            Word::Retry => Self::Retry,
            Word::SkipRetry => Self::SkipRetry,
            Word::StateRequest => Self::StateRequest,
        }
    }
}

pub(crate) async fn run(args: MobileRobotArgs, context: &Context) -> Result<Report, Failure> {
    let cell = context.cell().await?;
    match args.command {
        None | Some(MobileRobotCommand::List) => {
            let robots = context.client.mobile_robots(&cell).await?;
            Ok(context.report(Exit::Done, &robots, |robots| table(robots)))
        }
        Some(MobileRobotCommand::Show { id }) => {
            let robot = context.client.mobile_robot(&cell, &id).state().await?;
            Ok(context.report(Exit::Done, &robot, detail))
        }
        Some(MobileRobotCommand::Action(asked)) => {
            let body = InstantActionBody {
                action: asked.action.into(),
                order: asked.order,
                reason: asked.reason,
            };
            let robot = context.client.mobile_robot(&cell, &asked.id);
            let answer = robot.instant_action(&body, &Ask::default()).await?;
            Ok(context.report(Exit::Done, &answer, taken))
        }
    }
}

fn taken(answer: &InstantActionAnswer) -> String {
    let (robot, action) = (&answer.mobile_robot, word(answer.action));
    match answer.unacknowledged {
        0 => format!("{robot} has {action}.\n"),
        waiting => format!("{action} is in the outbox of {robot}, where {waiting} wait.\n"),
    }
}

fn table(robots: &[MobileRobotSummary]) -> String {
    if robots.is_empty() {
        return "No mobile robot.".to_owned();
    }
    let mut table = Table::new(&["mobile robot", "heard", "mode", "order"]);
    for robot in robots {
        table.row([
            robot.id.clone(),
            if robot.connected { "yes" } else { "no" }.to_owned(),
            robot.mode.map_or_else(String::new, word),
            robot
                .order
                .map_or_else(|| "none".to_owned(), |id| id.to_string()),
        ]);
    }
    table.to_string()
}

fn detail(robot: &MobileRobotState) -> String {
    let none = || "none".to_owned();
    let mut lines = vec![
        ("mobile robot", robot.id.clone()),
        (
            "heard",
            if robot.connected { "yes" } else { "no" }.to_owned(),
        ),
        (
            "session",
            robot.session.map_or_else(none, |id| id.to_string()),
        ),
        (
            "may move at the point",
            if robot.move_permit { "yes" } else { "no" }.to_owned(),
        ),
        ("messages waiting", robot.unacknowledged.to_string()),
    ];
    if let Some(data) = &robot.data {
        let loads = match &data.loads {
            None => "it cannot tell".to_owned(),
            Some(loads) => {
                let full = loads.iter().filter_map(|one| {
                    let load = one.load.as_ref()?;
                    Some(format!("{load} in {}", one.slot))
                });
                let full: Vec<_> = full.collect();
                if full.is_empty() {
                    none()
                } else {
                    full.join(", ")
                }
            }
        };
        let errors: Vec<_> = data
            .errors
            .iter()
            .map(|error| format!("{}: {}", error.error_type, error.description))
            .collect();
        lines.extend([
            ("mode", word(data.mode)),
            ("at", data.at_point.clone().unwrap_or_else(none)),
            ("order", data.order.map_or_else(none, |id| id.to_string())),
            ("loads", loads),
            (
                "errors",
                if errors.is_empty() {
                    none()
                } else {
                    errors.join("; ")
                },
            ),
        ]);
    }
    facts(&lines)
}
