//! T2: the servers of fanucpy, called by the real fanucpy, and by bare sockets where its wire is looked at.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};

use super::fanucpy::{Fanucpy, Outcome};
use super::rig::{Files, Found, Rig};
use super::table::Table;
use super::{mappdk_ports, mappdk_wire};

pub(crate) const SERVER: u16 = 18_735;
pub(crate) const LOGGER: u16 = 18_736;
pub(super) const PORTS: [u16; 2] = [SERVER, LOGGER];
pub(super) const GREETING: &str = "0:success";

/// Whose programs run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Programs {
    /// Those of the driver, with their faults.
    Theirs,
    /// Those of this project: the same wire, without the faults.
    Ours,
}

pub(crate) async fn observe(files: &Files, whose: Programs, python: &Path) -> Result<Table> {
    let mut table = Table::default();
    let mut fanucpy = Fanucpy::start(python)?;
    reading(files, &mut fanucpy, &mut table).await?;
    moving(files, &mut fanucpy, &mut table).await?;
    mappdk_ports::ports(files, whose, &mut fanucpy, &mut table).await?;
    stopping(files, &mut fanucpy, &mut table).await?;
    mappdk_wire::wire(files, &mut table).await?;
    mappdk_wire::wrong_width(files, whose, &mut table).await?;
    mappdk_wire::frames(files, whose, &mut table).await?;
    Ok(table)
}

pub(super) async fn start(files: &Files) -> Result<Rig> {
    Rig::start(&files.controller(&["MAPPDK"], &PORTS)?).await
}

/// A client that is connected to the server and to the logger, as `robot` and `logger`.
pub(super) async fn connected(rig: &Rig, fanucpy: &mut Fanucpy) -> Result<Outcome> {
    let server = rig.port(SERVER).await?;
    fanucpy.robot(rig, "robot", server, 30.0).await?;
    fanucpy.call(rig, "robot", "connect", json!({})).await
}

async fn reading(files: &Files, fanucpy: &mut Fanucpy, table: &mut Table) -> Result<()> {
    let rig = start(files).await?;
    let started =
        rig.task("MAPPDK_SERVER").await.is_ok() && rig.task("MAPPDK_LOGGER").await.is_ok();
    table.same("T2.1", "MAPPDK starts both servers", true, started);
    let greeting = connected(&rig, fanucpy).await?;
    table.same("T2.1", "connect()", success(), greeting);

    let pose = fanucpy.call(&rig, "robot", "get_curpos", json!({})).await?;
    let state = rig.state().await?;
    let (expected, seen): ([f64; 6], _) = (state.pose.into(), numbers(&pose));
    let near = near_all(&seen, &expected);
    table.put(
        "T2.2",
        "get_curpos()",
        in_row(&expected),
        in_row(&seen),
        near,
    );
    let joints = fanucpy
        .call(&rig, "robot", "get_curjpos", json!({}))
        .await?;
    let (expected, seen): ([f64; 6], _) = (state.joints_deg.into(), numbers(&joints));
    let near = near_all(&seen, &expected);
    table.put(
        "T2.2",
        "get_curjpos()",
        in_row(&expected),
        in_row(&seen),
        near,
    );
    let power = fanucpy
        .call(&rig, "robot", "get_ins_power", json!({}))
        .await?;
    let number = matches!(&power, Outcome::Returned(Value::Number(_)));
    table.put(
        "T2.2",
        "get_ins_power()",
        "a number of watts",
        power,
        number,
    );

    let answer = command(&rig, fanucpy, "ver").await?;
    table.same("T2.5", "send_cmd('ver')", raises("wrong-command"), answer);
    let hung_up = fanucpy.call(&rig, "robot", "disconnect", json!({})).await?;
    table.same("T2.8", "disconnect()", returned(Value::Null), hung_up);
    let again = connected(&rig, fanucpy).await?;
    table.same("T2.8", "connect() after it", success(), again);
    let last = command(&rig, fanucpy, "exit").await?;
    table.same("T2.8", "send_cmd('exit')", success(), last);
    let again = connected(&rig, fanucpy).await?;
    table.same("T2.8", "connect() after it", success(), again);
    rig.stop().await;
    Ok(())
}

async fn moving(files: &Files, fanucpy: &mut Fanucpy, table: &mut Table) -> Result<()> {
    let rig = start(files).await?;
    let _greeting = connected(&rig, fanucpy).await?;
    let mut logger = rig.connect(LOGGER).await?;
    let greeting = logger.next(5.0).await?.text();
    table.same("T2.1", "greeting of the logger", GREETING, &greeting);

    let target = [19.0, 26.0, -33.0, 18.0, -30.0, -33.0];
    let arguments = json!({
        "move_type": "joint", "vals": target, "velocity": 50, "acceleration": 80, "cnt_val": 10,
    });
    // The logger is asked while the server's client waits for its answer.
    let moved = fanucpy.call(&rig, "robot", "move", arguments);
    let looking = async {
        let mut seen = Vec::new();
        while seen.len() < 2 {
            if rig.state().await?.moving {
                seen.push(logger.ask("curpos\n").await?);
                rig.pass(0.1).await?;
            }
            tokio::task::yield_now().await;
        }
        let power = logger.ask("ins_pwr\n").await?;
        anyhow::Ok((seen, power))
    };
    let (moved, on_the_way) = tokio::join!(moved, looking);
    let (on_the_way, power) = on_the_way?;
    let kilowatts = power
        .strip_prefix("0:")
        .map(|text| text.trim().parse::<f64>());
    let more = matches!(kilowatts, Some(Ok(kw)) if kw > 0.3);
    table.put(
        "T2.2",
        "ins_pwr while the arm moves",
        "more than 0.25 kW",
        power,
        more,
    );
    table.same("T2.3", "move('joint')", success(), moved?);
    let different = on_the_way.first() != on_the_way.last();
    let good = different && on_the_way.iter().all(|answer| answer.starts_with("0:x="));
    let seen = on_the_way.last().cloned().unwrap_or_default();
    table.put(
        "T2.3",
        "the logger's curpos meanwhile",
        "another pose each time",
        seen,
        good,
    );
    let state = rig.state().await?;
    table.same(
        "T2.3",
        "the answer comes when the arm stands",
        false,
        state.moving,
    );
    let joints: [f64; 6] = state.joints_deg.into();
    let near = near_all(&joints, &target);
    table.put(
        "T2.3",
        "joints at the end",
        in_row(&target),
        in_row(&joints),
        near,
    );
    for (register, expected) in [("R[81]", "50"), ("R[82]", "80"), ("R[83]", "10")] {
        let seen = rig.register(register).await?;
        table.same("T2.3", register, expected, &seen);
    }
    let seen = rig.register("PR[81]").await?;
    let expected = "[19.000, 26.000, -33.000, 18.000, -30.000, -33.000]";
    table.same("T2.3", "PR[81]", expected, &seen);

    to_poses(&rig, fanucpy, table).await?;
    too_far(&rig, fanucpy, table).await?;
    rig.stop().await;
    Ok(())
}

async fn to_poses(rig: &Rig, fanucpy: &mut Fanucpy, table: &mut Table) -> Result<()> {
    let mut pose: [f64; 6] = rig.state().await?.pose.into();
    for (what, lift, arguments) in [
        (
            "move('pose')",
            40.0,
            json!({ "move_type": "pose", "velocity": 30 }),
        ),
        (
            "move('pose', linear=True)",
            -60.0,
            json!({ "move_type": "pose", "velocity": 250, "linear": true }),
        ),
    ] {
        if let Some(z) = pose.get_mut(2) {
            *z += lift;
        }
        let moved = fanucpy
            .call(rig, "robot", "move", with_values(arguments, &pose))
            .await?;
        table.same("T2.3", what, success(), moved);
        let seen: [f64; 6] = rig.state().await?.pose.into();
        let near = super::seed::same_pose(seen, pose);
        table.put(
            "T2.3",
            "pose at the end",
            in_row(&pose),
            in_row(&seen),
            near,
        );
    }
    let back = [10.0, 20.0, -20.0, 0.0, -60.0, 0.0];
    let arguments = json!({ "move_type": "joint", "velocity": 400, "linear": true });
    let moved = fanucpy
        .call(rig, "robot", "move", with_values(arguments, &back))
        .await?;
    table.same("T2.3", "move('joint', linear=True)", success(), moved);
    let joints: [f64; 6] = rig.state().await?.joints_deg.into();
    let near = near_all(&joints, &back);
    table.put(
        "T2.3",
        "joints at the end",
        in_row(&back),
        in_row(&joints),
        near,
    );

    Ok(())
}

async fn too_far(rig: &Rig, fanucpy: &mut Fanucpy, table: &mut Table) -> Result<()> {
    let far = [9000.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let before = rig.started().await?;
    let arguments = with_values(json!({ "move_type": "pose" }), &far);
    let moved = fanucpy.call(rig, "robot", "move", arguments).await?;
    table.same(
        "T2.3",
        "move('pose') beyond the reach",
        raises("position-is-not-reachable"),
        moved,
    );
    let arguments = with_values(
        json!({ "move_type": "pose", "continue_on_error": true }),
        &far,
    );
    let moved = fanucpy.call(rig, "robot", "move", arguments).await?;
    let expected = returned(json!([1, "position-is-not-reachable"]));
    table.same("T2.3", "the same, continue_on_error=True", expected, moved);
    table.same(
        "T2.3",
        "motions started for these",
        0,
        rig.started().await? - before,
    );
    let wrong = json!({ "move_type": "joint", "vals": far, "cnt_val": 101 });
    let moved = fanucpy.call(rig, "robot", "move", wrong).await?;
    let expected = Outcome::Raised("ValueError: Incorrect CNT value.".to_owned());
    table.same(
        "T2.3",
        "move(cnt_val=101), refused by the client",
        expected,
        moved,
    );
    Ok(())
}

/// An emergency stop while the client waits for the end of a motion.
async fn stopping(files: &Files, fanucpy: &mut Fanucpy, table: &mut Table) -> Result<()> {
    let rig = start(files).await?;
    let mut client = rig.connect(SERVER).await?;
    let _greeting = client.next(5.0).await?;
    let joints =
        "+000060.000000:+000020.000000:-000020.000000:+000000.000000:-000060.000000:+000000.000000";
    client
        .send(format!("movej:0020:0100:000:0:6:{joints}\n").as_bytes())
        .await?;
    let moves = rig.until(5.0, |state| state.moving).await?;
    rig.pass(0.3).await?;
    rig.controller.emergency_stop(true).await?;
    let stands = rig.until(2.0, |state| !state.moving).await?;
    let alarm = rig.had_alarm("SRVO-001").await?;
    let seen = format!("moved {moves}, stands {stands}, SRVO-001 {alarm}");
    table.put(
        "T2.3",
        "emergency stop on the way",
        "stands, SRVO-001",
        seen,
        moves && stands && alarm,
    );
    let reply = client.next(10.0).await?;
    table.same(
        "T2.3",
        "the client meanwhile",
        Found::Silence.text(),
        reply.text(),
    );
    rig.controller.emergency_stop(false).await?;
    rig.controller.reset().await?;
    rig.controller.cycle_start().await?;
    let reply = client.next(60.0).await?.text();
    table.same(
        "T2.3",
        "released, RESET, cycle start: the answer",
        GREETING,
        &reply,
    );
    let [j1, ..]: [f64; 6] = rig.state().await?.joints_deg.into();
    let near = near_all(&[j1], &[60.0]);
    table.put("T2.3", "J1 at the end", "60.000", in_row(&[j1]), near);
    drop(client);
    // fanucpy finds the server as it was.
    let greeting = connected(&rig, fanucpy).await?;
    table.same(
        "T2.8",
        "connect() after a client that vanished",
        success(),
        greeting,
    );
    rig.stop().await;
    Ok(())
}

/// A TP program for `call_prog`.
pub(crate) const CALLED: &str = "CONF_CALLED";
const CALLED_TEXT: &str = "/PROG  CONF_CALLED
/ATTR
/MN
   1:  R[5]=42 ;
/POS
/END
";

/// The programs with one more, which clients call.
pub(crate) fn with_called(mut files: Files) -> Files {
    let program = karel_emulator::ProgramSource::new("conf_called.ls", CALLED_TEXT);
    files.programs.push(program);
    files
}

pub(super) async fn command(rig: &Rig, fanucpy: &mut Fanucpy, text: &str) -> Result<Outcome> {
    let arguments = json!({ "cmd": text });
    fanucpy.call(rig, "robot", "send_cmd", arguments).await
}

pub(super) fn success() -> Outcome {
    returned(json!([0, "success"]))
}

pub(super) fn returned(value: Value) -> Outcome {
    Outcome::Returned(value)
}

pub(super) fn raises(text: &str) -> Outcome {
    Outcome::Raised(format!("FanucError: {text}"))
}

fn numbers(outcome: &Outcome) -> Vec<f64> {
    let Outcome::Returned(Value::Array(values)) = outcome else {
        return Vec::new();
    };
    values.iter().filter_map(Value::as_f64).collect()
}

/// Adds the target to the arguments of `move`.
fn with_values(mut arguments: Value, values: &[f64]) -> Value {
    if let Value::Object(fields) = &mut arguments {
        let _before = fields.insert("vals".to_owned(), json!(values));
    }
    arguments
}

/// Three decimals are sent.
fn near_all(seen: &[f64], expected: &[f64]) -> bool {
    let near = |(a, b): (&f64, &f64)| {
        let difference = (a - b).abs();
        difference <= 1e-3 || (difference - 360.0).abs() <= 1e-3
    };
    seen.len() == expected.len() && seen.iter().zip(expected).all(near)
}

fn in_row(values: &[f64]) -> String {
    let texts: Vec<String> = values.iter().map(|value| format!("{value:.3}")).collect();
    texts.join(" ")
}

pub(super) fn starts(text: &str, start: &str) -> bool {
    text.starts_with(start)
}
