//! Signals that are lost, late, doubled or overtaken; a cell that is away; messages that come twice.
#![allow(
    clippy::wildcard_enum_match_arm,
    reason = "a test looks for the events it is about"
)]
#![allow(clippy::unwrap_used, reason = "a helper that fails stops its test")]

mod common;

use std::time::Duration;

use api::{FloorPoseBody, MobileMessage, SignalName};
use common::{FakeCell, Scene, config, order, within};
use mobile_emulator::{Clock, Fault, LedgerEvent, LostNumber, MobileRobot, Phase};
use uuid::Uuid;

fn numbers_of(cell: &FakeCell, name: SignalName) -> Vec<u64> {
    let arrived = cell.arrived();
    let found = arrived.iter().filter(|one| one.signal == name);
    found.map(|one| one.seq).collect()
}

/// No signal is without its predecessor.
fn assert_no_holes(cell: &FakeCell) {
    let mut numbers: Vec<u64> = cell.arrived().iter().map(|one| one.seq).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let wanted: Vec<u64> = (1..=numbers.len() as u64).collect();
    assert_eq!(numbers, wanted);
}

#[tokio::test]
async fn a_signal_whose_transmissions_are_lost_gets_through_in_its_place() {
    let scene = Scene::start(config().with_fault(Fault::LoseSignal {
        signal: Some(SignalName::MrArrived),
        nth: None,
        transmissions: Some(3),
        number: LostNumber::Unused,
    }))
    .await;
    scene.until_ready(order()).await;
    assert_eq!(
        scene.cell.names(),
        [
            SignalName::MrAssigned,
            SignalName::MrArrived,
            SignalName::MrDocked,
            SignalName::MrReady
        ]
    );
    let lost = |event: &&LedgerEvent| matches!(event, LedgerEvent::SignalLost { .. });
    assert_eq!(scene.events().await.iter().filter(lost).count(), 3);
    assert_no_holes(&scene.cell);
}

#[tokio::test]
async fn a_signal_that_is_lost_for_ever_leaves_a_hole_only_when_it_shall() {
    for (number, hole) in [(LostNumber::Unused, false), (LostNumber::Consumed, true)] {
        let scene = Scene::start(config().with_fault(Fault::LoseSignal {
            signal: Some(SignalName::MrAssigned),
            nth: Some(1),
            transmissions: None,
            number,
        }))
        .await;
        scene.order(order());
        scene.advance(10.0).await;
        assert!(numbers_of(&scene.cell, SignalName::MrAssigned).is_empty());
        let mut seen: Vec<u64> = scene.cell.arrived().iter().map(|one| one.seq).collect();
        seen.dedup();
        let whole = seen.iter().zip(1..).all(|(seen, wanted)| *seen == wanted);
        assert_eq!(!whole, hole, "{seen:?}");
    }
}

#[tokio::test]
async fn a_lost_answer_makes_it_send_the_same_again() {
    let scene = Scene::start(config().with_fault(Fault::LoseAnswer {
        signal: Some(SignalName::MrDocked),
        nth: None,
        answers: 2,
    }))
    .await;
    scene.until_ready(order()).await;
    let docked: Vec<_> = scene
        .cell
        .arrived()
        .into_iter()
        .filter(|one| one.signal == SignalName::MrDocked)
        .collect();
    assert_eq!(docked.len(), 3);
    assert!(docked.iter().all(|one| *one == docked[0]), "byte for byte");
    assert_eq!(scene.count(SignalName::MrDocked), 1);
}

#[tokio::test]
async fn a_doubled_signal_is_answered_as_a_duplicate() {
    let scene = Scene::start(config().with_fault(Fault::DuplicateSignal {
        signal: Some(SignalName::MrArrived),
        nth: None,
        copies: 2,
    }))
    .await;
    scene.until_ready(order()).await;
    assert_eq!(numbers_of(&scene.cell, SignalName::MrArrived).len(), 3);
    assert_eq!(scene.count(SignalName::MrArrived), 1);
    let events = scene.events().await;
    let doubled = events.iter().filter(
        |event| matches!(event, LedgerEvent::SignalAnswered { answer, .. } if answer == "duplicate"),
    );
    assert_eq!(doubled.count(), 2);
}

#[tokio::test]
async fn an_overtaken_signal_is_parked_by_the_cell_and_nothing_is_lost() {
    let scene = Scene::start(config().with_fault(Fault::ReorderSignal {
        signal: Some(SignalName::MrArrived),
        nth: None,
    }))
    .await;
    scene.until_ready(order()).await;
    let arrived: Vec<u64> = scene.cell.arrived().iter().map(|one| one.seq).collect();
    assert!(
        arrived.windows(2).any(|pair| pair[1] < pair[0]),
        "{arrived:?}"
    );
    assert_eq!(
        scene.cell.names(),
        [
            SignalName::MrAssigned,
            SignalName::MrArrived,
            SignalName::MrDocked,
            SignalName::MrReady
        ]
    );
    assert_no_holes(&scene.cell);
}

#[tokio::test]
async fn a_delayed_signal_holds_back_those_behind_it() {
    let scene = Scene::start(config().with_fault(Fault::DelaySignal {
        signal: Some(SignalName::MrAssigned),
        nth: None,
        delay_s: 8.0,
    }))
    .await;
    scene.order(order());
    scene.permit(true);
    scene.advance(6.0).await;
    assert_eq!(scene.cell.names(), []);
    let _docked = scene.until(SignalName::MrDocked).await;
    assert_no_holes(&scene.cell);
}

#[tokio::test]
async fn the_nth_signal_of_a_name_is_the_one() {
    let scene = Scene::start(config().with_fault(Fault::DuplicateSignal {
        signal: Some(SignalName::MrHeartbeat),
        nth: Some(3),
        copies: 1,
    }))
    .await;
    scene.advance(6.0).await;
    let beats = numbers_of(&scene.cell, SignalName::MrHeartbeat);
    assert_eq!(beats, [1, 2, 3, 3, 4, 5, 6]);
}

#[tokio::test]
async fn an_outage_of_the_cell_loses_nothing_and_changes_no_order() {
    let scene = Scene::new().await;
    scene.order(order());
    scene.permit(true);
    let _assigned = scene.until(SignalName::MrAssigned).await;
    scene.cell.kill().await;
    // It has its permit: it finishes what was released, and keeps what it has to tell.
    scene.advance(60.0).await;
    let state = scene.robot.state().await.unwrap();
    assert_eq!(state.phase, Some(Phase::Docked));
    assert!(state.cell.away);
    // One heartbeat waits, not sixty.
    assert!(state.cell.waiting_signals <= 4, "{state:#?}");
    let revived = scene.cell.revive().await;
    scene.permit(false);
    let _ready = scene.until(SignalName::MrReady).await;
    assert_eq!(
        revived.names(),
        [
            SignalName::MrAssigned,
            SignalName::MrArrived,
            SignalName::MrDocked,
            SignalName::MrReady
        ]
    );
    assert_no_holes(&revived);
    let events = scene.events().await;
    let away = |event: &&LedgerEvent| matches!(event, LedgerEvent::CellAway { .. });
    assert_eq!(events.iter().filter(away).count(), 1);
    assert!(events.contains(&LedgerEvent::CellBack));
}

#[tokio::test]
async fn a_cell_that_is_not_ready_is_asked_again_and_one_that_says_no_is_not() {
    let scene = Scene::new().await;
    scene.cell.refuse(SignalName::MrAssigned, &[503, 500, 404]);
    scene.cell.refuse(SignalName::MrArrived, &[409]);
    scene.order(order());
    scene.permit(true);
    let _docked = scene.until(SignalName::MrDocked).await;
    assert_eq!(numbers_of(&scene.cell, SignalName::MrAssigned).len(), 4);
    assert_eq!(numbers_of(&scene.cell, SignalName::MrArrived).len(), 1);
    let answered = scene
        .events()
        .await
        .into_iter()
        .find_map(|event| match event {
            LedgerEvent::SignalAnswered {
                signal: SignalName::MrArrived,
                status,
                answer,
                ..
            } => Some((status, answer)),
            _ => None,
        });
    assert_eq!(answered, Some((409, "handover-conflict".to_owned())));
}

#[tokio::test]
async fn the_same_order_again_is_the_same_order() {
    let scene = Scene::new().await;
    scene.order(order());
    scene.order(order());
    scene.until_ready(order()).await;
    scene.order(order());
    scene.until_clear().await;
    scene.until_phase(None).await;
    // Even when it is over.
    scene.order(order());
    scene.permit(true);
    scene.advance(20.0).await;
    assert_eq!(scene.robot.state().await.unwrap().phase, None);
    assert_eq!(scene.count(SignalName::MrAssigned), 1);
    assert_eq!(scene.count(SignalName::MrDocked), 1);
    let repeated = |event: &&LedgerEvent| matches!(event, LedgerEvent::OrderRepeated { .. });
    assert_eq!(scene.events().await.iter().filter(repeated).count(), 4);
}

#[tokio::test]
async fn another_order_is_refused_while_one_is_carried_out() {
    let scene = Scene::new().await;
    scene.order(order());
    let _assigned = scene.until(SignalName::MrAssigned).await;
    let mut other = order();
    other.order = Uuid::from_u128(9);
    scene.order(other);
    let refused = scene.until(SignalName::MrRejected).await;
    assert_eq!(refused.data.order, Some(Uuid::from_u128(9)));
    assert_eq!(
        scene.robot.state().await.unwrap().order,
        Some(order().order)
    );
}

#[tokio::test]
async fn an_order_that_makes_no_sense_is_refused_with_item_value_and_limit() {
    type Spoil = fn(&mut api::TransportOrderBody);
    let cases: [(Spoil, &str); 5] = [
        (|order| order.goal = "no good".into(), "goal is \"no good\""),
        (|order| order.dock.x_mm = 1e9, "dock: x is 1000000000 mm"),
        (
            |order| {
                if let Some(zone) = &mut order.zone {
                    zone.max_x_mm = 0.0;
                }
            },
            "zone: max_x_mm is 0; it must be at least 1 mm above min_x_mm, which is 2000",
        ),
        (
            |order| order.then_to = Some("nowhere".into()),
            "then_to is `nowhere`",
        ),
        (
            |order| {
                order.dock_tolerance = Some(api::DockToleranceBody { mm: -1.0, deg: 1.0 });
            },
            "dock_tolerance.mm is -1; it must be from 0.1 to 1000",
        ),
    ];
    let scene = Scene::new().await;
    for (number, (spoil, wanted)) in cases.into_iter().enumerate() {
        let mut bad = order();
        bad.order = Uuid::from_u128(100 + number as u128);
        spoil(&mut bad);
        scene.order(bad);
        let refused = scene.until(SignalName::MrRejected).await;
        let said = &refused.data.errors[0].description;
        assert!(said.contains(wanted), "{said}");
    }
    assert!(scene.robot.pose().await.unwrap().x_mm.abs() < 1e-9);
}

#[tokio::test]
async fn an_update_gives_the_order_another_destination() {
    let scene = Scene::new().await;
    scene.until_ready(order()).await;
    let mut update = order();
    update.update = 1;
    update.then_to = Some("d/2".to_owned());
    update.then_pose = Some(FloorPoseBody {
        x_mm: 0.0,
        y_mm: -1500.0,
        heading_deg: 0.0,
    });
    scene.order(update);
    scene.until_clear().await;
    let delivered = scene.until(SignalName::MrDelivered).await;
    assert_eq!(delivered.data.at_point.as_deref(), Some("d/2"));
}

#[tokio::test]
async fn a_cancelled_order_ends_outside_of_the_zone() {
    // On its way: it stops where it is.
    let scene = Scene::new().await;
    let id = order().order;
    scene.order(order());
    scene.advance(1.0).await;
    scene.tell(MobileMessage::CancelOrder { order: id });
    scene.until_phase(None).await;
    scene.advance(2.0).await;
    assert_eq!(scene.cell.last().data.order, None);

    // Docked: it stays until it may leave, because the arm may be at work.
    let scene = Scene::new().await;
    scene.until_ready(order()).await;
    let before = scene.robot.pose().await.unwrap();
    scene.tell(MobileMessage::CancelOrder { order: id });
    scene.advance(20.0).await;
    assert_eq!(scene.robot.pose().await.unwrap(), before);
    // It is over when it has ended, and not before.
    assert_eq!(scene.cell.last().data.order, Some(id));
    scene.until_clear().await;
    scene.until_phase(None).await;
    scene.advance(2.0).await;
    assert_eq!(scene.cell.last().data.order, None);
    assert_eq!(scene.violations().await, []);

    // While it docks: it has its permit, and backs out.
    let scene = Scene::new().await;
    scene.order(order());
    scene.permit(true);
    scene.until_phase(Some(Phase::Docking)).await;
    scene.tell(MobileMessage::CancelOrder { order: id });
    let _clear = scene.until(SignalName::MrClear).await;
    scene.until_phase(None).await;
    assert_eq!(scene.violations().await, []);
}

#[tokio::test]
async fn a_pause_holds_it_and_a_resume_lets_it_go() {
    let scene = Scene::new().await;
    scene.order(order());
    scene.permit(true);
    scene.advance(1.0).await;
    scene.tell(MobileMessage::StartPause);
    scene.advance(1.0).await;
    let before = scene.robot.pose().await.unwrap();
    scene.advance(30.0).await;
    assert_eq!(scene.robot.pose().await.unwrap(), before);
    scene.tell(MobileMessage::StopPause);
    let _docked = scene.until(SignalName::MrDocked).await;
}

#[tokio::test]
async fn a_running_clock_does_the_same_over_a_long_poll() {
    let cell = FakeCell::start().await;
    let clock = Clock::scaled(200.0).unwrap();
    let robot = MobileRobot::start(&config(), clock, &cell.cell()).unwrap();
    let session = common::session();
    let grant = |granted| MobileMessage::MovePermit { granted };
    cell.react(SignalName::MrAssigned, session, &[grant(true)]);
    cell.react(SignalName::MrDocked, session, &[grant(false)]);
    let leave = [grant(true), MobileMessage::ExitGranted];
    cell.react(SignalName::MrReady, session, &leave);
    let _n = cell.send(
        Some(session),
        MobileMessage::TransportOrder(Box::new(order())),
    );
    let mut states = robot.subscribe();
    let clear = async {
        while !cell.names().contains(&SignalName::MrClear) {
            states.changed().await.unwrap();
        }
    };
    within(clear).await;
    let wanted = [
        SignalName::MrAssigned,
        SignalName::MrArrived,
        SignalName::MrDocked,
        SignalName::MrReady,
        SignalName::MrClear,
    ];
    assert_eq!(cell.names(), wanted);
    assert_no_holes(&cell);
    robot.shutdown().await;
}

#[tokio::test]
async fn a_running_robot_outlives_an_outage_of_its_cell() {
    let cell = FakeCell::start().await;
    let mut config = config();
    config.link.retry_first_ms = 1000;
    let clock = Clock::scaled(100.0).unwrap();
    let robot = MobileRobot::start(&config, clock, &cell.cell()).unwrap();
    let mut states = robot.subscribe();
    cell.kill().await;
    drop(
        within(states.wait_for(|state| state.cell.away))
            .await
            .unwrap(),
    );
    let cell = cell.revive().await;
    let before = cell.heartbeats();
    let back = async {
        while cell.heartbeats() < before + 3 {
            states.changed().await.unwrap();
        }
    };
    within(back).await;
    assert_no_holes(&cell);
    robot.shutdown().await;
}

#[tokio::test]
async fn the_clock_refuses_a_scale_that_is_none() {
    for scale in [0.0, -1.0, f64::NAN, 1001.0] {
        assert!(Clock::scaled(scale).is_none());
    }
    let (clock, stepper) = Clock::stepped();
    drop(clock);
    assert!(stepper.advance(Duration::ZERO).await.is_err());
}

#[tokio::test]
async fn numbers_that_are_lost_are_given_up_and_the_robot_goes_on() {
    let lost = |nth| Fault::LoseSignal {
        signal: Some(SignalName::MrHeartbeat),
        nth: Some(nth),
        transmissions: None,
        number: LostNumber::Consumed,
    };
    let scene = Scene::start(config().with_fault(lost(2)).with_fault(lost(2))).await;
    scene.advance(20.0).await;
    scene.until_ready(order()).await;
    let arrived = scene.cell.arrived();
    let resync: Vec<_> = arrived.iter().filter(|one| one.resync).collect();
    assert_eq!(resync.len(), 1, "said once: {resync:?}");
    assert_eq!(resync[0].signal, SignalName::MrHeartbeat);
    assert_eq!(scene.count(SignalName::MrReady), 1);
}
