//! `cellctl job`: the group workflows.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use api::{
    CompleteOn, Job, JobBody, JobCommand, JobCommandBody, JobItemBody, JobList, JobParams,
    JobReason, JobReport, JobState, OnCancelWithLoad, StepState, WorkflowName,
};
use clap::builder::NonEmptyStringValueParser;
use clap::{Args, Subcommand};
use client::{Ask, Jobs, Page};
use jiff::{SignedDuration, Timestamp};
use serde::de::DeserializeOwned;
use uuid::Uuid;

use crate::context::Context;
use crate::failure::Failure;
use crate::gantt;
use crate::report::{Exit, Report};
use crate::simulation;
use crate::text::{self, Table, word};

/// Ask for a job of arm and mobile robot together, steer it, see what it took.
///
/// An item is written TYPE:SLOT:PLACE, with the load's id before it where it is known: LOAD=TYPE:SLOT:PLACE. SLOT is
/// the mobile robot's, PLACE the fixed one. A job is named by its number in the cell, or by its id.
///
/// Examples:
///   cellctl job delivery --point handover/front --item load-1=crate:left:rack/d
///   cellctl job pickup --point handover/front --item crate:left:rack/a --destination warehouse/gate
///   cellctl job simulate delivery --point handover/front --item load-1=crate:left:rack/d --plot phases.svg
///   cellctl job list --state HELD
///   cellctl job hold 12 --reason "a visitor in the aisle"
///   cellctl job report 12 --plot phases.svg
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct JobArgs {
    #[command(subcommand)]
    command: JobWhat,
}

#[derive(Debug, Subcommand)]
enum JobWhat {
    #[command(flatten)]
    New(NewJob),
    /// Play a job in virtual time: what would become of it, and how long it would take. Nothing real moves.
    Simulate {
        #[command(subcommand)]
        new: NewJob,
        /// Draw the phases over simulated time into this file.
        #[arg(long, value_name = "FILE.svg", global = true)]
        plot: Option<PathBuf>,
    },
    /// List the jobs, the newest first.
    List {
        /// Only jobs in this state, e.g. HELD; may be given several times.
        #[arg(long, value_name = "STATE", value_parser = of_word::<JobState>)]
        state: Vec<JobState>,
        /// At most this many.
        #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u32).range(1..))]
        limit: Option<u32>,
        /// Where the page before said to go on.
        #[arg(long, value_name = "CURSOR")]
        cursor: Option<String>,
    },
    /// Show a job: state, phase, steps, what it waits for.
    Show {
        /// The job: its number, or its id.
        #[arg(value_name = "JOB")]
        id: JobRef,
    },
    /// Hold a job where it is safe.
    Hold(SteerArgs),
    /// Let a held job go on.
    Unhold(SteerArgs),
    /// Stop a job, and undo what can be undone.
    Stop(SteerArgs),
    /// Stop the arm at once and leave everything as it is.
    Abort(SteerArgs),
    /// Any command: retry-step, skip-step, complete-manually, compensate, clear, reset, ...
    Command {
        /// Which.
        #[arg(value_parser = of_word::<JobCommand>)]
        command: JobCommand,
        #[command(flatten)]
        steer: SteerArgs,
    },
    /// Tell what happened to a job.
    Events {
        /// The job: its number, or its id.
        #[arg(value_name = "JOB")]
        id: JobRef,
    },
    /// Report what a job took: phases, attempts, faults, decisions.
    Report {
        /// The job: its number, or its id.
        #[arg(value_name = "JOB")]
        id: JobRef,
        /// Draw the phases over time into this file.
        #[arg(long, value_name = "FILE.svg")]
        plot: Option<PathBuf>,
    },
}

/// A job of one of the workflows.
#[derive(Debug, Subcommand)]
enum NewJob {
    /// A mobile robot brings loads, an arm unloads and places them.
    Delivery {
        #[command(flatten)]
        new: NewArgs,
        /// Let the mobile robot go as soon as the last load was lifted.
        #[arg(long)]
        early_release: bool,
        /// Other places that do as well, for every item.
        #[arg(long, value_name = "PLACE")]
        alternate: Vec<String>,
    },
    /// An arm loads a mobile robot, which takes the loads away.
    Pickup {
        #[command(flatten)]
        new: NewArgs,
        /// Pick the first load while the mobile robot is on its way.
        #[arg(long)]
        prefetch: bool,
        /// Where the mobile robot takes the loads.
        #[arg(long, value_name = "ID")]
        destination: Option<String>,
        /// The job is complete when the loads are delivered, and not already when the mobile robot has left.
        #[arg(long, requires = "destination")]
        until_delivered: bool,
    },
}

#[derive(Args, Debug)]
struct NewArgs {
    /// Where the mobile robot docks: station/point.
    #[arg(long, value_name = "POINT")]
    point: String,
    /// What to move, in this order: [LOAD=]TYPE:SLOT:PLACE.
    #[arg(long, value_name = "ITEM", required = true, value_parser = item)]
    item: Vec<JobItemBody>,
    /// The mobile robot; any that is free where absent.
    #[arg(long, value_name = "ID")]
    mobile_robot: Option<String>,
    /// The arm; any that was taught the places where absent.
    #[arg(long, value_name = "ID")]
    arm: Option<String>,
    /// What to do with a load in the gripper if the job is canceled: COMPLETE, `RETURN_TO_MR`, `REJECT_BIN`, HOLD.
    #[arg(long, value_name = "WHAT", default_value = "HOLD", value_parser = of_word::<OnCancelWithLoad>)]
    on_cancel_with_load: OnCancelWithLoad,
    /// The place for loads that are rejected.
    #[arg(long, value_name = "PLACE")]
    reject_slot: Option<String>,
    /// How often a grip is tried.
    #[arg(long, value_name = "COUNT", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=10))]
    max_attempts: u8,
    /// Higher first.
    #[arg(
        long,
        value_name = "NUMBER",
        default_value_t = 0,
        allow_negative_numbers = true
    )]
    priority: i32,
    /// The job is dropped if it has not started after this many seconds.
    #[arg(long, value_name = "SECONDS", value_parser = clap::value_parser!(u32).range(1..))]
    start_within: Option<u32>,
    /// The key that names this request; a new one where absent.
    #[arg(long, value_name = "KEY", value_parser = NonEmptyStringValueParser::new())]
    key: Option<String>,
}

#[derive(Args, Debug)]
struct SteerArgs {
    /// The job: its number, or its id.
    #[arg(value_name = "JOB")]
    id: JobRef,
    /// Why, for the record.
    #[arg(long, value_name = "TEXT", value_parser = NonEmptyStringValueParser::new())]
    reason: String,
    /// The key that names this command; a new one where absent.
    #[arg(long, value_name = "KEY", value_parser = NonEmptyStringValueParser::new())]
    key: Option<String>,
}

/// A job as people name it.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum JobRef {
    /// By its number in the cell.
    Number(u64),
    Id(Uuid),
}

impl FromStr for JobRef {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let number = text.parse().ok().filter(|number| *number > 0);
        number
            .map(Self::Number)
            .or_else(|| text.parse().ok().map(Self::Id))
            .ok_or_else(|| {
                "it is neither a job's number nor its id; `cellctl job list` shows both".to_owned()
            })
    }
}

impl JobRef {
    /// The id of the job that is meant.
    ///
    /// # Errors
    /// The server cannot be asked, or has no job of this number.
    pub(crate) async fn id(self, jobs: &Jobs) -> Result<Uuid, Failure> {
        let number = match self {
            Self::Id(id) => return Ok(id),
            Self::Number(number) => number,
        };
        // The list goes down from the number that its cursor names.
        let page = Page {
            limit: Some(1),
            cursor: Some(number.saturating_add(1).to_string()),
        };
        let found = jobs.list(&[], &page).await?.jobs.into_iter().next();
        found
            .filter(|job| job.number == number)
            .map(|job| job.id)
            .ok_or(Failure::NoJob { number })
    }
}

/// An enum of the API by its word, in capitals or not.
fn of_word<T: DeserializeOwned>(text: &str) -> Result<T, String> {
    let read = |text: String| serde_json::from_value(serde_json::Value::String(text));
    read(text.to_owned())
        .or_else(|error| read(text.to_uppercase().replace('-', "_")).map_err(|_| error))
        .map_err(|error: serde_json::Error| error.to_string())
}

fn item(text: &str) -> Result<JobItemBody, String> {
    let (load_id, rest) = match text.split_once('=') {
        Some((load, rest)) => (Some(load.to_owned()), rest),
        None => (None, text),
    };
    let parts: Vec<_> = rest.split(':').collect();
    match parts.as_slice() {
        [load_type, mr_slot, place] if parts.iter().all(|part| !part.is_empty()) => {
            Ok(JobItemBody {
                load_id,
                load_type: (*load_type).to_owned(),
                mr_slot: (*mr_slot).to_owned(),
                place: (*place).to_owned(),
                alternates: Vec::new(),
            })
        }
        _ => Err("it is not [LOAD=]TYPE:SLOT:PLACE".to_owned()),
    }
}

pub(crate) async fn run(args: JobArgs, context: &Context) -> Result<Report, Failure> {
    let jobs = context.client.jobs(&context.cell().await?);
    match args.command {
        JobWhat::New(new) => {
            let (body, ask) = new.body();
            create(&jobs, &body, &ask, context).await
        }
        JobWhat::Simulate { new, plot } => {
            let (body, _key) = new.body();
            let simulation = jobs.simulate(&body).await?;
            if let Some(file) = &plot {
                draw(file, &gantt::svg_of_simulation(&simulation))?;
            }
            Ok(context.report(Exit::Done, &simulation, |simulation| {
                drawn(simulation::sentences(simulation), plot.as_deref())
            }))
        }
        JobWhat::List {
            state,
            limit,
            cursor,
        } => {
            let list = jobs.list(&state, &Page { limit, cursor }).await?;
            Ok(context.report(Exit::Done, &list, |list| table(list, &state, limit)))
        }
        JobWhat::Show { id } => {
            let job = jobs.get(id.id(&jobs).await?).await?;
            Ok(context.report(Exit::Done, &job, sentences))
        }
        JobWhat::Hold(to) => steer(&jobs, JobCommand::Hold, to, context).await,
        JobWhat::Unhold(to) => steer(&jobs, JobCommand::Unhold, to, context).await,
        JobWhat::Stop(to) => steer(&jobs, JobCommand::Stop, to, context).await,
        JobWhat::Abort(to) => steer(&jobs, JobCommand::Abort, to, context).await,
        JobWhat::Command { command, steer: to } => steer(&jobs, command, to, context).await,
        JobWhat::Events { id } => {
            let id = id.id(&jobs).await?;
            events(&jobs, id, context).await
        }
        JobWhat::Report { id, plot } => {
            let report = jobs.report(id.id(&jobs).await?).await?;
            if let Some(file) = &plot {
                draw(file, &gantt::svg(&report))?;
            }
            Ok(context.report(Exit::Done, &report, |report| {
                drawn(figures(report), plot.as_deref())
            }))
        }
    }
}

fn draw(file: &Path, svg: &str) -> Result<(), Failure> {
    std::fs::write(file, svg)
        .map_err(|error| Failure::Usage(format!("{} cannot be written: {error}", file.display())))
}

fn drawn(mut text: String, plot: Option<&Path>) -> String {
    if let Some(file) = plot {
        let _string = writeln!(text, "\nDrawn into {}", file.display());
    }
    text
}

impl NewJob {
    fn body(self) -> (JobBody, Ask) {
        match self {
            Self::Delivery {
                new,
                early_release,
                alternate,
            } => {
                let (mut body, ask) = body(new, WorkflowName::DeliveryAndPlacement);
                body.params.early_release = early_release;
                for item in &mut body.params.items {
                    item.alternates.clone_from(&alternate);
                }
                (body, ask)
            }
            Self::Pickup {
                new,
                prefetch,
                destination,
                until_delivered,
            } => {
                let (mut body, ask) = body(new, WorkflowName::PickupAndDelivery);
                body.params.prefetch = prefetch;
                body.params.destination = destination;
                if until_delivered {
                    body.params.complete_on = CompleteOn::Delivered;
                }
                (body, ask)
            }
        }
    }
}

fn body(new: NewArgs, workflow: WorkflowName) -> (JobBody, Ask) {
    let deadline = new
        .start_within
        .map(|seconds| Timestamp::now() + SignedDuration::from_secs(i64::from(seconds)));
    let body = JobBody {
        workflow,
        params: JobParams {
            mobile_robot: new.mobile_robot,
            arm: new.arm,
            point: new.point,
            items: new.item,
            early_release: false,
            prefetch: false,
            on_cancel_with_load: new.on_cancel_with_load,
            reject_slot: new.reject_slot,
            max_attempts: new.max_attempts,
            destination: None,
            complete_on: CompleteOn::Departed,
            expected_arrival_s: None,
            expected_transport_s: None,
        },
        priority: new.priority,
        deadline,
    };
    let ask = Ask {
        key: new.key,
        wait: None,
    };
    (body, ask)
}

async fn create(
    jobs: &Jobs,
    body: &JobBody,
    ask: &Ask,
    context: &Context,
) -> Result<Report, Failure> {
    let job = jobs.create(body, ask).await?;
    Ok(context.report(Exit::Done, &job, |job| {
        format!(
            "Job {} is {}.\n{}",
            job.number,
            word(job.state),
            sentences(job)
        )
    }))
}

async fn steer(
    jobs: &Jobs,
    command: JobCommand,
    to: SteerArgs,
    context: &Context,
) -> Result<Report, Failure> {
    let body = JobCommandBody {
        command,
        reason: to.reason,
    };
    let ask = Ask {
        key: to.key,
        wait: None,
    };
    let job = jobs.command(to.id.id(jobs).await?, &body, &ask).await?;
    Ok(context.report(Exit::Done, &job, |job| {
        format!(
            "Job {}: {} was taken; it is {}.\n{}",
            job.number,
            word(command),
            word(job.state),
            sentences(job)
        )
    }))
}

/// All of them: a job has some hundreds at most.
async fn events(jobs: &Jobs, id: Uuid, context: &Context) -> Result<Report, Failure> {
    let mut page = Page {
        limit: Some(200),
        cursor: None,
    };
    let mut all = jobs.events(id, &page).await?;
    while let Some(next) = all.next_cursor.take() {
        page.cursor = Some(next);
        let more = jobs.events(id, &page).await?;
        all.events.extend(more.events);
        all.next_cursor = more.next_cursor;
    }
    Ok(context.report(Exit::Done, &all, |all| {
        let mut table = Table::new(&[">s", "step", "what"]);
        for event in &all.events {
            table.row([
                seconds(event.since_ms),
                event.code.clone().unwrap_or_default(),
                event.text.clone(),
            ]);
        }
        table.to_string()
    }))
}

fn table(list: &JobList, states: &[JobState], limit: Option<u32>) -> String {
    if list.jobs.is_empty() {
        return "No job.".to_owned();
    }
    let mut table = Table::new(&[
        ">no",
        "job",
        "workflow",
        "state",
        "phase",
        ">steps",
        "mobile robot",
        "why",
    ]);
    for job in &list.jobs {
        let asks = if job.intervention.is_some() {
            "asks a person; "
        } else {
            ""
        };
        table.row([
            job.number.to_string(),
            job.id.to_string(),
            word(job.workflow),
            word(job.state),
            phase(job.code.as_deref(), job.phase.as_deref()),
            format!("{}/{}", job.steps_done, job.steps),
            job.mobile_robot.clone().unwrap_or_default(),
            match job.queue_position {
                Some(place) if job.text.is_empty() => format!("number {place} in the queue"),
                Some(place) => format!("number {place} in the queue: {}", job.text),
                None => format!("{asks}{}", job.text),
            },
        ]);
    }
    match &list.next_cursor {
        Some(cursor) => {
            let states = states
                .iter()
                .map(|state| format!(" --state {}", word(*state)));
            let limit = limit.map(|limit| format!(" --limit {limit}"));
            let asked = states.chain(limit).collect::<String>();
            format!("{table}\nMore: cellctl job list{asked} --cursor {cursor}")
        }
        None => table.to_string(),
    }
}

fn phase(code: Option<&str>, phase: Option<&str>) -> String {
    match (code, phase) {
        (Some(code), Some(phase)) => format!("{code} {}", phase.to_lowercase().replace('_', " ")),
        _ => String::new(),
    }
}

fn sentences(job: &Job) -> String {
    let mut facts = vec![
        ("job", job.id.to_string()),
        (
            "workflow",
            format!("{} at {}", word(job.workflow), job.params.point),
        ),
        (
            "state",
            if job.reason == JobReason::Course {
                word(job.state)
            } else {
                format!("{} ({})", word(job.state), word(job.reason))
            },
        ),
    ];
    let mut more = |name, value: Option<String>| {
        if let Some(value) = value.filter(|value| !value.is_empty()) {
            facts.push((name, value));
        }
    };
    more("why", Some(job.text.clone()));
    let fault = job.fault.as_ref();
    more(
        "fault",
        fault.map(|fault| format!("{} {}", fault.code, fault.name)),
    );
    more("by", job.principal.clone());
    more(
        "phase",
        Some(phase(job.code.as_deref(), job.phase.as_deref())),
    );
    more(
        "queue",
        job.queue_position.map(|place| format!("number {place}")),
    );
    more("arm", job.arm.clone());
    more("mobile robot", job.mobile_robot.clone());
    more("deadline", job.deadline.map(|at| at.to_string()));
    more(
        "asks",
        job.intervention
            .map(|id| format!("cellctl interventions answer {id} ...")),
    );
    let commands: Vec<_> = job.commands.iter().map(|command| word(*command)).collect();
    more("may be told", Some(commands.join(", ")));
    let mut text = text::facts(&facts);
    if !job.steps.is_empty() {
        text.push_str(&steps(job));
    }
    for timer in &job.timers {
        let _string = writeln!(
            text,
            "  waits: {} {} s left of {}",
            timer.timer,
            seconds(timer.left_ms),
            seconds(timer.total_ms)
        );
    }
    text
}

fn steps(job: &Job) -> String {
    let mut table = Table::new(&["step", "", "where", "state", ">try", ">s left", "now"]);
    let needed = |state| state != StepState::Dropped;
    for step in job.steps.iter().filter(|step| needed(step.state)) {
        let operation = step.operation.as_ref();
        table.row([
            step.code.clone(),
            step.phase.to_lowercase().replace('_', " "),
            step.place.clone().unwrap_or_default(),
            word(step.state),
            step.attempt.to_string(),
            step.left_ms.map(seconds).unwrap_or_default(),
            operation.map_or_else(String::new, |operation| operation.action.clone()),
        ]);
    }
    table.to_string()
}

/// Milliseconds as seconds.
pub(crate) fn seconds(ms: u64) -> String {
    format!("{}.{:01}", ms / 1_000, ms % 1_000 / 100)
}

/// The phases as a table; nothing where there are none.
pub(crate) fn phases(report: &JobReport) -> String {
    if report.phases.is_empty() {
        return String::new();
    }
    let mut table = Table::new(&["phase", "", "where", ">from s", ">took s", ">tries", "end"]);
    for phase in &report.phases {
        table.row([
            phase.code.clone(),
            phase.phase.to_lowercase().replace('_', " "),
            phase.place.clone().unwrap_or_default(),
            seconds(phase.begin_ms),
            seconds(phase.duration_ms),
            phase.attempts.len().to_string(),
            phase.end.clone().unwrap_or_else(|| "runs".to_owned()),
        ]);
    }
    table.to_string()
}

fn figures(report: &JobReport) -> String {
    let mut text = text::facts(&[
        ("job", report.job.to_string()),
        ("workflow", word(report.workflow)),
        ("state", word(report.state)),
        ("begun", text::whole_seconds(report.begun_at)),
        ("total", format!("{} s", seconds(report.total_ms))),
        ("in the queue", format!("{} s", seconds(report.queued_ms))),
        ("cycle time", format!("{} s", seconds(report.cycle_ms))),
        ("restarts", report.restarts.to_string()),
    ]);
    text.push_str(&phases(report));
    for fault in &report.faults {
        let _string = writeln!(
            text,
            "  at {} s: {} {}: {}",
            seconds(fault.at_ms),
            fault.fault.code,
            fault.fault.name,
            fault.text
        );
    }
    for decision in &report.decisions {
        let _string = writeln!(
            text,
            "  at {} s: {} by {}: {}",
            seconds(decision.at_ms),
            decision.decision,
            decision.principal,
            decision.reason
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_item_is_a_type_a_slot_and_a_place() {
        let named = item("load-1=crate:left:rack/d").unwrap();
        assert_eq!(named.load_id.as_deref(), Some("load-1"));
        assert_eq!(
            (&*named.load_type, &*named.mr_slot, &*named.place),
            ("crate", "left", "rack/d")
        );
        assert_eq!(item("crate:left:rack/d").unwrap().load_id, None);
        for wrong in ["", "crate", "crate:left", "crate::rack/d", "a:b:c:d"] {
            assert!(item(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_word_of_the_api_is_taken_and_no_other() {
        assert_eq!(
            of_word::<JobCommand>("retry-step"),
            Ok(JobCommand::RetryStep)
        );
        assert_eq!(of_word::<JobState>("HELD"), Ok(JobState::Held));
        assert_eq!(of_word::<JobState>("held"), Ok(JobState::Held));
        assert!(of_word::<JobState>("hold").is_err());
    }

    #[test]
    fn a_job_is_named_by_its_number_or_its_id() {
        assert_eq!("12".parse(), Ok(JobRef::Number(12)));
        let id = Uuid::from_u128(7);
        assert_eq!(id.to_string().parse(), Ok(JobRef::Id(id)));
        for wrong in ["", "0", "-1", "1.5", "019302d4"] {
            let error = wrong.parse::<JobRef>().unwrap_err();
            assert!(error.contains("cellctl job list"), "{wrong}: {error}");
        }
    }

    #[test]
    fn seconds_have_one_decimal() {
        assert_eq!(seconds(0), "0.0");
        assert_eq!(seconds(12_349), "12.3");
    }
}
