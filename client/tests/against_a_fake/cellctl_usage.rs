//! Command lines that make no sense: exit code 2, and nothing is sent.

use crate::fake::{Answer, Fake, cellctl, cellctl_in};
use crate::samples;

#[tokio::test]
async fn what_makes_no_sense_is_not_sent() {
    let fake = Fake::always(Answer::Json(samples::motion("accepted"))).await;
    for (arguments, complaint) in [
        (&["move", "600", "200", "600", "-180", "30"][..], "required"),
        (
            &["move", "600", "200", "600", "-180", "30", "nan"],
            "not a finite number",
        ),
        (
            &["move", "600", "200", "600", "-180", "30", "-inf"],
            "not a finite number",
        ),
        (
            &["move", "600", "200", "600", "-180", "30", "1,5"],
            "not a number",
        ),
        (
            &["move", "600", "200", "600", "-180", "30", "0", "7"],
            "unexpected",
        ),
        (&["move", "--x", "600"], "required"),
        (
            &["move", "1", "2", "3", "4", "5", "6", "--y", "2"],
            "cannot be used with",
        ),
        (
            &[
                "move", "1", "2", "3", "4", "5", "6", "--joints", "1", "2", "3", "4", "5", "6",
            ],
            "cannot be used with",
        ),
        (&["move", "--joints", "1", "2", "3"], "6 values required"),
        (
            &["move", "1", "2", "3", "4", "5", "6", "--speed", "inf"],
            "not a finite number",
        ),
        (&["move"], "required"),
        (
            &["fk", "0", "0", "0", "0", "-90", "NaN"],
            "not a finite number",
        ),
        (&["motions", "show", "no-uuid"], "invalid value"),
        (
            &["emulator", "state", "--wait-still", "-1"],
            "not between 0 and 3600",
        ),
        (&["fly"], "unrecognized subcommand"),
    ] {
        let ran = fake.cellctl(arguments).await;
        assert_eq!(ran.code, 2, "{arguments:?}: {ran:?}");
        assert!(
            ran.stderr.contains(complaint),
            "{arguments:?}: {}",
            ran.stderr
        );
    }
    assert_eq!(fake.lines(), Vec::<String>::new());
}

#[tokio::test]
async fn an_address_that_is_none_is_a_matter_of_usage() {
    for server in [
        "127.0.0.1:8080",
        "https://127.0.0.1",
        "http://127.0.0.1/?a=b",
    ] {
        let ran = cellctl(&["--server", server, "cells"]).await;
        assert_eq!(ran.code, 2, "{ran:?}");
        assert!(
            ran.stderr.contains("is not the address of a server"),
            "{ran:?}"
        );
    }
}

#[tokio::test]
async fn an_empty_name_in_the_environment_names_nothing() {
    let ran = cellctl_in(&[("ROBOCELL_ROBOT", "")], &["home"]).await;
    assert_eq!(ran.code, 2, "{ran:?}");
    assert!(ran.stderr.contains("--robot <ID>"), "{ran:?}");
}

#[tokio::test]
async fn of_several_robots_none_is_guessed() {
    let fake = Fake::always(Answer::Json(samples::cells(&["r1", "r2"]))).await;
    let ran = cellctl(&["--server", &fake.url(), "home"]).await;
    assert_eq!(ran.code, 2, "{ran:?}");
    assert!(
        ran.stderr
            .contains("--cell demo --robot r1\n  --cell demo --robot r2"),
        "{ran:?}"
    );
    assert_eq!(fake.lines(), ["GET /api/v1/cells"]);
}

#[tokio::test]
async fn help_shows_examples() {
    for subcommand in ["move", "delta", "fk", "ik", "motions", "emulator"] {
        let ran = cellctl(&[subcommand, "--help"]).await;
        assert_eq!(ran.code, 0);
        assert!(
            ran.stdout.contains(&format!("\n  cellctl {subcommand}")),
            "{}",
            ran.stdout
        );
    }
    assert!(cellctl(&["--help"]).await.stdout.contains("Exit codes:"));
}
