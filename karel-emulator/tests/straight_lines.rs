//! Motions of TP programs: straight lines that are straight, percentages, and what is refused.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a helper that fails stops its test"
)]

mod common;

use common::{Stepped, arm};
use karel_emulator::LedgerEvent::{Finished, Started};
use karel_emulator::ledger::MotionKind;
use karel_emulator::{ControllerConfig, LedgerEvent, ProgramSource};
use kinematics::Axis;

fn listing(name: &str, lines: &[&str], positions: &str) -> ProgramSource {
    let body: Vec<String> = lines
        .iter()
        .enumerate()
        .map(|(n, line)| format!("{:4}:{line} ;\n", n + 1))
        .collect();
    let text = format!(
        "/PROG  {name}\n/ATTR\n/MN\n{}/POS\n{positions}/END\n",
        body.concat()
    );
    ProgramSource::new(format!("{name}.ls"), text)
}

fn position(n: u32, pose: [f64; 6]) -> String {
    let [x, y, z, w, p, r] = pose;
    format!(
        "P[{n}:\"here\"]{{\n   GP1:\n\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',\n\tX = {x} mm,\tY = {y} mm,\tZ = {z} mm,\n\tW = {w} deg,\tP = {p} deg,\tR = {r} deg\n}};\n"
    )
}

fn cell(lines: &[&str], positions: &str) -> Stepped {
    let mut config = ControllerConfig::new("tp", arm());
    config = config.with_program(listing("moves", lines, positions));
    Stepped::start(&config)
}

async fn kinds(cell: &Stepped) -> Vec<(LedgerEvent, MotionKind)> {
    let ledger = cell.controller.ledger().await.unwrap();
    ledger.iter().map(|e| (e.event, e.kind)).collect()
}

#[tokio::test]
async fn a_straight_line_is_straight_at_its_speed_and_within_every_joints_speed() {
    let (a, b) = (
        [900.0, 200.0, 700.0, 180.0, 0.0, 0.0],
        [850.0, -150.0, 900.0, 170.0, 20.0, 30.0],
    );
    let positions = position(1, a) + &position(2, b);
    let cell = cell(&["J P[1] 50% FINE", "L P[2] 300mm/sec FINE"], &positions);
    cell.advance(0.001).await;
    while kinds(&cell).await.len() < 3 {
        cell.advance(0.002).await;
    }
    let start = [a[0], a[1], a[2]];
    let way: Vec<f64> = (0..3).map(|n| b[n] - a[n]).collect();
    let length = way.iter().map(|d| d * d).sum::<f64>().sqrt();
    let (mut before, mut last_share, mut fastest) = (None::<[f64; 6]>, 0.0, 0.0_f64);
    while cell.controller.state().await.unwrap().moving {
        let state = cell.controller.state().await.unwrap();
        let at = [state.pose.x_mm, state.pose.y_mm, state.pose.z_mm];
        let from: Vec<f64> = (0..3).map(|n| at[n] - start[n]).collect();
        let along = (0..3).map(|n| from[n] * way[n]).sum::<f64>() / length;
        let off = (from.iter().map(|d| d * d).sum::<f64>() - along * along)
            .max(0.0)
            .sqrt();
        assert!(off < 0.01, "{off} mm beside the line at {along} mm");
        assert!(along + 1e-6 >= last_share, "it goes back");
        if before.is_some() {
            fastest = fastest.max((along - last_share) / 0.004);
        }
        last_share = along;
        let joints: [f64; 6] = state.joints_deg.into();
        if let Some(before) = before {
            for (axis, (is, was)) in Axis::ALL.into_iter().zip(joints.iter().zip(before)) {
                let speed = (is - was).abs() / 0.004;
                assert!(
                    speed <= arm().max_speed(axis).0 * 1.001,
                    "{axis} at {speed}"
                );
            }
        }
        before = Some(joints);
        cell.advance(0.004).await;
    }
    assert!((fastest - 300.0).abs() < 1.0, "cruising at {fastest} mm/s");
    let end = cell.controller.state().await.unwrap().pose;
    for (is, wanted) in [end.x_mm, end.y_mm, end.z_mm, end.p_deg, end.r_deg]
        .iter()
        .zip([b[0], b[1], b[2], b[4], b[5]])
    {
        assert!((is - wanted).abs() < 1e-3, "{end}");
    }
    let flat: Vec<LedgerEvent> = kinds(&cell).await.into_iter().map(|e| e.0).collect();
    assert_eq!(flat, [Started, Finished, Started, Finished]);
}

#[tokio::test]
async fn a_hold_in_the_middle_of_a_line_goes_on_along_the_same_line() {
    let (a, b) = (
        [900.0, 200.0, 700.0, 180.0, 0.0, 0.0],
        [900.0, -200.0, 700.0, 180.0, 0.0, 0.0],
    );
    let positions = position(1, a) + &position(2, b);
    let cell = cell(&["J P[1] 100% FINE", "L P[2] 200mm/sec FINE"], &positions);
    cell.advance(0.001).await;
    while kinds(&cell).await.len() < 3 {
        cell.advance(0.01).await;
    }
    cell.advance(0.7).await;
    cell.controller.hold().await.unwrap();
    cell.advance(2.0).await;
    let held = cell.controller.state().await.unwrap();
    assert!(held.held && !held.moving);
    assert!((-150.0..150.0).contains(&held.pose.y_mm), "{}", held.pose);
    cell.controller.cycle_start().await.unwrap();
    for _ in 0..100 {
        cell.advance(0.02).await;
        let pose = cell.controller.state().await.unwrap().pose;
        assert!(
            (pose.x_mm - 900.0).abs() < 0.01 && (pose.z_mm - 700.0).abs() < 0.01,
            "{pose}"
        );
    }
    cell.advance(2.0).await;
    assert!((cell.controller.state().await.unwrap().pose.y_mm + 200.0).abs() < 1e-3);
}

#[tokio::test]
async fn a_line_that_cannot_be_traveled_is_an_alarm_with_its_reason_and_no_motion() {
    let start = [900.0, 200.0, 700.0, 180.0, 0.0, 0.0];
    let cases = [
        (
            "L P[2] 200mm/sec FINE",
            [-900.0, -200.0, 700.0, 180.0, 0.0, 0.0],
            "MOTN-",
        ),
        (
            "L P[2] 2000mm/sec FINE",
            [350.0, 0.0, 1700.0, 180.0, 0.0, 0.0],
            "MOTN-",
        ),
        (
            "L P[2] 2001mm/sec FINE",
            [900.0, 100.0, 700.0, 180.0, 0.0, 0.0],
            "speed is 2001",
        ),
        (
            "L P[2] 200mm/sec FINE",
            [900.0, 200.0, 700.0, 0.0, 0.0, 0.0],
            "half a turn",
        ),
        (
            "L P[2] 200mm/sec FINE",
            [5000.0, 0.0, 700.0, 180.0, 0.0, 0.0],
            "MOTN-018",
        ),
        (
            "J P[2] 101% FINE",
            [900.0, 100.0, 700.0, 180.0, 0.0, 0.0],
            "speed is 101",
        ),
    ];
    for (line, target, reason) in cases {
        let positions = position(1, start) + &position(2, target);
        let cell = cell(&["J P[1] 100% FINE", line], &positions);
        cell.advance(0.001).await;
        cell.until_standstill().await;
        cell.advance(0.1).await;
        let last = cell.controller.ledger().await.unwrap().pop().unwrap();
        assert_eq!(last.event, LedgerEvent::Refused, "{line} to {target:?}");
        let alarm = last.alarm.unwrap();
        assert!(alarm.contains(reason), "{line} to {target:?}: {alarm}");
        let state = cell.controller.state().await.unwrap();
        assert_eq!(state.active_alarms, 1);
    }
}

#[tokio::test]
async fn percentages_scale_the_time_and_so_does_acc() {
    let mut times = Vec::new();
    for line in [
        "J P[1] 100% FINE",
        "J P[1] 50% FINE",
        "J P[1] 50% FINE ACC20",
    ] {
        let cell = cell(
            &[line],
            &position(1, [900.0, 600.0, 700.0, 180.0, 0.0, 0.0]),
        );
        cell.advance(0.001).await;
        cell.until_standstill().await;
        let last = cell.controller.ledger().await.unwrap().pop().unwrap();
        times.push(last.duration_s.unwrap());
    }
    assert!(times[0] < times[1] && times[1] < times[2], "{times:?}");
}

#[tokio::test]
async fn a_taught_position_in_another_frame_is_refused() {
    let cell = cell(
        &["UFRAME_NUM=2", "J P[1] 100% FINE"],
        &position(1, [900.0, 0.0, 700.0, 180.0, 0.0, 0.0]),
    );
    cell.advance(0.1).await;
    let alarms = cell.controller.alarms().await.unwrap();
    assert!(
        alarms[0].text.contains("user frame 0, active is 2"),
        "{alarms:?}"
    );
    assert!(cell.controller.ledger().await.unwrap().is_empty());
}
