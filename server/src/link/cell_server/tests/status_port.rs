//! What goes wrong on the status port: the link's states, loss and return.

use std::time::Duration;

use api::{LinkState, ProblemCode};
use protocol::v2::FinishStatus;
use tokio::time::{Instant, sleep};

use super::fake::Event;
use super::harness::{BASE, Harness, arrived, to};
use super::serve::{Fake, Fault, Status};
use crate::link::cell_server::{LinkError, MotionEnd, NotReady, Phase};

#[tokio::test(start_paused = true)]
async fn a_controller_is_fenced_before_anything_else_with_the_journals_epoch() {
    let cell = Harness::start().await;
    assert_eq!(cell.fake.ledger(), [Event::Fenced(7_000)]);
    let view = cell.link.view();
    assert_eq!((view.wire_epoch, view.not_ready), (Some(7_000), None));
    assert_eq!(view.connections, 1);
}

/// Covers: N10.
#[tokio::test(start_paused = true)]
async fn it_is_polled_five_times_a_second() {
    let cell = Harness::start().await;
    let count = || cell.link.view().status.unwrap().count;
    let before = count();
    sleep(Duration::from_secs(10)).await;
    let polls = count() - before;
    assert!((48..=51).contains(&polls), "{polls} in ten seconds");
}

/// Covers: W12, N1.
#[tokio::test(start_paused = true)]
async fn a_silent_controller_is_declared_lost_within_a_second() {
    for status in [Status::Silent, Status::Deaf] {
        let cell = Harness::start().await;
        sleep(Duration::from_millis(1_234)).await;
        cell.fake.set_status(status);
        let began = Instant::now();
        cell.until_state(LinkState::Degraded).await;
        cell.until_state(LinkState::Disconnected).await;
        let took = began.elapsed();
        assert!(took <= Duration::from_secs(1), "{status:?}: {took:?}");
        let (code, text) = cell.link.view().failure.unwrap();
        assert_eq!(code, ProblemCode::ControllerDisconnected);
        assert!(text.contains("no answer"), "{text}");
        cell.fake.set_status(Status::Well);
        cell.until_state(LinkState::Control).await;
    }
}

/// Covers: N3.
#[tokio::test(start_paused = true)]
async fn late_answers_degrade_the_link_and_timely_ones_mend_it() {
    let cell = Harness::start().await;
    cell.fake
        .set_status(Status::Late(Duration::from_millis(400)));
    cell.until_state(LinkState::Degraded).await;
    assert!(arrived(&*cell.carry_out(to(100.0)).await));
    assert_eq!(cell.link.view().connections, 1);
    cell.fake.set_status(Status::Well);
    cell.until_state(LinkState::Control).await;
    assert_eq!(cell.link.view().connections, 1);
}

/// Covers: W1, C6.
#[tokio::test(start_paused = true)]
async fn a_controller_that_cannot_be_reached_is_knocked_at_less_and_less_often() {
    for (status, each) in [(Status::Refused, 0.0), (Status::BlackHole, 1.0)] {
        let fake = Fake::new();
        fake.set_status(status);
        let cell = Harness::on(&fake, BASE);
        sleep(Duration::from_mins(1)).await;
        let attempts = fake.attempts();
        assert!(
            (8..=16).contains(&attempts.len()),
            "{} attempts",
            attempts.len()
        );
        let pauses = attempts
            .windows(2)
            .map(|pair| (pair[1] - pair[0]).as_secs_f64());
        for (pause, expected) in pauses.zip([0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 8.0]) {
            let share = (pause - each) / expected;
            assert!(
                (0.74..=1.26).contains(&share),
                "{pause} s, not about {expected} s"
            );
        }
        assert_eq!(cell.link.view().wire_epoch, None);
        fake.set_status(Status::Well);
        cell.until_state(LinkState::Control).await;
        assert!(arrived(&*cell.carry_out(to(10.0)).await));
    }
}

#[tokio::test(start_paused = true)]
async fn nothing_is_sent_while_the_status_port_is_away() {
    let cell = Harness::start().await;
    cell.fake.set_status(Status::Refused);
    cell.fake.cut();
    cell.until_state(LinkState::Disconnected).await;
    let end = cell.carry_out(to(100.0)).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::NotReady(NotReady::Disconnected)
            }
        ),
        "{end:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn an_idle_link_that_comes_back_keeps_its_epoch_and_a_used_one_takes_the_next() {
    let cell = Harness::start().await;
    for connections in 2..=3 {
        cell.fake.cut();
        cell.until("it is back", |view| {
            view.connections == connections && view.is_connected()
        })
        .await;
        assert_eq!(cell.link.view().wire_epoch, Some(7_000));
    }
    assert!(arrived(&*cell.carry_out(to(10.0)).await));
    cell.fake.cut();
    cell.until("it is back", |view| {
        view.connections == 4 && view.is_connected()
    })
    .await;
    assert_eq!(cell.link.view().wire_epoch, Some(7_001));
}

/// Covers: N7.
#[tokio::test(start_paused = true)]
async fn what_was_queued_before_a_loss_is_not_sent_after_it() {
    let cell = Harness::start().await;
    let (first, _) = cell.submit(to(100.0));
    let (second, number) = cell.submit_until(to(50.0), Duration::from_secs(30));
    cell.until_step(first, "executing").await;
    cell.fake.cut();
    assert!(arrived(&*cell.end(first).await));
    let end = cell.end(second).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::WrongEpoch {
                    order: 7_000,
                    current: Some(7_001)
                }
            }
        ),
        "{end:?}"
    );
    assert_eq!(cell.fake.brain().count(Event::Received(number)), 0);
    cell.judge();
}

#[tokio::test(start_paused = true)]
async fn a_motion_goes_on_through_a_short_loss_and_is_found_arrived() {
    let cell = Harness::start().await;
    cell.fake.brain().duration = Duration::from_secs(3);
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    let phase = cell.link.view().in_flight.unwrap().phase;
    assert_eq!(phase, Phase::Executing);
    cell.fake.cut();
    cell.until_state(LinkState::Disconnected).await;
    assert!(arrived(&*cell.end(motion).await));
    cell.judge();
}

/// Covers: W10.
#[tokio::test(start_paused = true)]
async fn the_dead_man_stops_a_motion_that_is_watched_no_more_and_the_next_epoch_frees_the_arm() {
    let cell = Harness::start().await;
    cell.fake.brain().duration = Duration::from_secs(30);
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    cell.fake.set_status(Status::Silent);
    cell.until_state(LinkState::Disconnected).await;
    sleep(Duration::from_secs(3)).await;
    cell.fake.set_status(Status::Well);
    let end = cell.end(motion).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::Interrupted {
                fin_status: FinishStatus::DeadMan,
                ..
            }
        ),
        "{end:?}"
    );
    cell.until_state(LinkState::Control).await;
    assert_eq!(cell.link.view().wire_epoch, Some(7_001));
    cell.fake.brain().duration = Duration::from_millis(500);
    assert!(arrived(&*cell.carry_out(to(10.0)).await));
}

#[tokio::test(start_paused = true)]
async fn a_dead_man_found_on_a_living_connection_is_answered_with_the_next_generation() {
    let cell = Harness::start().await;
    assert!(arrived(&*cell.carry_out(to(10.0)).await));
    cell.fake.brain().latch_dead_man(7_000);
    cell.until("the next epoch", |view| view.wire_epoch == Some(7_001))
        .await;
    cell.until_state(LinkState::Control).await;
    assert!(arrived(&*cell.carry_out(to(20.0)).await));
}

/// Covers: N1.
#[tokio::test(start_paused = true)]
async fn a_controller_that_stays_away_leaves_the_motion_in_doubt_after_fifteen_seconds() {
    let cell = Harness::start().await;
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    cell.fake.set_status(Status::BlackHole);
    cell.fake.cut();
    cell.until_state(LinkState::Disconnected).await;
    let began = Instant::now();
    let end = cell.end(motion).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::InDoubt {
                error: LinkError::Lost { .. },
                status: None
            }
        ),
        "{end:?}"
    );
    let took = began.elapsed().as_millis();
    assert!((14_900..=15_100).contains(&took), "{took} ms");
}

/// Covers: C1.
#[tokio::test(start_paused = true)]
async fn a_controller_started_again_leaves_the_motion_in_doubt() {
    let cell = Harness::start().await;
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    cell.fake.lose_power();
    let end = cell.end(motion).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::InDoubt {
                error: LinkError::Restarted { was: 1, is: 2 },
                ..
            }
        ),
        "{end:?}"
    );
    cell.judge();
    cell.until_state(LinkState::Control).await;
    assert!(arrived(&*cell.carry_out(to(20.0)).await));
}

/// Covers: D5.
#[tokio::test(start_paused = true)]
async fn a_controller_that_lost_what_it_had_stored_leaves_an_accepted_motion_in_doubt() {
    let cell = Harness::start().await;
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    cell.fake.lose_power();
    cell.fake.brain().forget();
    let end = cell.end(motion).await;
    // It cannot be told from another controller, so nothing it says is taken for an answer, and nothing is sent to it.
    assert!(
        matches!(
            &*end,
            MotionEnd::InDoubt {
                error: LinkError::Lost { .. },
                ..
            }
        ),
        "{end:?}"
    );
    let why = cell.link.view().not_ready;
    assert!(
        matches!(why, Some(NotReady::OtherController { .. })),
        "{why:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn a_command_that_was_lost_with_the_power_before_it_was_taken_is_proven_not_executed() {
    let cell = Harness::start().await;
    cell.fake.then(Fault::LateRead(Duration::from_millis(400)));
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "dispatched").await;
    sleep(Duration::from_millis(100)).await;
    cell.fake.lose_power();
    let end = cell.end(motion).await;
    cell.judge();
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::NotTaken { .. }
            }
        ),
        "{end:?}"
    );
}

/// Covers: W4.
#[tokio::test(start_paused = true)]
async fn a_changed_byte_or_a_lost_line_costs_the_connection_and_nothing_else() {
    for fault in [Status::Corrupt, Status::Drop] {
        let cell = Harness::start().await;
        let (motion, _) = cell.submit(to(100.0));
        cell.until_step(motion, "executing").await;
        cell.fake.set_status(fault);
        cell.until_state(LinkState::Disconnected).await;
        assert!(arrived(&*cell.end(motion).await), "{fault:?}");
        cell.until_state(LinkState::Control).await;
        cell.judge();
    }
}

#[tokio::test(start_paused = true)]
async fn a_poll_the_controller_did_not_understand_is_asked_again() {
    let cell = Harness::start().await;
    let before = cell.link.view().status.unwrap().count;
    cell.fake.set_status(Status::Malformed);
    cell.until("the next line", |view| {
        view.status.unwrap().count > before + 1
    })
    .await;
    assert_eq!(cell.link.view().connections, 1);
}
