//! T3 before its clients come: what an operator has to enter, tags, rates and the order of bytes.

use anyhow::{Result, bail};
use karel_emulator::ControllerConfig;

use super::rig::{Files, Found, Rig};
use super::ros::{PORTS, STATE, next, ten_seconds};
use super::simple_message::hex;
use super::table::Table;

/// The programs stop until somebody has looked at their configuration.
pub(super) async fn first_run(files: &Files, table: &mut Table) -> Result<Rig> {
    let rig = Rig::start(&files.controller(&["ROS"], &PORTS)?).await?;
    rig.pass(1.0).await?;
    let alarms = rig.alarms().await?;
    let count = alarms.iter().filter(|a| a.starts_with("FILE-032")).count();
    table.put(
        "T3.1",
        "first run: FILE-032 among the alarms",
        "yes",
        count,
        count > 0,
    );
    let state = rig.state().await?;
    let alive = state.tasks.iter().filter(|task| {
        use karel_emulator::state::TaskWord::{Running, Waiting};
        matches!(task.state, Running | Waiting) && task.name.starts_with("ROS_")
    });
    table.same("T3.1", "first run: servers that go on", 0, alive.count());
    for program in ["ROS_STATE", "ROS_RELAY"] {
        rig.set(&format!("[{program}]CFG_.CHECKED"), "true").await?;
    }
    rig.controller.reset().await?;
    // A program that FILE-032 stopped before its first line has no defaults yet: its second run writes them.
    for _ in 0..2 {
        for program in ["ROS_STATE", "ROS_RELAY", "ROS"] {
            // It may be over.
            let _aborted = rig.with(move |core| core.abort_task(program)).await?;
        }
        rig.controller.reset().await?;
        rig.with(|core| core.run_program("ROS")).await??;
        rig.pass(1.0).await?;
        for program in ["ROS_STATE", "ROS_RELAY"] {
            rig.set(&format!("[{program}]CFG_.CHECKED"), "true").await?;
        }
        if rig.screen_has("RREL Waiting for ROS traj relay").await? {
            break;
        }
    }
    for line in [
        "RSTA Waiting for ROS state proxy",
        "RREL Waiting for ROS traj relay",
    ] {
        let has = rig.screen_has(line).await?;
        table.same("T3.1", &format!("'{line}' in the log"), true, has);
    }
    Ok(rig)
}

pub(super) async fn tag_not_started(files: &Files, table: &mut Table) -> Result<()> {
    let mut config = state_server(files, "42")?;
    let preset = ("$HOSTS_CFG[3].$STATE".to_owned(), "2".to_owned());
    config.presets.push(preset);
    let rig = Rig::start(&config).await?;
    rig.pass(1.0).await?;
    let posted = rig.had_alarm("HOST-144").await?;
    table.same(
        "T3.2",
        "tag S3 not started: HOST-144 among the alarms",
        true,
        posted,
    );
    let logged = rig.screen_has("cfg err, TAG idx:").await?;
    table.same("T3.2", "'cfg err, TAG idx:' in the log", true, logged);
    rig.stop().await;
    Ok(())
}

/// A pause of 25 ms is one of 32 ms on a controller of 8 ms: why the driver's authors chose 42 Hz.
pub(super) async fn slower_loop(files: &Files, table: &mut Table) -> Result<()> {
    let rig = Rig::start(&state_server(files, "40")?).await?;
    let mut client = rig.connect(STATE).await?;
    let _first = next(&mut client, &mut Vec::new()).await?;
    let (rate, _) = ten_seconds(&rig, &mut client).await?;
    let what = "JOINT_POSITION a second with LOOP_HZ = 40";
    let good = (30.5..32.0).contains(&rate);
    table.put(
        "T3.3",
        what,
        "31.25, each 32 ms",
        format!("{rate:.2}"),
        good,
    );
    rig.stop().await;
    Ok(())
}

/// What an operator enters before the first run.
const OPERATOR: &str = include_str!("../../drivers/ros_industrial.set");

/// What the file sets, for one program or for all.
fn entered(program: &str) -> Vec<(String, String)> {
    let lines = OPERATOR.lines().filter(|line| line.contains(program));
    let pairs = lines.filter_map(|line| line.split_once('='));
    pairs
        .filter(|(item, _)| item.starts_with('['))
        .map(|(item, value)| (item.to_owned(), value.to_owned()))
        .collect()
}

/// Only the state server, as somebody has configured and checked it.
fn state_server(files: &Files, loop_hz: &str) -> Result<ControllerConfig> {
    let mut config = files.controller(&["ROS_STATE"], &PORTS)?;
    config.presets = entered("[ROS_STATE]");
    let rate = ("[ROS_STATE]CFG_.LOOP_HZ".to_owned(), loop_hz.to_owned());
    config.presets.push(rate);
    Ok(config)
}

/// The order of bytes of the vendor's simulator.
pub(super) async fn little_endian(files: &Files, table: &mut Table) -> Result<()> {
    let mut config = state_server(files, "42")?;
    config.byte_order = karel::ByteOrder::Little;
    let rig = Rig::start(&config).await?;
    let mut client = rig.connect(STATE).await?;
    let Found::Bytes(bytes) = client.next(5.0).await? else {
        bail!("there is no message");
    };
    let expected = "38000000 0a000000 01000000 00000000 00000000";
    table.same(
        "T3.3",
        "the first message, little endian",
        expected,
        &hex(&bytes, 20),
    );
    rig.stop().await;
    Ok(())
}

/// The command line of the documentation: everything is entered before the first statement.
pub(super) async fn entered_before(files: &Files, table: &mut Table) -> Result<()> {
    let mut config = files.controller(&["ROS"], &PORTS)?;
    config.presets = entered("CFG_");
    let rig = Rig::start(&config).await?;
    rig.pass(1.0).await?;
    let relay = rig.screen_has("RREL Waiting for ROS traj relay").await?;
    let state = rig.screen_has("RSTA Waiting for ROS state proxy").await?;
    let what = "first run with CHECKED entered before: both wait";
    table.same("T3.1", what, true, relay && state);
    let alarms = rig.alarms().await?.len();
    table.same("T3.1", "alarms then", 0, alarms);
    rig.stop().await;
    Ok(())
}
