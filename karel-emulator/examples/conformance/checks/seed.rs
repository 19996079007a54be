//! T1: the socket server of fanuc-control, called as its HTTP server calls it: one connection for each command,
//! one `recv` for the answer.

use anyhow::Result;

use super::rig::{Files, Found, Rig};
use super::table::Table;

const PORT: u16 = 59_002;
/// The command of the driver's own examples.
const LINE: &str = "600000 200000 600000 -180000 30000 0 300 1";
const ACCEPTED: &str = "SUCESS: MOVEMENT COMPLETE";
const UNREACHABLE: &str = "ERROR: POINT UNREACHABLE";
const INCORRECT: &str = "ERROR: INCORRECT INPUT";

pub(crate) async fn observe(files: &Files) -> Result<Table> {
    let mut table = Table::default();
    let rig = Rig::start(&files.controller(&[], &[PORT])?).await?;
    let address = rig.port(PORT).await;
    let listens = address.is_ok();
    table.put("T1.1", "port of tag 3", "listens", or_not(listens), listens);

    moves(&rig, &mut table).await?;
    refusals(&rig, &mut table).await?;
    emergency_stop(&rig, &mut table).await?;
    reconnects(&rig, &mut table).await?;
    rig.stop().await;
    Ok(table)
}

fn or_not(listens: bool) -> &'static str {
    if listens { "listens" } else { "closed" }
}

async fn moves(rig: &Rig, table: &mut Table) -> Result<()> {
    let mut client = rig.connect(PORT).await?;
    client.send(LINE.as_bytes()).await?;
    let reply = client.next(10.0).await?.text();
    let moving = rig.state().await?.moving;
    table.same(
        "T1.2",
        "answer to a pose without a line end",
        ACCEPTED,
        &reply,
    );
    table.same(
        "T1.2",
        "the arm moves when the answer is there",
        true,
        moving,
    );
    let end = client.next(10.0).await?;
    table.same("T1.2", "after the answer", Found::End.text(), end.text());
    let override_percent = rig.variable("$MCR.$GENOVERRIDE").await?;
    table.same("T1.2", "$MCR.$GENOVERRIDE", "25", &override_percent);
    let still = rig.until(120.0, |state| !state.moving).await?;
    let pose: [f64; 6] = rig.state().await?.pose.into();
    let target = [600.0, 200.0, 600.0, -180.0, 30.0, 0.0];
    table.put(
        "T1.2",
        "CURPOS at the end, with tool 0",
        "(600.000, 200.000, 600.000, ±180.000, 30.000, 0.000)",
        karel_emulator::ledger::PoseMmDeg::from(pose),
        still && same_pose(pose, target),
    );
    Ok(())
}

async fn refusals(rig: &Rig, table: &mut Table) -> Result<()> {
    let before = rig.started().await?;
    for (what, line, expected) in [
        ("beyond the reach", "9000000 0 0 0 0 0 300 1", UNREACHABLE),
        (
            "speed 0",
            "600000 0 600000 -180000 30000 0 0 1",
            UNREACHABLE,
        ),
        (
            "speed 2000",
            "600000 0 600000 -180000 30000 0 2000 1",
            UNREACHABLE,
        ),
    ] {
        let reply = call(rig, line).await?;
        table.same("T1.3", &format!("answer to {what}"), expected, &reply);
    }
    let reply = call(rig, "a b c d e f g h\n").await?;
    table.same("T1.4", "answer to what are no numbers", INCORRECT, &reply);
    let after = rig.started().await?;
    table.same("T1.3", "motions started for these", 0, after - before);
    let reply = call(rig, LINE).await?;
    table.same("T1.4", "the next client is served", ACCEPTED, &reply);
    let _stands = rig.until(120.0, |state| !state.moving).await?;
    Ok(())
}

async fn emergency_stop(rig: &Rig, table: &mut Table) -> Result<()> {
    let reply = call(rig, "985000 0 940000 -180000 0 0 300 1").await?;
    table.same("T1", "answer to the way home", ACCEPTED, &reply);
    let _moves = rig.until(1.0, |state| state.moving).await?;
    rig.pass(0.5).await?;
    rig.controller.emergency_stop(true).await?;
    let stands = rig.until(2.0, |state| !state.moving).await?;
    let alarm = rig.had_alarm("SRVO-001").await?;
    table.put(
        "T1",
        "emergency stop on the way",
        "stands, SRVO-001",
        format!("stands {stands}, SRVO-001 {alarm}"),
        stands && alarm,
    );
    rig.controller.emergency_stop(false).await?;
    rig.controller.reset().await?;
    rig.controller.cycle_start().await?;
    let moves = rig.until(1.0, |state| state.moving).await?;
    let stands = rig.until(120.0, |state| !state.moving).await?;
    let home = [985.0, 0.0, 940.0, -180.0, 0.0, 0.0];
    let pose = rig.state().await?.pose;
    let there = same_pose(pose.into(), home);
    let what = "released, RESET, cycle start: the arm gets home";
    table.put(
        "T1",
        what,
        "(985.000, 0.000, 940.000, ±180.000, ..",
        pose,
        moves && stands && there,
    );
    let reply = call(rig, LINE).await?;
    table.same("T1", "the next command", ACCEPTED, &reply);
    let moves = rig.until(1.0, |state| state.moving).await?;
    table.same("T1", "the arm moves for it", true, moves);
    let _stands = rig.until(120.0, |state| !state.moving).await?;
    Ok(())
}

async fn reconnects(rig: &Rig, table: &mut Table) -> Result<()> {
    let mut answered = 0;
    for _ in 0..100 {
        if call(rig, "a b c d e f g h\n").await? == INCORRECT {
            answered += 1;
        }
    }
    table.same(
        "T1.5",
        "100 connections, one after the other",
        100,
        answered,
    );
    Ok(())
}

/// One command, as the driver's client sends it; the controller must close.
async fn call(rig: &Rig, line: &str) -> Result<String> {
    let mut client = rig.connect(PORT).await?;
    client.send(line.as_bytes()).await?;
    let reply = client.rest().await?;
    Ok(String::from_utf8_lossy(&reply).into_owned())
}

/// Within a hundredth, angles by whole turns.
pub(crate) fn same_pose(one: [f64; 6], other: [f64; 6]) -> bool {
    let differences = one.iter().zip(other).map(|(a, b)| (a - b).abs());
    differences
        .enumerate()
        .all(|(axis, d)| d < 0.01 || (axis > 2 && (d - 360.0).abs() < 0.01))
}
