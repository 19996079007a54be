//! Power off and on.

mod common;

use common::{LINE, PORT, Stepped, call, config_of, sock_server, wait_until, within};
use karel_emulator::{CmosMemory, LedgerEvent};
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;

/// Answers each client with the number of the epoch and counts what it was sent.
const EPOCHS: &str = "PROGRAM epochs
VAR
  epoch IN CMOS : INTEGER
  calls : INTEGER
  f : FILE
  s, n : INTEGER
BEGIN
  IF UNINIT(epoch) THEN
    epoch = 0
  ENDIF
  epoch = epoch + 1
  IF UNINIT(calls) THEN
    calls = 0
  ENDIF
  SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', 59002, s)
  WHILE TRUE DO
    MSG_DISCO('S3:', s)
    MSG_CONNECT('S3:', s)
    IF s = 0 THEN
      OPEN FILE f('RW', 'S3:')
      READ f(n)
      calls = calls + 1
      WRITE f(epoch, calls)
      CLOSE FILE f
    ENDIF
  ENDWHILE
END epochs
";

#[tokio::test]
async fn a_counter_in_cmos_goes_on_after_a_power_cycle_and_others_start_again() {
    let cell = Stepped::start(&config_of(EPOCHS, &[PORT]));
    assert_eq!(call(cell.address().await, b"1\n").await, " 1 1");
    assert_eq!(call(cell.address().await, b"1\n").await, " 1 2");
    cell.controller.power_cycle(CmosMemory::Kept).await.unwrap();
    wait_until(&cell.controller, |s| {
        s.tags.iter().any(|tag| tag.state == "listening")
    })
    .await;
    assert_eq!(call(cell.address().await, b"1\n").await, " 2 1");
    cell.controller.power_cycle(CmosMemory::Lost).await.unwrap();
    wait_until(&cell.controller, |s| {
        s.tags.iter().any(|tag| tag.state == "listening")
    })
    .await;
    assert_eq!(call(cell.address().await, b"1\n").await, " 1 1");
    assert_eq!(cell.controller.state().await.unwrap().power_cycles, 2);
}

#[tokio::test]
async fn a_power_cycle_ends_connections_and_motions() {
    let cell = Stepped::start(&sock_server());
    let _reply = call(cell.address().await, LINE).await;
    cell.advance(0.3).await;
    let mut waiting = within(TcpStream::connect(cell.address().await))
        .await
        .unwrap();
    wait_until(&cell.controller, |s| {
        s.tags.iter().any(|tag| tag.state == "connected")
    })
    .await;
    cell.controller.power_cycle(CmosMemory::Kept).await.unwrap();
    let mut byte = [0];
    assert!(matches!(
        within(waiting.read(&mut byte)).await,
        Ok(0) | Err(_)
    ));
    cell.until_standstill().await;
    let events = cell.events().await;
    assert_eq!(
        events,
        [(1, LedgerEvent::Started), (1, LedgerEvent::Cancelled)]
    );
    let state = cell.controller.state().await.unwrap();
    assert_eq!(state.tasks.len(), 1);
    let alarms = cell.controller.alarms().await.unwrap();
    assert_eq!(
        alarms.last().unwrap().headline(),
        "SYST-026 System normal power up"
    );
    let reply = call(cell.address().await, LINE).await;
    assert_eq!(reply, common::ACCEPTED, "the program serves again");
}
