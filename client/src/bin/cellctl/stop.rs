//! `cellctl stop`.

use api::{StopBody, StopCategory, StopEffect, StopResult};
use clap::{Args, ValueEnum};

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};

/// Stop the robot: nothing more is sent, and where the controller can be told to, the arm stops.
///
/// This is a functional stop and no emergency stop. The answer says which of the two happened.
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct StopArgs {
    /// 1: a controlled stop; 2: the same, and the power stays on.
    #[arg(long, value_enum, default_value_t = Category::One, value_name = "CATEGORY")]
    category: Category,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Category {
    #[value(name = "1")]
    One,
    #[value(name = "2")]
    Two,
}

pub(crate) async fn run(args: StopArgs, context: &Context) -> Result<Report, Failure> {
    let category = match args.category {
        Category::One => StopCategory::Stop1,
        Category::Two => StopCategory::Stop2,
    };
    let stopped = context.robot().await?.stop(StopBody { category }).await?;
    Ok(context.report(Exit::Done, &stopped, sentence))
}

fn sentence(stopped: &StopResult) -> String {
    let effect = match stopped.stop_effect {
        StopEffect::HaltsMotion => "STOPPED",
        StopEffect::IssuesNothingMore => "NOTHING MORE IS SENT",
    };
    let mut text = format!("{effect}. {}", stopped.text);
    for motion in &stopped.canceled {
        text.push_str("\nTaken back, not sent: ");
        text.push_str(&motion.to_string());
    }
    text
}
