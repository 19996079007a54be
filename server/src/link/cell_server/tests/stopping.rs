//! Stop, hold, override and fence, and the conditions under which nothing is sent.

use std::time::Duration;

use api::{LinkState, ProblemCode, StopEffect};
use protocol::v2::{FinishStatus, OperatingMode, Percent};
use tokio::time::{Instant, sleep};

use super::fake::Event;
use super::harness::{BASE, Harness, arrived, section, to};
use super::serve::{Fake, Fault, Status};
use crate::config::RobotSection;
use crate::link::cell_server::{LinkError, MotionEnd, NotReady, Rejection};

#[tokio::test(start_paused = true)]
async fn a_stop_ends_the_moving_motion_and_what_waits_behind_it() {
    let cell = Harness::start().await;
    let (moving, _) = cell.submit(to(100.0));
    let (queued, number) = cell.submit(to(50.0));
    cell.until_step(moving, "executing").await;
    let began = Instant::now();
    let report = cell.link.stop().await.unwrap();
    assert!(began.elapsed() <= Duration::from_millis(1));
    assert_eq!(report.effect, StopEffect::HaltsMotion);
    let end = cell.end(moving).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::Interrupted {
                fin_status: FinishStatus::Stopped,
                ..
            }
        ),
        "{end:?}"
    );
    let end = cell.end(queued).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::StoppedBeforeSent
            }
        ),
        "{end:?}"
    );
    assert_eq!(cell.fake.brain().count(Event::Received(number)), 0);
    cell.judge();
    // A stop is no latch: what is asked for afterwards is a new decision.
    assert!(arrived(&*cell.carry_out(to(20.0)).await));
}

#[tokio::test(start_paused = true)]
async fn a_stop_ends_an_order_that_waits_for_the_greeting() {
    let cell = Harness::start().await;
    cell.fake.then(Fault::NoGreeting);
    let (motion, number) = cell.submit(to(100.0));
    cell.until_step(motion, "dispatched").await;
    sleep(Duration::from_millis(100)).await;
    let _report = cell.link.stop().await.unwrap();
    let end = cell.end(motion).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::StoppedBeforeSent
            }
        ),
        "{end:?}"
    );
    assert_eq!(cell.fake.brain().count(Event::Received(number)), 0);
}

#[tokio::test(start_paused = true)]
async fn a_stop_between_the_sending_and_the_reading_kills_the_nonce() {
    let cell = Harness::start().await;
    cell.fake.then(Fault::LateRead(Duration::from_millis(300)));
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "dispatched").await;
    sleep(Duration::from_millis(100)).await;
    let _report = cell.link.stop().await.unwrap();
    let end = cell.end(motion).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::Rejected {
                code: Rejection::Error(protocol::v2::ErrorCode::Nonce),
                ..
            }
        ),
        "{end:?}"
    );
    cell.judge();
}

#[tokio::test(start_paused = true)]
async fn a_nonce_that_ran_out_without_a_stop_says_nothing_about_the_motion() {
    let cell = Harness::start().await;
    cell.fake.then(Fault::LateRead(Duration::from_millis(600)));
    let (motion, _) = cell.submit(to(100.0));
    let end = cell.end(motion).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::GreetingTooOld
            }
        ),
        "{end:?}"
    );
    cell.judge();
}

#[tokio::test(start_paused = true)]
async fn a_stop_right_after_the_acceptance_ends_the_motion() {
    let cell = Harness::start().await;
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "accepted").await;
    let _report = cell.link.stop().await.unwrap();
    let end = cell.end(motion).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::Interrupted {
                fin_status: FinishStatus::Stopped,
                ..
            }
        ),
        "{end:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn a_stop_does_not_wait_behind_a_slow_answer() {
    let cell = Harness::start().await;
    cell.fake.brain().duration = Duration::from_secs(5);
    let (motion, number) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    cell.fake
        .set_status(Status::Late(Duration::from_millis(300)));
    cell.until_state(LinkState::Degraded).await;
    let report = cell.link.stop().await.unwrap();
    assert_eq!(report.status.finished, number);
    assert!(!arrived(&*cell.end(motion).await));
}

#[tokio::test(start_paused = true)]
async fn a_stop_that_cannot_be_delivered_says_what_it_does_all_the_same() {
    let cell = Harness::start().await;
    let (motion, _) = cell.submit(to(100.0));
    let (queued, number) = cell.submit_until(to(50.0), Duration::from_mins(1));
    cell.until_step(motion, "executing").await;
    cell.fake.set_status(Status::Refused);
    cell.fake.cut();
    cell.until_state(LinkState::Disconnected).await;
    let error = cell.link.stop().await.unwrap_err();
    assert_eq!(error.code(), ProblemCode::StopUnconfirmed);
    assert_eq!(error.stop_effect(), Some(StopEffect::IssuesNothingMore));
    let text = error.chain();
    assert!(
        text.contains("may run on") && text.contains("59003"),
        "{text}"
    );
    cell.fake.set_status(Status::Well);
    assert!(arrived(&*cell.end(motion).await));
    let end = cell.end(queued).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::StoppedBeforeSent
            }
        ),
        "{end:?}"
    );
    assert_eq!(cell.fake.brain().count(Event::Received(number)), 0);
}

#[tokio::test(start_paused = true)]
async fn a_stop_that_was_sent_and_not_confirmed_says_so_within_a_second() {
    let cell = Harness::start().await;
    cell.fake.brain().duration = Duration::from_secs(5);
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    cell.fake.set_status(Status::Deaf);
    let began = Instant::now();
    let error = cell.link.stop().await.unwrap_err();
    assert!(began.elapsed() <= Duration::from_secs(1));
    assert_eq!(error.stop_effect(), Some(StopEffect::HaltsMotion));
    cell.fake.set_status(Status::Well);
    let end = cell.end(motion).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::Interrupted {
                fin_status: FinishStatus::Stopped,
                ..
            }
        ),
        "{end:?}"
    );
}

/// Covers: C3.
#[tokio::test(start_paused = true)]
async fn a_motion_on_hold_is_waited_for_and_goes_on() {
    let cell = Harness::start().await;
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    let status = cell.link.hold().await.unwrap();
    assert!(status.held && !status.moving);
    sleep(Duration::from_mins(1)).await;
    assert!(cell.heard_no_end(motion));
    assert_eq!(cell.link.view().not_ready, Some(NotReady::Held));
    let status = cell.link.resume().await.unwrap();
    assert!(!status.held && status.moving);
    assert!(arrived(&*cell.end(motion).await));
}

#[tokio::test(start_paused = true)]
async fn the_override_is_set_and_shown() {
    let cell = Harness::start().await;
    let status = cell
        .link
        .set_override(Percent::try_new(35).unwrap())
        .await
        .unwrap();
    assert_eq!(status.speed_override, 35);
    assert_eq!(cell.link.view().status.unwrap().line.speed_override, 35);
}

#[tokio::test(start_paused = true)]
async fn nothing_numbered_before_a_fence_is_sent_after_it_and_what_runs_goes_on() {
    let cell = Harness::start().await;
    let (moving, _) = cell.submit(to(100.0));
    let (queued, number) = cell.submit(to(50.0));
    cell.until_step(moving, "executing").await;
    let fenced = cell.link.fence().await.unwrap();
    assert_eq!(fenced.wire_epoch, 7_001);
    assert!(fenced.status.moving);
    assert!(arrived(&*cell.end(moving).await));
    let end = cell.end(queued).await;
    assert!(
        matches!(
            &*end,
            MotionEnd::NotSent {
                error: LinkError::WrongEpoch { .. }
            }
        ),
        "{end:?}"
    );
    assert_eq!(cell.fake.brain().count(Event::Received(number)), 0);
    assert!(arrived(&*cell.carry_out(to(20.0)).await));
    cell.judge();
}

#[tokio::test(start_paused = true)]
async fn verbs_say_that_the_port_is_away_or_did_not_understand() {
    let cell = Harness::start().await;
    cell.until_idle().await;
    cell.fake.set_status(Status::Malformed);
    let error = cell.link.hold().await.unwrap_err();
    assert!(
        matches!(error, LinkError::NotUnderstood { verb: "hold" }),
        "{error:?}"
    );
    cell.fake.set_status(Status::Refused);
    cell.fake.cut();
    cell.until_state(LinkState::Disconnected).await;
    for error in [
        cell.link.hold().await.unwrap_err(),
        cell.link.resume().await.unwrap_err(),
        cell.link.fence().await.unwrap_err(),
    ] {
        assert!(matches!(error, LinkError::StatusDown { .. }), "{error:?}");
    }
}

/// Covers: C4, C8, C9.
#[tokio::test(start_paused = true)]
async fn nothing_is_sent_to_a_controller_that_is_not_ready_and_the_reason_is_given() {
    type Change = fn(&Fake);
    let cases: [(Change, Change, NotReady); 8] = [
        (
            |fake| fake.brain().status.pendant = true,
            |fake| fake.brain().status.pendant = false,
            NotReady::Pendant,
        ),
        (
            |fake| fake.brain().status.mode = OperatingMode::T1,
            |fake| fake.brain().status.mode = OperatingMode::Auto,
            NotReady::Mode(OperatingMode::T1),
        ),
        (
            |fake| fake.brain().alarm(11_050),
            |fake| fake.brain().status.alarm = 0,
            NotReady::Alarm(11_050),
        ),
        (
            |fake| fake.brain().status.held = true,
            |fake| fake.brain().status.held = false,
            NotReady::Held,
        ),
        (
            |fake| fake.brain().status.speed_override = 0,
            |fake| fake.brain().status.speed_override = 100,
            NotReady::OverrideZero,
        ),
        (
            |fake| fake.brain().status.user_frame = 3,
            |fake| fake.brain().status.user_frame = 0,
            NotReady::UserFrame {
                active: 3,
                expected: 0,
            },
        ),
        (
            |fake| fake.brain().status.tool = 2,
            |fake| fake.brain().status.tool = 1,
            NotReady::Tool {
                active: 2,
                expected: 1,
            },
        ),
        (
            |fake| fake.brain().status.moving = true,
            |fake| fake.brain().status.moving = false,
            NotReady::MovedByOthers,
        ),
    ];
    let section = RobotSection {
        user_frame_number: Some(0),
        tool_number: Some(1),
        ..section()
    };
    let cell = Harness::with(&Fake::new(), BASE, section);
    cell.until_state(LinkState::Control).await;
    for (break_it, mend_it, expected) in cases {
        break_it(&cell.fake);
        cell.until_state(LinkState::Monitor).await;
        let view = cell.link.view();
        assert_eq!(view.not_ready, Some(expected));
        let end = cell.carry_out(to(100.0)).await;
        let MotionEnd::NotSent { error } = &*end else {
            panic!("{expected:?}: {end:?}");
        };
        assert!(matches!(error, LinkError::NotReady(reason) if *reason == expected));
        assert_eq!(error.code(), ProblemCode::ControllerNotReady);
        mend_it(&cell.fake);
        cell.until_state(LinkState::Control).await;
    }
    assert!(
        !cell
            .fake
            .ledger()
            .iter()
            .any(|event| matches!(event, Event::Received(_)))
    );
    assert!(arrived(&*cell.carry_out(to(100.0)).await));
}

/// Covers: C5.
#[tokio::test(start_paused = true)]
async fn an_alarm_in_the_middle_interrupts_the_motion() {
    let cell = Harness::start().await;
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    cell.fake.brain().alarm(15_018);
    let end = cell.end(motion).await;
    let MotionEnd::Interrupted { fin_status, status } = &*end else {
        panic!("{end:?}");
    };
    assert_eq!((*fin_status, status.alarm), (FinishStatus::Alarm, 15_018));
    let reason = cell.link.view().not_ready.unwrap();
    assert_eq!(reason.to_string(), "the controller has alarm 15-018");
}
