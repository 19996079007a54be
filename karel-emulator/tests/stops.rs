//! Emergency stops in stages, reduced speed, and what programs see of a moving arm.
#![allow(clippy::unwrap_used, reason = "a helper that fails stops its test")]

mod common;

use common::tp::{Core, config, corner, distance};
use karel::Number;
use karel_emulator::LedgerEvent::{Finished, Held, Resumed, Started};
use karel_emulator::{OperatingMode, Operation, StopCategory, StopSource};

const LINES: [&str; 2] = ["J P[1] 100% FINE", "L P[2] 200mm/sec FINE"];

/// In the middle of the second motion.
fn on_the_line(category: StopCategory) -> Core {
    let mut config = config(&LINES, &corner());
    config.stop_category = category;
    let mut core = Core::of(&config);
    core.until(|core| core.started(2));
    core.advance(0.5);
    assert!(core.0.state().moving);
    core
}

/// Seconds and millimeters from a stop to the standstill.
fn stop(core: &mut Core, operation: Operation) -> (f64, f64) {
    let (begin, place) = (core.now(), core.tool());
    core.0.operate(operation).unwrap();
    core.until(|core| !core.0.state().moving);
    (core.now() - begin, distance(core.tool(), place))
}

#[test]
fn an_emergency_stop_brakes_first_and_then_takes_the_power() {
    let mut core = on_the_line(StopCategory::Controlled);
    core.0.operate(Operation::EmergencyStop(true)).unwrap();
    assert_eq!(core.last_alarm(), "SRVO-001 Operator panel E-stop");
    let state = core.0.state();
    assert!(state.moving && state.servo_power && state.emergency_stop);
    core.until(|core| !core.0.state().moving);
    let state = core.0.state();
    assert!(!state.servo_power && state.held);
    let there = core.tool();
    assert!((there[0] - 900.0).abs() < 0.01 && (there[2] - 700.0).abs() < 0.01);

    core.0.operate(Operation::EmergencyStop(false)).unwrap();
    assert!(
        core.0.operate(Operation::CycleStart).is_err(),
        "a reset is due"
    );
    assert!(!core.0.state().servo_power);
    core.0.operate(Operation::Reset).unwrap();
    assert!(core.0.state().servo_power);
    core.advance(1.0);
    assert!(
        distance(core.tool(), there) < 1e-9,
        "nothing goes on by itself"
    );
    core.0.operate(Operation::CycleStart).unwrap();
    core.until(|core| core.0.state().idle);
    assert!(distance(core.tool(), [900.0, 0.0, 700.0]) < 1e-3);
    let history = [(2, Started), (2, Held), (2, Resumed), (2, Finished)];
    assert_eq!(core.events()[2..], history);
}

#[test]
fn category_0_takes_the_power_at_once_and_stops_in_half_of_the_way() {
    let press = Operation::EmergencyStop(true);
    let (seconds, way) = stop(&mut on_the_line(StopCategory::Controlled), press.clone());
    let mut core = on_the_line(StopCategory::PowerOff);
    core.0.operate(press.clone()).unwrap();
    let state = core.0.state();
    assert!(state.moving && !state.servo_power);
    let mut core = on_the_line(StopCategory::PowerOff);
    let (sooner, shorter) = stop(&mut core, press);
    assert!(
        (seconds - 2.0 * sooner).abs() < 0.01,
        "{seconds} s, {sooner} s"
    );
    assert!((way - 2.0 * shorter).abs() < 0.5, "{way} mm, {shorter} mm");
    // 200 mm/s at 30,000 mm/s³: 2 sqrt(v / j) s, and half of that way. It would take 300 mm/s to reach 3000 mm/s².
    let expected = 200.0 * (200.0_f64 / 30_000.0).sqrt();
    assert!((way - expected).abs() < 0.5, "{way} mm, {expected} mm");
}

#[test]
fn every_stop_has_its_alarm_and_its_bit() {
    for (source, headline, bit) in [
        (StopSource::Panel, "SRVO-001 Operator panel E-stop", 1),
        (StopSource::Pendant, "SRVO-002 Teach pendant E-stop", 2),
        (StopSource::Fence, "SRVO-004 Fence open", 8),
        (
            StopSource::External,
            "SRVO-007 External emergency stops",
            64,
        ),
    ] {
        let mut core = on_the_line(StopCategory::Controlled);
        let status = |core: &mut Core| {
            let value = core.0.variable("$MOR.$SAFETY_STAT").unwrap();
            serde_json::to_value(value).unwrap()
        };
        assert_eq!(status(&mut core), serde_json::json!(0));
        let active = true;
        core.0
            .operate(Operation::SafetyStop { source, active })
            .unwrap();
        assert_eq!(core.last_alarm(), headline);
        assert_eq!(status(&mut core), serde_json::json!(bit));
        core.until(|core| !core.0.state().moving);
        core.0.operate(Operation::Reset).unwrap();
        assert_eq!(core.0.state().active_alarms, 1, "it still stops");
        let active = false;
        core.0
            .operate(Operation::SafetyStop { source, active })
            .unwrap();
        core.0.operate(Operation::Reset).unwrap();
        core.0.operate(Operation::CycleStart).unwrap();
        core.until(|core| core.0.state().idle);
    }
}

#[test]
fn an_open_fence_is_a_controlled_stop_whatever_the_buttons_are() {
    let (source, active) = (StopSource::Fence, true);
    let open = Operation::SafetyStop { source, active };
    let (_, way) = stop(&mut on_the_line(StopCategory::PowerOff), open.clone());
    let (_, other) = stop(&mut on_the_line(StopCategory::Controlled), open);
    assert!((way - other).abs() < 1e-6);
}

#[test]
fn in_t1_the_tool_is_not_faster_than_250_mm_s_and_the_enabling_switch_stops_it() {
    let lines = [
        "J P[1] 100% FINE",
        "L P[2] 1000mm/sec FINE",
        "J P[3] 100% FINE",
    ];
    let mut core = Core::moves(&lines, &corner());
    for operation in [
        Operation::SetMode(OperatingMode::T1),
        Operation::SetPendant(true),
        Operation::Reset,
    ] {
        core.0.operate(operation).unwrap();
    }
    assert!(
        core.0.operate(Operation::CycleStart).is_err(),
        "nobody holds the switch"
    );
    core.0.operate(Operation::SetDeadman(true)).unwrap();
    core.0.operate(Operation::CycleStart).unwrap();
    core.advance(0.001);
    let mut fastest = 0.0_f64;
    core.until(|core| core.started(2));
    core.advance(0.4);
    core.0.operate(Operation::SetDeadman(false)).unwrap();
    assert_eq!(core.last_alarm(), "SRVO-003 Deadman switch released");
    core.until(|core| !core.0.state().moving);
    assert!(!core.0.state().servo_power);
    core.0.operate(Operation::SetDeadman(true)).unwrap();
    core.0.operate(Operation::Reset).unwrap();
    core.0.operate(Operation::CycleStart).unwrap();
    let mut before = core.tool();
    core.advance(0.002);
    while !core.0.state().idle {
        let here = core.tool();
        fastest = fastest.max(distance(here, before) / 0.002);
        before = here;
        core.advance(0.002);
    }
    assert!((240.0..250.5).contains(&fastest), "{fastest} mm/s");
    assert!(distance(core.tool(), [900.0, 0.0, 900.0]) < 1e-3);
}

#[test]
fn the_override_changes_the_speed_without_a_jump() {
    let mut core = on_the_line(StopCategory::Controlled);
    let mut speeds = Vec::new();
    core.0.operate(Operation::SetOverride(20)).unwrap();
    let mut before = core.tool();
    // 2 sqrt(v / j) for 200 mm/s at 30,000 mm/s³ are 0.163 s.
    for _ in 0..90 {
        core.advance(0.002);
        let here = core.tool();
        speeds.push(distance(here, before) / 0.002);
        before = here;
    }
    let jumps = speeds.iter().zip(speeds.iter().skip(1));
    assert!(
        jumps.clone().all(|(a, b)| (a - b).abs() < 7.0),
        "{speeds:?}"
    );
    assert!(
        speeds[0] > 190.0 && (speeds[89] - 40.0).abs() < 0.5,
        "{speeds:?}"
    );
}

/// CURPOS while the arm moves is that of the last interpolation period, and exact at a standstill.
#[test]
fn programs_see_the_arm_as_it_was_at_the_last_period() {
    let program = "PROGRAM looks
VAR p, q : XYZWPR
    s : INTEGER
BEGIN
  $MOTYPE = LINEAR
  p = CURPOS(0, 0)
  p.y = p.y + 100
  MOVE TO p NOWAIT
  WHILE TRUE DO
    q = CURPOS(0, 0)
    SET_REAL_REG(1, q.y, s)
    DELAY 1
  ENDWHILE
END looks
";
    let mut core = Core::of(&common::config_of(program, &[]));
    core.advance(0.1);
    let (mut changes, mut last) = (Vec::new(), Number::Integer(0));
    for _ in 0..48 {
        core.advance(0.001);
        let seen = core.0.registers().number(1).unwrap();
        if seen != last {
            changes.push((core.now() * 1000.0).round());
            last = seen;
        }
    }
    let steps: Vec<f64> = changes
        .iter()
        .zip(changes.iter().skip(1))
        .map(|(a, b)| b - a)
        .collect();
    assert!(
        steps.len() >= 4 && steps[1..].iter().all(|step| (*step - 8.0).abs() < 0.5),
        "{changes:?}"
    );
    core.advance(5.0);
    let Number::Real(y) = core.0.registers().number(1).unwrap() else {
        panic!("no number");
    };
    assert!((f64::from(y) - core.tool()[1]).abs() < 1e-3);
}

#[test]
fn a_speed_is_a_part_of_speedlim_and_rotspeed_limits_a_rotation() {
    let joint = |limit: &str| {
        let program = format!(
            "PROGRAM j
VAR p : XYZWPR
BEGIN
  $SPEED = 200
  {limit}
  p = CURPOS(0, 0)
  p.y = p.y + 400
  MOVE TO p
END j
"
        );
        let mut core = Core::of(&common::config_of(&program, &[]));
        core.finish();
        core.lasted(1)
    };
    assert!(joint("$SPEEDLIM = 1000") < 0.75 * joint(""));
    let turn = |speed: f64| {
        let program = format!(
            "PROGRAM t
VAR p : XYZWPR
BEGIN
  $MOTYPE = LINEAR
  $ROTSPEED = {speed}
  p = CURPOS(0, 0)
  p.r = p.r + 45
  MOVE TO p
END t
"
        );
        let mut core = Core::of(&common::config_of(&program, &[]));
        core.finish();
        core.lasted(1)
    };
    // 30 deg/s at 7200 deg/s³ take 2 sqrt(v / j), half of it beyond the 45 / 30 s, at either end.
    let expected = 45.0 / 30.0 + 2.0 * (30.0_f64 / 7200.0).sqrt();
    assert!((turn(30.0) - expected).abs() < 0.01, "{}", turn(30.0));
}
