//! Files of the controller, pipes, client tags, and condition handlers that see an abort.
#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, where a failure is a failed test"
)]

mod common;

use std::time::Duration;

use common::{Stepped, config_of, within};
use karel_emulator::alarms::{Alarm, Severity};
use karel_emulator::controller::{Controller, Operation};
use karel_emulator::effects::Effect;
use karel_emulator::{ControllerConfig, ProgramSource};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpListener;

/// What a program has written to the screen after some seconds.
fn screen_after(config: &ControllerConfig, seconds: u64) -> (Controller, Vec<String>) {
    let mut controller = Controller::try_new(config).unwrap();
    controller.advance_fully(Duration::from_secs(seconds));
    let screen = controller.screen();
    (controller, screen)
}

#[test]
fn files_are_written_read_listed_and_stay_on_their_device() {
    let program = "PROGRAM filer
VAR
  f : FILE
  n, s : INTEGER
  line : STRING[20]
  names : ARRAY[4] OF STRING[12]
BEGIN
  OPEN FILE f ('RW', 'MC:log.txt')
  WRITE f ('one', CR, 2, CR)
  CLOSE FILE f
  OPEN FILE f ('AP', 'mc:LOG.TXT')
  WRITE f ('three', CR)
  CLOSE FILE f
  OPEN FILE f ('RO', 'MC:LOG.TXT')
  READ f (line)
  READ f (n)
  WRITE (line, n, IO_STATUS(f), CR)
  READ f (line)
  WRITE (line, IO_STATUS(f), CR)
  READ f (line)
  WRITE (UNINIT(line), IO_STATUS(f), CR)
  CLOSE FILE f
  OPEN FILE f ('RW', 'MC:../out.txt')
  WRITE (IO_STATUS(f), CR)
  OPEN FILE f ('RO', 'RD:none.txt')
  WRITE (IO_STATUS(f), CR)
  COPY_FILE('MC:LOG.TXT', 'RD:COPY.TXT', FALSE, FALSE, s)
  WRITE (s, CR)
  FILE_LIST('MC:*.TXT', 0, 3, names, n, s)
  WRITE (n, names[1], s, CR)
  DELETE_FILE('MC:LOG.TXT', FALSE, s)
  FILE_LIST('MC:*', 0, 3, names, n, s)
  WRITE (n, s, CR)
END filer
";
    let (mut controller, screen) = screen_after(&config_of(program, &[]), 1);
    assert_eq!(
        screen,
        [
            "one 2 0",
            "three 0",
            "TRUE 2021",
            " 2032",
            " 2014",
            " 0",
            " 1LOG.TXT 0",
            " 0 0",
        ]
    );
    let kept: Vec<String> = controller
        .take_effects()
        .into_iter()
        .filter_map(|effect| {
            let Effect::Keep { name, bytes } = effect else {
                return None;
            };
            Some(format!("{name} {:?}", bytes.map(|bytes| bytes.len())))
        })
        .collect();
    assert_eq!(
        kept,
        [
            "MC:LOG.TXT Some(9)",
            "MC:LOG.TXT Some(16)",
            "RD:COPY.TXT Some(16)",
            "MC:LOG.TXT None",
        ]
    );
    let names: Vec<String> = controller
        .files()
        .iter()
        .map(|(name, _)| name.to_string())
        .collect();
    assert_eq!(names, ["RD:COPY.TXT"]);
}

#[test]
fn a_pipe_leads_from_one_task_to_another() {
    let reader = "PROGRAM reader
VAR
  f : FILE
  n, s : INTEGER
BEGIN
  OPEN FILE f ('RO', 'PIP:numbers')
  READ f (n)
  WRITE (UNINIT(n), IO_STATUS(f), CR)
  SET_FILE_ATR(f, ATR_PIPWAIT)
  RUN_TASK('writer', 1, FALSE, FALSE, 0, s)
  READ f (n)
  WRITE (n, CR)
  READ f (n)
  WRITE (n, CR)
END reader
";
    let writer = "PROGRAM writer
VAR
  f : FILE
BEGIN
  DELAY 100
  OPEN FILE f ('RW', 'PIP:numbers')
  WRITE f (42, CR)
  DELAY 100
  WRITE f (43, CR)
END writer
";
    let config = config_of(reader, &[]).with_program(ProgramSource::new("writer.kl", writer));
    let (_, screen) = screen_after(&config, 1);
    assert_eq!(screen, ["TRUE 282", " 42", " 43"]);
}

#[test]
fn a_program_that_writes_for_ever_fills_its_device_and_nothing_else() {
    let program = "PROGRAM filler
VAR
  f : FILE
  line : STRING[254]
  n : INTEGER
BEGIN
  line = ''
  FOR n = 1 TO 254 DO
    line = line + 'x'
  ENDFOR
  OPEN FILE f ('RW', 'RD:big')
  WHILE TRUE DO
    WRITE f (line)
    IF IO_STATUS(f) <> 0 THEN
      WRITE (IO_STATUS(f), CR)
      ABORT
    ENDIF
  ENDWHILE
END filler
";
    let (controller, screen) = screen_after(&config_of(program, &[]), 20);
    assert_eq!(screen, [" 2005"]);
    let size: usize = controller
        .files()
        .iter()
        .map(|(_, bytes)| bytes.len())
        .sum();
    assert!(size <= 1 << 20, "{size}");
}

#[test]
fn an_abort_is_seen_by_a_handler_that_tidies_up() {
    let program = "PROGRAM driver
VAR
  leave : BOOLEAN
  f : FILE
  s : INTEGER
  line : STRING[9]
BEGIN
  leave = FALSE
  CONDITION[1]:
    WITH $SCAN_TIME = 256
    WHEN ABORT DO
      NOABORT
      leave = TRUE
      CANCEL FILE f
  ENDCONDITION
  ENABLE CONDITION[1]
  WHILE NOT leave DO
    DELAY 10
  ENDWHILE
  WRITE ('left by itself', CR)
  DELAY 1000
END driver
";
    let mut controller = Controller::try_new(&config_of(program, &[])).unwrap();
    let alarm = || Operation::RaiseAlarm {
        facility: "SRVO".to_owned(),
        number: 1,
        text: "test".to_owned(),
        severity: Severity::Abort,
    };
    controller.advance_fully(Duration::from_millis(100));
    controller.operate(alarm()).unwrap();
    controller.advance_fully(Duration::from_millis(200));
    assert_eq!(controller.screen(), ["left by itself"]);
    // The handler has fired and nobody enabled it again.
    controller.operate(alarm()).unwrap();
    controller.advance_fully(Duration::from_millis(300));
    let word = controller.state().tasks[0].state;
    assert_eq!(word, karel_emulator::state::TaskWord::Ended);
}

#[test]
fn assumed_an_alarm_of_a_program_stops_the_tasks_as_its_severity_says() {
    let program = "PROGRAM main
VAR s : INTEGER
BEGIN
  RUN_TASK('other', 1, FALSE, FALSE, 0, s)
  DELAY 100
  POST_ERR(67144, 'no link', 0, 2)
  WRITE ('never', CR)
END main
";
    let other = "PROGRAM other
VAR n : INTEGER
BEGIN
  FOR n = 1 TO 100 DO
    DELAY 40
    WRITE (n, CR)
  ENDFOR
END other
";
    let config = config_of(program, &[]).with_program(ProgramSource::new("other.kl", other));
    let (controller, screen) = screen_after(&config, 1);
    assert_eq!(screen, [" 1", " 2"]);
    let alarm = controller.alarms().pop().unwrap();
    assert_eq!(alarm.headline(), "HOST-144 no link");
    assert_eq!((alarm.severity, alarm.line), (Severity::Abort, Some(6)));
}

const CLIENT: &str = "PROGRAM client
VAR
  f : FILE
  e, s, n, port : INTEGER
  host : STRING[20]
BEGIN
  SET_VAR(e, '*SYSTEM*', '$HOSTC_CFG[1].$SERVER_PORT', port, s)
  SET_VAR(e, '*SYSTEM*', '$HOSTC_CFG[1].$STRT_REMOTE', host, s)
  MSG_CONNECT('C1:', s)
  WRITE (s, CR)
  IF s <> 0 THEN
    MSG_CONNECT('C1:', s)
    MSG_PING(host, s)
    WRITE (s, CR)
    ABORT
  ENDIF
  SET_FILE_ATR(f, ATR_UF)
  OPEN FILE f ('RW', 'C1:')
  WRITE f (7, CR)
  READ f (n)
  WRITE (n, IO_STATUS(f), CR)
  CLOSE FILE f
  MSG_DISCO('C1:', s)
END client
";

fn client_of(host: &str, port: u16) -> ControllerConfig {
    let start = format!("BEGIN\n  host = '{host}'\n  port = {port}\n");
    config_of(&CLIENT.replacen("BEGIN\n", &start, 1), &[])
}

#[tokio::test]
async fn a_client_tag_connects_to_a_server_of_this_machine() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    let cell = Stepped::start(&client_of("localhost", port));
    let (mut stream, _) = within(listener.accept()).await.unwrap();
    let mut number = [0; 4];
    let _count = within(stream.read_exact(&mut number)).await.unwrap();
    assert_eq!(number, [0, 0, 0, 7]);
    stream.write_all(&[0, 0, 1, 0]).await.unwrap();
    let mut rest = Vec::new();
    let _count = within(stream.read_to_end(&mut rest)).await.unwrap();
    assert!(rest.is_empty(), "{rest:?}");
    let screen = cell.controller.screen().await.unwrap();
    assert_eq!(screen, [" 0", " 256 0"]);
}

#[tokio::test]
async fn a_server_that_is_not_there_is_a_status() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let port = listener.local_addr().unwrap().port();
    drop(listener);
    let cell = Stepped::start(&client_of("127.0.0.1", port));
    // A MSG_CONNECT that fails rests a little.
    common::wait_until(&cell.controller, |state| {
        let detail = state.tasks[0].detail.as_deref();
        detail.is_some_and(|detail| detail.starts_with("waits until"))
    })
    .await;
    cell.advance(0.01).await;
    let screen = cell.controller.screen().await.unwrap();
    assert_eq!(screen.first().map(String::as_str), Some(" 67144"));
}

#[test]
fn hosts_that_nobody_has_permitted_are_never_asked() {
    let config = client_of("192.0.2.1", 80);
    let (mut controller, screen) = screen_after(&config, 1);
    assert_eq!(screen, [" 67178", " 67178"]);
    let asked = controller.take_effects();
    let asked = asked
        .iter()
        .any(|effect| matches!(effect, Effect::Connect { .. }));
    assert!(!asked, "nothing goes out");
    let alarms: Vec<String> = controller.alarms().iter().map(Alarm::headline).collect();
    assert_eq!(
        alarms,
        ["HOST-178 C1: may not connect to the host \"192.0.2.1\""]
    );
    let mut permitted = client_of("robot-pc", 80);
    permitted
        .hosts
        .permit("ROBOT-PC", "192.0.2.1".parse().unwrap());
    let mut controller = Controller::try_new(&permitted).unwrap();
    controller.advance_fully(Duration::from_millis(1));
    let asked = controller.take_effects();
    let wanted = "192.0.2.1:80".parse().unwrap();
    assert!(
        asked
            .iter()
            .any(|effect| matches!(effect, Effect::Connect { server, .. } if *server == wanted)),
        "{asked:?}"
    );
}
