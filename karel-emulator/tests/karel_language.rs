//! What the controller around the language does: every form of MOVE on the arm, hands, the keyboard, files of
//! variables, simulated inputs.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a helper that fails stops its test"
)]

mod common;

use std::net::SocketAddr;

use common::{Stepped, config_of, http, wait_until};
use karel::{Port, PortValue};
use karel_emulator::ledger::MotionKind;
use karel_emulator::state::TaskWord;
use karel_emulator::{ControlAccess, LedgerEvent, OperateError, Operation};
use serde_json::json;

/// Runs a program to its end and returns the lines of the USER screen.
async fn ended(cell: &Stepped) -> Vec<String> {
    for _ in 0..2000 {
        if matches!(cell.task_word().await, TaskWord::Ended | TaskWord::Aborted) {
            break;
        }
        cell.advance(0.05).await;
    }
    let alarms = cell.controller.alarms().await.unwrap();
    let last = alarms.last().map(karel_emulator::alarms::Alarm::headline);
    assert_eq!(cell.task_word().await, TaskWord::Ended, "{last:?}");
    let screen = cell.controller.screen().await.unwrap();
    screen.iter().map(|line| line.trim().to_owned()).collect()
}

const HEAD: &str = "PROGRAM t
VAR
  p, q : XYZWPREXT
  v : VECTOR
  route : PATH
  s, i : INTEGER
ROUTINE show
BEGIN
  q = CURPOS(0, 0)
  WRITE (ROUND(q.x * 10), ROUND(q.y * 10), ROUND(q.z * 10), CR)
END show
BEGIN
  $SPEED = 500
  p.x = 900; p.y = 200; p.z = 700; p.w = 180; p.p = 0; p.r = 0
  MOVE TO p
";

#[tokio::test]
async fn every_form_of_move_gets_where_it_says() {
    let program = format!(
        "{HEAD}MOVE AWAY 50\nshow\nMOVE NEAR p BY 20\nshow\nv.x = 10; v.y = -20; v.z = 30\nMOVE RELATIVE v\nshow
v.x = 0; v.y = 0; v.z = 1\nMOVE ABOUT v BY 30\nshow\nWRITE (ROUND(q.r * 10), CR)\nMOVE AXIS 1 BY 5\nshow\nEND t\n"
    );
    let cell = Stepped::start(&config_of(&program, &[]));
    let screen = ended(&cell).await;
    // The tool looks down, so away is up.
    let expected = [
        "9000 2000 7500",
        "9000 2000 7200",
        "9100 1800 7500",
        "9100 1800 7500",
    ];
    assert_eq!(screen[..4], expected);
    assert!(["300", "-300"].contains(&screen[4].as_str()), "{screen:?}");
    // Five degrees about the first axis.
    let (x, y) = (910.0_f64, 180.0_f64);
    let (sin, cos) = 5.0_f64.to_radians().sin_cos();
    let turned = format!(
        "{:.0} {:.0} 7500",
        10.0 * (x * cos - y * sin),
        10.0 * (x * sin + y * cos)
    );
    assert_eq!(screen[5], turned);
    let ledger = cell.controller.ledger().await.unwrap();
    let started = ledger.iter().filter(|e| e.event == LedgerEvent::Started);
    let kinds: Vec<MotionKind> = started.map(|entry| entry.kind).collect();
    let (joint, line) = (MotionKind::Joint, MotionKind::Linear);
    assert_eq!(kinds, [joint, line, joint, line, line, joint]);
}

#[tokio::test]
async fn a_path_is_followed_and_its_conditions_see_nodes_and_times() {
    let program = format!(
        "{HEAD}FOR i = 1 TO 3 DO\nAPPEND_NODE(route, s)\nroute[i].node_pos = p\nroute[i].node_pos.z = 700 - 50 * i\nENDFOR
MOVE ALONG route, WHEN AT NODE[2] DO DOUT[2] = ON
WHEN TIME 100 BEFORE NODE[3] DO DOUT[3] = ON
WHEN TIME 60 AFTER NODE[1] DO DOUT[1] = ON\nENDMOVE\nshow\nEND t\n"
    );
    let cell = Stepped::start(&config_of(&program, &[]));
    let mut seen = Vec::new();
    for _ in 0..4000 {
        cell.advance(0.004).await;
        let state = cell.controller.state().await.unwrap();
        for view in &state.ports {
            if !seen.iter().any(|(port, _)| *port == view.port) {
                seen.push((view.port.clone(), state.pose.z_mm));
            }
        }
        if cell.task_word().await == TaskWord::Ended {
            break;
        }
    }
    assert_eq!(ended(&cell).await, ["9000 2000 5500"]);
    let height = |wanted: &str| seen.iter().find(|(port, _)| port == wanted).unwrap().1;
    assert!((595.0..=600.5).contains(&height("DOUT[2]")), "{seen:?}");
    assert!((550.0..590.0).contains(&height("DOUT[3]")), "{seen:?}");
    assert!((600.0..650.0).contains(&height("DOUT[1]")), "{seen:?}");
}

#[tokio::test]
async fn a_joint_beyond_its_limit_refuses_the_move() {
    let cell = Stepped::start(&config_of(
        &format!("{HEAD}MOVE AXIS 1 BY 400\nEND t\n"),
        &[],
    ));
    for _ in 0..400 {
        cell.advance(0.05).await;
    }
    assert_eq!(cell.task_word().await, TaskWord::Aborted);
    let alarms = cell.controller.alarms().await.unwrap();
    let headline = alarms.last().unwrap().headline();
    assert!(headline.contains("MOTN-017"), "{headline}");
}

#[tokio::test]
async fn assumed_hands_are_valves_and_switches_at_the_wrist() {
    let program =
        "PROGRAM t\nBEGIN\nCLOSE HAND 1\nWRITE (RDO[1], RDO[2], RDI[1], RDI[2], CR)\nOPEN HAND 1
WRITE (RDO[1], RDO[2], RDI[1], RDI[2], CR)\nRELAX HAND 1\nWRITE (RDO[1], RDO[2], RDI[1], RDI[2], CR)
OPEN HAND 4\nWRITE (RDO[7], RDI[7], CR)\nEND t\n";
    let cell = Stepped::start(&config_of(program, &[]));
    let screen = ended(&cell).await;
    let expected = [
        "FALSETRUEFALSETRUE",
        "TRUEFALSETRUEFALSE",
        "FALSEFALSETRUEFALSE",
        "TRUETRUE",
    ];
    assert_eq!(screen, expected);
    for hand in ["0", "5", "2000000000"] {
        let program = format!("PROGRAM t\nBEGIN\nOPEN HAND {hand}\nEND t\n");
        let cell = Stepped::start(&config_of(&program, &[]));
        cell.advance(0.1).await;
        let alarms = cell.controller.alarms().await.unwrap();
        let headline = alarms.last().unwrap().headline();
        assert!(headline.contains("PRIO-002"), "{headline}");
    }
}

#[tokio::test]
async fn a_read_waits_for_what_an_operator_types_and_the_state_says_so() {
    let program = "PROGRAM t\n%INCLUDE klevkeys\nVAR n, k, c, s : INTEGER\n x : STRING[10]\n kb : FILE\nBEGIN
READ (n, x)\nWRITE (n, x, CR)\nOPEN FILE kb('RO', 'KB:TPKB')\nREAD_KB(kb, x, 0, 0, 1, -1, '', c, k, s)
WRITE (k = ky_f1, CR)\nEND t\n";
    let mut config = config_of(program, &[]);
    config.panel = Some(([127, 0, 0, 1], 0).into());
    config.control = ControlAccess::Control;
    let cell = Stepped::start(&config);
    cell.advance(0.1).await;
    let detail = |state: &karel_emulator::state::State| state.tasks[0].detail.clone();
    wait_until(&cell.controller, |state| {
        detail(state).as_deref() == Some("waits for the pendant's keyboard")
    })
    .await;
    let address: SocketAddr = cell.controller.panel_address().unwrap();
    let typed = async |text: &str| {
        let body = json!({ "text": text });
        http(address, "POST", "/api/v1/keyboard", Some(&body))
            .await
            .0
    };
    assert_eq!(typed("42 wo").await, 200);
    assert_eq!(typed("rd\n").await, 200);
    cell.advance(0.1).await;
    assert_eq!(typed("\u{81}").await, 200);
    assert_eq!(typed("€").await, 422);
    assert_eq!(typed(&"x".repeat(5000)).await, 409);
    assert_eq!(ended(&cell).await, ["42word", "TRUE"]);
    let full = Operation::Type("y".repeat(5000));
    let refused = cell.controller.operate(full).await;
    assert!(matches!(refused, Err(OperateError::KeyboardFull { .. })));
}

#[tokio::test]
async fn variables_and_dictionaries_are_files_of_the_devices() {
    let program = "PROGRAM t\nVAR n, s : INTEGER\n f : FILE\n lines : ARRAY[2] OF STRING[20]\nBEGIN
n = 7\nSAVE('t', 'MC:kept', s)\nn = 8\nLOAD('MC:kept.vr', 0, s)\nWRITE (n, s, CR)
OPEN FILE f('RW', 'RD:words.utx')\nWRITE f('$3 \"three\"', CR)\nCLOSE FILE f
ADD_DICT('RD:words', 'W', 'ENGLISH', 0, s)\nREAD_DICT('W', 3, lines, 1, n, s)\nWRITE (lines[1], s, CR)\nEND t\n";
    let cell = Stepped::start(&config_of(program, &[]));
    assert_eq!(ended(&cell).await, ["7 0", "three 0"]);
}

#[tokio::test]
async fn a_simulated_input_is_what_the_program_says_until_it_ends_that() {
    let program = "PROGRAM t\n%INCLUDE kliotyps\nVAR s : INTEGER\nBEGIN\nDELAY 100\nSET_PORT_SIM(io_din, 4, 1, s)
WRITE (DIN[4], s, CR)\nSET_PORT_VAL(io_din, 4, 0, s)\nWRITE (DIN[4], s, CR)\nCLR_PORT_SIM(io_din, 4, s)
WRITE (DIN[4], s, CR)\nSET_PORT_SIM(io_dout, 1, 1, s)\nWRITE (s)\nSET_PORT_SIM(io_din, 9999, 1, s)\nWRITE (s, CR)\nEND t\n";
    let config = config_of(program, &[]);
    let cell = Stepped::start(&config);
    let on = PortValue::Switch(true);
    cell.controller
        .set_input(Port::DigitalIn, 4, on)
        .await
        .unwrap();
    let expected = ["TRUE 0", "FALSE 0", "TRUE 0", "12322", "13002"];
    assert_eq!(ended(&cell).await, expected);
}
