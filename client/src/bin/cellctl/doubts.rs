//! `cellctl doubts`: what only a person can decide.

use std::fmt::Write as _;

use api::{Intervention, InterventionList, RespondBody};
use clap::builder::NonEmptyStringValueParser;
use clap::{Args, Subcommand, ValueEnum};
use client::Ask;
use uuid::Uuid;

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{self, word};

/// List the motions in doubt, or answer one.
///
/// A motion is in doubt when nobody can tell whether the arm moved. Until a person has looked and answered, the
/// server takes no further motion of that robot.
///
/// Examples:
///   cellctl doubts
///   cellctl doubts answer 019302d4-7b3f-7c7e-8f3a-2f6f1b0c9d11 did-not-happen --reason "it stands where it stood"
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct DoubtsArgs {
    #[command(subcommand)]
    command: Option<DoubtsCommand>,
}

#[derive(Debug, Subcommand)]
enum DoubtsCommand {
    /// List the motions in doubt.
    List,
    /// Answer one, once and for good.
    Answer {
        /// Its id.
        id: Uuid,
        /// What you saw.
        #[arg(value_enum)]
        answer: Answer,
        /// How you know, for the record.
        #[arg(long, value_name = "TEXT", value_parser = NonEmptyStringValueParser::new())]
        reason: String,
        /// The key that names this answer; a new one where absent.
        #[arg(long, value_name = "KEY", value_parser = NonEmptyStringValueParser::new())]
        key: Option<String>,
    },
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Answer {
    /// The arm is at the target, standing still.
    Happened,
    /// The arm did not move.
    DidNotHappen,
    /// The arm is somewhere else, or nobody knows.
    Abort,
}

pub(crate) async fn run(args: DoubtsArgs, context: &Context) -> Result<Report, Failure> {
    let cell = context.cell().await?;
    let Some(DoubtsCommand::Answer {
        id,
        answer,
        reason,
        key,
    }) = args.command
    else {
        let list = context.client.interventions(&cell).await?;
        return Ok(context.report(Exit::Done, &list, sentences));
    };
    let answer = match answer {
        Answer::Happened => "happened",
        Answer::DidNotHappen => "did_not_happen",
        Answer::Abort => "abort",
    };
    let body = RespondBody {
        answer: answer.to_owned(),
        reason,
        mobile_robot: None,
        place: None,
        custody: None,
    };
    let ask = Ask { key, wait: None };
    let answered = context.client.respond(&cell, id, &body, &ask).await?;
    Ok(context.report(Exit::Done, &answered, |answered| {
        format!("Answered, for good.\n{}", facts(answered))
    }))
}

fn sentences(list: &InterventionList) -> String {
    if list.interventions.is_empty() {
        return "Nothing is in doubt.".to_owned();
    }
    let mut text = String::new();
    for one in &list.interventions {
        text.push_str(&one.question);
        text.push('\n');
        text.push_str(&facts(one));
        for allowed in &one.allowed {
            let answer = allowed.answer.replace('_', "-");
            // Writing to a string cannot fail.
            let _ = writeln!(text, "  {answer}: {}", allowed.consequence);
        }
        text.push('\n');
    }
    text
}

fn facts(one: &Intervention) -> String {
    let facts: Vec<(&str, String)> = [
        ("id", Some(one.id.to_string())),
        ("robot", one.robot.clone()),
        ("state", Some(word(one.state))),
        ("since", Some(one.opened_at.to_string())),
        ("why", one.code.map(word)),
        ("target", one.target.as_ref().map(text::pose)),
        ("controller", one.controller_text.clone()),
        (
            "seen at",
            one.evidence
                .as_ref()
                .map(|evidence| text::pose(&evidence.pose)),
        ),
        (
            "answer",
            one.decision.as_ref().map(|decision| {
                format!(
                    "{} ({}, {})",
                    decision.answer, decision.principal, decision.reason
                )
            }),
        ),
    ]
    .into_iter()
    .filter_map(|(name, fact)| fact.map(|fact| (name, fact)))
    .collect();
    text::facts(&facts)
}
