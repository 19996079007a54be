//! T3: the driver of ROS-Industrial, called by a client of `simple_message`.

use anyhow::{Context as _, Result, bail};

use super::rig::{Client, Files, Found, Rig};
use super::ros_setup;
use super::simple_message::{JOINT_POSITION, Message, REPLY_FAILURE, REPLY_SUCCESS, STATUS, hex};
use super::table::Table;

const MOTION: u16 = 11_000;
pub(super) const STATE: u16 = 11_002;
pub(super) const PORTS: [u16; 2] = [MOTION, STATE];

pub(crate) async fn observe(files: &Files) -> Result<Table> {
    let mut table = Table::default();
    let rig = ros_setup::first_run(files, &mut table).await?;
    idle(&rig, &mut table).await?;
    state_stream(&rig, &mut table).await?;
    trajectory(&rig, &mut table).await?;
    stop(&rig, &mut table).await?;
    out_of_range(&rig, &mut table).await?;
    status(&rig, &mut table).await?;
    abort(&rig, &mut table).await?;
    rig.stop().await;
    ros_setup::tag_not_started(files, &mut table).await?;
    ros_setup::slower_loop(files, &mut table).await?;
    ros_setup::entered_before(files, &mut table).await?;
    ros_setup::little_endian(files, &mut table).await?;
    Ok(table)
}

/// The task dump of a controller that waits, from a user's report.
async fn idle(rig: &Rig, table: &mut Table) -> Result<()> {
    let relay = rig.stack("ROS_RELAY").await?.join(" ");
    table.same(
        "T3.10",
        "call stack of ROS_RELAY",
        "LIBSSOCK,169 LIBSSOCK,254 ROS_RELAY,263",
        &relay,
    );
    let ros = rig.stack("ROS").await?.join(" ");
    table.same("T3.10", "call stack of ROS", "ROS_MOVESM,12 ROS,3", &ros);
    Ok(())
}

async fn state_stream(rig: &Rig, table: &mut Table) -> Result<()> {
    let mut client = rig.connect(STATE).await?;
    let first = next(&mut client, &mut Vec::new()).await?;
    table.same(
        "T3.3",
        "the first message",
        "00000038 0000000a 00000001 00000000 00000000",
        &hex(&first.bytes(), 20),
    );
    let state = rig.state().await?;
    let joints: [f64; 6] = state.joints_deg.into();
    let seen: Vec<f64> = first
        .reals()
        .iter()
        .map(|rad| f64::from(rad.to_degrees()))
        .collect();
    let same = seen.iter().zip(joints).all(|(a, b)| (a - b).abs() < 1e-3);
    table.put(
        "T3.3",
        "joints 1 to 6, in degrees",
        in_row(&joints),
        in_row(seen.get(..6).unwrap_or_default()),
        same,
    );
    let rest = first.reals().get(6..).unwrap_or_default().to_vec();
    let zero = rest.iter().all(|value| value.to_bits() == 0) && rest.len() == 4;
    table.put(
        "T3.3",
        "joints 7 to 10",
        "0 0 0 0",
        format!("{rest:?}"),
        zero,
    );

    cadence(rig, &mut client, table).await?;
    drop(client);
    rig.pass(10.0).await?;
    let mut again = rig.connect(STATE).await?;
    let message = next(&mut again, &mut Vec::new()).await?;
    let what = "a client after one that vanished: type";
    table.same("T3.4", what, JOINT_POSITION, message.kind);
    let logged = rig.screen_has("srlise err:").await?;
    table.same("T3.4", "the write error is in the log", true, logged);
    Ok(())
}

/// How often what comes.
async fn cadence(rig: &Rig, client: &mut Client<'_>, table: &mut Table) -> Result<()> {
    let (positions, messages) = ten_seconds(rig, client).await?;
    let what = "JOINT_POSITION a second";
    let seen = format!("{positions:.2}");
    let good = (41.0..42.0).contains(&positions);
    table.put("T3.3", what, "41.67, each 24 ms", seen, good);
    let statuses: Vec<usize> = messages
        .iter()
        .enumerate()
        .filter(|(_, message)| message.kind == STATUS)
        .map(|(at, _)| at)
        .collect();
    let gaps = statuses.iter().zip(statuses.iter().skip(1));
    let regular = statuses.len() > 10 && gaps.into_iter().all(|(a, b)| b - a == 12);
    let seen = format!("{} among {}", statuses.len(), messages.len());
    let what = "a STATUS after every 11 JOINT_POSITION";
    table.put("T3.3", what, "11 and 1, in turn", seen, regular);
    let mut statuses = messages.iter().filter(|message| message.kind == STATUS);
    let status = statuses.next().context("there is no STATUS")?;
    let expected = "00000028 0000000d 00000001 00000000";
    table.same("T3.3", "STATUS", expected, &hex(&status.bytes(), 16));
    let fields: Vec<i32> = (0..7).map(|at| status.integer(at)).collect();
    // Drives on, no emergency stop, no error, no error, still, automatic, motion possible.
    let seen = format!("{fields:?}");
    table.same("T3.3", "its seven values", "[1, 0, 0, 0, 0, 2, 1]", &seen);
    Ok(())
}

/// Ten seconds of the stream: joint positions a second, and all messages.
pub(super) async fn ten_seconds(rig: &Rig, client: &mut Client<'_>) -> Result<(f64, Vec<Message>)> {
    let mut bytes = Vec::new();
    // What is on its way is old.
    while let Found::Bytes(old) = client.next(0.0).await? {
        bytes.extend(old);
    }
    while Message::take(&mut bytes)?.is_some() {}
    let mut messages = Vec::new();
    let begin = rig.state().await?.time_s;
    while rig.state().await?.time_s < begin + 10.0 {
        if let Found::Bytes(more) = client.next(1.0).await? {
            bytes.extend(more);
        }
        while let Some(message) = Message::take(&mut bytes)? {
            messages.push(message);
        }
    }
    let passed = rig.state().await?.time_s - begin;
    let positions = messages
        .iter()
        .filter(|message| message.kind == JOINT_POSITION);
    #[expect(clippy::cast_precision_loss, reason = "a few hundred messages")]
    let rate = positions.count() as f64 / passed;
    Ok((rate, messages))
}

async fn trajectory(rig: &Rig, table: &mut Table) -> Result<()> {
    let mut client = rig.connect(MOTION).await?;
    let mut bytes = Vec::new();
    let target = [10.0, 10.0, -10.0, 20.0, -60.0, 30.0];
    let point = Message::point(7, target);
    table.same("T3.5", "bytes of a JOINT_TRAJ_PT", 68, point.bytes().len());
    client.send(&point.bytes()).await?;
    let reply = next(&mut client, &mut bytes).await?;
    let expected = "type 10, comm 3, reply 1, seq 7";
    table.same("T3.5", "its answer", expected, &reply.head());
    table.same("T3.5", "bytes of the answer", 60, reply.bytes().len());
    let zero = reply.reals().iter().all(|value| value.to_bits() == 0);
    table.same("T3.5", "its joints are 0", true, zero);
    let arm: [f64; 6] = rig.state().await?.joints_deg.into();
    let near = near_all(&arm, target);
    table.same(
        "T3.5",
        "the arm is there when the answer comes",
        false,
        near,
    );
    let reached = rig
        .until(60.0, |state| near_all(&state.joints_deg.into(), target))
        .await?;
    table.same("T3.5", "the arm gets there", true, reached);
    for (register, expected) in [("R[1]", "20"), ("R[2]", "50")] {
        let seen = rig.register(register).await?;
        table.same("T3.5", register, expected, &seen);
    }

    // All at once: the second is taken while the first is under way, the third waits.
    let before = rig.started().await?;
    let targets = [
        [20.0, 10.0, -10.0, 0.0, -60.0, 0.0],
        [20.0, 20.0, -20.0, 0.0, -60.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, -90.0, 0.0],
    ];
    let mut together = Vec::new();
    for (sequence, target) in (8..).zip(targets) {
        together.extend(Message::point(sequence, target).bytes());
    }
    client.send(&together).await?;
    for sequence in 8..11 {
        let reply = next(&mut client, &mut bytes).await?;
        let expected = format!("type 10, comm 3, reply 1, seq {sequence}");
        table.same(
            "T3.5",
            "points in one segment: an answer",
            &expected,
            &reply.head(),
        );
    }
    let [.., last] = targets;
    let reached = rig
        .until(60.0, |state| {
            !state.moving && near_all(&state.joints_deg.into(), last)
        })
        .await?;
    let started = rig.started().await? - before;
    let seen = format!("{started} motions, at the last {reached}");
    table.same(
        "T3.5",
        "points in one segment",
        "3 motions, at the last true",
        &seen,
    );

    unusual(rig, &mut client, &mut bytes, table).await?;

    // A message that arrives byte by byte.
    let point = Message::point(11, target).bytes();
    for byte in point {
        client.send(&[byte]).await?;
        rig.pass(0.004).await?;
    }
    let reply = next(&mut client, &mut bytes).await?;
    let expected = "type 10, comm 3, reply 1, seq 11";
    table.same(
        "T3.5",
        "a point byte by byte: its answer",
        expected,
        &reply.head(),
    );
    let reached = rig
        .until(60.0, |state| near_all(&state.joints_deg.into(), target))
        .await?;
    table.same("T3.5", "the arm gets there", true, reached);
    Ok(())
}

/// The short form of a point, and a length that is not true: neither is looked at.
async fn unusual(
    rig: &Rig,
    client: &mut Client<'_>,
    bytes: &mut Vec<u8>,
    table: &mut Table,
) -> Result<()> {
    let target = [5.0, 5.0, -5.0, 0.0, -80.0, 0.0];
    let mut short = Message::point(12, target);
    short.kind = JOINT_POSITION;
    short.body.truncate(11);
    let mut lies = short.bytes();
    drop(lies.splice(..4, 9_999_i32.to_be_bytes()));
    for (what, message) in [
        ("a JOINT_POSITION of 60 bytes: its answer", short.bytes()),
        ("a LENGTH of 9999: the answer", lies),
    ] {
        client.send(&message).await?;
        let reply = next(client, bytes).await?;
        table.same(
            "T3.5",
            what,
            "type 10, comm 3, reply 1, seq 12",
            &reply.head(),
        );
    }
    let reached = rig
        .until(60.0, |state| near_all(&state.joints_deg.into(), target))
        .await?;
    table.same("T3.5", "the arm gets there", true, reached);
    client.send(&Message::point(-5, target).bytes()).await?;
    rig.pass(1.0).await?;
    let found = client.next(2.0).await?;
    table.same(
        "T3.7",
        "answer to seq -5",
        Found::Silence.text(),
        found.text(),
    );
    let logged = rig.screen_has("unknown seq nr:").await?;
    table.same("T3.7", "'unknown seq nr:' in the log", true, logged);
    Ok(())
}

async fn stop(rig: &Rig, table: &mut Table) -> Result<()> {
    rig.pass(1.0).await?;
    let mut client = rig.connect(MOTION).await?;
    let mut bytes = Vec::new();
    let far = [80.0, 0.0, 0.0, 0.0, -90.0, 0.0];
    client.send(&Message::point(20, far).bytes()).await?;
    let _reply = next(&mut client, &mut bytes).await?;
    let _moves = rig.until(2.0, |state| state.moving).await?;
    rig.pass(0.3).await?;
    client.send(&Message::point(-4, far).bytes()).await?;
    let reply = next(&mut client, &mut bytes).await?;
    let expected = "type 10, comm 3, reply 1, seq -4";
    table.same(
        "T3.7",
        "answer to seq -4 on the way",
        expected,
        &reply.head(),
    );
    let reached = rig
        .until(60.0, |state| near_all(&state.joints_deg.into(), far))
        .await?;
    // The relay holds no motion group, so its CANCEL reaches no motion: the report of issue 93.
    table.same("T3.7", "the arm goes on to the point", true, reached);
    for sequence in [-1, -2, -3] {
        client.send(&Message::point(sequence, far).bytes()).await?;
    }
    rig.pass(1.0).await?;
    let found = client.next(2.0).await?;
    table.same(
        "T3.7",
        "answer to seq -1, -2, -3",
        Found::Silence.text(),
        found.text(),
    );
    let logged = rig.screen_has("RREL Trajectory end").await?;
    table.same("T3.7", "'Trajectory end' in the log", true, logged);
    Ok(())
}

async fn out_of_range(rig: &Rig, table: &mut Table) -> Result<()> {
    rig.pass(1.0).await?;
    let before = rig.started().await?;
    let mut client = rig.connect(MOTION).await?;
    let mut bytes = Vec::new();
    let beyond = [400.0, 0.0, 0.0, 0.0, -90.0, 0.0];
    client.send(&Message::point(31, beyond).bytes()).await?;
    for (what, reply) in [
        ("out of range: the first answer", REPLY_SUCCESS),
        ("out of range: the second answer", REPLY_FAILURE),
    ] {
        let expected = format!("type 10, comm 3, reply {reply}, seq 31");
        let seen = next(&mut client, &mut bytes).await?;
        table.same("T3.6", what, &expected, &seen.head());
    }
    let end = client.next(5.0).await?;
    table.same("T3.6", "after that", Found::End.text(), end.text());
    table.same("T3.6", "motions started", 0, rig.started().await? - before);
    Ok(())
}

/// What STATUS says of the controller.
async fn status(rig: &Rig, table: &mut Table) -> Result<()> {
    let mut client = rig.connect(STATE).await?;
    let mut bytes = Vec::new();
    rig.controller.emergency_stop(true).await?;
    let seen = status_now(rig, &mut client, &mut bytes).await?;
    let expected = "e-stop 1, error SRVO-001 (11001), in error 1, possible 0";
    table.same("T3.8", "emergency stop", expected, &told(&seen));
    rig.controller.emergency_stop(false).await?;
    let seen = status_now(rig, &mut client, &mut bytes).await?;
    let expected = "e-stop 0, error SRVO-001 (11001), in error 1, possible 0";
    table.same("T3.8", "released, not RESET", expected, &told(&seen));
    rig.controller.reset().await?;
    let seen = status_now(rig, &mut client, &mut bytes).await?;
    let expected = "e-stop 0, error none (0), in error 0, possible";
    table.put(
        "T3.8",
        "RESET",
        expected,
        told(&seen),
        told(&seen).starts_with(expected),
    );
    rig.controller.cycle_start().await?;
    let seen = status_now(rig, &mut client, &mut bytes).await?;
    let expected = "e-stop 0, error none (0), in error 0, possible 1";
    table.same("T3.8", "cycle start", expected, &told(&seen));
    rig.with(|core| core.abort_task("ROS")).await??;
    let seen = status_now(rig, &mut client, &mut bytes).await?;
    let expected = "e-stop 0, error none (0), in error 0, possible 0";
    table.same("T3.8", "without the task ROS", expected, &told(&seen));
    Ok(())
}

async fn abort(rig: &Rig, table: &mut Table) -> Result<()> {
    rig.with(|core| core.abort_task("ROS_RELAY")).await??;
    rig.pass(2.0).await?;
    let exit = rig.screen_has("RREL Exit").await?;
    table.same(
        "T3.9",
        "ABORT of ROS_RELAY: 'RREL Exit' in the log",
        true,
        exit,
    );
    let task = rig.task("ROS_RELAY").await?;
    table.same("T3.9", "the task ends as a program does", "ended", &task);
    Ok(())
}

/// The next STATUS that was made from now on.
async fn status_now(rig: &Rig, client: &mut Client<'_>, bytes: &mut Vec<u8>) -> Result<Message> {
    rig.pass(1.0).await?;
    // What is on its way is old.
    while let Found::Bytes(old) = client.next(0.0).await? {
        bytes.extend(old);
    }
    while Message::take(bytes)?.is_some() {}
    loop {
        let message = next(client, bytes).await?;
        if message.kind == STATUS {
            return Ok(message);
        }
    }
}

fn told(status: &Message) -> String {
    let code = status.integer(2);
    let name = match code {
        0 => "none".to_owned(),
        11_001 => "SRVO-001".to_owned(),
        other => format!("another, {other}"),
    };
    format!(
        "e-stop {}, error {name} ({code}), in error {}, possible {}",
        status.integer(1),
        status.integer(3),
        status.integer(6)
    )
}

pub(super) async fn next(client: &mut Client<'_>, bytes: &mut Vec<u8>) -> Result<Message> {
    loop {
        if let Some(message) = Message::take(bytes)? {
            return Ok(message);
        }
        match client.next(30.0).await? {
            Found::Bytes(more) => bytes.extend(more),
            other @ (Found::End | Found::Silence) => bail!("{} instead of a message", other.text()),
        }
    }
}

fn near_all(joints: &[f64; 6], target: [f32; 6]) -> bool {
    let near = |(a, b): (&f64, f32)| (a - f64::from(b)).abs() < 1e-2;
    joints.iter().zip(target).all(near)
}

fn in_row(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|value| format!("{value:.3}")).collect();
    texts.join(" ")
}
