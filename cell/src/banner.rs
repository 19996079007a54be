//! What a person reads first: where everything is, and what to try.

use std::io::Write;
use std::net::SocketAddr;
use std::path::Path;

use anyhow::Result;
use api::NewToken;

use crate::config::{File, Loaded};
use crate::plant::Plant;

const DEMO: &str = "\
############################################################################
#  DEMO MODE: nobody is asked for a token.                                 #
#  Every program on this machine may do everything. Not for a real robot.  #
############################################################################";

const CELLCTL: &str = "cargo run -q --release -p client --bin cellctl --";

/// A delivery and a pickup in the built-in configuration, followed live.
const JOBS: &str = "\
job delivery --point handover/front --item load-1=crate:left:rack/d
job pickup --point handover/front --item load-2=crate:right:rack/a --destination warehouse/gate
watch";

const ADMIN: &str = "\
An admin manages tokens and moves nothing. Log in with it, and make yourself an operator:

  cellctl login                                  # asks for the token above
  cellctl tokens create alice --role operator    # shows the operator's token
  cellctl login                                  # asks for that one";

/// Prints the addresses and lines to paste.
///
/// # Errors
/// Standard output cannot be written.
pub(crate) fn print(
    http: SocketAddr,
    file: &File,
    folder: &Path,
    plant: &Plant,
    first: Option<&NewToken>,
    server: Option<u32>,
) -> Result<()> {
    let controllers = &plant.controllers;
    let mut out = std::io::stdout().lock();
    writeln!(out, "robocell is up. It is not a safety function.\n")?;
    if file.server.demo {
        writeln!(out, "{DEMO}\n")?;
    }
    drop(out);
    token(first)?;
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "  server               http://{http}/  documentation: http://{http}/docs/"
    )?;
    match &file.journal.path {
        // A path counts from the configuration, not from where a person stands.
        Some(path) => writeln!(
            out,
            "  journal              {}",
            folder.join(path).display()
        )?,
        None => writeln!(
            out,
            "  journal              in memory: NOTHING SURVIVES A RESTART ([journal] path = \"..\" keeps it)"
        )?,
    }
    for part in controllers {
        let at = format!("{} (`{}`)", part.at.command, part.name);
        write!(out, "  virtual controller   {at:<27}")?;
        if let Some(panel) = part.controller.panel_address() {
            write!(out, "  panel: http://{panel}/")?;
        }
        writeln!(out)?;
    }
    for robot in plant.mobile_robots() {
        let id = format!("`{}`", robot.id());
        write!(out, "  mobile robot         {id:<27}")?;
        if let Some(view) = robot.view_address() {
            write!(out, "  page:  http://{view}/")?;
        }
        writeln!(out)?;
    }
    if let Some(server) = server {
        writeln!(
            out,
            "  server process       {server}: `kill -9 {server}` pulls its plug. Arms, mobile robots and loads go on; it is started\n                       again by itself and finds out what became of everything"
        )?;
    }
    let cells = file.cells.iter();
    let first_robot = cells.flat_map(|cell| &cell.robots).next();
    if first_robot.is_none() {
        return Ok(());
    }
    let token = if file.server.demo {
        ""
    } else {
        "-H \"Authorization: Bearer $ROBOCELL_TOKEN\" "
    };
    writeln!(out, "\nTry, in another terminal:\n")?;
    writeln!(
        out,
        "  curl -s -X POST 'http://{http}/fanuc/move?velocity=300' {token}-H 'Content-Type: application/json' \\\n       \
         -d '{{\"x\":600,\"y\":200,\"z\":600,\"w\":-180,\"p\":30,\"r\":0}}'"
    )?;
    jobs(&mut out, http, file)?;
    if let Some(panel) = controllers
        .iter()
        .find_map(|part| part.controller.panel_address())
    {
        writeln!(
            out,
            "\n  curl -s http://{panel}/state      # where the arm is now"
        )?;
        writeln!(
            out,
            "  curl -s http://{panel}/ledger     # what it did, and what it refused"
        )?;
    }
    writeln!(out, "\n  {CELLCTL} --help")?;
    writeln!(out, "\nCtrl-C stops the cell.")?;
    out.flush()?;
    Ok(())
}

/// Lines that start jobs, where the built-in cell `line` is; else one that shows the first cell.
fn jobs(out: &mut impl Write, http: SocketAddr, file: &File) -> Result<()> {
    let line = file.cells.iter().find(|cell| cell.id == "line");
    let line = line.filter(|_| file.server.demo && !file.virtual_mobile_robots.is_empty());
    let Some(cell) = line.or(file.cells.first()) else {
        return Ok(());
    };
    let at = format!("{CELLCTL} --server http://{http} --cell {}", cell.id);
    writeln!(out)?;
    let shown = if line.is_some() { JOBS } else { "state" };
    for words in shown.lines() {
        writeln!(out, "  {at} {words}")?;
    }
    Ok(())
}

/// Shows the token that was made at the first start, once.
///
/// # Errors
/// Standard output cannot be written.
pub(crate) fn token(first: Option<&NewToken>) -> Result<()> {
    let Some(first) = first else {
        return Ok(());
    };
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "THE ADMIN TOKEN. It is shown this once; only its hash is kept:\n\n  {}\n\n{ADMIN}\n",
        first.token.reveal()
    )?;
    out.flush()?;
    Ok(())
}

/// Says that the server was started again.
///
/// # Errors
/// Standard output cannot be written.
pub(crate) fn again(server: u32) -> Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "The server is up again as process {server}.")?;
    out.flush()?;
    Ok(())
}

fn count(number: usize, thing: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{plural}")
}

/// Says what a checked configuration holds.
///
/// # Errors
/// Standard output cannot be written.
pub(crate) fn checked(loaded: &Loaded) -> Result<()> {
    let robots: usize = loaded.file.cells.iter().map(|cell| cell.robots.len()).sum();
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "{}: {}, {}, {}; nothing was started",
        loaded.name,
        count(loaded.file.cells.len(), "cell"),
        count(robots, "robot"),
        count(loaded.file.virtual_controllers.len(), "virtual controller")
    )?;
    Ok(())
}
