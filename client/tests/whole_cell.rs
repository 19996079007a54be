//! The real `cellctl` binary against a whole cell: the real server, and a virtual controller that runs the program.

use std::process::{Command, Output};
use std::time::Duration;

use tests::TestCell;

const LONG: Duration = Duration::from_secs(30);

/// What a run left behind: exit code, standard output, standard error.
async fn cellctl(
    cell: &TestCell,
    arguments: &str,
) -> anyhow::Result<(Option<i32>, String, String)> {
    let panel = cell.emulator().panel_address();
    let panel = panel.ok_or_else(|| anyhow::anyhow!("the controller has no panel"))?;
    let mut command = Command::new(env!("CARGO_BIN_EXE_cellctl"));
    let _ = command
        .env_clear()
        .args(["--server", &format!("http://{}", cell.server_address())])
        .args(["--emulator", &format!("http://{panel}")])
        .args(arguments.split_whitespace());
    let Output {
        status,
        stdout,
        stderr,
    } = tokio::task::spawn_blocking(move || command.output()).await??;
    Ok((
        status.code(),
        String::from_utf8(stdout)?,
        String::from_utf8(stderr)?,
    ))
}

#[tokio::test]
async fn a_move_from_the_terminal_moves_the_arm() -> anyhow::Result<()> {
    let mut cell = TestCell::start().await?;
    // cellctl takes it by itself.
    cell.give_up_control().await?;
    let (code, said, wrong) = cellctl(&cell, "move 600 200 600 -180 30 0 --speed 300").await?;
    assert_eq!((code, &*wrong), (Some(0), ""));
    assert!(
        said.starts_with("The controller took the motion."),
        "{said}"
    );
    let state = cell.wait_until_finished(1, LONG).await?;
    assert!((state.pose.x_mm - 600.0).abs() < 0.01, "{:?}", state.pose);
    assert!((state.pose.y_mm - 200.0).abs() < 0.01, "{:?}", state.pose);

    let (code, said, _) = cellctl(&cell, "emulator state --wait-still 30").await?;
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("X 600.000  Y 200.000  Z 600.000"), "{said}");
    cell.shutdown().await
}

#[tokio::test]
async fn a_refusal_says_each_thing_once_and_the_arm_stands_still() -> anyhow::Result<()> {
    let mut cell = TestCell::start().await?;
    // cellctl takes it by itself.
    cell.give_up_control().await?;
    for (arguments, code, begin) in [
        (
            "move 5000 0 900 180 0 0",
            1,
            "cellctl: The pose is out of reach: the wrist center would be 3290.398 mm beyond the stretched arm\nRequest ",
        ),
        (
            "move --joints 0 0 0 0 0 0",
            1,
            "cellctl: The pose is singular: its distance from the wrist singularity is 0.0000 on a scale of 0 to 1; \
             0.05 is needed\n  wrist = 0 (at least 0.05)\nRequest ",
        ),
        (
            "move 985 0 940 180 0 0 --speed 2000",
            1,
            "cellctl: The request does not fit: the speed is 2000; it must be a whole number of 1 to 1999 mm/s\n  \
             speed_mm_s = 2000 (limits 1 to 1999)\nRequest ",
        ),
        (
            "fk 1e300 0 0 0 0 0",
            1,
            "cellctl: The request does not fit: J1 is 1e300; it must be from -36000 to 36000 degrees\n",
        ),
    ] {
        let (exit, said, wrong) = cellctl(&cell, arguments).await?;
        assert_eq!((exit, &*said), (Some(code), ""), "{arguments}");
        assert!(wrong.starts_with(begin), "{arguments}: {wrong}");
    }
    assert_eq!(cell.emulator().ledger().await?, []);
    cell.shutdown().await
}
