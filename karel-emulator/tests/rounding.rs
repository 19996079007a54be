//! Corners of programs: what rounds them and what does not, and when the program goes on.
#![allow(clippy::unwrap_used, reason = "a helper that fails stops its test")]

mod common;

use std::time::Duration;

use common::tp::{Core, config, corner, distance, listing};
use karel::{Port, PortValue, PositionRegister};
use karel_emulator::LedgerEvent::{Finished, Passed, Started};
use karel_emulator::{Controller, Operation, ProgramSource};

const CORNER: [f64; 3] = [900.0, 0.0, 700.0];

/// How near the tool comes to the corner, and how slow it is there.
fn drive_around(core: &mut Core) -> (f64, f64) {
    core.advance(0.001);
    core.until(|core| core.started(2));
    let (mut nearest, mut slowest) = (f64::INFINITY, f64::INFINITY);
    let mut before = core.tool();
    core.advance(0.1);
    while !core.0.state().idle {
        core.advance(0.002);
        let here = core.tool();
        let to_corner = distance(here, CORNER);
        nearest = nearest.min(to_corner);
        if to_corner < 40.0 {
            slowest = slowest.min(distance(here, before) / 0.002);
        }
        before = here;
    }
    (nearest, slowest)
}

fn lines(termination: &str) -> [String; 3] {
    [
        "J P[1] 100% FINE".to_owned(),
        format!("L P[2] 300mm/sec {termination}"),
        "L P[3] 300mm/sec FINE".to_owned(),
    ]
}

#[test]
fn the_more_cnt_the_rounder_and_the_faster_is_the_corner() {
    let mut found = Vec::new();
    for termination in ["FINE", "CNT0", "CNT50", "CNT100"] {
        let lines = lines(termination);
        let lines: Vec<&str> = lines.iter().map(String::as_str).collect();
        found.push(drive_around(&mut Core::moves(&lines, &corner())));
    }
    let mut pairs = found.iter().zip(found.iter().skip(1));
    assert!(
        pairs.all(|(one, next)| one.0 < next.0 && one.1 < next.1),
        "{found:?}"
    );
    let (near, slowest) = found[3];
    assert!((2.0..8.0).contains(&near) && slowest > 200.0, "{found:?}");
}

#[test]
fn lines_between_two_motions_are_executed_when_the_corner_begins() {
    let lines = [
        "J P[1] 100% FINE",
        "L P[2] 300mm/sec CNT100",
        "DO[1]=ON",
        "R[1]=R[1]+1",
        "IF R[1]=1,JMP LBL[1]",
        "LBL[1]",
        "L P[3] 300mm/sec FINE",
        "DO[2]=ON",
    ];
    let mut core = Core::moves(&lines, &corner());
    let is_on = |core: &Core, n: u16| {
        let ports = core.0.state().ports;
        let name = format!("DOUT[{n}]");
        ports
            .iter()
            .any(|port| port.port == name && port.value == 1)
    };
    core.until(|core| is_on(core, 1));
    let way = distance(core.tool(), CORNER);
    // 300 mm/s at 3000 mm/s² and 30,000 mm/s³: v (v / a + a / j) / 2 are 30 mm.
    assert!((25.0..31.0).contains(&way), "{way} mm before the corner");
    core.until(|core| is_on(core, 2));
    assert!(distance(core.tool(), [900.0, 0.0, 900.0]) < 1e-3);
    let history = [
        (1, Started),
        (1, Finished),
        (2, Started),
        (3, Started),
        (2, Passed),
        (3, Finished),
    ];
    assert_eq!(core.events(), history);
}

#[test]
fn a_wait_that_has_to_wait_ends_the_rounding_and_one_that_holds_does_not() {
    for (wait, events) in [
        // The arm brakes for 0.2 s.
        ("WAIT .30(sec)", [(2, Finished), (3, Started)]),
        ("WAIT DI[1]=ON", [(3, Started), (2, Passed)]),
    ] {
        let lines = [
            "J P[1] 100% FINE",
            "L P[2] 300mm/sec CNT100",
            wait,
            "L P[3] 300mm/sec FINE",
        ];
        let mut core = Core::moves(&lines, &corner());
        core.0
            .set_input(Port::DigitalIn, 1, PortValue::Switch(true))
            .unwrap();
        let (near, _) = drive_around(&mut core);
        assert_eq!(core.events()[3..5], events, "{wait}");
        assert_eq!(near < 0.1, wait.contains("sec"), "{wait}: {near} mm");
    }
}

#[test]
fn a_corner_between_a_line_and_a_joint_motion_and_around_an_arc_is_smooth() {
    let more = common::tp::position(4, [900.0, 100.0, 1000.0, 180.0, 0.0, 0.0]);
    let lines = [
        "J P[1] 50% CNT100",
        "L P[2] 300mm/sec CNT80",
        "J P[3] 30% CNT50",
        "C P[4]\n    :  P[2] 250mm/sec CNT100",
        "L P[1] 400mm/sec FINE",
    ];
    let mut core = Core::moves(&lines, &(corner() + &more));
    core.advance(0.001);
    let step = 0.002;
    let arm = common::arm();
    let (mut before, mut speeds) = (core.0.joints_deg(), [0.0; 6]);
    while !core.0.state().idle {
        core.advance(step);
        let here = core.0.joints_deg();
        for (n, axis) in kinematics::Axis::ALL.into_iter().enumerate() {
            let speed = (here[n] - before[n]) / step;
            assert!(
                speed.abs() <= arm.max_speed(axis).0 * 1.001,
                "{axis} at {speed}"
            );
            let jump = (speed - speeds[n]).abs();
            assert!(
                jump < 12.0,
                "{axis} jumps by {jump} deg/s at {}",
                core.now()
            );
            speeds[n] = speed;
        }
        before = here;
    }
    let passed: Vec<_> = core
        .events()
        .into_iter()
        .filter(|(_, event)| *event == Passed)
        .collect();
    assert_eq!(passed, [(1, Passed), (2, Passed), (3, Passed), (4, Passed)]);
}

#[test]
fn a_program_that_karel_calls_ends_when_the_arm_stands_still() {
    let karel = "PROGRAM caller
VAR n, s : INTEGER
BEGIN
  n = 1
  CALL_PROG('MOVES', n)
  SET_POS_REG(1, CURPOS(0, 0), s)
END caller
";
    let lines = [
        "UFRAME_NUM=0",
        "UTOOL_NUM=1",
        "J P[1] 100% FINE",
        "L P[2] 300mm/sec CNT100",
    ];
    let mut config = config(&lines, &corner());
    config.programs.push(ProgramSource::new("caller.kl", karel));
    config.run = vec!["CALLER".to_owned()];
    let mut core = Core::of(&config);
    core.finish();
    let Ok(PositionRegister::Cartesian(end)) = core.0.registers().position(1) else {
        panic!("{:?}", core.0.registers().position(1));
    };
    let end = [end.x, end.y, end.z].map(f64::from);
    assert!(distance(end, CORNER) < 1e-3, "{end:?}");
}

#[test]
fn a_called_program_hands_its_last_corner_to_its_caller() {
    let lines = ["J P[1] 100% FINE", "CALL INNER", "L P[3] 300mm/sec FINE"];
    let inner = listing("INNER", &["L P[2] 300mm/sec CNT100"], &corner());
    let mut core = Core::of(&config(&lines, &corner()).with_program(inner));
    core.finish();
    assert_eq!(core.events()[3..5], [(3, Started), (2, Passed)]);
}

fn karel_moves(termtype: &str, nowait: &str) -> Vec<(u64, karel_emulator::LedgerEvent)> {
    let program = format!(
        "PROGRAM kmoves
VAR p : XYZWPR
BEGIN
  $TERMTYPE = {termtype}
  $MOTYPE = LINEAR
  p = CURPOS(0, 0)
  p.y = p.y + 100
  MOVE TO p {nowait}
  p.z = p.z - 100
  MOVE TO p {nowait}
END kmoves
"
    );
    let mut core = Core::of(&common::config_of(&program, &[]));
    core.finish();
    core.events()
}

#[test]
fn nodecel_and_vardecel_round_moves_of_karel_and_fine_does_not() {
    let round = [(1, Started), (2, Started), (1, Passed), (2, Finished)];
    let angular = [(1, Started), (1, Finished), (2, Started), (2, Finished)];
    for nowait in ["", "NOWAIT"] {
        assert_eq!(karel_moves("NODECEL", nowait), round);
        assert_eq!(karel_moves("VARDECEL", nowait), round);
        for termtype in ["FINE", "COARSE", "NOSETTLE"] {
            assert_eq!(karel_moves(termtype, nowait), angular, "{termtype}");
        }
    }
}

#[test]
fn a_round_way_with_holds_is_the_same_however_time_is_cut() {
    let lines = [
        "LBL[1]",
        "J P[1] 80% CNT60",
        "L P[2] 500mm/sec CNT100",
        "L P[3] 500mm/sec CNT20",
        "R[1]=R[1]+1",
        "IF R[1]<4,JMP LBL[1]",
    ];
    let run = |cuts: u32| {
        let mut core = Controller::try_new(&config(&lines, &corner())).unwrap();
        for (phase, operation) in [
            Operation::Hold,
            Operation::CycleStart,
            Operation::SetOverride(40),
            Operation::SetOverride(100),
        ]
        .into_iter()
        .enumerate()
        {
            let begin = Duration::from_millis(1900) * u32::try_from(phase).unwrap();
            for cut in 1..=cuts {
                core.advance_fully(begin + Duration::from_millis(1900) * cut / cuts);
            }
            core.operate(operation).unwrap();
        }
        core.advance_fully(Duration::from_mins(1));
        serde_json::to_string(&core.ledger(0)).unwrap()
    };
    let whole = run(1);
    assert!(
        whole.contains("\"passed\"") && whole.contains("\"held\""),
        "{whole}"
    );
    assert_eq!(run(1), whole);
    assert_eq!(run(1237), whole);
}
