//! What a mobile robot is told in the course of a hand-over, and what becomes of what it says at the wrong time.

use api::{FloorPoseBody, MobileMessage};
use journal::MemoryDisk;
use workflow::{SessionState, SignalAnswer, SignalKind, SlotLoad};

use super::{World, order_of};

impl World {
    /// From the order to the dock.
    async fn docked(&mut self) -> uuid::Uuid {
        let order = self.message("TRANSPORT_ORDER").await;
        let session = order.session;
        self.state.order = Some(order_of(&order).order);
        self.says(SignalKind::MrAssigned, session).await;
        let permit = self.message("MOVE_PERMIT").await;
        assert_eq!(permit.message, MobileMessage::MovePermit { granted: true });
        assert_eq!(permit.session, session);
        self.taken(permit.n).await;
        self.state.at_point = Some("handover/front".to_owned());
        let dock = order_of(&order).dock;
        self.state.pose.x_mm = dock.x_mm;
        self.state.pose.y_mm = dock.y_mm;
        self.state.pose.heading_deg = dock.heading_deg;
        self.says(SignalKind::MrArrived, session).await;
        self.says(SignalKind::MrDocked, session).await;
        let permit = self.message("MOVE_PERMIT").await;
        assert_eq!(permit.message, MobileMessage::MovePermit { granted: false });
        self.taken(permit.n).await;
        session.unwrap()
    }
}

#[tokio::test]
async fn an_order_carries_the_map_of_the_cell() {
    let world = World::on(&MemoryDisk::new()).await;
    let _job = world.pickup().await;
    let message = world.message("TRANSPORT_ORDER").await;
    let order = order_of(&message);
    assert_eq!(order.goal, "handover/front");
    let dock = FloorPoseBody {
        x_mm: 1100.0,
        y_mm: 0.0,
        heading_deg: 90.0,
    };
    assert_eq!(order.dock, dock);
    assert!((order.dock_tolerance.unwrap().mm - 15.0).abs() < 1e-9);
    let zone = order.zone.unwrap();
    assert_eq!((zone.min_x_mm, zone.max_x_mm), (650.0, 1600.0));
    assert!((order.route.last().unwrap().y_mm + 1200.0).abs() < 1e-9);
    assert_eq!(order.then_to.as_deref(), Some("warehouse/gate"));
    assert!((order.then_pose.unwrap().x_mm - 4000.0).abs() < 1e-9);
    assert!((order.then_route.first().unwrap().y_mm + 1200.0).abs() < 1e-9);
    assert!(jiff::Timestamp::now().duration_since(message.at).as_secs() < 60);
}

#[tokio::test]
async fn a_robot_is_led_in_and_out_and_its_way_on_is_an_update_of_the_same_order() {
    let mut world = World::on(&MemoryDisk::new()).await;
    let _job = world.pickup().await;
    let first = order_of(&world.message("TRANSPORT_ORDER").await).clone();
    let session = world.docked().await;
    world.says(SignalKind::MrReady, Some(session)).await;
    let _ready = world.message("CELL_READY").await;
    // The arm has put the load down; the robot's sensor sees it.
    let loads = ["left", "right"].iter().zip(["load-1", "load-2"]);
    world.state.loads = Some(
        loads
            .map(|(slot, load)| SlotLoad {
                slot: (*slot).to_owned(),
                load: Some(load.to_owned()),
            })
            .collect(),
    );
    world.says(SignalKind::LoadChanged, Some(session)).await;
    let exit = world.message("EXIT_GRANTED").await;
    let told = world.outboxes.after("mr1", 0);
    let permit = told
        .iter()
        .find(|one| one.n < exit.n && one.message == MobileMessage::MovePermit { granted: true });
    assert!(permit.is_some(), "{told:?}");
    let update = told
        .iter()
        .find(|one| one.message.kind() == "TRANSPORT_ORDER")
        .map(order_of)
        .unwrap();
    assert_eq!(
        (update.order, update.update),
        (first.order, first.update + 1)
    );
    assert_eq!((&update.goal, update.dock), (&first.goal, first.dock));
    assert_eq!(update.then_to, first.then_to);
}

/// Covers: M2, M3.
#[tokio::test]
async fn a_signal_that_does_not_fit_moves_nothing_and_uses_its_number_up() {
    let mut world = World::on(&MemoryDisk::new()).await;
    let _job = world.pickup().await;
    let order = world.message("TRANSPORT_ORDER").await;
    world.says(SignalKind::MrAssigned, order.session).await;
    let _permit = world.message("MOVE_PERMIT").await;
    // Of another hand-over; and one step too many.
    let late = world.signal(SignalKind::MrArrived, Some(uuid::Uuid::from_u128(1)));
    let answer = world.send(late.clone()).await;
    assert!(
        matches!(
            answer,
            SignalAnswer::Closed {
                duplicate: false,
                ..
            }
        ),
        "{answer:?}"
    );
    let ready = world.signal(SignalKind::MrReady, order.session);
    let answer = world.send(ready.clone()).await;
    assert!(
        matches!(
            answer,
            SignalAnswer::Conflict {
                duplicate: false,
                ..
            }
        ),
        "{answer:?}"
    );
    let answer = world.send(ready).await;
    assert!(
        matches!(
            answer,
            SignalAnswer::Conflict {
                duplicate: true,
                ..
            }
        ),
        "{answer:?}"
    );
    let sessions = world.work.view().sessions(0);
    assert_eq!(sessions[0].state, SessionState::AccessGranted);
    world.says(SignalKind::MrArrived, order.session).await;
}

/// Covers: M4. The wait is there to be seen, with what is left of it.
#[tokio::test]
async fn what_is_waited_for_has_a_deadline_that_is_shown() {
    let world = World::on(&MemoryDisk::new()).await;
    let job = world.pickup().await;
    let _order = world.message("TRANSPORT_ORDER").await;
    let view = world
        .work
        .view()
        .job(world.work.clock().now(), job)
        .unwrap();
    let step = view.steps.iter().find(|step| step.code == "B3").unwrap();
    let left = step.left_ms.unwrap();
    assert!((1..=5_000).contains(&left), "{left}");
}

/// Covers: M7, M8. Over a restart nothing is taken for granted: the order stays the same one, its number is not used
/// again, and a permit that was not fetched is gone.
#[tokio::test]
async fn an_order_is_the_same_whenever_it_is_fetched_and_a_permit_is_not() {
    let disk = MemoryDisk::new();
    let mut world = World::on(&disk).await;
    let _job = world.pickup().await;
    let first = world.message("TRANSPORT_ORDER").await;
    assert_eq!(world.message("TRANSPORT_ORDER").await, first);
    world.says(SignalKind::MrAssigned, first.session).await;
    let permit = world.message("MOVE_PERMIT").await;
    disk.lose_power();

    let world = World::on(&disk).await;
    let waiting = world.outboxes.after("mr1", 0);
    assert_eq!(waiting.first(), Some(&first), "{waiting:?}");
    let granted = MobileMessage::MovePermit { granted: true };
    assert!(
        waiting.iter().all(|one| one.message != granted),
        "{waiting:?}"
    );
    let newer = waiting.iter().skip(1);
    assert!(newer.clone().all(|one| one.n > permit.n), "{waiting:?}");
    // The zone stays reserved for a robot nobody hears: it may be on its way.
    let sessions = world.work.view().sessions(0);
    assert!(!sessions[0].state.is_closed(), "{sessions:?}");
    world.taken(first.n).await;
    assert!(
        world
            .outboxes
            .after("mr1", 0)
            .iter()
            .all(|one| one.n > first.n)
    );
}
