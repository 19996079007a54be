//! `cellctl emulator`: the virtual controller's own view.

use std::time::Duration;

use api::JointsBody;
use clap::{Args, Subcommand};
use client::{Alarm, EmulatorClient, EmulatorState, LedgerEntry, Log, Notes};
use tokio::time::{Instant, MissedTickBehavior};

use crate::context::Context;
use crate::emulator_control::{self, Control};
use crate::failure::Failure;
use crate::numbers::finite;
use crate::report::{Exit, Report};
use crate::text::{self, Table, word};

/// How often the panel is asked whether the arm stands still.
const POLL: Duration = Duration::from_millis(50);

/// Look at a virtual controller, operate it, and break it on purpose.
///
/// --emulator says which one, by the address of its panel. A demo names the panels in its first lines.
///
/// Examples:
///   cellctl emulator state --wait-still 10
///   cellctl --emulator $PANEL emulator emergency-stop on
///   cellctl emulator emergency-stop off
///   cellctl emulator reset
///   cellctl emulator fault '"freeze"'
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct EmulatorArgs {
    #[command(subcommand)]
    command: EmulatorCommand,
    /// First wait, at most this many seconds, until nothing moves and nothing is about to.
    #[arg(long, global = true, value_name = "SECONDS", allow_hyphen_values = true, value_parser = seconds)]
    wait_still: Option<f64>,
}

#[derive(Debug, Subcommand)]
enum EmulatorCommand {
    /// Show joints, pose, programs and connections.
    State,
    /// List what the arm did.
    Ledger {
        /// Only entries with a higher number than this.
        #[arg(long, value_name = "SEQ")]
        after: Option<u64>,
    },
    /// List the alarms.
    Alarms,
    /// List what a kind controller has said about itself: why a client waits, a number is none, a pose is out of reach.
    Notes {
        /// Only notes with a higher number than this.
        #[arg(long, default_value_t = 0, value_name = "SEQ")]
        after: u64,
        /// If there is none, wait for one, at most so many seconds, up to 30.
        #[arg(long, value_name = "SECONDS", allow_hyphen_values = true, value_parser = short)]
        wait: Option<f64>,
    },
    #[command(flatten)]
    Control(Control),
}

fn seconds(text: &str) -> Result<f64, String> {
    up_to(text, 3600.0)
}

fn short(text: &str) -> Result<f64, String> {
    up_to(text, 30.0)
}

fn up_to(text: &str, most: f64) -> Result<f64, String> {
    let seconds = finite(text)?;
    if (0.0..=most).contains(&seconds) {
        Ok(seconds)
    } else {
        Err(format!("not between 0 and {most} seconds"))
    }
}

pub(crate) async fn run(args: EmulatorArgs, context: &Context) -> Result<Report, Failure> {
    let emulator = context.emulator()?;
    if let Some(seconds) = args.wait_still {
        wait_still(&emulator, seconds).await?;
    }
    match args.command {
        EmulatorCommand::State => {
            let state = emulator.state().await?;
            Ok(context.report(Exit::Done, &state, state_text))
        }
        EmulatorCommand::Ledger { after } => {
            let ledger = emulator.ledger(after).await?;
            Ok(context.report(Exit::Done, &ledger, ledger_text))
        }
        EmulatorCommand::Alarms => {
            let alarms = emulator.alarms().await?;
            Ok(context.report(Exit::Done, &alarms, alarms_text))
        }
        EmulatorCommand::Notes { after, wait } => {
            let wait = wait.map(Duration::from_secs_f64);
            let notes = emulator.notes(after, wait).await?;
            Ok(context.report(Exit::Done, &notes, notes_text))
        }
        EmulatorCommand::Control(control) => {
            emulator_control::run(&control, &emulator, context).await
        }
    }
}

async fn wait_still(emulator: &EmulatorClient, seconds: f64) -> Result<(), Failure> {
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    let mut ticks = tokio::time::interval(POLL);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    loop {
        let _ = ticks.tick().await;
        let state = emulator.state().await?;
        if state.is_still() {
            return Ok(());
        }
        if Instant::now() >= end {
            let last = activity(&state);
            return Err(Failure::NotStill { seconds, last });
        }
    }
}

fn activity(state: &EmulatorState) -> String {
    let moving = if state.moving { "moving" } else { "not moving" };
    let peers: Vec<&str> = state
        .tags
        .iter()
        .filter_map(|tag| tag.peer.as_deref())
        .collect();
    format!(
        "{moving}, {} in the motion queue, connected: {}",
        state.motion_queue,
        if peers.is_empty() {
            "nobody".to_owned()
        } else {
            peers.join(", ")
        }
    )
}

fn state_text(state: &EmulatorState) -> String {
    let mut tasks = Table::new(&["task", "program", "state", ">line", ""]);
    for task in &state.tasks {
        tasks.row([
            task.name.clone(),
            task.program.clone(),
            task.state.clone(),
            number(task.line),
            [&task.detail, &task.hint]
                .map(|text| text.clone().unwrap_or_default())
                .join("  ")
                .trim_end()
                .to_owned(),
        ]);
    }
    let mut tags = Table::new(&["tag", ">port", "state", "peer"]);
    for tag in &state.tags {
        tags.row([
            tag.tag.clone(),
            number(tag.port),
            tag.state.clone(),
            tag.peer.clone().unwrap_or_default(),
        ]);
    }
    let joints: [f64; 6] = state.joints_deg.into();
    let facts = [
        (
            "controller",
            format!("{} ({})", state.controller, state.model),
        ),
        ("on for", format!("{:.3} s", state.time_s)),
        ("joints", text::joints(JointsBody::from(joints))),
        ("pose", text::pose(&state.pose)),
        ("config", state.configuration.clone()),
        ("motion", activity(state)),
        ("operator", operator(state)),
        ("override", format!("{} %", state.override_percent)),
        ("alarms", format!("{} active", state.active_alarms)),
        ("profile", profile(state)),
    ];
    format!("{}\n{tasks}\n{tags}", text::facts(&facts))
}

/// The mode switch, and what keeps the arm from moving.
fn operator(state: &EmulatorState) -> String {
    let servo_off = state.servo_power == Some(false);
    let lamps = [
        (state.held, "held"),
        (state.emergency_stop, "emergency stop"),
        (servo_off, "servo off"),
        (state.faults > 0, "injected faults"),
    ];
    let lit = lamps.iter().filter(|(on, _)| *on).map(|(_, name)| *name);
    let shown: Vec<&str> = std::iter::once(state.mode.as_str()).chain(lit).collect();
    shown.join(", ")
}

/// Which controller it is, and how much it has said.
fn profile(state: &EmulatorState) -> String {
    let generation = match state.generation.as_str() {
        "any" => "any generation".to_owned(),
        generation => format!("generation {generation}"),
    };
    let fidelity = &state.fidelity;
    match state.note_seq {
        0 => format!("{fidelity}, {generation}"),
        1 => format!("{fidelity}, {generation}, 1 note"),
        notes => format!("{fidelity}, {generation}, {notes} notes"),
    }
}

fn notes_text(notes: &Notes) -> String {
    if notes.notes.is_empty() {
        return "No note.".to_owned();
    }
    let mut table = Table::new(&[">seq", ">time s", "program", ">line", ">times", "note"]);
    for note in &notes.notes {
        table.row([
            note.seq.to_string(),
            format!("{:.3}", note.time_s),
            note.program.clone().unwrap_or_default(),
            number(note.line),
            note.times.to_string(),
            note.text.clone(),
        ]);
    }
    table.to_string()
}

fn ledger_text(ledger: &Log<LedgerEntry>) -> String {
    let mut table = Table::new(&[
        ">seq", ">time s", "event", ">motion", "kind", ">mm/s", "target", "request",
    ]);
    for entry in &ledger.entries {
        let target = entry.target_pose.as_ref().map(text::pose);
        let note = entry.alarm.clone().or_else(|| entry.request_id.clone());
        table.row([
            entry.seq.to_string(),
            format!("{:.3}", entry.time_s),
            word(entry.event),
            entry.motion.to_string(),
            entry.kind.clone(),
            entry.speed_mm_s.to_string(),
            target.unwrap_or_default(),
            note.unwrap_or_default(),
        ]);
    }
    with_dropped(&table, ledger.dropped)
}

fn alarms_text(alarms: &Log<Alarm>) -> String {
    if alarms.entries.is_empty() {
        return "No alarm.".to_owned();
    }
    let mut table = Table::new(&[
        ">seq", ">time s", "alarm", "severity", "active", "program", ">line", "text",
    ]);
    for alarm in &alarms.entries {
        table.row([
            alarm.seq.to_string(),
            format!("{:.3}", alarm.time_s),
            format!("{}-{:03}", alarm.facility, alarm.number),
            alarm.severity.clone(),
            if alarm.active { "yes" } else { "no" }.to_owned(),
            alarm.program.clone().unwrap_or_default(),
            number(alarm.line),
            alarm.text.clone(),
        ]);
    }
    with_dropped(&table, alarms.dropped)
}

fn with_dropped(table: &Table, dropped: u64) -> String {
    match dropped {
        0 => table.to_string(),
        count => format!("{table}\n{count} older entries are not kept any more."),
    }
}

fn number<T: ToString>(number: Option<T>) -> String {
    number.map(|number| number.to_string()).unwrap_or_default()
}
