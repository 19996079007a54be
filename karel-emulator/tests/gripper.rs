//! The gripper: one output, three inputs, and the parts that it takes.

mod common;

use std::sync::{Arc, Mutex};
use std::time::Duration;

use common::wire::{Line, command, field, joints};
use common::{Stepped, arm};
use karel_emulator::gripper::GripperPosition;
use karel_emulator::{
    CmosMemory, ControllerConfig, GripperConfig, LedgerEvent, Operation, StartError,
    VirtualController, Workpieces,
};
use kinematics::Pose;

const CLOSED: i64 = 1;
const OPEN: i64 = 2;
const PART: i64 = 4;

/// One part, wherever the arm closes its gripper first.
#[derive(Default)]
struct Table {
    calls: Mutex<Vec<String>>,
    empty: bool,
}

impl Table {
    fn calls(&self) -> Vec<String> {
        self.calls.lock().unwrap().clone()
    }
}

impl Workpieces for Table {
    fn close_at(&self, controller: &str, tcp: &Pose) -> Option<String> {
        let at = tcp.xyzwpr();
        let call = format!("{controller} closes at {:.0}", at.z.0);
        self.calls.lock().unwrap().push(call);
        (!self.empty).then(|| "cube".to_owned())
    }

    fn open_at(&self, controller: &str, part: &str, tcp: &Pose) {
        let at = tcp.xyzwpr();
        let call = format!("{controller} opens {part} at {:.0}", at.z.0);
        self.calls.lock().unwrap().push(call);
    }
}

fn with(table: &Arc<Table>) -> Stepped {
    let config = ControllerConfig::cell_server("arm-1", arm())
        .with_gripper(GripperConfig::default())
        .with_workpieces(table.clone());
    Stepped::start(&config)
}

async fn output(cell: &Stepped, seq: u32, level: u32) {
    let (answer, mut line) = command(cell, |n| format!("O 1000 {seq} {n} 1 {level}")).await;
    assert_eq!(answer[0], "ACK");
    assert_eq!(line.next().await[0], "DONE");
}

async fn inputs(cell: &Stepped) -> i64 {
    let mut status = Line::status(cell).await;
    field(&status.ask("S 1000").await, "inputs")
}

#[tokio::test]
async fn it_closes_on_a_part_carries_it_and_lets_it_go() {
    let table = Arc::new(Table::default());
    let cell = with(&table);
    assert_eq!(inputs(&cell).await, OPEN);
    output(&cell, 1, 1).await;
    assert_eq!(inputs(&cell).await, 0, "on its way");
    cell.advance(0.3).await;
    assert_eq!(inputs(&cell).await, CLOSED + PART);
    output(&cell, 2, 1).await;
    cell.advance(0.5).await;
    assert_eq!(inputs(&cell).await, CLOSED + PART, "the same level again");
    let there = [20.0, 10.0, -10.0, 5.0, -60.0, 15.0];
    let (_answer, mut line) = command(&cell, |n| joints((1000, 3), n, there, 90)).await;
    assert_eq!(line.next().await[3], "0");
    output(&cell, 4, 0).await;
    cell.advance(0.4).await;
    assert_eq!(inputs(&cell).await, OPEN);
    let calls = table.calls();
    assert_eq!(calls.len(), 2, "{calls:?}");
    assert!(calls[0].starts_with("arm-1 closes at"), "{calls:?}");
    assert!(calls[1].starts_with("arm-1 opens cube at"), "{calls:?}");
    let ledger = cell.controller.ledger().await.unwrap();
    let parts: Vec<_> = ledger
        .iter()
        .filter(|e| e.part.as_deref() == Some("cube"))
        .collect();
    assert_eq!(parts[0].event, LedgerEvent::Gripped);
    assert_eq!(parts[1].event, LedgerEvent::Released);
    assert_ne!(parts[0].target_pose, parts[1].target_pose);
    let gripper = cell.controller.state().await.unwrap().gripper.unwrap();
    assert_eq!(
        (gripper.position, gripper.part),
        (GripperPosition::Open, None)
    );
}

#[tokio::test]
async fn it_closes_on_nothing_and_says_so() {
    let table = Arc::new(Table {
        empty: true,
        ..Table::default()
    });
    let cell = with(&table);
    output(&cell, 1, 1).await;
    cell.advance(0.3).await;
    assert_eq!(inputs(&cell).await, CLOSED);
}

#[tokio::test]
async fn a_jammed_gripper_never_arrives_and_goes_on_when_it_is_free() {
    let cell = with(&Arc::new(Table::default()));
    let jam = |jammed| cell.controller.operate(Operation::JamGripper(jammed));
    jam(true).await.unwrap();
    output(&cell, 1, 1).await;
    cell.advance(5.0).await;
    assert_eq!(inputs(&cell).await, 0);
    jam(false).await.unwrap();
    cell.advance(0.3).await;
    assert_eq!(inputs(&cell).await, CLOSED + PART);
}

#[tokio::test]
async fn a_part_that_falls_is_gone_and_the_ledger_knows_where() {
    let cell = with(&Arc::new(Table::default()));
    output(&cell, 1, 1).await;
    cell.advance(0.3).await;
    cell.controller.operate(Operation::LosePart).await.unwrap();
    assert_eq!(inputs(&cell).await, CLOSED);
    let last = cell.controller.ledger().await.unwrap().pop().unwrap();
    assert_eq!(
        (last.event, last.part.as_deref()),
        (LedgerEvent::Lost, Some("cube"))
    );
    assert!(cell.controller.operate(Operation::LosePart).await.is_err());
}

#[tokio::test]
async fn a_change_of_mind_keeps_the_part_that_was_not_let_go_yet() {
    let table = Arc::new(Table::default());
    let cell = with(&table);
    output(&cell, 1, 1).await;
    cell.advance(0.3).await;
    output(&cell, 2, 0).await;
    cell.advance(0.1).await;
    output(&cell, 3, 1).await;
    cell.advance(0.3).await;
    assert_eq!(inputs(&cell).await, CLOSED + PART);
    assert_eq!(table.calls().len(), 1);
}

#[tokio::test]
async fn assumed_it_holds_its_part_without_power() {
    let cell = with(&Arc::new(Table::default()));
    output(&cell, 1, 1).await;
    cell.advance(0.3).await;
    cell.controller.power_cycle(CmosMemory::Kept).await.unwrap();
    cell.advance(1.0).await;
    let mut status = Line::status(&cell).await;
    let after = status.ask("S 1000").await;
    assert_eq!(field(&after, "outputs"), 0, "outputs are off at power-on");
    assert_eq!(field(&after, "inputs"), CLOSED + PART);
}

#[tokio::test]
async fn ports_that_do_not_exist_are_refused_at_the_start() {
    let start = |gripper: GripperConfig| {
        let config = ControllerConfig::cell_server("x", arm()).with_gripper(gripper);
        let (clock, _stepper) = karel_emulator::Clock::stepped();
        VirtualController::start(&config, clock, karel_emulator::PeerLabels::new())
    };
    for gripper in [
        GripperConfig {
            close_output: 0,
            ..GripperConfig::default()
        },
        GripperConfig {
            part_input: 9999,
            ..GripperConfig::default()
        },
        GripperConfig {
            open_input: 1,
            ..GripperConfig::default()
        },
    ] {
        assert!(matches!(start(gripper), Err(StartError::Gripper { .. })));
    }
    let slow = GripperConfig {
        travel: Duration::from_secs(3600),
        ..GripperConfig::default()
    };
    assert!(start(slow).is_ok());
}
