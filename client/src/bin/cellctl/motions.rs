//! `cellctl motions`: the record of motions.

use api::{ControlToken, Motion, MotionList};
use clap::{Args, Subcommand};
use client::Page;
use uuid::Uuid;

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{self, Table, word};

/// List the robot's motions, newest first, or show one.
///
/// Examples:
///   cellctl motions
///   cellctl motions list --limit 5
///   cellctl motions show 019302d4-7b3f-7c7e-8f3a-2f6f1b0c9d11
#[derive(Args, Debug)]
#[command(verbatim_doc_comment, args_conflicts_with_subcommands = true)]
pub(crate) struct MotionsArgs {
    #[command(subcommand)]
    command: Option<MotionsCommand>,
    #[command(flatten)]
    list: ListArgs,
}

#[derive(Debug, Subcommand)]
enum MotionsCommand {
    /// List the motions, newest first.
    List(ListArgs),
    /// Show one motion and what became of it.
    Show {
        /// The motion's id.
        id: Uuid,
    },
    /// Take one motion back: not sent if it waits, stopped if it runs and the controller can be told to.
    Cancel {
        /// The motion's id.
        id: Uuid,
    },
    /// Hold the running motion.
    Pause {
        /// The motion's id.
        id: Uuid,
    },
    /// Let a motion on hold go on.
    Resume {
        /// The motion's id.
        id: Uuid,
        /// Control that was taken with `cellctl control take`. Where absent it is taken for this.
        #[arg(long, value_name = "TOKEN", env = "ROBOCELL_CONTROL")]
        control: Option<ControlToken>,
    },
}

#[derive(Args, Debug)]
struct ListArgs {
    /// At most this many.
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
    limit: Option<u32>,
    /// Where the page before said to go on.
    #[arg(long, value_name = "CURSOR")]
    cursor: Option<String>,
}

pub(crate) async fn run(args: MotionsArgs, context: &Context) -> Result<Report, Failure> {
    let robot = context.robot().await?;
    let list = match args.command {
        Some(MotionsCommand::Show { id }) => {
            let motion = robot.motion(id).await?;
            return Ok(context.report(Exit::Done, &motion, sentences));
        }
        Some(MotionsCommand::Cancel { id }) => {
            let motion = robot.cancel_motion(id).await?;
            return Ok(context.report(Exit::Done, &motion, sentences));
        }
        Some(MotionsCommand::Pause { id }) => {
            let motion = robot.pause_motion(id).await?;
            return Ok(context.report(Exit::Done, &motion, sentences));
        }
        Some(MotionsCommand::Resume { id, control }) => {
            let why = "a motion goes on, by cellctl";
            let (robot, held) = context.control_of(&robot, control, why).await?;
            let resumed = robot.resume_motion(id).await;
            if let Some(held) = held {
                // It ends by itself soon, if it cannot be given back.
                let _given_back = held.release().await;
            }
            return Ok(context.report(Exit::Done, &resumed?, sentences));
        }
        Some(MotionsCommand::List(list)) => list,
        None => args.list,
    };
    let page = Page {
        limit: list.limit,
        cursor: list.cursor,
    };
    let motions = robot.motions(&page).await?;
    Ok(context.report(Exit::Done, &motions, table))
}

fn table(list: &MotionList) -> String {
    if list.motions.is_empty() {
        return "No motion yet.".to_owned();
    }
    let mut table = Table::new(&["motion", "created", "type", "state", ">speed", "target"]);
    for motion in &list.motions {
        table.row([
            motion.id.to_string(),
            format!("{:.0}", motion.created_at),
            word(motion.motion_type),
            word(motion.state),
            text::speed(motion),
            text::pose(&motion.target),
        ]);
    }
    match &list.next_cursor {
        Some(cursor) => format!("{table}\nMore: cellctl motions list --cursor {cursor}"),
        None => table.to_string(),
    }
}

fn sentences(motion: &Motion) -> String {
    let mut facts = vec![
        ("motion", motion.id.to_string()),
        ("robot", format!("{} in {}", motion.robot, motion.cell)),
        ("type", word(motion.motion_type)),
        ("state", word(motion.state)),
        ("completion", word(motion.completion)),
        ("target", text::pose(&motion.target)),
        ("joints", text::joints(motion.expected_joints)),
        ("speed", text::speed(motion)),
        ("created", motion.created_at.to_string()),
    ];
    let optional = [
        ("not after", motion.not_after.map(|at| at.to_string())),
        ("ended", motion.ended_at.map(|at| at.to_string())),
        ("code", motion.code.map(word)),
        ("outcome", motion.outcome.map(word)),
        ("controller", motion.controller_text.clone()),
        ("reason", motion.reason.clone()),
        ("request", Some(motion.request_id.clone())),
    ];
    facts.extend(
        optional
            .into_iter()
            .filter_map(|(name, fact)| fact.map(|fact| (name, fact))),
    );
    text::facts(&facts)
}
