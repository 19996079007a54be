//! Everything that can go wrong with the robot, as the cell sees it and as the ledger has it.
#![allow(
    clippy::wildcard_enum_match_arm,
    reason = "a test looks for the events it is about"
)]
#![allow(clippy::unwrap_used, reason = "a helper that fails stops its test")]

mod common;

use api::{FloorPoseBody, MobileErrorLevel, MobileMessage, OperatingMode, SignalName};
use common::{Scene, config, order};
use mobile_emulator::{
    DriveEnd, Fault, LedgerEvent, OrderOutcome, Phase, Purpose, Refusal, SlipMoment, Violation,
};
use uuid::Uuid;

async fn set(scene: &Scene, fault: Fault) {
    let _id = scene.robot.set_fault(fault).await.unwrap();
}

async fn time_of(scene: &Scene, name: SignalName) -> jiff::Timestamp {
    scene.until(name).await.at
}

#[tokio::test]
async fn without_a_permit_it_waits_before_the_zone_for_ever() {
    let scene = Scene::new().await;
    scene.order(order());
    let _assigned = scene.until(SignalName::MrAssigned).await;
    scene.advance(600.0).await;
    let state = scene.robot.state().await.unwrap();
    assert_eq!(state.stands_because, Some(DriveEnd::NoPermit));
    assert!(!state.zones[0].touched && !state.driving);
    assert_eq!(scene.cell.names(), [SignalName::MrAssigned]);
    let entered = |event: &LedgerEvent| matches!(event, LedgerEvent::ZoneEntered { .. });
    assert!(!scene.events().await.iter().any(entered));
    // And it goes in when it may.
    scene.permit(true);
    let _docked = scene.until(SignalName::MrDocked).await;
    assert_eq!(scene.violations().await, []);
}

#[tokio::test]
async fn a_robot_that_is_late_arrives_later() {
    let (on_time, late) = (Scene::new().await, Scene::new().await);
    set(&late, Fault::Late { delay_s: 40.0 }).await;
    let mut arrivals = Vec::new();
    for scene in [&on_time, &late] {
        scene.order(order());
        scene.permit(true);
        arrivals.push(time_of(scene, SignalName::MrArrived).await);
    }
    let delay = arrivals[1].duration_since(arrivals[0]).as_secs_f64();
    assert!((39.0..41.0).contains(&delay), "{delay} s");
}

#[tokio::test]
async fn a_stuck_robot_says_so_and_goes_on_when_it_is_free() {
    let scene = Scene::new().await;
    scene.order(order());
    scene.permit(true);
    let _assigned = scene.until(SignalName::MrAssigned).await;
    scene.advance(1.0).await;
    let before = scene.robot.pose().await.unwrap();
    set(&scene, Fault::Stuck { for_s: Some(20.0) }).await;
    let fault = scene.until(SignalName::MrFault).await;
    assert_eq!(fault.data.errors[0].error_type, "STUCK");
    assert_eq!(fault.data.errors[0].level, MobileErrorLevel::Fatal);
    assert!(fault.data.driving, "its wheels turn");
    assert_eq!(scene.robot.pose().await.unwrap(), before);
    let docked = scene.until(SignalName::MrDocked).await;
    assert!(docked.data.errors.is_empty());
}

#[tokio::test]
async fn it_stops_before_an_obstacle_and_goes_on_when_it_is_gone() {
    let scene = Scene::new().await;
    set(
        &scene,
        Fault::Obstacle {
            x_mm: 1300.0,
            y_mm: 400.0,
            radius_mm: 200.0,
            for_s: Some(30.0),
        },
    )
    .await;
    scene.order(order());
    scene.permit(true);
    scene.advance(20.0).await;
    let state = scene.robot.state().await.unwrap();
    assert_eq!(state.stands_because, Some(DriveEnd::Obstacle));
    let _docked = scene.until(SignalName::MrDocked).await;
}

#[tokio::test]
async fn the_wrong_dock_is_told_with_its_true_pose_and_the_ledger_knows() {
    let scene = Scene::new().await;
    let dock = FloorPoseBody {
        x_mm: 3000.0,
        y_mm: 1400.0,
        heading_deg: 90.0,
    };
    set(&scene, Fault::WrongDock { dock }).await;
    scene.order(order());
    scene.permit(true);
    let docked = scene.until(SignalName::MrDocked).await;
    assert!((docked.data.pose.y_mm - 1400.0).abs() < 5.0);
    assert_eq!(docked.data.at_point.as_deref(), Some(common::GOAL));
    assert_eq!(scene.violations().await, [Violation::ToldDockedOffDock]);
}

#[tokio::test]
async fn docking_that_fails_is_tried_again_when_the_cell_says_so() {
    let scene = Scene::new().await;
    set(&scene, Fault::DockFails { times: 2 }).await;
    scene.order(order());
    scene.permit(true);
    for count in 1..=2 {
        let failed = scene.until_count(SignalName::MrDockFailed, count).await;
        assert_eq!(failed.data.errors[0].error_type, "DOCKING_FAILED");
        // It does nothing by itself.
        scene.advance(10.0).await;
        assert_eq!(scene.count(SignalName::MrDockFailed), count);
        scene.tell(MobileMessage::Retry);
    }
    let docked = scene.until(SignalName::MrDocked).await;
    assert!(docked.data.errors.is_empty());
    assert_eq!(scene.count(SignalName::MrArrived), 1);
}

#[tokio::test]
async fn docking_that_is_given_up_ends_outside_of_the_zone() {
    let scene = Scene::new().await;
    set(&scene, Fault::DockFails { times: 1 }).await;
    let mut to_d1 = order();
    to_d1.then_to = Some("d/1".to_owned());
    to_d1.then_pose = Some(FloorPoseBody::default());
    scene.order(to_d1);
    scene.permit(true);
    let _failed = scene.until(SignalName::MrDockFailed).await;
    scene.tell(MobileMessage::SkipRetry);
    let _clear = scene.until(SignalName::MrClear).await;
    scene.until_phase(None).await;
    assert!(!scene.cell.names().contains(&SignalName::MrDelivered));
    let ended = LedgerEvent::OrderEnded {
        order: order().order,
        outcome: OrderOutcome::Failed,
    };
    assert!(scene.events().await.contains(&ended));
    assert!(
        !scene
            .robot
            .state()
            .await
            .unwrap()
            .zones
            .iter()
            .any(|z| z.touched)
    );
}

#[tokio::test]
async fn a_slip_that_is_noticed_fails_docking_and_one_that_is_not_is_a_lie() {
    for noticed in [true, false] {
        let scene = Scene::new().await;
        set(
            &scene,
            Fault::Slip {
                forward_mm: 0.0,
                left_mm: 60.0,
                turn_deg: 3.0,
                when: SlipMoment::Docking,
                noticed,
            },
        )
        .await;
        scene.order(order());
        scene.permit(true);
        let docked = scene.until(SignalName::MrDocked).await;
        let off = (docked.data.pose.x_mm - 3000.0).hypot(docked.data.pose.y_mm - 1000.0);
        assert!(off < 5.0, "that is what it tells: {off}");
        let truth = scene.robot.pose().await.unwrap();
        let truly_off = (truth.x_mm - 3000.0).hypot(truth.y_mm - 1000.0);
        // Noticed in time, the way is corrected; unnoticed, nobody knows but the ledger.
        assert_eq!(truly_off < 5.0, noticed, "{truly_off}");
        let caught = scene.violations().await;
        assert_eq!(caught.is_empty(), noticed, "{caught:?}");
    }
}

#[tokio::test]
async fn a_docked_robot_that_is_pushed_tells_its_new_pose() {
    let scene = Scene::new().await;
    scene.until_ready(order()).await;
    set(
        &scene,
        Fault::Slip {
            forward_mm: 40.0,
            left_mm: 0.0,
            turn_deg: 0.0,
            when: SlipMoment::Now,
            noticed: true,
        },
    )
    .await;
    scene.advance(1.1).await;
    let beat = scene.cell.last();
    assert!((beat.data.pose.y_mm - 1040.0).abs() < 5.0);
    assert!(!beat.data.driving);
}

#[tokio::test]
async fn a_lie_is_told_and_the_truth_is_in_the_state() {
    let scene = Scene::new().await;
    set(
        &scene,
        Fault::Lie {
            x_mm: 500.0,
            y_mm: -20.0,
            heading_deg: 10.0,
            for_s: Some(5.0),
        },
    )
    .await;
    scene.advance(1.0).await;
    let told = scene.cell.last().data.pose;
    assert!((told.x_mm - 500.0).abs() < 1e-9 && (told.heading_deg - 10.0).abs() < 1e-9);
    assert!(scene.robot.pose().await.unwrap().x_mm.abs() < 1e-9);
    scene.advance(6.0).await;
    assert!(scene.cell.last().data.pose.x_mm.abs() < 1e-9);
}

#[tokio::test]
async fn a_lost_robot_says_so_and_stands() {
    let scene = Scene::new().await;
    scene.order(order());
    scene.permit(true);
    scene.advance(1.0).await;
    set(&scene, Fault::Unlocalized { for_s: None }).await;
    let fault = scene.until(SignalName::MrFault).await;
    assert!(!fault.data.localized);
    let before = scene.robot.pose().await.unwrap();
    scene.advance(5.0).await;
    assert_eq!(scene.robot.pose().await.unwrap(), before);
    assert_eq!(scene.robot.clear_faults().await.unwrap(), 1);
    let docked = scene.until(SignalName::MrDocked).await;
    assert!(docked.data.localized && docked.data.errors.is_empty());
}

#[tokio::test]
async fn a_robot_may_stay_although_it_may_leave() {
    let scene = Scene::new().await;
    scene.until_ready(order()).await;
    set(&scene, Fault::DoesNotLeave { for_s: Some(60.0) }).await;
    scene.permit(true);
    scene.exit();
    scene.advance(50.0).await;
    assert_eq!(scene.robot.state().await.unwrap().phase, Some(Phase::Ready));
    let _clear = scene.until(SignalName::MrClear).await;
}

#[tokio::test]
async fn a_robot_that_drives_off_is_caught_by_its_own_ledger() {
    let scene = Scene::new().await;
    scene.until_ready(order()).await;
    set(&scene, Fault::DrivesOff { after_s: 2.0 }).await;
    scene.advance(1.5).await;
    assert!(!scene.cell.last().data.driving);
    scene.advance(2.5).await;
    assert!(scene.cell.last().data.driving, "its heartbeat is honest");
    let _clear = scene.until(SignalName::MrClear).await;
    assert_eq!(
        scene.violations().await,
        [Violation::MovedInZoneWithoutPermit]
    );
}

#[tokio::test]
async fn a_robot_that_ignores_its_permit_is_caught_too() {
    let scene = Scene::start(config().with_fault(Fault::IgnoresPermit { for_s: None })).await;
    scene.order(order());
    scene.until_phase(Some(Phase::AtEntry)).await;
    assert_eq!(
        scene.violations().await,
        [Violation::MovedInZoneWithoutPermit]
    );
}

#[tokio::test]
async fn heartbeats_stop_and_come_back() {
    let scene = Scene::new().await;
    scene.advance(10.0).await;
    assert_eq!(scene.cell.heartbeats(), 10);
    set(&scene, Fault::HeartbeatStops { for_s: Some(20.0) }).await;
    scene.advance(19.0).await;
    assert_eq!(scene.cell.heartbeats(), 10);
    scene.advance(5.0).await;
    assert!(scene.cell.heartbeats() > 12);
}

#[tokio::test]
async fn a_person_who_takes_over_ends_the_order() {
    let scene = Scene::new().await;
    scene.order(order());
    scene.permit(true);
    scene.advance(1.0).await;
    let mode = OperatingMode::Manual;
    set(&scene, Fault::Mode { mode }).await;
    let told = scene.until(SignalName::MrMode).await;
    assert_eq!(told.data.mode, OperatingMode::Manual);
    scene.advance(1.5).await;
    assert_eq!(scene.cell.last().data.order, None);
    let before = scene.robot.pose().await.unwrap();
    // It takes no orders, and says why.
    let mut again = order();
    again.order = Uuid::from_u128(2);
    scene.order(again.clone());
    let rejected = scene.until(SignalName::MrRejected).await;
    assert_eq!(rejected.data.order, Some(again.order));
    assert!(rejected.data.errors[0].description.contains("AUTOMATIC"));
    assert_eq!(scene.robot.pose().await.unwrap(), before);
    let mode = OperatingMode::Automatic;
    set(&scene, Fault::Mode { mode }).await;
    // The lost order may be sent again as it was.
    scene.order(order());
    scene.permit(true);
    let _docked = scene.until(SignalName::MrDocked).await;
}

#[tokio::test]
async fn a_person_who_only_intervenes_lets_it_go_on() {
    let scene = Scene::new().await;
    scene.order(order());
    scene.permit(true);
    scene.advance(1.0).await;
    let mode = OperatingMode::Intervened;
    set(&scene, Fault::Mode { mode }).await;
    scene.advance(5.0).await;
    let before = scene.robot.pose().await.unwrap();
    scene.advance(5.0).await;
    assert_eq!(scene.robot.pose().await.unwrap(), before);
    let mode = OperatingMode::Automatic;
    set(&scene, Fault::Mode { mode }).await;
    let _docked = scene.until(SignalName::MrDocked).await;
}

#[tokio::test]
async fn a_crash_forgets_the_order_and_the_permit_and_keeps_the_loads() {
    let scene = Scene::new().await;
    scene.until_ready(order()).await;
    let before = scene.robot.pose().await.unwrap();
    set(&scene, Fault::Crash { down_s: 5.0 }).await;
    let beats = scene.cell.heartbeats();
    scene.advance(4.0).await;
    assert!(scene.robot.state().await.unwrap().down);
    assert_eq!(scene.cell.heartbeats(), beats);
    scene.advance(3.0).await;
    let beat = scene.cell.last();
    assert_eq!((beat.boot, beat.data.order), (2, None));
    assert_eq!(
        beat.data.loads.as_ref().unwrap()[0].load.as_deref(),
        Some("box-1")
    );
    let first = scene.cell.arrived().into_iter().find(|one| one.boot == 2);
    assert_eq!(first.unwrap().seq, 1);
    assert_eq!(scene.robot.pose().await.unwrap(), before);
    // The order again: it stands in the zone, and does not move before it may.
    scene.order(order());
    let _assigned = scene.until_count(SignalName::MrAssigned, 2).await;
    scene.advance(5.0).await;
    assert_eq!(scene.robot.pose().await.unwrap(), before);
    scene.permit(true);
    let _docked = scene.until_count(SignalName::MrDocked, 2).await;
    assert_eq!(scene.violations().await, []);
}

#[tokio::test]
async fn a_robot_that_lost_its_order_in_a_zone_does_not_leave_it_for_another() {
    let scene = Scene::new().await;
    scene.until_ready(order()).await;
    set(&scene, Fault::Crash { down_s: 1.0 }).await;
    scene.advance(3.0).await;
    let before = scene.robot.pose().await.unwrap();
    let mut other = order();
    other.order = Uuid::from_u128(2);
    other.goal = "s2/p1".to_owned();
    other.dock.x_mm = -3000.0;
    other.zone = None;
    scene.order(other);
    scene.permit(true);
    let _assigned = scene.until_count(SignalName::MrAssigned, 2).await;
    scene.advance(30.0).await;
    // Its permit is for the other point's zone, not for this one.
    assert_eq!(scene.robot.pose().await.unwrap(), before);
    let state = scene.robot.state().await.unwrap();
    assert_eq!(state.stands_because, Some(DriveEnd::NoPermit));
    assert_eq!(scene.violations().await, []);
}

#[tokio::test]
async fn loads_can_be_missing_wrong_extra_or_misreported() {
    let slot = |id: &str| id.to_owned();
    let load = || "box-9".to_owned();
    let cases = [
        (Fault::LoadMissing { slot: slot("a") }, [None, None]),
        (
            Fault::LoadWrong {
                slot: slot("a"),
                load: load(),
            },
            [Some("box-9"), None],
        ),
        (
            Fault::LoadExtra {
                slot: slot("b"),
                load: load(),
            },
            [Some("box-1"), Some("box-9")],
        ),
        (
            Fault::MisreportLoad {
                slot: slot("a"),
                load: None,
                for_s: None,
            },
            [None, None],
        ),
    ];
    for (fault, wanted) in cases {
        let lies = matches!(fault, Fault::MisreportLoad { .. });
        let scene = Scene::new().await;
        set(&scene, fault.clone()).await;
        scene.until_ready(order()).await;
        let told = scene
            .cell
            .taken()
            .last()
            .unwrap()
            .data
            .loads
            .clone()
            .unwrap();
        let told: Vec<Option<&str>> = told.iter().map(|one| one.load.as_deref()).collect();
        assert_eq!(told, wanted, "{fault:?}");
        let truth = scene.robot.slots().await.unwrap();
        let truth: Vec<Option<&str>> = truth.iter().map(|one| one.load.as_deref()).collect();
        let really = if lies { [Some("box-1"), None] } else { wanted };
        assert_eq!(truth, really, "{fault:?}");
    }
}

#[tokio::test]
async fn an_order_can_be_overlooked_or_refused() {
    let scene = Scene::new().await;
    set(&scene, Fault::OrderUnacknowledged { times: 2 }).await;
    for _ in 0..2 {
        scene.order(order());
        scene.advance(5.0).await;
        assert_eq!(scene.cell.names(), []);
    }
    scene.order(order());
    let _assigned = scene.until(SignalName::MrAssigned).await;

    let scene = Scene::new().await;
    set(&scene, Fault::OrderRefused { times: 1 }).await;
    scene.order(order());
    let refused = scene.until(SignalName::MrRejected).await;
    assert_eq!(refused.data.errors[0].error_type, "ORDER_REFUSED");
    scene.order(order());
    let _assigned = scene.until(SignalName::MrAssigned).await;
}

#[tokio::test]
async fn a_low_battery_warns_and_an_empty_one_stops() {
    let scene = Scene::new().await;
    scene.order(order());
    scene.permit(true);
    scene.advance(1.0).await;
    set(&scene, Fault::Battery { percent: 15.0 }).await;
    let low = scene.until(SignalName::MrFault).await;
    assert_eq!(low.data.errors[0].error_type, "BATTERY_LOW");
    assert_eq!(low.data.errors[0].level, MobileErrorLevel::Warning);
    set(&scene, Fault::Battery { percent: 1.0 }).await;
    let empty = scene.until(SignalName::MrFault).await;
    assert_eq!(empty.data.errors[1].error_type, "BATTERY_EMPTY");
    let before = scene.robot.pose().await.unwrap();
    scene.advance(10.0).await;
    assert_eq!(scene.robot.pose().await.unwrap(), before);
    set(&scene, Fault::Battery { percent: 80.0 }).await;
    let docked = scene.until(SignalName::MrDocked).await;
    assert!(docked.data.errors.is_empty());
}

#[tokio::test]
async fn driving_drains_the_battery_by_the_way() {
    let mut config = config();
    config.battery.drain_percent_per_km = 1000.0;
    config.battery.drain_percent_per_h = 0.0;
    let scene = Scene::start(config).await;
    scene.until_ready(order()).await;
    let state = scene.robot.state().await.unwrap();
    let used = 100.0 - state.battery_percent;
    assert!((used - state.odometer_mm / 1000.0).abs() < 1e-6, "{used}");
    assert!(state.odometer_mm > 3000.0);
    assert!(state.fastest_wheel_rad_s > 1.0 && state.fastest_wheel_rad_s <= state.max_wheel_rad_s);
}

#[tokio::test]
async fn a_fault_that_makes_no_sense_is_refused_and_nothing_happens() {
    let scene = Scene::new().await;
    let cases = [
        (
            Fault::Late { delay_s: -1.0 },
            "delay_s is -1; it must be from 0",
        ),
        (Fault::Battery { percent: f64::NAN }, "percent is NaN"),
        (
            Fault::DockFails { times: 0 },
            "times is 0; it must be from 1",
        ),
        (
            Fault::LoadMissing {
                slot: "z".to_owned(),
            },
            "no slot `z`; there are: a, b",
        ),
        (
            Fault::LoadMissing {
                slot: "b".to_owned(),
            },
            "slot `b` is empty",
        ),
        (
            Fault::LoadExtra {
                slot: "b".to_owned(),
                load: "box-1".to_owned(),
            },
            "`box-1` lies in slot `a` already",
        ),
        (
            Fault::LoadWrong {
                slot: "a".to_owned(),
                load: "no good".to_owned(),
            },
            "\"no good\"",
        ),
    ];
    for (fault, wanted) in cases {
        let refused = scene.robot.set_fault(fault).await.unwrap_err();
        assert!(refused.to_string().contains(wanted), "{refused}");
    }
    let state = scene.robot.state().await.unwrap();
    assert_eq!(state.faults, []);
    assert_eq!(state.slots[0].load.as_deref(), Some("box-1"));
    for _ in 0..mobile_emulator::MAX_FAULTS {
        set(&scene, Fault::Late { delay_s: 1.0 }).await;
    }
    let refused = scene.robot.set_fault(Fault::Late { delay_s: 1.0 }).await;
    assert!(matches!(refused, Err(Refusal::Value { .. })));
}

#[tokio::test]
async fn loads_are_moved_once_and_moving_them_at_the_wrong_time_is_recorded() {
    let scene = Scene::new().await;
    scene.until_ready(order()).await;
    assert_eq!(scene.robot.take("a").await.unwrap(), "box-1");
    assert!(matches!(
        scene.robot.take("a").await,
        Err(Refusal::SlotEmpty { .. })
    ));
    scene.robot.put("b", "box-1").await.unwrap();
    assert!(matches!(
        scene.robot.put("a", "box-1").await,
        Err(Refusal::LoadElsewhere { .. })
    ));
    assert_eq!(scene.violations().await, []);
    scene.until_clear().await;
    scene.until_phase(None).await;
    scene.order({
        let mut next = order();
        next.order = Uuid::from_u128(2);
        next
    });
    scene.permit(true);
    scene.until_phase(Some(Phase::Approach)).await;
    scene.advance(1.0).await;
    let _load = scene.robot.take("b").await.unwrap();
    assert_eq!(scene.violations().await, [Violation::LoadMovedWhileDriving]);
}

#[tokio::test]
async fn a_drive_is_in_the_ledger_from_its_start_to_its_end() {
    let scene = Scene::new().await;
    scene.until_ready(order()).await;
    let mut drives = Vec::new();
    for event in scene.events().await {
        match event {
            LedgerEvent::DriveStarted { purpose, .. } => drives.push((purpose, None)),
            LedgerEvent::DriveEnded {
                purpose,
                reason,
                driven_mm,
            } => {
                assert!(driven_mm > 100.0);
                drives.push((purpose, Some(reason)));
            }
            _ => {}
        }
    }
    let arrived = Some(DriveEnd::Arrived);
    let wanted = [
        (Purpose::Approach, None),
        (Purpose::Approach, arrived),
        (Purpose::Dock, None),
        (Purpose::Dock, arrived),
    ];
    assert_eq!(drives, wanted);
}
