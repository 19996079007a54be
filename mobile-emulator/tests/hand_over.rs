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
