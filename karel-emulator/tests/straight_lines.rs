//! Motions of TP and KAREL programs: straight lines that are straight, arcs that are round, percentages, and what is refused.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a helper that fails stops its test"
)]

mod common;

use common::tp::{Core, config, position};
use common::{Stepped, arm};
use karel_emulator::LedgerEvent::{Finished, Started};
use karel_emulator::ledger::MotionKind;
use karel_emulator::{ControllerConfig, LedgerEvent, ProgramSource};
use kinematics::Axis;

fn cell(lines: &[&str], positions: &str) -> Stepped {
    Stepped::start(&config(lines, positions))
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
        // J1 turns by 34 degrees; at 50 % it would not reach its speed within 34.1, and be as fast as at 100 %.
        "J P[1] 25% FINE",
        "J P[1] 25% FINE ACC20",
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

/// Looks at the whole motion of a cell that has just started its second one: how far the tool is from the circle of
/// `radius` about `center` in the plane `x = 900`, the poses it passed, and the fastest it was.
async fn around(cell: &Stepped, center: [f64; 2], radius: f64) -> (f64, Vec<[f64; 3]>, f64) {
    while cell.controller.ledger().await.unwrap().len() < 3 {
        cell.advance(0.002).await;
    }
    let (mut off, mut passed, mut fastest) = (0.0_f64, Vec::<[f64; 3]>::new(), 0.0_f64);
    loop {
        let state = cell.controller.state().await.unwrap();
        let p = state.pose;
        let from_center = (p.y_mm - center[0]).hypot(p.z_mm - center[1]);
        off = off
            .max((from_center - radius).abs())
            .max((p.x_mm - 900.0).abs());
        if let Some([y, z, _]) = passed.last() {
            fastest = fastest.max((p.y_mm - y).hypot(p.z_mm - z) / 0.004);
        }
        passed.push([p.y_mm, p.z_mm, p.p_deg]);
        if !state.moving {
            return (off, passed, fastest);
        }
        cell.advance(0.004).await;
    }
}

const ON_THE_LEFT: [f64; 6] = [900.0, 200.0, 700.0, 180.0, 0.0, 0.0];
const ON_TOP: [f64; 6] = [900.0, 0.0, 900.0, 180.0, 10.0, 0.0];
const BELOW: [f64; 6] = [900.0, 0.0, 500.0, 180.0, 0.0, 0.0];

#[tokio::test]
async fn an_arc_is_round_passes_its_middle_and_keeps_its_speed() {
    // Three quarters of a circle, the long way around.
    let positions = position(1, ON_THE_LEFT) + &position(2, ON_TOP) + &position(3, BELOW);
    let lines = ["J P[1] 100% FINE", "C P[2]\n    :  P[3] 300mm/sec FINE"];
    let cell = cell(&lines, &positions);
    cell.advance(0.001).await;
    let (off, passed, fastest) = around(&cell, [0.0, 700.0], 200.0).await;
    assert!(off < 0.02, "{off} mm beside the circle");
    assert!((fastest - 300.0).abs() < 1.0, "{fastest} mm/s");
    let top = passed
        .iter()
        .min_by(|a, b| (a[0].abs() - a[1]).total_cmp(&(b[0].abs() - b[1])))
        .unwrap();
    assert!(
        (top[1] - 900.0).abs() < 1.0 && (top[2] - 10.0).abs() < 0.5,
        "{top:?}"
    );
    assert!(
        passed.iter().any(|p| (p[0] + 200.0).abs() < 1.0),
        "not over the right"
    );
    let last = passed.last().unwrap();
    assert!(
        (last[1] - 500.0).abs() < 1e-3 && last[2].abs() < 1e-3,
        "{last:?}"
    );
    let ends = kinds(&cell).await.split_off(2);
    assert_eq!(
        ends,
        [
            (Started, MotionKind::Circular),
            (Finished, MotionKind::Circular)
        ]
    );
}

/// The kinds of the motions that were started.
fn started(core: &Core) -> Vec<MotionKind> {
    let ledger = core.0.ledger(0);
    let started = ledger.iter().filter(|entry| entry.event == Started);
    started.map(|entry| entry.kind).collect()
}

#[test]
fn assumed_places_of_a_lines_make_arcs_of_the_circle_through_three_of_them() {
    let right = [900.0, -200.0, 700.0, 180.0, 0.0, 0.0];
    let above = [900.0, 200.0, 900.0, 180.0, 0.0, 0.0];
    let positions = position(1, ON_THE_LEFT)
        + &position(2, ON_TOP)
        + &position(3, right)
        + &position(4, BELOW)
        + &position(5, above);
    let lines = [
        "J P[5] 100% FINE",
        "A P[1] 300mm/sec FINE",
        "A P[2] 300mm/sec FINE",
        "! on the way",
        "A P[3] 300mm/sec FINE",
        "A P[4] 300mm/sec FINE",
        // Two of them are no circle.
        "L P[1] 300mm/sec FINE",
        "A P[5] 300mm/sec FINE",
        "A P[1] 300mm/sec FINE",
    ];
    let mut core = Core::moves(&lines, &positions);
    let (mut off, mut quarters) = (0.0_f64, Vec::new());
    while !(core.0.state().idle && started(&core).len() == 8) {
        core.advance(0.004);
        let [x, y, z] = core.tool();
        if (3..=5).contains(&started(&core).len()) {
            off = off
                .max((y.hypot(z - 700.0) - 200.0).abs())
                .max((x - 900.0).abs());
            let quarter = (y > 0.0, z > 700.0);
            if quarters.last() != Some(&quarter) {
                quarters.push(quarter);
            }
        }
    }
    assert!(off < 0.02, "{off} mm beside the circle");
    // From the left over the top to the right, and on to below: never back over the left.
    let over_the_top = [(true, true), (false, true), (false, false)];
    assert_eq!(quarters.get(..3), Some(&over_the_top[..]), "{quarters:?}");
    let (joint, line, arc) = (MotionKind::Joint, MotionKind::Linear, MotionKind::Circular);
    let kinds = [joint, line, arc, arc, arc, line, line, line];
    assert_eq!(started(&core), kinds);
}

#[test]
fn three_places_of_a_lines_on_one_line_are_no_circle() {
    let place = |n, y| position(n, [900.0, y, 700.0, 180.0, 0.0, 0.0]);
    let lines = [
        "J P[1] 100% FINE",
        "A P[1] 300mm/sec FINE",
        "A P[2] 300mm/sec FINE",
        "A P[3] 300mm/sec FINE",
    ];
    let mut core = Core::moves(
        &lines,
        &(place(1, -100.0) + &place(2, 0.0) + &place(3, 100.0)),
    );
    core.finish();
    let alarm = core.last_alarm();
    assert!(alarm.starts_with("MOTN-997"), "{alarm}");
}

#[tokio::test]
async fn a_karel_move_goes_along_the_same_line_or_arc() {
    let program = "PROGRAM arc
VAR p, via : XYZWPR
BEGIN
  $UTOOL = $MNUTOOL[1,1]
  p = POS(900, 200, 700, 180, 0, 0, $NILPOS.CONFIG_DATA)
  MOVE TO p
  $MOTYPE = CIRCULAR
  $SPEED = 250
  via = p ; via.y = 0 ; via.z = 900
  p.y = -200
  MOVE TO p VIA via
  $MOTYPE = LINEAR
  p.y = 200
  MOVE TO p NOWAIT
END arc
";
    let program = program.replace(", $NILPOS.CONFIG_DATA", ", c");
    let program = program.replace(
        "via : XYZWPR\n",
        "via : XYZWPR\n    c : CONFIG\n    s : INTEGER\n",
    );
    let program = program.replace("BEGIN\n", "BEGIN\n  CNV_STR_CONF('N U T', c, s)\n");
    let mut config = ControllerConfig::new("karel", arm());
    config = config.with_program(ProgramSource::new("arc.kl", program));
    let cell = Stepped::start(&config);
    cell.advance(0.001).await;
    let (mut highest, mut off) = (0.0_f64, 0.0_f64);
    while kinds(&cell).await.len() < 6 {
        cell.advance(0.004).await;
        if kinds(&cell).await.len() == 3 {
            let p = cell.controller.state().await.unwrap().pose;
            highest = highest.max(p.z_mm);
            off = off.max((p.y_mm.hypot(p.z_mm - 700.0) - 200.0).abs());
        }
    }
    assert!(
        (highest - 900.0).abs() < 0.1 && off < 0.02,
        "{highest}, {off}"
    );
    let seen: Vec<MotionKind> = kinds(&cell).await.into_iter().map(|e| e.1).collect();
    let [joint, arc, line] = [MotionKind::Joint, MotionKind::Circular, MotionKind::Linear];
    assert_eq!(seen, [joint, joint, arc, arc, line, line]);
}

#[tokio::test]
async fn an_arc_that_does_not_exist_is_an_alarm_and_no_motion() {
    let on_the_line = [900.0, 0.0, 700.0, 180.0, 0.0, 0.0];
    let behind_it = [900.0, -200.0, 700.0, 180.0, 0.0, 0.0];
    let cases = [
        (on_the_line, behind_it, "100mm/sec", "on one line"),
        (ON_TOP, ON_THE_LEFT, "100mm/sec", "at the same place"),
        (ON_TOP, ON_TOP, "100mm/sec", "at the same place"),
        (
            ON_TOP,
            [900.0, 0.0, 500.0, 0.0, 0.0, 0.0],
            "100mm/sec",
            "half a turn",
        ),
        (
            ON_TOP,
            [900.0, -3000.0, 700.0, 180.0, 0.0, 0.0],
            "100mm/sec",
            "MOTN-018",
        ),
        (ON_TOP, BELOW, "2001mm/sec", "speed is 2001"),
    ];
    for (via, end, speed, reason) in cases {
        let positions = position(1, ON_THE_LEFT) + &position(2, via) + &position(3, end);
        let circle = format!("C P[2]\n    :  P[3] {speed} FINE");
        let cell = cell(&["J P[1] 100% FINE", &circle], &positions);
        cell.advance(0.001).await;
        cell.until_standstill().await;
        cell.advance(0.1).await;
        let last = cell.controller.ledger().await.unwrap().pop().unwrap();
        assert_eq!(last.event, LedgerEvent::Refused, "{reason}");
        assert_eq!(last.kind, MotionKind::Circular);
        let alarm = last.alarm.unwrap();
        assert!(alarm.contains(reason), "{reason}: {alarm}");
        assert!(!cell.controller.state().await.unwrap().moving);
    }
}

#[tokio::test]
async fn offsets_shift_the_target_in_the_user_frame_and_in_the_tool() {
    // The tool looks down: its X is that of the world, its Z and Y are turned around.
    for (line, wanted) in [
        ("L P[1] 500mm/sec FINE Offset,PR[1]", [890.0, 230.0, 705.0]),
        (
            "L P[1] 500mm/sec FINE Tool_Offset,PR[1]",
            [890.0, 170.0, 695.0],
        ),
        ("L P[1] 500mm/sec CNT50 ACC50 Offset", [890.0, 230.0, 705.0]),
    ] {
        let lines = [
            "J P[1] 100% FINE",
            "PR[1,1]=(-10)",
            "PR[1,2]=30",
            "PR[1,3]=5",
            "OFFSET CONDITION PR[1]",
            line,
        ];
        let cell = cell(&lines, &position(1, ON_THE_LEFT));
        cell.advance(0.001).await;
        while kinds(&cell).await.len() < 4 {
            cell.advance(0.05).await;
        }
        let p = cell.controller.state().await.unwrap().pose;
        for (is, wanted) in [p.x_mm, p.y_mm, p.z_mm].into_iter().zip(wanted) {
            assert!((is - wanted).abs() < 1e-2, "{line}: {p}");
        }
    }
}

#[tokio::test]
async fn a_skip_condition_ends_the_motion_and_without_it_the_label_is_next() {
    let target = [900.0, -200.0, 700.0, 180.0, 0.0, 0.0];
    let positions = position(1, ON_THE_LEFT) + &position(2, target);
    for (flag, ended, register) in [
        ("F[1]=(ON)", LedgerEvent::Cancelled, 1),
        ("F[1]=(OFF)", LedgerEvent::Finished, 2),
    ] {
        let lines = [
            "J P[1] 100% FINE",
            flag,
            "SKIP CONDITION F[1]=ON",
            "L P[2] 200mm/sec FINE Skip,LBL[1]",
            "MESSAGE[part 1]",
            "END",
            "LBL[1]",
            "MESSAGE[part 2]",
        ];
        let cell = cell(&lines, &positions);
        cell.advance(0.001).await;
        while cell.controller.screen().await.unwrap().is_empty() {
            cell.advance(0.05).await;
        }
        assert_eq!(kinds(&cell).await.pop().unwrap().0, ended, "{flag}");
        let screen = cell.controller.screen().await.unwrap();
        assert_eq!(screen, [format!("part {register}")]);
    }
}
