//! Speeds, increments and wrists of TP motions.
#![allow(clippy::unwrap_used, reason = "a helper that fails stops its test")]

mod common;

use common::tp::{Core, corner, distance, position};
use karel_emulator::LedgerEvent;

#[test]
fn a_motion_takes_the_seconds_that_it_is_given() {
    for (line, seconds) in [
        ("J P[2] 3.0sec FINE", 3.0),
        ("J P[2] 2500msec FINE", 2.5),
        ("L P[2] 4.0sec FINE", 4.0),
        ("L P[2] 1500msec FINE", 1.5),
    ] {
        let mut core = Core::moves(&["J P[1] 100% FINE", line], &corner());
        core.finish();
        assert!(
            (core.lasted(2) - seconds).abs() < 1e-3,
            "{line}: {}",
            core.lasted(2)
        );
    }
}

#[test]
fn a_time_that_is_too_short_and_a_speed_that_cannot_be_are_refused_with_a_reason() {
    let turned = position(4, [900.0, -200.0, 700.0, 180.0, 0.0, 90.0]);
    for (line, reason) in [
        ("J P[2] 50msec FINE", "is the shortest"),
        ("L P[2] 50msec FINE", "is the shortest"),
        ("L P[2] 0sec FINE", "no speed of this motion"),
        ("L P[2] 90deg/sec FINE", "needs a change of orientation"),
        ("L P[4] 181deg/sec FINE", "would be faster than"),
        ("L P[2] 5000inch/min FINE", "at most 2000"),
        ("J P[2] 10% FINE ACC151", "ACC is 151"),
    ] {
        let mut core = Core::moves(&["J P[1] 100% FINE", line], &(corner() + &turned));
        core.finish();
        let last = core.0.ledger(0).pop().unwrap();
        assert_eq!(last.event, LedgerEvent::Refused, "{line}");
        let alarm = last.alarm.unwrap();
        assert!(alarm.contains(reason), "{line}: {alarm}");
        assert!(alarm.starts_with("INTP-215"), "{line}: {alarm}");
    }
}

#[test]
fn degrees_and_inches_are_what_they_are() {
    let turned = position(4, [900.0, -200.0, 700.0, 180.0, 0.0, 90.0]);
    let time = |line: &str| {
        let mut core = Core::moves(&["J P[1] 100% FINE", line], &(corner() + &turned));
        core.finish();
        core.lasted(2)
    };
    // 45 deg/s at 7200 deg/s³ take 2 sqrt(v / j), half of it beyond the 90 / 45 s, at either end.
    let expected = 2.0 + 2.0 * (45.0_f64 / 7200.0).sqrt();
    assert!((time("L P[4] 45deg/sec FINE") - expected).abs() < 1e-3);
    let inches = time("L P[2] 600inch/min FINE");
    assert!((inches - time("L P[2] 254mm/sec FINE")).abs() < 1e-6);
    assert!((inches - time("L P[2] 1524cm/min FINE")).abs() < 1e-6);
}

#[test]
fn an_increment_counts_from_where_the_motion_starts() {
    let lines = [
        "J P[1] 100% FINE",
        "PR[1]=LPOS",
        "PR[1]=PR[1]-PR[1]",
        "PR[1,2]=50",
        "L PR[1] 200mm/sec CNT100 INC",
        "PR[1,2]=0",
        "PR[1,3]=40",
        "L PR[1] 200mm/sec FINE INC",
        "PR[2]=JPOS",
        "PR[2]=PR[2]-PR[2]",
        "PR[2,1]=10",
        "J PR[2] 20% FINE INC",
    ];
    let mut core = Core::moves(&lines, &corner());
    core.advance(0.001);
    core.until(|core| core.events().contains(&(3, LedgerEvent::Finished)));
    assert!(
        distance(core.tool(), [900.0, -150.0, 740.0]) < 0.01,
        "{:?}",
        core.tool()
    );
    let j1 = core.0.joints_deg()[0];
    core.until(|core| core.0.state().idle);
    assert!((core.0.joints_deg()[0] - j1 - 10.0).abs() < 1e-3);
}

/// Through a straight wrist no line keeps the orientation; with Wjnt the tool stays on its line.
#[test]
fn a_wrist_that_goes_as_in_a_joint_motion_passes_its_singularity() {
    // The wrist bends to one side at the start, to the other at the end.
    let ends = "P[1]{\n   GP1:\n\tUF : F, UT : F,\n\tJ1 = 0 deg,\tJ2 = 0 deg,\tJ3 = 0 deg,\n\tJ4 = 0 deg,\tJ5 = -40 deg,\tJ6 = 0 deg\n};\n\
        P[2]{\n   GP1:\n\tUF : F, UT : F,\n\tJ1 = 10 deg,\tJ2 = 5 deg,\tJ3 = 5 deg,\n\tJ4 = 0 deg,\tJ5 = 40 deg,\tJ6 = 0 deg\n};\n";
    let mut core = Core::moves(&["J P[1] 100% FINE", "L P[2] 200mm/sec FINE"], ends);
    core.finish();
    let last = core.0.ledger(0).pop().unwrap();
    assert_eq!(last.event, LedgerEvent::Refused);

    let mut core = Core::moves(&["J P[1] 100% FINE", "L P[2] 200mm/sec FINE Wjnt"], ends);
    core.advance(0.001);
    core.until(|core| core.started(2));
    let (start, mut way) = (core.tool(), Vec::new());
    core.until(|core| {
        way.push((core.tool(), core.0.joints_deg()));
        core.0.state().idle
    });
    let end = core.tool();
    assert_eq!(
        core.events().last(),
        Some(&(2, LedgerEvent::Finished)),
        "{:?}",
        core.0.alarms()
    );
    let length = distance(start, end);
    for (place, joints) in &way {
        let detour = distance(start, *place) + distance(*place, end) - length;
        assert!(detour < 0.05, "{detour} mm longer at {place:?}");
        assert!(joints[3].abs() < 1e-6, "J4 at {}", joints[3]);
    }
    assert!((core.0.joints_deg()[4] - 40.0).abs() < 1e-3);
}

#[test]
fn a_skip_keeps_where_the_arm_was_and_goes_on_and_without_it_jumps() {
    for (after, skipped) in [(0.3, true), (60.0, false)] {
        let lines = [
            "J P[1] 100% FINE",
            "SKIP CONDITION DI[1]=ON",
            "L P[2] 100mm/sec FINE Skip,LBL[1],PR[5]=LPOS",
            "R[1]=1",
            "LBL[1]",
            "R[2]=1",
        ];
        let mut core = Core::moves(&lines, &corner());
        core.until(|core| core.started(2));
        core.advance(if skipped { after } else { 0.0 });
        let place = core.tool();
        if skipped {
            let on = karel::PortValue::Switch(true);
            core.0.set_input(karel::Port::DigitalIn, 1, on).unwrap();
        }
        core.until(|core| core.0.state().idle);
        let r1 = core.0.registers().number(1).unwrap();
        assert_eq!(r1 == karel::Number::Integer(1), skipped);
        let kept = core.0.registers().position(5).unwrap().clone();
        if !skipped {
            assert_eq!(kept, karel::PositionRegister::Unset);
            assert!(distance(core.tool(), [900.0, 0.0, 700.0]) < 1e-3);
            continue;
        }
        let karel::PositionRegister::Cartesian(kept) = kept else {
            panic!("{kept:?}");
        };
        let kept = [kept.x, kept.y, kept.z].map(f64::from);
        let later = distance(kept, place);
        assert!(later < 1.7, "kept {later} mm behind the input");
        let braking = distance(core.tool(), kept);
        // 100 mm/s at 30,000 mm/s³: v sqrt(v / j) are 5.8 mm, of which the input's period is no part.
        assert!((4.0..6.5).contains(&braking), "{braking} mm to brake");
    }
}
