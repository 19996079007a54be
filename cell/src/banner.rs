//! What a person reads first: where everything is, and what to try.

use std::io::Write as _;
use std::net::SocketAddr;

use anyhow::Result;

use crate::config::{File, Loaded};
use crate::virtual_controllers::Running;

/// Prints the addresses and lines to paste.
///
/// # Errors
/// Standard output cannot be written.
pub(crate) fn print(http: SocketAddr, file: &File, controllers: &[Running]) -> Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(out, "robocell is up. It is not a safety function.\n")?;
    writeln!(
        out,
        "  HTTP API             http://{http}      documentation: http://{http}/docs"
    )?;
    match &file.journal.path {
        Some(path) => writeln!(out, "  journal              {}", path.display())?,
        None => writeln!(
            out,
            "  journal              in memory: NOTHING SURVIVES A RESTART ([journal] path = \"..\" keeps it)"
        )?,
    }
    for part in controllers {
        write!(
            out,
            "  virtual controller   {} (`{}`)",
            part.robot_address, part.name
        )?;
        if let Some(panel) = part.controller.panel_address() {
            write!(out, "      panel: http://{panel}/")?;
        }
        writeln!(out)?;
    }
    let cells = file.cells.iter();
    let first = cells
        .flat_map(|cell| cell.robots.iter().map(move |robot| (cell, robot)))
        .next();
    let Some((cell, robot)) = first else {
        return Ok(());
    };
    let (cell, robot) = (&cell.id, &robot.id);
    writeln!(out, "\nTry, in another terminal:\n")?;
    writeln!(
        out,
        "  curl -s -X POST 'http://{http}/fanuc/move?velocity=300' -H 'Content-Type: application/json' \\\n       \
         -d '{{\"x\":600,\"y\":200,\"z\":600,\"w\":-180,\"p\":30,\"r\":0}}'"
    )?;
    writeln!(
        out,
        "\n  curl -s -X POST http://{http}/api/v1/cells/{cell}/robots/{robot}/motions -H 'Content-Type: application/json' \\\n       \
         -H \"Idempotency-Key: $(date +%s)\" -d '{{\"type\":\"HOME\",\"speed_mm_s\":500}}'"
    )?;
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
    writeln!(
        out,
        "\n  cargo run --release -p client --bin cellctl -- --help"
    )?;
    writeln!(out, "\nCtrl-C stops the cell.")?;
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
