//! `cellctl cell`: the operator's set-up of a cell.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use api::setup::{
    CheckFinding, SetupCheck, SetupFile, SetupRevision, Severity, TaughtPoseCheck, TriggerBody,
    ZoneMargin,
};
use clap::{Args, Subcommand, ValueEnum};
use client::{SetupForm, SetupText, Tagged};
use serde::Serialize;

use crate::context::Context;
use crate::failure::Failure;
use crate::report::{Exit, Report};
use crate::text::{Table, facts, word};

/// The set-up of a cell: export it, check it, import it.
///
/// The set-up is one file (TOML or JSON): tools, zones, stations, places, taught poses, mobile robots, routes, loads,
/// triggers.
///
/// Examples:
///   cellctl cell show
///   cellctl cell export --output cell.setup.toml
///   cellctl cell check cell.setup.toml
///   cellctl cell import cell.setup.toml
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct CellArgs {
    #[command(subcommand)]
    command: CellCommand,
}

#[derive(Debug, Subcommand)]
enum CellCommand {
    /// Show what is set up, in a few lines.
    Show,
    /// Write the set-up to the standard output, or to a file.
    Export {
        /// The form; by the name of the output file where absent, else TOML.
        #[arg(long, value_enum, value_name = "FORM")]
        format: Option<FormWord>,
        /// A file to write, instead of the standard output.
        #[arg(long, short, value_name = "FILE")]
        output: Option<PathBuf>,
    },
    /// Put a set-up in the place of the one that holds: all of it, or nothing.
    Import {
        /// The file; JSON where it ends with .json, else TOML.
        file: PathBuf,
        /// Only if the set-up still has this entity tag, as `export` told it.
        #[arg(long, value_name = "ETAG")]
        if_match: Option<String>,
    },
    /// Plan every taught pose, and say how much room there is. Nothing moves, nothing is imported.
    ///
    /// Exit code 0 if all is well, 1 if something would not work.
    Check {
        /// The file; the set-up that holds where absent.
        file: Option<PathBuf>,
    },
}

/// The form of a set-up.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum FormWord {
    Toml,
    Json,
}

/// What became of an export to a file, for machines.
#[derive(Debug, Serialize)]
struct Exported {
    file: String,
    etag: String,
}

pub(crate) async fn run(args: CellArgs, context: &Context) -> Result<Report, Failure> {
    let setup = context.client.setup(&context.cell().await?);
    match args.command {
        CellCommand::Show => {
            let shown = setup.get().await?;
            Ok(context.report(Exit::Done, &shown.value, |file| {
                summary(setup.cell(), file, &shown.etag)
            }))
        }
        CellCommand::Export { format, output } => {
            let form = match (format, &output) {
                (Some(FormWord::Json), _) => SetupForm::Json,
                (None, Some(path)) => form_of(path),
                (Some(FormWord::Toml), _) | (None, None) => SetupForm::Toml,
            };
            let Tagged { etag, value: text } = setup.export(form).await?;
            let Some(output) = output else {
                return Ok(Report::text(Exit::Done, &text));
            };
            let file = output.display().to_string();
            std::fs::write(&output, text)
                .map_err(|error| Failure::Usage(format!("writing {file}: {error}")))?;
            let exported = Exported { file, etag };
            Ok(context.report(Exit::Done, &exported, |exported| {
                let Exported { file, etag } = exported;
                format!("Wrote {file}, entity tag {etag}")
            }))
        }
        CellCommand::Import { file, if_match } => {
            let text = read(&file)?;
            let etag = match if_match {
                Some(etag) => etag,
                None => setup.get().await?.etag,
            };
            let revision = setup.import(text, &etag).await?;
            Ok(context.report(Exit::Done, &revision, imported))
        }
        CellCommand::Check { file } => {
            let text = file.as_deref().map(read).transpose()?;
            let check = setup.check(text).await?;
            let exit = if check.passed {
                Exit::Done
            } else {
                Exit::Refused
            };
            Ok(context.report(exit, &check, checked))
        }
    }
}

fn form_of(path: &Path) -> SetupForm {
    let extension = path.extension().and_then(|extension| extension.to_str());
    match extension {
        Some(json) if json.eq_ignore_ascii_case("json") => SetupForm::Json,
        Some(_) | None => SetupForm::Toml,
    }
}

fn read(path: &Path) -> Result<SetupText, Failure> {
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::Usage(format!("reading {}: {error}", path.display())))?;
    Ok(SetupText {
        form: form_of(path),
        text,
    })
}

fn imported(revision: &SetupRevision) -> String {
    let mut text = if revision.changed.is_empty() {
        format!("Nothing was changed: revision {}", revision.revision)
    } else {
        format!("Revision {} holds now; changed:", revision.revision)
    };
    for changed in &revision.changed {
        let _ = write!(text, "\n  {changed}");
    }
    text
}

/// Each trigger with what fires it; those that are off are said to be.
fn triggers(all: &[TriggerBody]) -> String {
    let each = all.iter().map(|trigger| {
        let on = &trigger.on;
        let at = on.point.as_ref().or(on.station.as_ref());
        let at = at.map(|at| format!(" at {at}")).unwrap_or_default();
        let of = on.mobile_robot.as_ref();
        let of = of.map(|of| format!(" of {of}")).unwrap_or_default();
        let off = if trigger.enabled { "" } else { ", off" };
        format!("{} ({}{of}{at}{off})", trigger.id, on.signal.as_str())
    });
    let each: Vec<_> = each.collect();
    if each.is_empty() {
        "none".to_owned()
    } else {
        each.join(", ")
    }
}

fn summary(cell: &str, file: &SetupFile, etag: &str) -> String {
    let names = |names: Vec<&str>| {
        if names.is_empty() {
            "none".to_owned()
        } else {
            names.join(", ")
        }
    };
    let points = file.stations.iter().flat_map(|station| {
        let points = station.points.iter();
        points.map(move |point| format!("{}/{}", station.id, point.id))
    });
    let points: Vec<String> = points.collect();
    let mut text = facts(&[
        (
            "cell",
            format!("{cell} ({})", file.name.as_deref().unwrap_or("no name")),
        ),
        ("entity tag", etag.to_owned()),
        (
            "arms",
            names(file.arms.iter().map(|arm| &*arm.id).collect()),
        ),
        (
            "mobile robots",
            names(file.mobile_robots.iter().map(|robot| &*robot.id).collect()),
        ),
        ("points", names(points.iter().map(String::as_str).collect())),
        (
            "destinations",
            names(file.destinations.iter().map(|it| &*it.id).collect()),
        ),
        (
            "zones",
            names(file.zones.iter().map(|zone| &*zone.id).collect()),
        ),
        (
            "routes",
            names(file.routes.iter().map(|route| &*route.id).collect()),
        ),
        (
            "loads",
            names(file.loads.iter().map(|load| &*load.id).collect()),
        ),
        ("triggers", triggers(&file.triggers)),
    ]);
    let mut table = Table::new(&["place", "kind", "taught for", "accepts"]);
    for place in &file.places {
        let taught = file
            .taught_poses
            .iter()
            .filter(|taught| taught.place == place.id);
        let arms: Vec<&str> = taught.map(|taught| &*taught.arm).collect();
        table.row([
            place.id.clone(),
            word(place.kind),
            names(arms),
            place.accepts.join(", "),
        ]);
    }
    let _ = write!(text, "\n{table}");
    text
}

fn checked(check: &SetupCheck) -> String {
    let mut table = Table::new(&[
        "arm",
        "place",
        "",
        ">docks",
        "joint",
        ">deg left",
        ">singularity",
        "keep-out",
        ">mm",
        "work area",
        ">mm",
    ]);
    for taught in &check.taught_poses {
        let TaughtPoseCheck {
            arm,
            place,
            passed,
            dock_poses,
            samples: _,
            joint,
            singularity,
            keep_out,
            work,
            findings: _,
        } = taught;
        let (zone, gap) = zone_margin(keep_out.as_ref());
        let (area, inside) = zone_margin(work.as_ref());
        table.row([
            arm.clone(),
            place.clone(),
            verdict(*passed),
            dock_poses.to_string(),
            joint
                .as_ref()
                .map_or_else(none, |joint| joint.joint.clone()),
            joint
                .as_ref()
                .map_or_else(none, |joint| format!("{:.1}", joint.margin_deg)),
            singularity.map_or_else(none, |measure| format!("{measure:.3}")),
            zone,
            gap,
            area,
            inside,
        ]);
    }
    let mut text = table.to_string();
    if !check.routes.is_empty() {
        let mut table = Table::new(&["route", "", ">mm long", "keep-out", ">mm"]);
        for route in &check.routes {
            let (zone, gap) = zone_margin(route.keep_out.as_ref());
            let length = format!("{:.0}", route.length_mm);
            table.row([
                route.route.clone(),
                verdict(route.passed),
                length,
                zone,
                gap,
            ]);
        }
        let _ = write!(text, "\n{table}");
    }
    let findings = check
        .taught_poses
        .iter()
        .flat_map(|taught| &taught.findings)
        .chain(check.routes.iter().flat_map(|route| &route.findings))
        .chain(&check.findings);
    let mut text_of_findings = String::new();
    for CheckFinding {
        severity,
        item,
        message,
    } in findings
    {
        let begin = match severity {
            Severity::Error => "Wrong",
            Severity::Warning => "Look at",
        };
        let _ = write!(text_of_findings, "\n{begin}: {item}: {message}");
    }
    text.push_str(&text_of_findings);
    let end = if check.passed {
        "Every taught pose can be reached, every route can be driven."
    } else {
        "Something would not work."
    };
    let _ = write!(text, "\n{end}");
    text
}

fn none() -> String {
    "-".to_owned()
}

fn verdict(passed: bool) -> String {
    if passed { "ok" } else { "WRONG" }.to_owned()
}

fn zone_margin(margin: Option<&ZoneMargin>) -> (String, String) {
    match margin {
        Some(margin) => (margin.zone.clone(), format!("{:.1}", margin.margin_mm)),
        None => (none(), none()),
    }
}
