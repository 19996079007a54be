//! Programs and clients that mean no good: the controller stays bounded, answers, and serves the next one.

mod common;

use std::time::Duration;

use common::{
    ACCEPTED, INCORRECT, LINE, PORT, Stepped, call, config_of, http_get, read_to_end, sock_server,
    wait_until, within,
};
use karel_emulator::state::TaskWord;
use karel_emulator::{
    Clock, ControllerConfig, LedgerEvent, PeerLabels, StartError, VirtualController,
};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// A program that moves 50 mm up in the middle of `statements`, which see `p`, `n`, `s`, `r`, `t` and `f`.
fn program(statements: &str) -> ControllerConfig {
    let text = format!(
        "PROGRAM hostile
VAR
  p    : XYZWPR
  n, s : INTEGER
  r    : REAL
  t    : STRING[5]
  f    : FILE
ROUTINE meet_client
BEGIN
  SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', 59002, s)
  MSG_CONNECT('S3:', s)
  OPEN FILE f('RW', 'S3:')
END meet_client
BEGIN
  p = CURPOS(0, 0)
  p.z = p.z + 50
{statements}
END hostile
"
    );
    config_of(&text, &[PORT])
}

/// The alarms of a program without clients, after an hour.
#[allow(clippy::unwrap_used, reason = "a failure stops the test")]
async fn alarms_of(statements: &str) -> Vec<String> {
    let cell = Stepped::start(&program(statements));
    cell.advance(3600.0).await;
    let alarms = cell.controller.alarms().await.unwrap();
    alarms
        .iter()
        .map(karel_emulator::alarms::Alarm::headline)
        .collect()
}

/// The USER screen of a program without clients, after an hour.
#[allow(clippy::unwrap_used, reason = "a failure stops the test")]
async fn screen_of(statements: &str) -> Vec<String> {
    let cell = Stepped::start(&program(statements));
    cell.advance(3600.0).await;
    assert_eq!(cell.controller.alarms().await.unwrap(), []);
    cell.controller.screen().await.unwrap()
}

#[tokio::test]
async fn two_controllers_on_one_fixed_port_are_one_too_many() {
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = free.local_addr().unwrap().port();
    drop(free);
    // The first one's program never listens, so the port is only reserved.
    let first = program("DELAY 1000000").with_port(PORT, port);
    let _first = VirtualController::start(&first, Clock::real(), PeerLabels::new()).unwrap();
    let second = sock_server().with_port(PORT, port);
    match VirtualController::start(&second, Clock::real(), PeerLabels::new()) {
        Err(error @ StartError::Port { .. }) => {
            assert!(error.to_string().contains(&port.to_string()), "{error}");
        }
        other => panic!("{other:?}"),
    }
}

#[tokio::test]
async fn a_fixed_port_can_be_used_again_at_once() {
    let free = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = free.local_addr().unwrap().port();
    drop(free);
    for _ in 0..3 {
        let config = sock_server().with_port(PORT, port);
        let controller =
            VirtualController::start(&config, Clock::real(), PeerLabels::new()).unwrap();
        let address = within(controller.address_of_port(PORT)).await.unwrap();
        // The program closes first, so this connection stays in TIME_WAIT on the controller's side.
        assert_eq!(call(address, b"x x x x x x x x ").await, INCORRECT);
        within(controller.shutdown()).await;
    }
}

#[tokio::test]
async fn a_port_that_the_program_chose_and_that_is_taken_is_reported_to_whoever_asks() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let program = format!(
        "PROGRAM chooses\nVAR n, s : INTEGER\nBEGIN\n\
         SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', {port}, s)\n\
         MSG_CONNECT('S3:', s)\nEND chooses\n"
    );
    let cell = Stepped::start(&config_of(&program, &[]));
    let reason = within(cell.controller.port_failure()).await.unwrap();
    assert!(reason.contains(&port.to_string()), "{reason}");
}

/// One task waits for clients on one port after the other, another one keeps ending its waits.
const RESTLESS: [&str; 2] = [
    "PROGRAM restless
VAR n, s, port : INTEGER
BEGIN
  FOR port = 20001 TO 20300 DO
    SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', port, s)
    MSG_CONNECT('S3:', s)
  ENDFOR
  WRITE (s, CR)
END restless
",
    "PROGRAM spoiler
VAR s : INTEGER
BEGIN
  WHILE TRUE DO
    DELAY 10
    MSG_DISCO('S3:', s)
  ENDWHILE
END spoiler
",
];

#[tokio::test]
async fn a_tag_that_another_task_disconnects_ends_the_wait_and_no_port_is_kept() {
    let mut config = config_of(RESTLESS[0], &[])
        .with_program(karel_emulator::ProgramSource::new("b.kl", RESTLESS[1]));
    config.run = vec!["restless".to_owned(), "spoiler".to_owned()];
    let open_files = || std::fs::read_dir("/proc/self/fd").map_or(0, Iterator::count);
    let before = open_files();
    let cell = Stepped::start(&config);
    cell.advance(10.0).await;
    assert_eq!(cell.task_word().await, TaskWord::Ended);
    let screen = cell.controller.screen().await.unwrap();
    assert_eq!(screen, [" 67144"], "HOST-144");
    // Other tests of this process open some, too.
    assert!(open_files() < before + 250, "{} files", open_files());
}

/// Covers: K6.
#[tokio::test]
async fn a_program_that_writes_for_ever_to_a_deaf_client_waits() {
    let mut config =
        program("meet_client ; WHILE TRUE DO\nWRITE f ('0123456789'::200, CR)\nENDWHILE");
    config.panel = Some(([127, 0, 0, 1], 0).into());
    let controller = VirtualController::start(&config, Clock::real(), PeerLabels::new()).unwrap();
    let address = within(controller.address_of_port(PORT)).await.unwrap();
    let mut deaf = TcpStream::connect(address).await.unwrap();
    wait_until(&controller, |state| {
        state.tasks[0].detail.as_deref() == Some("waits until the peer takes bytes")
    })
    .await;
    let panel = controller.panel_address().unwrap();
    let answer = http_get(panel, "/state", "localhost").await;
    assert!(answer.starts_with("HTTP/1.1 200"), "{answer}");
    // What it reads at last is whole.
    let mut lines = vec![0; 2020];
    let _count = within(deaf.read_exact(&mut lines)).await.unwrap();
    assert!(lines.ends_with(b"\r\n") || lines.contains(&b'9'));
    within(controller.shutdown()).await;
}

/// Covers: K4.
#[tokio::test]
async fn ten_megabytes_without_a_delimiter_are_one_wrong_command() {
    for config in [
        config_of(include_str!("programs/eight_reads.kl"), &[PORT]),
        sock_server(),
    ] {
        let cell = Stepped::start(&config);
        let address = cell.address().await;
        let (mut reader, mut writer) = TcpStream::connect(address).await.unwrap().into_split();
        let send = async {
            let chunk = vec![b'7'; 1 << 16];
            for _ in 0..160 {
                // The controller may have had enough.
                if writer.write_all(&chunk).await.is_err() {
                    break;
                }
            }
            let _closed = writer.shutdown().await;
        };
        let receive = async {
            let mut reply = vec![0; INCORRECT.len()];
            let _count = reader.read_exact(&mut reply).await.unwrap();
            reply
        };
        let ((), reply) = within(async { tokio::join!(send, receive) }).await;
        assert_eq!(reply, INCORRECT.as_bytes());
        assert_eq!(call(address, LINE).await, ACCEPTED);
    }
}

#[tokio::test]
async fn a_thousand_connects_without_a_byte_hold_nobody_up_once_they_are_gone() {
    let cell = Stepped::start(&sock_server());
    let address = cell.address().await;
    let open_files = || std::fs::read_dir("/proc/self/fd").map_or(0, Iterator::count);
    for _ in 0..10 {
        let mut crowd: Vec<_> = (0..100)
            .map(|_| Box::pin(TcpStream::connect(address)))
            .collect();
        for connect in &mut crowd {
            // Beyond the backlog a connect hangs; it is begun all the same.
            let _begun = tokio::time::timeout(Duration::ZERO, connect).await;
        }
        cell.advance(0.0).await;
        drop(crowd);
    }
    assert_eq!(call(address, LINE).await, ACCEPTED);
    assert!(open_files() < 500, "{} files are open", open_files());
}

#[tokio::test]
async fn a_position_beyond_all_measure_is_refused() {
    for statements in [
        "p.x = 3.0E38 ; MOVE TO p",
        "p.x = -3.0E38 ; p.y = 3.0E38 ; p.z = 3.0E38 ; MOVE TO p",
        "$UTOOL = p ; p.x = 3.0E38 ; $UFRAME = p ; MOVE TO p",
    ] {
        let alarms = alarms_of(statements).await;
        assert_eq!(alarms.len(), 1, "{statements}: {alarms:?}");
        assert!(alarms[0].starts_with("MOTN-018"), "{alarms:?}");
    }
    // An angle is an angle, however often it goes around.
    let alarms = alarms_of("p.w = 3.0E38 ; MOVE TO p").await;
    assert!(alarms.iter().all(|a| a.starts_with("MOTN-")), "{alarms:?}");
    let alarms = alarms_of("r = 3.0E38 ; r = r * r ; p.x = r ; MOVE TO p").await;
    assert_eq!(alarms.len(), 1, "no infinity is made: {alarms:?}");
    assert!(!alarms[0].starts_with("MOTN"), "{alarms:?}");
}

#[tokio::test]
async fn a_speed_of_nothing_is_refused_and_the_smallest_speed_takes_its_time() {
    for speed in ["0", "-1", "-0.0", "2001", "3.0E38"] {
        let alarms = alarms_of(&format!("$SPEED = {speed} ; MOVE TO p")).await;
        assert_eq!(alarms.len(), 1, "{speed}: {alarms:?}");
        assert!(alarms[0].starts_with("VARS-032"), "{alarms:?}");
    }
    let cell = Stepped::start(&program("$SPEED = 1.0E-37 ; MOVE TO p"));
    cell.advance(1.0e9).await;
    let state = cell.controller.state().await.unwrap();
    assert!(state.moving && state.tasks[0].state == TaskWord::Waiting);
    let ledger = cell.controller.ledger().await.unwrap();
    assert!(ledger[0].duration_s.unwrap().is_finite(), "{ledger:?}");
}

#[tokio::test]
async fn a_speed_without_a_value_is_an_alarm_and_no_motion() {
    let alarms = alarms_of("SET_VAR(n, '*SYSTEM*', '$SPEED', r, s) ; MOVE TO p").await;
    assert_eq!(alarms.len(), 1, "{alarms:?}");
    assert!(alarms[0].contains("$SPEED has no value"), "{alarms:?}");
}

#[tokio::test]
async fn an_override_of_zero_holds_the_arm_until_it_is_raised() {
    let cell = Stepped::start(&program(
        "$MCR.$GENOVERRIDE = 0 ; $SPEED = 500 ; MOVE TO p NOWAIT
DELAY 86400000
$MCR.$GENOVERRIDE = 50
DELAY 200
$MCR.$GENOVERRIDE = 0
DELAY 86400000
$MCR.$GENOVERRIDE = 100",
    ));
    cell.advance(86_000.0).await;
    let held = cell.controller.state().await.unwrap();
    cell.advance(300.0).await;
    let state = cell.controller.state().await.unwrap();
    assert_eq!(state.joints_deg, held.joints_deg, "it does not creep");
    let started = &cell.controller.ledger().await.unwrap()[0];
    assert_eq!(
        (started.event, started.duration_s),
        (LedgerEvent::Started, None),
        "nobody knows how long it takes"
    );
    cell.advance(101.0).await;
    let held = cell.controller.state().await.unwrap();
    assert!(held.moving && held.joints_deg != state.joints_deg);
    cell.advance(86_000.0).await;
    let state = cell.controller.state().await.unwrap();
    assert_eq!(state.joints_deg, held.joints_deg);
    cell.advance(1000.0).await;
    let ledger = cell.controller.ledger().await.unwrap();
    assert_eq!(ledger.last().unwrap().event, LedgerEvent::Finished);
    assert_eq!(ledger.len(), 2);
}

#[tokio::test]
async fn an_arm_that_is_held_by_its_override_can_be_aborted() {
    let cell = Stepped::start(&program("$MCR.$GENOVERRIDE = 0 ; MOVE TO p"));
    cell.advance(10.0).await;
    cell.controller.abort_all().await.unwrap();
    cell.advance(1.0).await;
    let state = cell.controller.state().await.unwrap();
    assert!(!state.moving);
    let events = cell.events().await;
    assert_eq!(events.last(), Some(&(1, LedgerEvent::Cancelled)));
}

#[tokio::test]
async fn a_wrong_value_for_a_system_variable_is_a_status() {
    let lines = screen_of(
        "SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', 'x', s) ; WRITE (s, CR)
SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', 1.5, s) ; WRITE (s, CR)
SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', 70000, s) ; WRITE (s, CR)
SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[99].$SERVER_PORT', 1, s) ; WRITE (s, CR)
SET_VAR(n, '*SYSTEM*', '$NO[1].$SUCH', 1, s) ; WRITE (s, CR)
SET_VAR(n, '*SYSTEM*', '[[[', 1, s) ; WRITE (s, CR)
SET_VAR(n, 'NO_PROGRAM', 'x', 1, s) ; WRITE (s, CR)",
    )
    .await;
    assert_eq!(lines.len(), 7);
    assert!(lines.iter().all(|line| line.trim() != "0"), "{lines:?}");
}

#[tokio::test]
async fn a_string_is_cut_and_a_delay_is_checked() {
    assert_eq!(
        screen_of("t = '1234567890' + '1234567890' ; WRITE (t, CR)").await,
        ["12345"]
    );
    let alarms = alarms_of("DELAY -1").await;
    assert!(alarms[0].contains("DELAY of -1 ms"), "{alarms:?}");
    let alarms = alarms_of("DELAY -2147483647 - 1").await;
    assert_eq!(alarms.len(), 1, "{alarms:?}");
    let cell = Stepped::start(&program("DELAY 2147483647 ; WRITE ('over', CR)"));
    cell.advance(2_147_483.0).await;
    assert!(cell.controller.screen().await.unwrap().is_empty());
    cell.advance(1.0).await;
    assert_eq!(cell.controller.screen().await.unwrap(), ["over"]);
}

#[tokio::test]
async fn however_a_program_ends_the_controller_answers_and_the_client_learns_by_abort() {
    for (end, word) in [
        ("", TaskWord::Ended),
        ("ABORT", TaskWord::Ended),
        ("n = 0 ; s = 1 DIV n", TaskWord::Aborted),
    ] {
        let statements = format!("meet_client ; $SPEED = 20 ; MOVE TO p NOWAIT\nREAD f (n)\n{end}");
        let cell = Stepped::start(&program(&statements));
        let mut client = TcpStream::connect(cell.address().await).await.unwrap();
        client.write_all(b"5 ").await.unwrap();
        wait_until(&cell.controller, |state| state.tasks[0].state == word).await;
        cell.advance(3600.0).await;
        let state = cell.controller.state().await.unwrap();
        assert!(!state.moving, "{end}: the arm has come to rest");
        let last = *cell.events().await.last().unwrap();
        let expected = match word {
            TaskWord::Aborted => LedgerEvent::Cancelled,
            TaskWord::Ended | TaskWord::Running | TaskWord::Waiting => LedgerEvent::Finished,
        };
        assert_eq!(last, (1, expected), "{end}");
        cell.controller.abort_all().await.unwrap();
        assert_eq!(read_to_end(&mut client).await, "");
    }
}

#[tokio::test]
async fn time_can_leap_to_its_end() {
    let cell = Stepped::start(&sock_server());
    let address = cell.address().await;
    for leap in [Duration::from_hours(24 * 365), Duration::MAX, Duration::MAX] {
        let _now = within(cell.stepper.advance(leap)).await.unwrap();
        assert_eq!(call(address, b"x x x x x x x x ").await, INCORRECT);
    }
    let cell = Stepped::start(&program("meet_client ; DELAY 1000 ; MOVE TO p ; DELAY 1"));
    let _now = within(cell.stepper.advance(Duration::MAX)).await.unwrap();
    let _client = TcpStream::connect(cell.address().await).await.unwrap();
    cell.advance(1.0).await;
    assert!(within(cell.controller.state()).await.is_ok());
}

#[tokio::test]
async fn a_clock_that_runs_a_thousand_times_faster_than_a_busy_program_can_still_answers() {
    let mut config = program("n = 0 ; WHILE TRUE DO\nn = 1 - n\nENDWHILE");
    config.panel = Some(([127, 0, 0, 1], 0).into());
    let clock = Clock::scaled(1000.0).unwrap();
    let controller = VirtualController::start(&config, clock, PeerLabels::new()).unwrap();
    let panel = controller.panel_address().unwrap();
    for _ in 0..5 {
        let answer = http_get(panel, "/state", "localhost").await;
        assert!(answer.contains("\"running\""), "{answer}");
    }
    within(controller.abort_all()).await.unwrap();
    within(controller.shutdown()).await;
}

/// Covers: K6.
#[test]
fn a_program_that_writes_for_ever_to_the_screen_keeps_its_last_lines_only() {
    let program = "PROGRAM chatter
VAR n : INTEGER
BEGIN
  n = 0
  WHILE TRUE DO
    WRITE ('line', n, CR)
    WRITE ('xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx')
    n = n + 1
  ENDWHILE
END chatter
";
    let mut core = karel_emulator::Controller::try_new(&config_of(program, &[])).unwrap();
    core.advance_fully(Duration::from_secs(2));
    let screen = core.screen();
    assert!(screen.len() <= 20, "{} lines", screen.len());
    assert!(screen.iter().all(|line| line.chars().count() <= 80));
    assert!(core.ledger(0).is_empty() && core.alarms().is_empty());
}

/// As on the real controller: nobody else is served while the first client says nothing, and nothing gives it up.
///
/// Covers: K1.
#[tokio::test]
async fn a_silent_client_blocks_the_server_and_the_state_view_says_so() {
    let cell = Stepped::start(&sock_server());
    let address = cell.address().await;
    let mut silent = TcpStream::connect(address).await.unwrap();
    let mut second = TcpStream::connect(address).await.unwrap();
    second.write_all(LINE).await.unwrap();
    wait_until(&cell.controller, |state| {
        state.tags.iter().any(|tag| tag.state == "connected")
    })
    .await;
    cell.advance(36_000.0).await;
    let state = cell.controller.state().await.unwrap();
    let task = state.tasks.first().unwrap();
    assert_eq!(task.state, TaskWord::Waiting);
    let detail = task.detail.as_deref().unwrap();
    assert!(detail.contains("waits for bytes"), "{detail}");
    let tag = state.tags.first().unwrap();
    assert_eq!((tag.tag.as_str(), tag.state.as_str()), ("S3:", "connected"));
    assert_eq!(tag.peer, Some(silent.local_addr().unwrap()));
    assert!(cell.controller.ledger().await.unwrap().is_empty());
    // It speaks at last, and then the second one has its turn.
    silent.write_all(LINE).await.unwrap();
    for client in [&mut silent, &mut second] {
        let mut reply = String::new();
        let _length = within(client.read_to_string(&mut reply)).await.unwrap();
        assert_eq!(reply, common::ACCEPTED);
    }
}
