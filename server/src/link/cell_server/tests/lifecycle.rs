//! Starts and stops of the server, other servers, and what is found out about what an earlier start has sent.

use std::time::Duration;

use api::LinkState;
use protocol::v2::{FinishStatus, MotionNumber};
use tokio::time::{Instant, sleep};

use super::fake::Event;
use super::harness::{BASE, Harness, arrived, to};
use super::serve::{Fake, Fault, Status};
use crate::link::cell_server::{ControllerView, LinkError, MotionEnd, NotReady, Open};

fn open(number: MotionNumber, x: f64) -> Open {
    Open {
        number,
        boot: Some(1),
        accepted: false,
        command: to(x).into(),
    }
}

/// A server that ends the hard way: its connections go, its tasks with them.
async fn kill(cell: Harness) -> Fake {
    let fake = cell.fake.clone();
    let tracker = cell.tracker.clone();
    fake.set_status(Status::Refused);
    fake.cut();
    cell.stop.cancel();
    let _closed = tracker.close();
    tracker.wait().await;
    fake.set_status(Status::Well);
    fake
}

#[tokio::test(start_paused = true)]
async fn a_start_finds_out_what_became_of_a_motion_of_the_start_before() {
    // Sent, and the server dies before it hears anything; the arm needs longer than the next start.
    for (duration, arrives) in [(1_500, true), (10_000, false)] {
        let cell = Harness::start().await;
        cell.fake.brain().duration = Duration::from_millis(duration);
        let (motion, number) = cell.submit(to(100.0));
        cell.until_step(motion, "accepted").await;
        let fake = kill(cell).await;
        let next = Harness::on(&fake, BASE + 1);
        next.until_state(LinkState::Control).await;
        let end = next.link.reconcile(open(number, 100.0)).await.unwrap();
        match end {
            MotionEnd::Arrived { .. } => assert!(arrives),
            // Three seconds without a heartbeat: that is how long a stopping server parts.
            MotionEnd::Interrupted { fin_status, .. } => {
                assert!(!arrives);
                assert_eq!(fin_status, FinishStatus::DeadMan);
            }
            other @ (MotionEnd::Rejected { .. }
            | MotionEnd::NotSent { .. }
            | MotionEnd::InDoubt { .. }) => panic!("{duration} ms: {other:?}"),
        }
        assert_eq!(fake.brain().count(Event::Started(number)), 1);
    }
}

/// Covers: P8.
#[tokio::test(start_paused = true)]
async fn a_start_waits_for_a_motion_that_still_runs() {
    let cell = Harness::start().await;
    cell.fake.brain().duration = Duration::from_secs(4);
    let (motion, number) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    // Another start takes over while the first still lives.
    let next = Harness::on(&cell.fake, BASE + 1);
    next.until("it is connected", ControllerView::is_connected)
        .await;
    assert!(matches!(
        next.link.view().not_ready,
        Some(NotReady::MovedByOthers)
    ));
    let end = next.link.reconcile(open(number, 100.0)).await.unwrap();
    assert!(arrived(&end), "{end:?}");
    assert!(arrived(&*cell.end(motion).await));
}

/// Covers: P4.
#[tokio::test(start_paused = true)]
async fn a_motion_that_never_got_there_is_proven_not_executed() {
    let cell = Harness::start().await;
    let number = MotionNumber {
        epoch: 6_003,
        seq: 2,
    };
    let end = cell.link.reconcile(open(number, 100.0)).await.unwrap();
    assert!(
        matches!(
            end,
            MotionEnd::NotSent {
                error: LinkError::NotTaken { .. }
            }
        ),
        "{end:?}"
    );
    // One that is said to have been accepted then is not.
    let accepted = Open {
        accepted: true,
        ..open(number, 100.0)
    };
    let end = cell.link.reconcile(accepted).await.unwrap();
    assert!(matches!(end, MotionEnd::InDoubt { .. }), "{end:?}");
}

#[tokio::test(start_paused = true)]
async fn a_motion_of_this_epoch_is_fenced_before_it_is_judged() {
    let cell = Harness::start().await;
    let number = MotionNumber {
        epoch: 7_000,
        seq: 5,
    };
    let end = cell.link.reconcile(open(number, 100.0)).await.unwrap();
    assert!(matches!(end, MotionEnd::NotSent { .. }), "{end:?}");
    assert_eq!(cell.link.view().wire_epoch, Some(7_001));
}

#[tokio::test(start_paused = true)]
async fn an_old_server_that_wakes_up_moves_nothing_and_says_why() {
    let old = Harness::start().await;
    let new = Harness::on(&old.fake, BASE + 1);
    new.until_state(LinkState::Control).await;
    old.until_state(LinkState::Monitor).await;
    let superseded = NotReady::Superseded {
        epoch_max: 8_000,
        ours: 7_000,
    };
    assert_eq!(old.link.view().not_ready, Some(superseded));
    let end = old.carry_out(to(100.0)).await;
    assert!(matches!(&*end, MotionEnd::NotSent { .. }), "{end:?}");
    assert!(arrived(&*new.carry_out(to(50.0)).await));
    old.judge();
}

/// Covers: W8.
#[tokio::test(start_paused = true)]
async fn an_old_server_whose_command_comes_late_is_told_so_by_the_controller() {
    let old = Harness::start().await;
    old.fake.then(Fault::LateRead(Duration::from_millis(200)));
    let (motion, number) = old.submit(to(100.0));
    old.until_step(motion, "dispatched").await;
    sleep(Duration::from_millis(50)).await;
    let new = Harness::on(&old.fake, BASE + 1);
    let end = old.end(motion).await;
    // The new server's fence has killed the nonce: that is proof enough that nothing happened.
    let late = LinkError::GreetingTooOld;
    assert!(
        matches!(&*end, MotionEnd::NotSent { error } if error.code() == late.code()),
        "{end:?}"
    );
    assert_eq!(old.fake.brain().count(Event::Started(number)), 0);
    new.until_state(LinkState::Control).await;
    // Sent again, it is refused for its epoch, or not sent at all.
    let end = old.carry_out(to(100.0)).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent { .. } | MotionEnd::Rejected { .. }
        ),
        "{end:?}"
    );
    assert_eq!(old.fake.brain().count(Event::Started(number)), 0);
}

#[tokio::test(start_paused = true)]
async fn a_server_that_stops_ends_what_waits_and_leaves_what_moves_to_the_next_start() {
    let cell = Harness::start().await;
    cell.fake.brain().duration = Duration::from_mins(1);
    let (moving, _) = cell.submit(to(100.0));
    let (queued, number) = cell.submit_until(to(50.0), Duration::from_mins(1));
    cell.until_step(moving, "executing").await;
    let began = Instant::now();
    cell.stop.cancel();
    let _closed = cell.tracker.close();
    cell.tracker.wait().await;
    assert!(began.elapsed() <= Duration::from_millis(3_100));
    assert!(cell.heard_no_end(moving));
    let end = cell.end(queued).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::Stopping
            }
        ),
        "{end:?}"
    );
    assert_eq!(cell.fake.brain().count(Event::Received(number)), 0);
    assert!(!cell.link.is_running());
    assert!(cell.link.stop().await.is_err());
}

#[tokio::test(start_paused = true)]
async fn a_server_that_stops_waits_for_a_motion_that_is_about_to_arrive() {
    let cell = Harness::start().await;
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    cell.stop.cancel();
    assert!(arrived(&*cell.end(motion).await));
}

/// Covers: N7.
#[tokio::test(start_paused = true)]
async fn a_link_whose_generations_are_used_up_watches_on_and_moves_nothing() {
    let cell = Harness::start().await;
    for generation in 1..1_000 {
        let fenced = cell.link.fence().await.unwrap();
        assert_eq!(fenced.wire_epoch, 7_000 + generation);
    }
    assert!(arrived(&*cell.carry_out(to(100.0)).await));
    let error = cell.link.fence().await.unwrap_err();
    assert!(
        matches!(error, LinkError::GenerationsUsedUp { limit: 1_000 }),
        "{error:?}"
    );
    cell.until_state(LinkState::Monitor).await;
    let end = cell.carry_out(to(50.0)).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::NotReady(NotReady::GenerationsUsedUp { .. })
            }
        ),
        "{end:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn a_journal_epoch_beyond_the_wire_moves_nothing() {
    let cell = Harness::on(&Fake::new(), 2_147_483);
    cell.until_state(LinkState::Monitor).await;
    assert!(matches!(
        cell.link.view().not_ready,
        Some(NotReady::GenerationsUsedUp { .. })
    ));
}
