//! The conversation of a delivery and of a pickup, as the cell sees it.
#![allow(clippy::unwrap_used, reason = "a helper that fails stops its test")]

mod common;

use api::{FloorPoseBody, MobileMessage, RoutePointBody, SignalName};
use common::{GOAL, Scene, config, order, session};
use mobile_emulator::{LedgerEvent, OrderOutcome};

#[tokio::test]
async fn a_delivery_is_told_step_by_step() {
    let scene = Scene::new().await;
    scene.order(order());
    let assigned = scene.until(SignalName::MrAssigned).await;
    assert_eq!(assigned.session, Some(session()));
    assert_eq!(assigned.data.order, Some(order().order));

    scene.permit(true);
    let arrived = scene.until(SignalName::MrArrived).await;
    assert_eq!(arrived.data.at_point.as_deref(), Some(GOAL));
    assert!(!arrived.data.driving);

    let docked = scene.until(SignalName::MrDocked).await;
    assert!(!docked.data.driving);
    let off = (docked.data.pose.x_mm - 3000.0).hypot(docked.data.pose.y_mm - 1000.0);
    assert!(off < 5.0, "{off} mm from the dock");
    assert!((docked.data.pose.heading_deg - 90.0).abs() < 0.5);

    // It is not ready before it has seen its permit withdrawn.
    scene.advance(3.0).await;
    assert_eq!(scene.count(SignalName::MrReady), 0);
    scene.permit(false);
    let ready = scene.until(SignalName::MrReady).await;
    assert_eq!(
        ready.data.loads.as_ref().unwrap()[0].load.as_deref(),
        Some("box-1")
    );

    scene.tell(MobileMessage::CellReady);
    assert_eq!(scene.robot.take("a").await.unwrap(), "box-1");
    let changed = scene.until(SignalName::LoadChanged).await;
    assert_eq!(changed.data.loads.as_ref().unwrap()[0].load, None);
    scene.tell(MobileMessage::TransferDone);

    // It leaves with both words, not with one.
    scene.exit();
    scene.advance(3.0).await;
    assert_eq!(scene.count(SignalName::MrClear), 0);
    scene.permit(true);
    let clear = scene.until(SignalName::MrClear).await;
    assert_eq!(clear.session, Some(session()));
    scene.until_phase(None).await;

    let wanted = [
        SignalName::MrAssigned,
        SignalName::MrArrived,
        SignalName::MrDocked,
        SignalName::MrReady,
        SignalName::LoadChanged,
        SignalName::MrClear,
    ];
    assert_eq!(scene.cell.names(), wanted);
    assert_eq!(scene.violations().await, []);
    let ended = LedgerEvent::OrderEnded {
        order: order().order,
        outcome: OrderOutcome::Finished,
    };
    assert!(scene.events().await.contains(&ended));
    scene.robot.shutdown().await;
}

#[tokio::test]
async fn a_pickup_goes_on_to_its_destination() {
    let scene = Scene::start(config()).await;
    let mut pickup = order();
    pickup.route = vec![RoutePointBody {
        x_mm: 1000.0,
        y_mm: 1000.0,
        heading_deg: Some(0.0),
    }];
    pickup.then_to = Some("dispatch/d1".to_owned());
    pickup.then_pose = Some(FloorPoseBody {
        x_mm: -2000.0,
        y_mm: 0.0,
        heading_deg: 180.0,
    });
    scene.until_ready(pickup).await;
    scene.robot.put("b", "box-2").await.unwrap();
    scene.until_clear().await;
    let delivered = scene.until(SignalName::MrDelivered).await;
    assert_eq!(delivered.session, None);
    assert_eq!(delivered.data.at_point.as_deref(), Some("dispatch/d1"));
    assert_eq!(delivered.data.order, Some(order().order));
    assert_eq!(
        delivered.data.loads.as_ref().unwrap()[1].load.as_deref(),
        Some("box-2")
    );
    assert!((delivered.data.pose.x_mm + 2000.0).abs() < 6.0);
    assert_eq!(scene.violations().await, []);
}

#[tokio::test]
async fn signals_are_numbered_without_holes_and_the_outbox_is_acknowledged() {
    let scene = Scene::new().await;
    scene.until_ready(order()).await;
    let numbers: Vec<u64> = scene.cell.arrived().iter().map(|one| one.seq).collect();
    let wanted: Vec<u64> = (1..=numbers.len() as u64).collect();
    assert_eq!(numbers, wanted);
    assert!(scene.cell.arrived().iter().all(|one| one.boot == 1));
    scene.advance(0.2).await;
    assert_eq!(scene.cell.unacknowledged(), 0);
    assert_eq!(scene.cell.polls().last(), Some(&3));
}

#[tokio::test]
async fn the_same_history_follows_from_the_same_messages() {
    let mut histories = Vec::new();
    for _ in 0..2 {
        let scene = Scene::new().await;
        scene.until_ready(order()).await;
        scene.until_clear().await;
        histories.push((scene.cell.arrived(), scene.ledger().await));
    }
    assert_eq!(histories[0], histories[1]);
}

#[tokio::test]
async fn an_order_that_comes_with_the_word_that_it_is_clear_is_taken() {
    let scene = Scene::new().await;
    scene.until_ready(order()).await;
    scene.until_clear().await;
    let mut next = order();
    next.order = uuid::Uuid::from_u128(2);
    let id = next.order;
    scene.order(next);
    scene.advance(2.0).await;
    assert!(!scene.cell.names().contains(&SignalName::MrRejected));
    assert_eq!(scene.cell.last().data.order, Some(id));
}

fn slot(slot: &str, load: &str) -> api::SlotLoadBody {
    api::SlotLoadBody {
        slot: slot.to_owned(),
        load: Some(load.to_owned()),
    }
}

fn with_destination() -> mobile_emulator::MobileConfig {
    let mut config = config();
    config.points.push(mobile_emulator::config::PointSection {
        id: "dispatch/d1".to_owned(),
        pose: FloorPoseBody {
            x_mm: -2000.0,
            y_mm: 0.0,
            heading_deg: 180.0,
        },
        zone: None,
        unload_s: Some(1.0),
    });
    config
}

#[tokio::test]
async fn only_what_the_order_names_is_taken_off() {
    let scene = Scene::start(with_destination()).await;
    let mut pickup = order();
    pickup.then_to = Some("dispatch/d1".to_owned());
    pickup.unload = Some(vec![slot("b", "box-2")]);
    scene.until_ready(pickup).await;
    scene.robot.put("b", "box-2").await.unwrap();
    scene.until_clear().await;
    let _delivered = scene.until(SignalName::MrDelivered).await;
    let slots = scene.robot.slots().await.unwrap();
    assert_eq!(
        slots,
        [
            slot("a", "box-1"),
            api::SlotLoadBody {
                slot: "b".to_owned(),
                load: None
            }
        ]
    );
}

#[tokio::test]
async fn an_order_that_only_gives_loads_away_needs_no_hand_over() {
    let scene = Scene::start(with_destination()).await;
    let mut transport = order();
    transport.goal = "dispatch/d1".to_owned();
    transport.dock = FloorPoseBody {
        x_mm: -2000.0,
        y_mm: 0.0,
        heading_deg: 180.0,
    };
    transport.zone = None;
    transport.unload = Some(vec![slot("a", "box-1")]);
    scene.order(transport);
    let delivered = scene.until(SignalName::MrDelivered).await;
    assert_eq!(delivered.session, None);
    assert_eq!(scene.robot.slots().await.unwrap()[0].load, None);
    assert_eq!(scene.violations().await, []);
}

#[tokio::test]
async fn it_comes_by_itself_where_it_is_sent() {
    let scene = Scene::start(with_destination()).await;
    let unknown = scene.robot.visit("nowhere/n1").await.unwrap_err();
    assert!(unknown.to_string().contains("not on the robot's map"));
    scene.robot.visit("dispatch/d1").await.unwrap();
    let arrived = scene.until(SignalName::MrArrived).await;
    assert_eq!((arrived.session, arrived.data.order), (None, None));
    assert_eq!(arrived.data.at_point.as_deref(), Some("dispatch/d1"));
    assert_eq!(scene.violations().await, []);
}
