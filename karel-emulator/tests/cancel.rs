//! CANCEL: one task stops the arm that another moves.

mod common;

use common::{Stepped, config_of};
use karel_emulator::{LedgerEvent, ProgramSource};

const MOVER: &str = "PROGRAM mover
VAR p : XYZWPR
    s : INTEGER
BEGIN
  p = CURPOS(0, 0)
  p.z = p.z - 300
  $SPEED = 50
  RUN_TASK('stopper', 1, FALSE, FALSE, 0, s)
  MOVE TO p
  WRITE ('goes on')
END mover
";

#[tokio::test]
async fn assumed_a_cancelled_move_brakes_and_its_program_goes_on() {
    let stopper = "PROGRAM stopper\nBEGIN\nDELAY 1000\nCANCEL\nEND stopper\n";
    let config = config_of(MOVER, &[]).with_program(ProgramSource::new("stopper.kl", stopper));
    let cell = Stepped::start(&config);
    cell.advance(0.9).await;
    assert!(cell.controller.state().await.unwrap().moving);
    cell.advance(1.0).await;
    assert!(
        !cell.controller.state().await.unwrap().moving,
        "long before the target"
    );
    assert_eq!(cell.controller.screen().await.unwrap(), ["goes on"]);
    let events = cell.events().await;
    assert_eq!(
        events,
        [(1, LedgerEvent::Started), (1, LedgerEvent::Cancelled)]
    );
    let last = cell.controller.ledger().await.unwrap().pop().unwrap();
    assert_eq!(last.alarm.as_deref(), Some("CANCEL by task 2"));
}

/// Reported by users of the ROS-Industrial driver, whose relay cancels without holding the motion group.
#[tokio::test]
async fn a_cancel_without_control_of_the_group_reaches_no_motion() {
    let stopper = "PROGRAM stopper\n%NOLOCKGROUP\nBEGIN\nDELAY 1000\nCANCEL\nSTOP\nEND stopper\n";
    let config = config_of(MOVER, &[]).with_program(ProgramSource::new("stopper.kl", stopper));
    let cell = Stepped::start(&config);
    cell.until_standstill().await;
    let events = cell.events().await;
    assert_eq!(
        events,
        [(1, LedgerEvent::Started), (1, LedgerEvent::Finished)]
    );
}
