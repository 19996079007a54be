//! What goes wrong on the command port.

use std::time::Duration;

use api::{LinkState, Outcome, ProblemCode};
use protocol::v2::{ErrorCode, MotionNumber, Reply};
use tokio::time::Instant;

use super::fake::Event;
use super::harness::{Harness, arrived, output, to, to_joints};
use super::serve::Fault;
use crate::link::cell_server::{LinkError, MotionEnd, Rejection};

#[tokio::test(start_paused = true)]
async fn a_motion_is_told_step_by_step_and_arrives() {
    let cell = Harness::start().await;
    for command in [to(100.0), to_joints(30.0)] {
        let (motion, number) = cell.submit(command);
        let end = cell.end(motion).await;
        assert!(arrived(&end), "{end:?}");
        let steps = ["dispatched", "accepted", "executing", "ended"];
        assert_eq!(cell.steps(motion), steps);
        assert_eq!(number.epoch, 7_000);
    }
    let end = cell.carry_out(output(1, true)).await;
    assert!(arrived(&end), "{end:?}");
    assert!(cell.link.view().status.unwrap().line.output(1));
    cell.judge();
}

#[tokio::test(start_paused = true)]
async fn motions_follow_one_another_in_order() {
    let cell = Harness::start().await;
    let motions: Vec<_> = (1..=4).map(|x| cell.submit(to(f64::from(x)))).collect();
    for (motion, _) in &motions {
        assert!(arrived(&*cell.end(*motion).await));
    }
    let started: Vec<_> = cell
        .fake
        .ledger()
        .into_iter()
        .filter(|event| matches!(event, Event::Started(_)))
        .collect();
    let expected: Vec<_> = motions
        .iter()
        .map(|(_, number)| Event::Started(*number))
        .collect();
    assert_eq!(started, expected);
}

/// Covers: W2.
#[tokio::test(start_paused = true)]
async fn a_connection_lost_before_the_command_is_written_proves_that_it_was_not_sent() {
    let faults = [
        Fault::DropBeforeGreeting,
        Fault::NoGreeting,
        Fault::CorruptGreeting,
        Fault::DropAfterGreeting,
    ];
    for fault in faults {
        let cell = Harness::start().await;
        cell.fake.then(fault);
        let end = cell.carry_out(to(100.0)).await;
        let MotionEnd::NotSent { error } = &*end else {
            panic!("{fault:?}: {end:?}");
        };
        assert_eq!(error.outcome(), Outcome::NotSent);
        assert!(
            !cell
                .fake
                .ledger()
                .iter()
                .any(|event| matches!(event, Event::Received(_)))
        );
        assert!(arrived(&*cell.carry_out(to(50.0)).await), "{fault:?}");
    }
}

/// Covers: W1.
#[tokio::test(start_paused = true)]
async fn a_refused_connection_is_tried_again_until_there_is_no_time_left() {
    let cell = Harness::start().await;
    cell.fake.then(Fault::Refused);
    cell.fake.then(Fault::Refused);
    assert!(arrived(&*cell.carry_out(to(100.0)).await));
    for _ in 0..100 {
        cell.fake.then(Fault::Refused);
    }
    let began = Instant::now();
    let end = cell.carry_out(to(50.0)).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::Connect { .. }
            }
        ),
        "{end:?}"
    );
    assert!(began.elapsed() <= Duration::from_millis(1_001));
}

/// Covers: W5, N2.
#[tokio::test(start_paused = true)]
async fn a_lost_reply_is_no_failure_of_the_motion_the_status_port_tells() {
    let faults = [
        Fault::DropAfterAccept,
        Fault::CorruptAck,
        Fault::SilentAfterAccept,
        Fault::DropAfterAck,
        Fault::SilentAfterAck,
        Fault::CorruptDone,
    ];
    for fault in faults {
        let cell = Harness::start().await;
        cell.fake.then(fault);
        let end = cell.carry_out(to(100.0)).await;
        assert!(arrived(&end), "{fault:?}: {end:?}");
        assert!(arrived(&*cell.carry_out(to(50.0)).await), "{fault:?}");
    }
}

/// Covers: W5.
#[tokio::test(start_paused = true)]
async fn a_command_that_was_written_and_not_taken_is_fenced_and_then_proven_not_executed() {
    for fault in [
        Fault::DropAfterRead,
        Fault::LateRead(Duration::from_secs(3)),
    ] {
        let cell = Harness::start().await;
        cell.fake.then(fault);
        let (motion, number) = cell.submit(to(100.0));
        let end = cell.end(motion).await;
        cell.judge();
        assert!(
            matches!(
                &*end,
                MotionEnd::NotSent {
                    error: LinkError::NotTaken { .. }
                }
            ),
            "{fault:?}: {end:?}"
        );
        let fence = cell.link.view().wire_epoch.unwrap();
        assert!(fence > number.epoch, "fenced with {fence}");
        // The port is free again once the late reader has gone.
        tokio::time::sleep(Duration::from_secs(3)).await;
        assert!(arrived(&*cell.carry_out(to(50.0)).await), "{fault:?}");
    }
}

#[tokio::test(start_paused = true)]
async fn a_greeting_that_comes_too_late_ends_in_the_deadline_and_nothing_is_sent() {
    let cell = Harness::start().await;
    cell.fake
        .then(Fault::LateGreeting(Duration::from_millis(800)));
    let (motion, number) = cell.submit_until(to(100.0), Duration::from_millis(500));
    let began = Instant::now();
    let end = cell.end(motion).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::DeadlinePassed
            }
        ),
        "{end:?}"
    );
    assert!(began.elapsed() <= Duration::from_millis(501));
    assert_eq!(cell.fake.brain().count(Event::Received(number)), 0);
}

#[tokio::test(start_paused = true)]
async fn an_order_whose_turn_comes_too_late_is_not_sent() {
    let cell = Harness::start().await;
    let (first, _) = cell.submit(to(100.0));
    let (second, number) = cell.submit_until(to(50.0), Duration::from_millis(300));
    assert!(arrived(&*cell.end(first).await));
    let end = cell.end(second).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::DeadlinePassed
            }
        ),
        "{end:?}"
    );
    assert_eq!(cell.steps(second), ["ended"]);
    assert_eq!(cell.fake.brain().count(Event::Received(number)), 0);
}

/// Covers: W6.
#[tokio::test(start_paused = true)]
async fn every_refusal_of_the_controller_is_a_rejection_with_its_words() {
    let other = MotionNumber { epoch: 1, seq: 1 };
    // A nonce that ran out is none of the motion's: see `a_nonce_that_ran_out_without_a_stop_...`.
    let mut answers: Vec<_> = ErrorCode::ALL
        .into_iter()
        .filter(|code| *code != ErrorCode::Nonce)
        .map(|code| (Reply::Err(code), Rejection::Error(code)))
        .collect();
    answers.push((
        Reply::Stale { epoch_max: 9_000 },
        Rejection::Stale { epoch_max: 9_000 },
    ));
    answers.push((Reply::Busy(other), Rejection::Busy(other)));
    let cell = Harness::start().await;
    for (reply, expected) in answers {
        cell.fake.then(Fault::Answer(reply));
        let end = cell.carry_out(to(100.0)).await;
        let MotionEnd::Rejected { code, text } = &*end else {
            panic!("{reply:?}: {end:?}");
        };
        assert_eq!(*code, expected);
        assert!(!text.is_empty());
    }
    assert!(arrived(&*cell.carry_out(to(50.0)).await));
}

/// Covers: W7, C11.
#[tokio::test(start_paused = true)]
async fn a_number_the_controller_has_had_before_is_in_doubt_and_another_ones_answer_is_none() {
    let cell = Harness::start().await;
    let next = |seq| MotionNumber { epoch: 7_000, seq };
    cell.fake.then(Fault::Answer(Reply::Dup {
        number: next(1),
        finished: true,
    }));
    let end = cell.carry_out(to(100.0)).await;
    let MotionEnd::InDoubt { error, .. } = &*end else {
        panic!("{end:?}");
    };
    assert_eq!(error.code(), ProblemCode::MotionOvertaken);

    // An acceptance of another number says nothing of this one: fenced, and proven not taken.
    cell.fake.then(Fault::Answer(Reply::Ack(next(9))));
    let end = cell.carry_out(to(100.0)).await;
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

/// Covers: W11.
#[tokio::test(start_paused = true)]
async fn a_motion_that_ends_beside_its_target_is_in_doubt() {
    let cell = Harness::start().await;
    cell.fake.brain().miss = 0.49;
    assert!(arrived(&*cell.carry_out(to(100.0)).await));
    cell.fake.brain().miss = 0.51;
    let end = cell.carry_out(to(50.0)).await;
    let MotionEnd::InDoubt { error, status } = &*end else {
        panic!("{end:?}");
    };
    assert!(
        matches!(error, LinkError::PoseMismatch { apart_mm, .. } if (*apart_mm - 0.51).abs() < 1e-9),
        "{error:?}"
    );
    assert!(status.is_some());
}

/// Covers: W9.
#[tokio::test(start_paused = true)]
async fn a_motion_that_is_accepted_and_never_begins_is_in_doubt_after_two_seconds() {
    let cell = Harness::start().await;
    cell.fake.brain().stuck = true;
    let began = Instant::now();
    let end = cell.carry_out(to(100.0)).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::InDoubt {
                error: LinkError::Unfinished,
                ..
            }
        ),
        "{end:?}"
    );
    let took = began.elapsed().as_millis();
    assert!((2_000..=2_500).contains(&took), "{took} ms");
}

/// Covers: R3.
#[tokio::test(start_paused = true)]
async fn a_full_queue_turns_away_at_once() {
    let cell = Harness::start().await;
    let (first, _) = cell.submit(to(100.0));
    cell.until_step(first, "dispatched").await;
    for x in 0..4 {
        let _queued = cell.submit(to(f64::from(x)));
    }
    let turned = cell.try_submit(to(9.0), Duration::from_secs(5));
    assert_eq!(turned.unwrap_err(), crate::link::Turned::Busy);
    assert_eq!(cell.link.view().state, LinkState::Control);
}
