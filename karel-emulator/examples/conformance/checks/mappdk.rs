//! T2: the servers of fanucpy, called by the real fanucpy, and by bare sockets where its wire is looked at.

use std::path::Path;

use anyhow::Result;
use serde_json::{Value, json};

use super::fanucpy::{Fanucpy, Outcome};
use super::rig::{Files, Found, Rig};
use super::table::Table;

pub(crate) const SERVER: u16 = 18_735;
pub(crate) const LOGGER: u16 = 18_736;
const PORTS: [u16; 2] = [SERVER, LOGGER];
const GREETING: &str = "0:success";

/// The width of numbers before March 2023, which the server of today cannot read.
const OLD_WIDTH: &str = "movej:0025:0100:000:0:6:+0000000019.000000:+0000000066.000000:-0000000033.000000:\
     +0000000018.000000:-0000000030.000000:-0000000033.000000\n";

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
    ports(files, whose, &mut fanucpy, &mut table).await?;
    stopping(files, &mut fanucpy, &mut table).await?;
    wire(files, &mut table).await?;
    wrong_width(files, whose, &mut table).await?;
    frames(files, whose, &mut table).await?;
    Ok(table)
}

async fn start(files: &Files) -> Result<Rig> {
    Rig::start(&files.controller(&["MAPPDK"], &PORTS)?).await
}

/// A client that is connected to the server and to the logger, as `robot` and `logger`.
async fn connected(rig: &Rig, fanucpy: &mut Fanucpy) -> Result<Outcome> {
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

async fn ports(
    files: &Files,
    whose: Programs,
    fanucpy: &mut Fanucpy,
    table: &mut Table,
) -> Result<()> {
    let rig = start(files).await?;
    let _greeting = connected(&rig, fanucpy).await?;
    for (what, method, arguments, expected) in [
        ("get_rdo(3)", "get_rdo", json!({ "rdo_num": 3 }), json!(0)),
        (
            "set_rdo(3, True)",
            "set_rdo",
            json!({ "rdo_num": 3, "val": true }),
            json!([0, "success"]),
        ),
        ("get_rdo(3)", "get_rdo", json!({ "rdo_num": 3 }), json!(1)),
        (
            "gripper(True), RDO[7]",
            "gripper",
            json!({ "value": true }),
            json!([0, "success"]),
        ),
        ("get_rdo(7)", "get_rdo", json!({ "rdo_num": 7 }), json!(1)),
        (
            "get_dout(17)",
            "get_dout",
            json!({ "dout_num": 17 }),
            json!(0),
        ),
        (
            "set_dout(17, True)",
            "set_dout",
            json!({ "dout_num": 17, "val": true }),
            json!([0, "success"]),
        ),
        (
            "get_dout(17)",
            "get_dout",
            json!({ "dout_num": 17 }),
            json!(1),
        ),
        (
            "set_dout(17, False)",
            "set_dout",
            json!({ "dout_num": 17, "val": false }),
            json!([0, "success"]),
        ),
        (
            "get_dout(17)",
            "get_dout",
            json!({ "dout_num": 17 }),
            json!(0),
        ),
        (
            "set_sys_var('$DMAURST', True)",
            "set_sys_var",
            json!({ "sys_var": "$DMAURST", "val": true }),
            json!([0, "success"]),
        ),
    ] {
        let seen = fanucpy.call(&rig, "robot", method, arguments).await?;
        table.same("T2.4", what, returned(expected), seen);
    }
    let set = rig.variable("$DMAURST").await?;
    table.same("T2.4", "$DMAURST", "true", &set);
    let arguments = json!({ "prog_name": CALLED });
    let called = fanucpy.call(&rig, "robot", "call_prog", arguments).await?;
    table.same("T2.4", "call_prog() of a TP program", success(), called);
    let register = rig.register("R[5]").await?;
    table.same("T2.4", "R[5], which it sets", "42", &register);
    let wrong = command(&rig, fanucpy, "setrdo:3:maybe").await?;
    table.same("T2.4", "'setrdo:3:maybe'", raises("wrong-rdo-value"), wrong);
    let wrong = command(&rig, fanucpy, "setdout:00003:maybe").await?;
    table.same(
        "T2.4",
        "'setdout:00003:maybe'",
        raises("wrong-dout-value"),
        wrong,
    );
    let wrong = command(&rig, fanucpy, "setsysvar:$DMAURST:X").await?;
    table.same(
        "T2.4",
        "'setsysvar:$DMAURST:X'",
        raises("wrong-sys_var-value"),
        wrong,
    );

    let arguments = json!({ "rdo_num": 1, "val": true });
    let set = fanucpy.call(&rig, "robot", "set_rdo", arguments).await?;
    table.same("T2.4", "set_rdo(1, True)", success(), set);
    let arguments = json!({ "rdo_num": 10 });
    let seen = fanucpy.call(&rig, "robot", "get_rdo", arguments).await?;
    // One digit is all that their server reads of the number.
    let (what, expected) = match whose {
        Programs::Theirs => ("get_rdo(10), which is RDO[1]", returned(json!(1))),
        Programs::Ours => ("get_rdo(10)", raises("wrong-rdo-value")),
    };
    table.same("T2.4", what, expected, seen);
    rig.stop().await;
    grippers(files, fanucpy, table).await?;
    beyond(files, whose, fanucpy, table).await
}

/// A gripper on a digital output, and those that the client refuses.
async fn grippers(files: &Files, fanucpy: &mut Fanucpy, table: &mut Table) -> Result<()> {
    let rig = start(files).await?;
    let server = rig.port(SERVER).await?;
    let refused = |text: &str| Outcome::Raised(format!("ValueError: {text}"));
    for (what, gripper, expected) in [
        ("gripper(True), DOUT[12]", (Some("DO"), Some(12)), success()),
        (
            "gripper(True), type XY",
            (Some("XY"), Some(1)),
            refused("Wrong DO type!"),
        ),
        (
            "gripper(True), none",
            (None, None),
            refused("DO type or number is None!"),
        ),
    ] {
        fanucpy
            .robot_with(&rig, "gripper", server, (30.0, gripper))
            .await?;
        let _greeting = fanucpy.call(&rig, "gripper", "connect", json!({})).await?;
        let arguments = json!({ "value": true });
        let seen = fanucpy.call(&rig, "gripper", "gripper", arguments).await?;
        table.same("T2.4", what, expected, seen);
        let _gone = fanucpy
            .call(&rig, "gripper", "disconnect", json!({}))
            .await?;
    }
    let state = rig.state().await?;
    let on: Vec<String> = state.ports.iter().map(|port| port.port.clone()).collect();
    table.same("T2.4", "outputs that are on", "DOUT[12]", &on.join(" "));
    let arguments = json!({ "resp": "7:x" });
    let seen = fanucpy
        .call(&rig, "gripper", "handle_response", arguments)
        .await?;
    let expected =
        Outcome::Raised("FanucError: Unknown response code: 7 and message: x".to_owned());
    table.same("T2.4", "handle_response('7:x')", expected, seen);
    rig.stop().await;
    Ok(())
}

/// Ports and programs that the controller does not have.
async fn beyond(
    files: &Files,
    whose: Programs,
    fanucpy: &mut Fanucpy,
    table: &mut Table,
) -> Result<()> {
    for (what, method, arguments, theirs, ours) in [
        (
            "get_dout(20000), beyond the hardware",
            "get_dout",
            json!({ "dout_num": 20_000 }),
            "aborted: PRIO-002 (MAPPDK_SERVER, 501)",
            "wrong-dout-value",
        ),
        (
            "call_prog('NOTHING')",
            "call_prog",
            json!({ "prog_name": "NOTHING" }),
            "aborted: ",
            "no-such-program",
        ),
    ] {
        let rig = start(files).await?;
        let server = rig.port(SERVER).await?;
        fanucpy.robot(&rig, "patient", server, 0.7).await?;
        let _greeting = fanucpy.call(&rig, "patient", "connect", json!({})).await?;
        let answer = fanucpy.call(&rig, "patient", method, arguments).await?;
        match whose {
            Programs::Ours => table.same("T2.4", what, raises(ours), answer),
            Programs::Theirs => {
                let expected = Outcome::Raised("TimeoutError: timed out".to_owned());
                table.same("T2.4", what, expected, answer);
                let task = rig.task("MAPPDK_SERVER").await?;
                let aborted = task.starts_with(theirs);
                table.put("T2.4", "the server afterwards", theirs, task, aborted);
            }
        }
        rig.stop().await;
    }
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

/// The bytes, which fanucpy takes apart.
async fn wire(files: &Files, table: &mut Table) -> Result<()> {
    let rig = start(files).await?;
    let mut client = rig.connect(SERVER).await?;
    let greeting = client.next(5.0).await?.text();
    table.same("T2.1", "bytes of the greeting", GREETING, &greeting);
    let pose = client.ask("curpos\n").await?;
    let expected = "0:x= 985.000,y=    .000,z= 940.000,w= 180.000,p=";
    table.put(
        "T2.2",
        "bytes of curpos, at home",
        format!("{expected}.."),
        &pose,
        starts(&pose, expected),
    );
    let joints = client.ask("curjpos\n").await?;
    let absent = joints.matches("j=none").count();
    table.same(
        "T2.2",
        "bytes of curjpos: axes, and those that are none",
        "9, 3",
        &format!("{}, {absent}", joints.matches("j=").count()),
    );
    // Dispatch is by prefix.
    let prefix = client.ask("curposxyz\n").await?;
    table.same("T2.5", "'curposxyz'", &pose, &prefix);
    for split in ["cu", "rp", "os", "\r"] {
        client.send(split.as_bytes()).await?;
        rig.pass(0.05).await?;
    }
    let answer = client.ask("\n").await?;
    table.same("T2.5", "'curpos' in pieces, with CR LF", &pose, &answer);
    let answer = client.ask("exit\n").await?;
    table.same("T2.8", "'exit'", GREETING, &answer);
    // The server reads once more before it closes, and waits for nothing.
    let end = client.next(5.0).await?.text();
    table.same("T2.8", "after 'exit'", Found::End.text(), end);
    for what in ["a client after 'exit'", "a client after one that vanished"] {
        let mut client = rig.connect(SERVER).await?;
        let greeting = client.next(5.0).await?.text();
        table.same("T2.8", what, GREETING, &greeting);
    }
    rig.stop().await;
    Ok(())
}

async fn wrong_width(files: &Files, whose: Programs, table: &mut Table) -> Result<()> {
    let rig = start(files).await?;
    let mut client = rig.connect(SERVER).await?;
    let _greeting = client.next(5.0).await?;
    client.send(OLD_WIDTH.as_bytes()).await?;
    let found = client.next(20.0).await?;
    let what = "movej with numbers of 18 characters";
    match whose {
        Programs::Ours => table.same("T2.6", what, "1:error-in-joint-values", &found.text()),
        Programs::Theirs => {
            table.same("T2.6", what, Found::Silence.text(), found.text());
            let expected = "INTP-311 (MAPPDK_SERVER, 204)";
            let task = rig.task("MAPPDK_SERVER").await?;
            table.put(
                "T2.6",
                "the server afterwards",
                expected,
                &task,
                task.contains(expected),
            );
            let alarm = rig.had_alarm("INTP-311").await?;
            table.same("T2.6", "INTP-311 among the alarms", true, alarm);
            rig.with(|core| core.run_program("MAPPDK_SERVER")).await??;
            rig.pass(0.1).await?;
            let end = client.next(5.0).await?.text();
            table.same(
                "T2.6",
                "the program is started again: the old client",
                Found::End.text(),
                end,
            );
            let greeting = rig.connect(SERVER).await?.next(5.0).await?.text();
            table.same("T2.6", "a new client", GREETING, &greeting);
        }
    }
    rig.stop().await;
    Ok(())
}

/// The frame's number does not fit into a `STRING[1]` with its blank, so it is never taken over.
async fn frames(files: &Files, whose: Programs, table: &mut Table) -> Result<()> {
    let mut variants = vec![(
        "the frame of $MNUFRAME[1,8]",
        files.clone(),
        whose == Programs::Ours,
    )];
    if whose == Programs::Theirs {
        let mut mended = files.clone();
        for program in &mut mended.programs {
            let text = String::from_utf8_lossy(&program.text).replace("STRING[1]", "STRING[2]");
            program.text = text.into_bytes();
        }
        variants.push(("with STRING[2] instead of STRING[1]", mended, true));
    }
    for (what, files, taken) in variants {
        let mut config = files.controller(&["MAPPDK"], &PORTS)?;
        let preset = |item: &str, value: &str| (item.to_owned(), value.to_owned());
        config.presets = vec![
            preset("$MNUFRAME[1,8].x", "100"),
            preset("$MNUTOOL[1,8].z", "50"),
        ];
        let rig = Rig::start(&config).await?;
        let number = rig.variable("$MNUFRAMENUM[1]").await?;
        table.same("T2.7", "$MNUFRAMENUM[1]", "8", &number);
        let x = rig.variable("$GROUP[1].$UFRAME.x").await?;
        let z = rig.variable("$GROUP[1].$UTOOL.z").await?;
        let expected = if taken { "100, 50" } else { "0, 0" };
        table.same(
            "T2.7",
            &format!("$UFRAME.x, $UTOOL.z: {what}"),
            expected,
            &format!("{x}, {z}"),
        );
        let mut client = rig.connect(SERVER).await?;
        let _greeting = client.next(5.0).await?;
        let pose = client.ask("curpos\n").await?;
        // The tool looks down at home.
        let expected = if taken {
            "0:x= 885.000,y=    .000,z= 890.000,"
        } else {
            "0:x= 985.000,y=    .000,z= 940.000,"
        };
        table.put(
            "T2.7",
            "curpos then",
            format!("{expected}.."),
            &pose,
            starts(&pose, expected),
        );
        rig.stop().await;
    }
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

async fn command(rig: &Rig, fanucpy: &mut Fanucpy, text: &str) -> Result<Outcome> {
    let arguments = json!({ "cmd": text });
    fanucpy.call(rig, "robot", "send_cmd", arguments).await
}

fn success() -> Outcome {
    returned(json!([0, "success"]))
}

fn returned(value: Value) -> Outcome {
    Outcome::Returned(value)
}

fn raises(text: &str) -> Outcome {
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

fn starts(text: &str, start: &str) -> bool {
    text.starts_with(start)
}
