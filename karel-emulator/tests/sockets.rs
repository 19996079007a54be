//! Server tags as clients see them.

mod common;

use std::time::Duration;

use common::{
    ACCEPTED, INCORRECT, LINE, PORT, Stepped, call, config_of, read_to_end, sock_server,
    wait_until, within,
};
use karel_emulator::state::TaskWord;
use karel_emulator::{Clock, PeerLabels, SecondClient, StartError, VirtualController};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

#[tokio::test]
async fn a_second_client_waits_in_the_backlog_for_its_turn() {
    let cell = Stepped::start(&sock_server());
    let address = cell.address().await;
    let mut first = TcpStream::connect(address).await.unwrap();
    wait_until(&cell.controller, |state| state.tags[0].state == "connected").await;
    let mut second = TcpStream::connect(address).await.unwrap();
    second.write_all(LINE).await.unwrap();
    first.write_all(b"x x x x x x x x\n").await.unwrap();
    assert_eq!(read_to_end(&mut first).await, INCORRECT);
    assert_eq!(read_to_end(&mut second).await, ACCEPTED);
}

#[tokio::test]
async fn a_second_client_is_refused_where_the_controller_does_so() {
    let mut config = sock_server();
    config.second_client = SecondClient::Refuse;
    let cell = Stepped::start(&config);
    let address = cell.address().await;
    let mut first = TcpStream::connect(address).await.unwrap();
    wait_until(&cell.controller, |state| state.tags[0].state == "connected").await;
    assert!(TcpStream::connect(address).await.is_err());
    first.write_all(LINE).await.unwrap();
    assert_eq!(read_to_end(&mut first).await, ACCEPTED);
    wait_until(&cell.controller, |state| state.tags[0].state == "listening").await;
    assert_eq!(
        call(address, b"x\n x x x x x x x").await,
        INCORRECT,
        "the port is the same"
    );
}

#[tokio::test]
async fn nobody_can_connect_before_the_program_listens_or_after_it_ended() {
    let program = "PROGRAM quiet\nBEGIN\nDELAY 1000\nEND quiet\n";
    let config = config_of(program, &[]).with_port(PORT, 0);
    let cell = Stepped::start(&config);
    cell.advance(5.0).await;
    let state = cell.controller.state().await.unwrap();
    assert_eq!(state.tags, []);
}

#[tokio::test]
async fn a_reply_survives_bytes_that_the_program_did_not_read() {
    for _ in 0..20 {
        let cell = Stepped::start(&sock_server());
        let mut line = LINE.to_vec();
        line.extend(std::iter::repeat_n(b'7', 4096));
        assert_eq!(call(cell.address().await, &line).await, ACCEPTED);
    }
}

#[tokio::test]
async fn a_line_may_be_split_at_every_byte() {
    let cell = Stepped::start(&sock_server());
    let address = cell.address().await;
    for cut in 1..LINE.len() {
        let mut stream = TcpStream::connect(address).await.unwrap();
        stream.set_nodelay(true).unwrap();
        stream.write_all(&LINE[..cut]).await.unwrap();
        cell.advance(0.0).await;
        stream.write_all(&LINE[cut..]).await.unwrap();
        let mut reply = vec![0; ACCEPTED.len()];
        let _count = within(stream.read_exact(&mut reply)).await.unwrap();
        assert_eq!(reply, ACCEPTED.as_bytes(), "cut at {cut}");
        cell.until_standstill().await;
        assert_eq!(read_to_end(&mut stream).await, "");
    }
}

#[tokio::test]
async fn a_hundred_clients_reconnect_back_to_back() {
    for second_client in [SecondClient::Backlog, SecondClient::Refuse] {
        let mut config = sock_server();
        config.second_client = second_client;
        let cell = Stepped::start(&config);
        let address = cell.address().await;
        for _ in 0..100 {
            wait_until(&cell.controller, |state| state.tags[0].state == "listening").await;
            assert_eq!(call(address, b"x x x x x x x x\n").await, INCORRECT);
        }
    }
}

#[tokio::test]
async fn a_program_error_leaves_the_connection_open_and_silent() {
    let program = "PROGRAM fails
VAR f : FILE
    s : INTEGER
    n : INTEGER
BEGIN
  SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', 59002, s)
  MSG_CONNECT('S3:', s)
  OPEN FILE f('RW', 'S3:')
  READ f(n)
  s = n DIV 0
END fails
";
    let cell = Stepped::start(&config_of(program, &[PORT]));
    let mut stream = TcpStream::connect(cell.address().await).await.unwrap();
    stream.write_all(b"5 ").await.unwrap();
    wait_until(&cell.controller, |state| state.active_alarms == 1).await;
    cell.advance(60.0).await;
    let mut byte = [0];
    let silence = tokio::time::timeout(Duration::from_millis(50), stream.read(&mut byte)).await;
    assert!(silence.is_err(), "neither bytes nor an end: {silence:?}");
    let alarm = cell.controller.alarms().await.unwrap().remove(0);
    assert_eq!(
        (alarm.program.as_deref(), alarm.line),
        (Some("FAILS"), Some(10))
    );
    assert!(
        TcpStream::connect(cell.address().await).await.is_err(),
        "nobody listens any more"
    );
    cell.controller.abort_all().await.unwrap();
    assert_eq!(read_to_end(&mut stream).await, "", "ABORT ALL closes it");
}

#[tokio::test]
async fn an_undefined_tag_answers_with_an_error_and_costs_time() {
    let program = "PROGRAM nobody
VAR n, s : INTEGER
BEGIN
  n = 0
  WHILE n < 10 DO
    MSG_CONNECT('S9:', s)
    IF s <> 67144 THEN
      DELAY 1000000
    ENDIF
    n = n + 1
  ENDWHILE
END nobody
";
    let cell = Stepped::start(&config_of(program, &[]));
    cell.advance(0.009).await;
    assert_eq!(cell.task_word().await, TaskWord::Waiting);
    cell.advance(0.003).await;
    assert_eq!(cell.task_word().await, TaskWord::Ended);
}

#[tokio::test]
async fn a_mapped_port_that_is_taken_stops_the_start_and_names_the_port() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let config = sock_server().with_port(PORT, port);
    // A reserved port is taken at the latest when it is opened.
    let started = VirtualController::start(&config, Clock::real(), PeerLabels::new());
    match started {
        Err(error @ StartError::Port { .. }) => {
            assert!(error.to_string().contains(&port.to_string()), "{error}");
        }
        other => panic!("{other:?}"),
    }
}

#[tokio::test]
async fn a_port_that_is_taken_at_run_time_raises_one_alarm_that_names_it() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    let program = format!(
        "PROGRAM retries
VAR n, s : INTEGER
BEGIN
  SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', {port}, s)
  WHILE TRUE DO
    MSG_CONNECT('S3:', s)
  ENDWHILE
END retries
"
    );
    let cell = Stepped::start(&config_of(&program, &[]));
    cell.advance(1.0).await;
    let alarms = cell.controller.alarms().await.unwrap();
    assert_eq!(alarms.len(), 1, "{alarms:#?}");
    assert!(
        alarms[0].text.contains(&port.to_string()),
        "{}",
        alarms[0].text
    );
    drop(taken);
    cell.advance(0.01).await;
    let _client = TcpStream::connect(("127.0.0.1", port)).await.unwrap();
}

#[tokio::test]
async fn a_peer_that_sends_without_end_is_slowed_down_and_not_buffered() {
    let program = "PROGRAM deaf
VAR n, s : INTEGER
BEGIN
  SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', 59002, s)
  MSG_CONNECT('S3:', s)
  DELAY 100000000
END deaf
";
    let cell = Stepped::start(&config_of(program, &[PORT]));
    let mut stream = TcpStream::connect(cell.address().await).await.unwrap();
    let chunk = vec![b'x'; 1 << 16];
    let mut sent = 0_usize;
    // The kernel's own buffers take some megabytes; then nothing more goes.
    while let Ok(count) =
        tokio::time::timeout(Duration::from_millis(200), stream.write(&chunk)).await
    {
        sent += count.unwrap();
        assert!(sent < 1 << 28, "the controller swallows everything");
    }
    cell.advance(1.0).await;
}
