//! `cellctl loads` and `cellctl sessions`: where the loads are, and who may be where.

use api::{CustodyBody, LoadDetail, LoadList, LoadLocation, SessionList};
use clap::builder::NonEmptyStringValueParser;
use clap::{Args, Subcommand};

use crate::context::Context;
use crate::failure::Failure;
use crate::job::seconds;
use crate::report::{Exit, Report};
use crate::text::{self, Table, word};

/// List where every load is, show how one came there, or say where it is.
///
/// Examples:
///   cellctl loads
///   cellctl loads show load-1
///   cellctl loads set load-1 --confirm load-1 --place rack/a --reason "it stands there"
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct LoadsArgs {
    #[command(subcommand)]
    command: Option<LoadsCommand>,
}

#[derive(Debug, Subcommand)]
enum LoadsCommand {
    /// List where every load is.
    List,
    /// Show a load and how it came to where it is.
    Show {
        /// The load's id.
        id: String,
    },
    /// Say where a load is, after you have looked.
    Set(SetArgs),
}

#[derive(Args, Debug)]
struct SetArgs {
    /// The load's id.
    id: String,
    /// The load's id once more.
    #[arg(long, value_name = "ID", requires = "where")]
    confirm: String,
    #[command(flatten)]
    at: Whereabouts,
    /// How you know, for the record.
    #[arg(long, value_name = "TEXT", value_parser = NonEmptyStringValueParser::new())]
    reason: String,
}

/// Where a load is, as a person says it.
#[derive(Args, Debug)]
#[group(id = "where", multiple = false)]
pub(crate) struct Whereabouts {
    /// At this fixed place.
    #[arg(long, value_name = "PLACE")]
    place: Option<String>,
    /// In the gripper of this arm.
    #[arg(long, value_name = "ARM")]
    gripper: Option<String>,
    /// On a mobile robot: ROBOT:SLOT.
    #[arg(long, value_name = "ROBOT:SLOT", value_parser = on)]
    on: Option<(String, String)>,
    /// Delivered to this destination.
    #[arg(long, value_name = "ID")]
    delivered: Option<String>,
}

fn on(text: &str) -> Result<(String, String), String> {
    match text.split_once(':') {
        Some((robot, slot)) if !robot.is_empty() && !slot.is_empty() => {
            Ok((robot.to_owned(), slot.to_owned()))
        }
        _ => Err("it is not ROBOT:SLOT".to_owned()),
    }
}

impl Whereabouts {
    pub(crate) fn location(&self) -> Option<LoadLocation> {
        match (&self.place, &self.gripper, &self.on, &self.delivered) {
            (Some(place), _, _, _) => Some(LoadLocation::Fixed {
                place: place.clone(),
            }),
            (_, Some(arm), _, _) => Some(LoadLocation::Gripper { arm: arm.clone() }),
            (_, _, Some((mobile_robot, slot)), _) => Some(LoadLocation::MobileRobot {
                mobile_robot: mobile_robot.clone(),
                slot: slot.clone(),
            }),
            (_, _, _, Some(destination)) => Some(LoadLocation::Delivered {
                destination: destination.clone(),
            }),
            (None, None, None, None) => None,
        }
    }
}

pub(crate) async fn run(args: LoadsArgs, context: &Context) -> Result<Report, Failure> {
    let jobs = context.client.jobs(&context.cell().await?);
    match args.command {
        None | Some(LoadsCommand::List) => {
            Ok(context.report(Exit::Done, &jobs.loads().await?, table))
        }
        Some(LoadsCommand::Show { id }) => {
            Ok(context.report(Exit::Done, &jobs.load(&id).await?, detail))
        }
        Some(LoadsCommand::Set(set)) => {
            let location = set.at.location().ok_or_else(|| {
                Failure::Usage("say where it is: --place, --gripper, --on or --delivered".into())
            })?;
            let body = CustodyBody {
                location,
                confirm: set.confirm,
                reason: set.reason,
            };
            let load = jobs.set_custody(&set.id, &body).await?;
            Ok(context.report(Exit::Done, &load, |load| {
                format!("{} is booked {}.\n", load.id, place_of(&load.location))
            }))
        }
    }
}

/// Where a load is, in words.
fn place_of(location: &LoadLocation) -> String {
    match location {
        LoadLocation::Fixed { place } => format!("at {place}"),
        LoadLocation::Gripper { arm } => format!("in the gripper of {arm}"),
        LoadLocation::MobileRobot { mobile_robot, slot } => format!("in {slot} of {mobile_robot}"),
        LoadLocation::Delivered { destination } => format!("delivered to {destination}"),
        LoadLocation::Unknown { arm: Some(arm) } => format!("UNKNOWN, {arm} had it"),
        LoadLocation::Unknown { arm: None } => "UNKNOWN".to_owned(),
    }
}

fn table(list: &LoadList) -> String {
    if list.loads.is_empty() {
        return "No load.".to_owned();
    }
    let mut table = Table::new(&["load", "type", "where", "job"]);
    for load in &list.loads {
        table.row([
            load.id.clone(),
            load.load_type.clone(),
            place_of(&load.location),
            load.job.map(|job| job.to_string()).unwrap_or_default(),
        ]);
    }
    table.to_string()
}

fn detail(detail: &LoadDetail) -> String {
    let load = &detail.load;
    let mut text = text::facts(&[
        ("load", load.id.clone()),
        ("type", load.load_type.clone()),
        ("where", place_of(&load.location)),
    ]);
    let mut table = Table::new(&["when", "came", "known by", "because"]);
    for event in &detail.history {
        table.row([
            format!("{:.0}", event.at),
            place_of(&event.to),
            match &event.principal {
                Some(principal) => principal.clone(),
                None => word(event.evidence),
            },
            event.text.clone(),
        ]);
    }
    text.push_str(&table.to_string());
    text
}

/// `cellctl sessions`.
pub(crate) async fn sessions(context: &Context) -> Result<Report, Failure> {
    let jobs = context.client.jobs(&context.cell().await?);
    Ok(context.report(Exit::Done, &jobs.sessions().await?, session_table))
}

fn session_table(list: &SessionList) -> String {
    if list.sessions.is_empty() {
        return "No hand-over session.".to_owned();
    }
    let mut table = Table::new(&[
        "point",
        "mobile robot",
        "state",
        "permit",
        "waits",
        "session",
    ]);
    for session in &list.sessions {
        let permit = match (session.arm_entry_permit, session.mr_move_permit) {
            (true, _) => "the arm may enter",
            (false, true) => "the mobile robot may move",
            (false, false) => "nobody",
        };
        let waits: Vec<_> = session
            .timers
            .iter()
            .map(|timer| format!("{} {} s", timer.timer, seconds(timer.left_ms)))
            .collect();
        let state = match &session.fault {
            Some(fault) => format!("{} ({} {})", word(session.state), fault.code, fault.name),
            None => word(session.state),
        };
        table.row([
            session.point.clone(),
            session.mobile_robot.clone(),
            state,
            permit.to_owned(),
            waits.join(", "),
            session.id.to_string(),
        ]);
    }
    table.to_string()
}
