//! T2 without fanucpy: the bytes of the wire, what ends the server, and the frames it reads positions in.

use anyhow::Result;

use super::mappdk::{GREETING, PORTS, Programs, SERVER, start, starts};
use super::rig::{Files, Found, Rig};
use super::table::Table;

/// The width of numbers before March 2023, which the server of today cannot read.
const OLD_WIDTH: &str = "movej:0025:0100:000:0:6:+0000000019.000000:+0000000066.000000:-0000000033.000000:\
     +0000000018.000000:-0000000030.000000:-0000000033.000000\n";

/// The bytes, which fanucpy takes apart.
pub(super) async fn wire(files: &Files, table: &mut Table) -> Result<()> {
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

pub(super) async fn wrong_width(files: &Files, whose: Programs, table: &mut Table) -> Result<()> {
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
pub(super) async fn frames(files: &Files, whose: Programs, table: &mut Table) -> Result<()> {
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
