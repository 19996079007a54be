//! Programs that share routines and start each other.

mod common;

use common::{Stepped, call, config_of, wait_until};
use karel_emulator::ProgramSource;
use karel_emulator::config::ControllerConfig;
use karel_emulator::state::TaskWord;

const MOTION_PORT: u16 = 59_002;
const STATUS_PORT: u16 = 59_003;

/// Starts STATUS as a second task, then serves its own port; both use the same library.
const MAIN: &str = "PROGRAM main
%NOLOCKGROUP
VAR
  f : FILE
  s, n : INTEGER
ROUTINE lib_answer(tag : STRING; f : FILE; text : STRING) FROM lib
BEGIN
  SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', 59002, s)
  SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[4].$SERVER_PORT', 59003, s)
  RUN_TASK('STATUS', 1, FALSE, FALSE, 0, s)
  WHILE TRUE DO
    lib_answer('S3:', f, 'main')
  ENDWHILE
END main
";

const STATUS: &str = "PROGRAM status
%NOLOCKGROUP
VAR
  f : FILE
ROUTINE lib_answer(tag : STRING; f : FILE; text : STRING) FROM lib
BEGIN
  WHILE TRUE DO
    lib_answer('S4:', f, 'status')
  ENDWHILE
END status
";

const LIB: &str = "PROGRAM lib
VAR
%INCLUDE shared
BEGIN
END lib
ROUTINE lib_answer(tag : STRING; f : FILE; text : STRING)
VAR s, n : INTEGER
BEGIN
  MSG_DISCO(tag, s)
  MSG_CONNECT(tag, s)
  IF s = 0 THEN
    OPEN FILE f('RW', tag)
    READ f(n)
    IF UNINIT(calls) THEN
      calls = 0
    ENDIF
    calls = calls + n
    WRITE f(text, calls)
    CLOSE FILE f
  ENDIF
  MSG_DISCO(tag, s)
END lib_answer
";

fn config() -> ControllerConfig {
    config_of(MAIN, &[MOTION_PORT, STATUS_PORT])
        .with_program(ProgramSource::new("status.kl", STATUS))
        .with_program(ProgramSource::new("lib.kl", LIB))
        .with_include(ProgramSource::new("shared.kl", "calls : INTEGER\n"))
}

#[tokio::test]
async fn a_second_task_serves_its_own_port_while_the_first_waits() {
    let cell = Stepped::start(&config());
    let main = cell.controller.address_of_port(MOTION_PORT).await.unwrap();
    let status = cell.controller.address_of_port(STATUS_PORT).await.unwrap();
    assert_eq!(call(status, b"1\n").await, "status 1");
    assert_eq!(
        call(main, b"10\n").await,
        "main 11",
        "the library's variable is one"
    );
    assert_eq!(call(status, b"100\n").await, "status 111");
    let state = cell.controller.state().await.unwrap();
    let names: Vec<&str> = state.tasks.iter().map(|task| task.name.as_str()).collect();
    assert_eq!(names, ["MAIN", "STATUS"]);
}

/// Covers: K6.
#[tokio::test]
async fn programs_that_start_each_other_for_ever_do_not_stop_the_clock() {
    let main = "PROGRAM main\nVAR s: INTEGER\nBEGIN\nWHILE TRUE DO\n\
        RUN_TASK('other', 1, FALSE, FALSE, 0, s)\nENDWHILE\nEND main\n";
    let other = "PROGRAM other\nVAR s: INTEGER\nBEGIN\nRUN_TASK('third', 1, FALSE, FALSE, 0, s)\n\
        ABORT_TASK('third', TRUE, TRUE, s)\nEND other\n";
    let third = "PROGRAM third\nBEGIN\nWHILE TRUE DO\nENDWHILE\nEND third\n";
    let config = config_of(main, &[])
        .with_program(ProgramSource::new("other.kl", other))
        .with_program(ProgramSource::new("third.kl", third));
    let cell = Stepped::start(&config);
    cell.advance(0.2).await;
    let state = cell.controller.state().await.unwrap();
    assert!(state.tasks.len() <= 3, "{:?}", state.tasks);
}

#[tokio::test]
async fn a_task_that_another_aborts_gives_its_port_back() {
    let main = "PROGRAM main\nVAR s, n: INTEGER\nBEGIN\n\
        SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[4].$SERVER_PORT', 59003, s)\n\
        RUN_TASK('STATUS', 1, FALSE, FALSE, 0, s)\nDELAY 100\nABORT_TASK('STATUS', TRUE, TRUE, s)\n\
        DELAY 100\nRUN_TASK('STATUS', 1, FALSE, FALSE, 0, s)\nWRITE ('again', s)\nEND main\n";
    let config = config_of(main, &[STATUS_PORT])
        .with_program(ProgramSource::new("status.kl", STATUS))
        .with_program(ProgramSource::new("lib.kl", LIB))
        .with_include(ProgramSource::new("shared.kl", "calls : INTEGER\n"));
    let cell = Stepped::start(&config);
    cell.advance(0.15).await;
    let status = |state: &karel_emulator::State| {
        let task = state.tasks.iter().find(|task| task.name == "STATUS");
        task.map(|task| task.state)
    };
    let state = cell.controller.state().await.unwrap();
    assert_eq!(status(&state), Some(TaskWord::Ended));
    cell.advance(0.1).await;
    assert_eq!(cell.controller.screen().await.unwrap(), ["again 0"]);
    wait_until(&cell.controller, |state| {
        status(state) == Some(TaskWord::Waiting)
    })
    .await;
    let address = cell.controller.address_of_port(STATUS_PORT).await.unwrap();
    assert_eq!(call(address, b"5\n").await, "status 5");
}
