//! T2: ports, system variables and programs of the controller, by fanucpy.

use anyhow::Result;
use serde_json::json;

use super::fanucpy::{Fanucpy, Outcome};
use super::mappdk::{
    CALLED, Programs, SERVER, command, connected, raises, returned, start, success,
};
use super::rig::Files;
use super::table::Table;

pub(super) async fn ports(
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
