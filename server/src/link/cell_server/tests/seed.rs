//! Tier 1: the pose server's port, and the status beside it that knows no numbers.

use std::time::Duration;

use api::{LinkState, Tier};
use protocol::v2::{FinishStatus, MotionNumber};
use protocol::{MoveCommand, Reply};
use tokio::time::{Instant, sleep};
use units::{Degrees, Millimeters, MmPerSec};

use super::fake::{Event, x_of};
use super::harness::{BASE, Harness, arrived, section};
use super::serve::{Fake, Fault, Status};
use crate::config::RobotSection;
use crate::link::cell_server::{Instruction, LinkError, MotionEnd, Open};

const ONE: MotionNumber = MotionNumber { epoch: 0, seq: 0 };

fn to(x: f64) -> Instruction {
    let command = MoveCommand {
        x: Millimeters(900.0 + x),
        y: Millimeters(0.0),
        z: Millimeters(940.0),
        w: Degrees(-180.0),
        p: Degrees(0.0),
        r: Degrees(0.0),
        speed: MmPerSec(100.0),
    };
    Instruction::Seed(command.to_wire().unwrap())
}

async fn start() -> Harness {
    let section = RobotSection {
        tier: Tier::SeedStatus,
        ..section()
    };
    let harness = Harness::with(&Fake::seed(), BASE, section);
    harness.until_state(LinkState::Control).await;
    harness
}

fn started(cell: &Harness) -> usize {
    cell.fake.brain().count(Event::Started(ONE))
}

fn doubt(end: &MotionEnd) -> (&LinkError, f64) {
    let MotionEnd::InDoubt {
        error,
        status: Some(status),
    } = end
    else {
        panic!("no doubt: {end:?}");
    };
    (error, x_of(&status.pose))
}

#[tokio::test(start_paused = true)]
async fn an_answer_is_no_arrival_and_the_pose_is() {
    let cell = start().await;
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "accepted").await;
    assert!(cell.heard_no_end(motion));
    assert!(arrived(&*cell.end(motion).await));
    assert_eq!(
        cell.steps(motion),
        ["dispatched", "accepted", "executing", "ended"]
    );
    // To where it stands: nothing is to be seen moving.
    cell.fake.brain().duration = Duration::ZERO;
    assert!(arrived(&*cell.carry_out(to(100.0)).await));
    assert_eq!(started(&cell), 2);
}

#[tokio::test(start_paused = true)]
async fn w5_without_an_answer_the_pose_proves_an_arrival_and_nothing_proves_the_contrary() {
    for fault in [Fault::DropAfterAccept, Fault::SilentAfterAccept] {
        let cell = start().await;
        assert!(arrived(&*cell.carry_out(to(10.0)).await));
        cell.fake.then(fault);
        assert!(arrived(&*cell.carry_out(to(100.0)).await));
        assert_eq!(started(&cell), 2);
    }
    let cell = start().await;
    assert!(arrived(&*cell.carry_out(to(10.0)).await));
    cell.fake.then(Fault::DropAfterRead);
    let end = cell.carry_out(to(100.0)).await;
    let (error, x) = doubt(&end);
    assert!(
        matches!(
            error,
            LinkError::Unanswered {
                fenced: true,
                at_start: Some(true)
            }
        ),
        "{error:?}"
    );
    assert!((x - 10.0).abs() < 0.5);
    assert_eq!(started(&cell), 1);
}

/// W8: the command is read so late that waiting for its answer is over. The fence waits behind it.
#[tokio::test(start_paused = true)]
async fn w8_a_command_that_is_read_late_is_found_by_the_fence_behind_it() {
    let cell = start().await;
    assert!(arrived(&*cell.carry_out(to(10.0)).await));
    cell.fake
        .then(Fault::LateRead(Duration::from_millis(1_500)));
    assert!(arrived(&*cell.carry_out(to(100.0)).await));
    assert_eq!(started(&cell), 2);
}

#[tokio::test(start_paused = true)]
async fn w9_what_was_taken_and_never_begins_is_in_doubt_and_c3_not_while_it_is_held() {
    let cell = start().await;
    cell.fake.brain().stuck = true;
    let end = cell.carry_out(to(100.0)).await;
    assert!(matches!(doubt(&end).0, LinkError::NotBegun), "{end:?}");

    let cell = start().await;
    cell.fake.brain().duration = Duration::from_secs(5);
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    let held = protocol::v2::Verb::Hold;
    let _status = cell.fake.brain().obey(held);
    sleep(Duration::from_mins(1)).await;
    assert!(cell.heard_no_end(motion));
    cell.fake.brain().release();
    assert!(arrived(&*cell.end(motion).await));
}

#[tokio::test(start_paused = true)]
async fn c5_an_alarm_ends_the_motion_and_the_controller_is_told_to_drop_the_rest() {
    let cell = start().await;
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    cell.fake.brain().alarm(11_050);
    let end = cell.end(motion).await;
    assert!(
        matches!(&*end, MotionEnd::Interrupted { fin_status: FinishStatus::Alarm, status } if status.alarm == 11_050),
        "{end:?}"
    );
    assert_eq!(cell.fake.brain().count(Event::Stopped), 1);
}

#[tokio::test(start_paused = true)]
async fn a_stop_ends_what_moves_and_what_was_written_and_not_read_yet() {
    let cell = start().await;
    cell.fake.brain().duration = Duration::from_secs(5);
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    assert!(cell.link.stop().await.is_ok());
    let end = cell.end(motion).await;
    let stopped = |end: &MotionEnd| {
        matches!(
            end,
            MotionEnd::Interrupted {
                fin_status: FinishStatus::Stopped,
                ..
            }
        )
    };
    assert!(stopped(&end), "{end:?}");

    cell.fake.then(Fault::LateRead(Duration::from_millis(300)));
    let (motion, _) = cell.submit(to(200.0));
    cell.until_step(motion, "dispatched").await;
    sleep(Duration::from_millis(50)).await;
    assert!(cell.link.stop().await.is_ok());
    let end = cell.end(motion).await;
    assert!(stopped(&end), "{end:?}");
    let brain = cell.fake.brain();
    assert!(
        !brain.status.moving,
        "it was read after the stop, and stopped again"
    );
}

/// N2, N3: the status answers late, then not at all, then again.
#[tokio::test(start_paused = true)]
async fn n3_a_status_that_is_late_or_lost_for_a_while_ends_no_motion() {
    let cell = start().await;
    cell.fake.brain().duration = Duration::from_secs(5);
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    cell.fake
        .set_status(Status::Late(Duration::from_millis(400)));
    cell.until_state(LinkState::Degraded).await;
    cell.fake.set_status(Status::Refused);
    cell.fake.cut();
    cell.until_state(LinkState::Disconnected).await;
    sleep(Duration::from_secs(3)).await;
    assert!(cell.heard_no_end(motion));
    cell.fake.set_status(Status::Well);
    assert!(arrived(&*cell.end(motion).await));

    // For good: it cannot be known.
    let (motion, _) = {
        cell.until_state(LinkState::Control).await;
        cell.submit(to(0.0))
    };
    cell.until_step(motion, "executing").await;
    cell.fake.set_status(Status::Refused);
    cell.fake.cut();
    let since = Instant::now();
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
    assert!(since.elapsed() >= Duration::from_secs(15));
}

/// C1: the controller was started again; nothing can be said of the motion.
#[tokio::test(start_paused = true)]
async fn c1_a_power_loss_in_the_middle_is_a_doubt() {
    let cell = start().await;
    let (motion, _) = cell.submit(to(100.0));
    cell.until_step(motion, "executing").await;
    cell.fake.lose_power();
    let end = cell.end(motion).await;
    assert!(
        matches!(doubt(&end).0, LinkError::Restarted { was: 1, is: 2 }),
        "{end:?}"
    );
}

#[tokio::test(start_paused = true)]
async fn p8_after_a_restart_the_pose_tells_of_an_arrival_and_of_nothing_else() {
    let cell = start().await;
    assert!(arrived(&*cell.carry_out(to(100.0)).await));
    let open = |x| Open {
        number: MotionNumber { epoch: 1, seq: 1 },
        boot: Some(1),
        accepted: false,
        command: to(x),
    };
    assert!(arrived(&cell.link.reconcile(open(100.0)).await.unwrap()));
    let end = cell.link.reconcile(open(300.0)).await.unwrap();
    assert!(
        matches!(
            doubt(&end).0,
            LinkError::Unanswered {
                fenced: false,
                at_start: None
            }
        ),
        "{end:?}"
    );
}

/// N4: a byte each 40 ms: each is in time, the whole answer is not.
#[tokio::test(start_paused = true)]
async fn n4_a_reply_that_drips_has_one_deadline_for_all_of_it() {
    let cell = start().await;
    assert!(arrived(&*cell.carry_out(to(10.0)).await));
    cell.fake.then(Fault::Drip(Duration::from_millis(80)));
    let since = Instant::now();
    let (motion, _) = cell.submit(to(100.0));
    let end = cell.end(motion).await;
    // Not from the answer, which would have taken two seconds: `reply_timeout_ms` is one.
    assert!(arrived(&end), "{end:?}");
    assert!(!cell.steps(motion).contains(&"accepted"));
    assert!(since.elapsed() < Duration::from_secs(4));
    assert_eq!(Reply::Accepted.text().len(), 25);
}
