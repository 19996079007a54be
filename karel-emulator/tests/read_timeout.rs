//! `ATR_TIMEOUT`: a silent client costs the program a little time and not the robot.

mod common;

use common::{PORT, Stepped, call, config_of, read_to_end, wait_until, within};
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;

const PROGRAM: &str = "PROGRAM t
VAR
  f : FILE
  s, n : INTEGER
BEGIN
  SET_VAR(n, '*SYSTEM*', '$HOSTS_CFG[3].$SERVER_PORT', 59002, s)
  SET_FILE_ATR(f, ATR_TIMEOUT, 500)
  WHILE TRUE DO
    MSG_DISCO('S3:', s)
    MSG_CONNECT('S3:', s)
    IF s = 0 THEN
      OPEN FILE f('RW', 'S3:')
      READ f(n)
      WRITE f(IO_STATUS(f))
      CLOSE FILE f
    ENDIF
  ENDWHILE
END t
";

/// Covers: K1.
#[tokio::test]
async fn a_silent_client_is_given_up_after_the_timeout_and_the_next_is_served() {
    let cell = Stepped::start(&config_of(PROGRAM, &[PORT]));
    let mut silent = within(TcpStream::connect(cell.address().await))
        .await
        .unwrap();
    silent.write_all(b"12").await.unwrap();
    wait_until(&cell.controller, |s| {
        s.tags.iter().any(|tag| tag.state == "connected")
    })
    .await;
    cell.advance(0.4).await;
    assert_eq!(
        cell.controller.state().await.unwrap().tags[0].state,
        "connected"
    );
    cell.advance(0.2).await;
    assert_eq!(read_to_end(&mut silent).await, " 12358");
    assert_eq!(call(cell.address().await, b"7\n").await, " 0");
}
