//! `cellctl interventions`: what only a person can decide, whatever asks.

use std::fmt::Write as _;

use api::{AnswerNeeds, CustodyAnswer, Intervention, InterventionList, LoadLocation, RespondBody};
use clap::builder::NonEmptyStringValueParser;
use clap::{Args, Subcommand};
use client::Ask;
use uuid::Uuid;

use crate::context::Context;
use crate::failure::Failure;
use crate::loads::Whereabouts;
use crate::report::{Exit, Report};
use crate::text::{self, word};

/// List what waits for a person, or answer it, once and for good.
///
/// Examples:
///   cellctl interventions
///   cellctl interventions answer 019302d4-7b3f-7c7e-8f3a-2f6f1b0c9d11 retry --reason "the crate was turned"
///   cellctl interventions answer 019302d4-7b3f-7c7e-8f3a-2f6f1b0c9d11 choose-slot --place rack/b --reason "rack/a is full"
///   cellctl interventions answer 019302d4-7b3f-7c7e-8f3a-2f6f1b0c9d11 set-custody --confirm load-1 --on mr1:left --reason "seen"
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct InterventionsArgs {
    #[command(subcommand)]
    command: Option<InterventionsCommand>,
}

#[derive(Debug, Subcommand)]
enum InterventionsCommand {
    /// List what waits for a person.
    List,
    /// Answer one, once and for good.
    Answer(Box<AnswerArgs>),
}

#[derive(Args, Debug)]
struct AnswerArgs {
    /// Its id.
    id: Uuid,
    /// One of the answers that are allowed.
    answer: String,
    /// Why, or what you saw, for the record.
    #[arg(long, value_name = "TEXT", value_parser = NonEmptyStringValueParser::new())]
    reason: String,
    /// The mobile robot, for answers that need one.
    #[arg(long, value_name = "ID")]
    mobile_robot: Option<String>,
    /// The load's id, for the answer that says where it is.
    #[arg(long, value_name = "LOAD", requires = "where")]
    confirm: Option<String>,
    #[command(flatten)]
    at: Whereabouts,
    /// The key that names this answer; a new one where absent.
    #[arg(long, value_name = "KEY", value_parser = NonEmptyStringValueParser::new())]
    key: Option<String>,
}

pub(crate) async fn run(args: InterventionsArgs, context: &Context) -> Result<Report, Failure> {
    let cell = context.cell().await?;
    let Some(InterventionsCommand::Answer(args)) = args.command else {
        // Named or not, it is the list.
        let list = context.client.interventions(&cell).await?;
        return Ok(context.report(Exit::Done, &list, sentences));
    };
    let (place, custody) = match (args.at.location(), args.confirm) {
        (Some(location), Some(confirm)) => (None, Some(CustodyAnswer { confirm, location })),
        (Some(LoadLocation::Fixed { place }), None) => (Some(place), None),
        (Some(_), None) => {
            let why = "--gripper, --on and --delivered say where a load is: name it with --confirm";
            return Err(Failure::Usage(why.to_owned()));
        }
        (None, _) => (None, None),
    };
    let body = RespondBody {
        answer: args.answer.replace('-', "_"),
        reason: args.reason,
        mobile_robot: args.mobile_robot,
        place,
        custody,
    };
    let ask = Ask {
        key: args.key,
        wait: None,
    };
    let answered = context.client.respond(&cell, args.id, &body, &ask).await?;
    Ok(context.report(Exit::Done, &answered, |answered| {
        format!("Answered, for good.\n{}", facts(answered))
    }))
}

fn sentences(list: &InterventionList) -> String {
    if list.interventions.is_empty() {
        return "Nothing waits for a person.".to_owned();
    }
    let mut text = String::new();
    for one in &list.interventions {
        text.push_str(&one.question);
        text.push('\n');
        text.push_str(&facts(one));
        for known in &one.known {
            // Writing to a string cannot fail.
            let _ = writeln!(text, "  known: {known}");
        }
        for unknown in &one.unknown {
            let _ = writeln!(text, "  not known: {unknown}");
        }
        for allowed in &one.allowed {
            let answer = allowed.answer.replace('_', "-");
            let needs = match allowed.needs {
                Some(AnswerNeeds::MobileRobot) => " --mobile-robot ID",
                Some(AnswerNeeds::Place) => " --place PLACE",
                Some(AnswerNeeds::Custody) => {
                    " --confirm LOAD and --place PLACE, --on ROBOT:SLOT, --gripper ARM or --delivered ID"
                }
                None => "",
            };
            let role = allowed
                .role
                .map_or_else(String::new, |role| format!(" ({role} only)"));
            let _ = writeln!(text, "  {answer}{needs}: {}{role}", allowed.consequence);
        }
        if let Some(first) = one.allowed.first() {
            let (id, answer) = (one.id, first.answer.replace('_', "-"));
            let _ = writeln!(
                text,
                "  say: cellctl interventions answer {id} {answer} --reason \"...\""
            );
        }
        text.push('\n');
    }
    text
}

fn facts(one: &Intervention) -> String {
    let fault = one.fault.as_ref();
    let decision = one.decision.as_ref();
    let facts: Vec<(&str, String)> = [
        ("id", Some(one.id.to_string())),
        ("robot", one.robot.clone()),
        ("job", one.job.map(|job| job.to_string())),
        ("session", one.session.map(|session| session.to_string())),
        ("load", one.load.clone()),
        ("state", Some(word(one.state))),
        ("since", Some(one.opened_at.to_string())),
        (
            "fault",
            fault.map(|fault| format!("{} {}", fault.code, fault.name)),
        ),
        ("why", one.code.map(word)),
        ("target", one.target.as_ref().map(text::pose)),
        ("controller", one.controller_text.clone()),
        (
            "seen at",
            one.evidence.as_ref().map(|seen| text::pose(&seen.pose)),
        ),
        ("withdrawn", one.withdrawn.clone()),
        (
            "answer",
            decision.map(|it| format!("{} ({}, {})", it.answer, it.principal, it.reason)),
        ),
    ]
    .into_iter()
    .filter_map(|(name, fact)| fact.map(|fact| (name, fact)))
    .collect();
    text::facts(&facts)
}
