//! Frames, configurations and turn numbers of TP motions, and programs line by line.
#![allow(clippy::unwrap_used, reason = "a helper that fails stops its test")]

mod common;

use common::tp::{Core, config, corner, distance, joints, position};
use karel::PositionRegister;
use karel_emulator::LedgerEvent::{self, Finished, Started};
use karel_emulator::{Operation, ProgramSource};

fn register(core: &Core, n: i32) -> [f64; 3] {
    match core.0.registers().position(n) {
        Ok(PositionRegister::Cartesian(p)) => [p.x, p.y, p.z].map(f64::from),
        other => panic!("{other:?}"),
    }
}

/// TP programs live in `$MNUFRAME` and `$MNUTOOL`, KAREL in `$UFRAME` and `$UTOOL`; neither changes the other.
#[test]
fn frames_of_tp_programs_are_not_those_of_karel() {
    let karel = "PROGRAM looks
VAR s : INTEGER
BEGIN
  SET_POS_REG(9, CURPOS(0, 0), s)
END looks
";
    let lines = [
        "UFRAME_NUM=2",
        "UTOOL_NUM=3",
        "PR[1,1]=900",
        "PR[1,3]=700",
        "PR[1,4]=180",
        "J PR[1] 100% FINE",
        "PR[2]=LPOS",
        "CALL LOOKS",
        "UFRAME_NUM=0",
        "UTOOL_NUM=1",
        "PR[3]=LPOS",
    ];
    let mut config = config(&lines, "").with_program(ProgramSource::new("looks.kl", karel));
    for (item, value) in [
        ("$MNUFRAME[1,2].x", "100"),
        ("$MNUFRAME[1,2].y", "-50"),
        ("$MNUTOOL[1,3].z", "120"),
    ] {
        config.presets.push((item.to_owned(), value.to_owned()));
    }
    let mut core = Core::of(&config);
    core.finish();
    assert_eq!(
        core.events(),
        [(1, Started), (1, Finished)],
        "{:?}",
        core.0.alarms()
    );
    assert!(distance(register(&core, 2), [900.0, 0.0, 700.0]) < 0.01);
    // The tool looks down, so the flange is 120 mm above; the frame is shifted.
    for n in [3, 9] {
        let flange = register(&core, n);
        assert!(
            distance(flange, [1000.0, -50.0, 820.0]) < 0.01,
            "{flange:?}"
        );
    }
}

/// The same pose, once around with the last axis.
#[test]
fn a_turn_number_chooses_how_often_the_axis_goes_around() {
    let bent = [0.0, 0.0, 0.0, 0.0, -60.0, 150.0];
    let mut core = Core::moves(&["J P[1] 100% FINE"], &joints(1, bent));
    core.finish();
    let pose = core.0.state().pose;
    assert_eq!(core.0.state().configuration, "N U T, 0, 0, 0");
    let place = position(1, pose.into());
    for (turns, j6) in [("0, 0, 0", 150.0), ("0, 0, -1", -210.0)] {
        let place = place.replace("0, 0, 0'", &format!("{turns}'"));
        let mut core = Core::moves(&["J P[1] 100% FINE"], &place);
        core.finish();
        let found = core.0.joints_deg();
        assert!(
            (found[5] - j6).abs() < 0.01,
            "{turns}: {found:?} {:?}",
            core.0.alarms()
        );
        let here = core.tool();
        assert!(distance(here, [pose.x_mm, pose.y_mm, pose.z_mm]) < 0.01);
    }
    let place = place.replace("0, 0, 0'", "0, 0, 2'");
    let mut core = Core::moves(&["J P[1] 100% FINE"], &place);
    core.finish();
    let last = core.0.ledger(0).pop().unwrap();
    assert_eq!(
        last.event,
        LedgerEvent::Refused,
        "no axis goes around twice"
    );
}

/// A line keeps the turns and the branch that it has; another configuration at its end is refused.
#[test]
fn a_line_keeps_its_configuration() {
    let flipped = position(4, [900.0, 0.0, 700.0, 180.0, 0.0, 0.0]).replace("N U T", "F U T");
    let lines = ["J P[1] 100% FINE", "L P[4] 100mm/sec FINE"];
    let mut core = Core::moves(&lines, &(corner() + &flipped));
    core.finish();
    let alarm = core.last_alarm();
    assert!(
        alarm.starts_with("MOTN-079") && alarm.contains("F U T"),
        "{alarm}"
    );
    assert_eq!(core.0.state().configuration, "N U T, 0, 0, 0");
}

/// In single steps every motion ends at its corner, whatever CNT says.
#[test]
fn in_single_steps_no_corner_is_rounded() {
    let lines = [
        "J P[1] 100% FINE",
        "L P[2] 300mm/sec CNT100",
        "L P[3] 300mm/sec CNT100",
    ];
    let mut core = Core::moves(&lines, &corner());
    core.0.operate(Operation::SetSingleStep(true)).unwrap();
    let mut steps = 0;
    while core
        .events()
        .iter()
        .filter(|(_, event)| *event == Finished)
        .count()
        < 3
    {
        core.advance(3.0);
        assert!(!core.0.state().moving);
        core.0.operate(Operation::CycleStart).unwrap();
        steps += 1;
        assert!(steps < 10, "{:?}", core.events());
    }
    let history = [
        (1, Started),
        (1, Finished),
        (2, Started),
        (2, Finished),
        (3, Started),
        (3, Finished),
    ];
    assert_eq!(core.events(), history);
}

/// Two programs that hand points over with flags, as motion servers of the field do: one point moves, one waits, and
/// the way is round because the next point is there when the corner begins.
#[test]
fn points_that_are_handed_over_in_time_make_a_round_way() {
    let feeder = "PROGRAM feeder
VAR n, s : INTEGER
    p : XYZWPR
BEGIN
  FOR n = 1 TO 4 DO
    WHILE FLG[1] = FALSE DO
      DELAY 8
    ENDWHILE
    FLG[1] = FALSE
    p.x = 900
    p.y = 60 * n
    p.z = 700 + 60 * (n MOD 2)
    p.w = 180
    p.p = 0
    p.r = 0
    SET_POS_REG(1, p, s)
    FLG[2] = TRUE
    WHILE FLG[2] DO
      DELAY 8
    ENDWHILE
  ENDFOR
END feeder
";
    let lines = [
        "J P[1] 100% FINE",
        "LBL[1]",
        "F[1]=(ON)",
        "WAIT (F[2])",
        "PR[2]=PR[1]",
        "F[2]=(OFF)",
        "L PR[2] 150mm/sec CNT R[2]",
        "JMP LBL[1]",
    ];
    let mut config = config(&lines, &corner());
    config
        .programs
        .push(ProgramSource::new("feeder.kl", feeder));
    config.run = vec!["MOVES".to_owned(), "FEEDER".to_owned()];
    config.presets.push(("R[2]".to_owned(), "100".to_owned()));
    let mut core = Core::of(&config);
    core.advance(30.0);
    let ends: Vec<LedgerEvent> = core.events().into_iter().map(|(_, event)| event).collect();
    let passed = ends
        .iter()
        .filter(|event| **event == LedgerEvent::Passed)
        .count();
    assert_eq!(passed, 3, "{:?} {:?}", core.events(), core.0.alarms());
}
