//! I/O ports: programs, the world outside, and the panel's state.

mod common;

use common::{Stepped, config_of};
use karel::{Port, PortValue};
use karel_emulator::SetInputError;
use karel_emulator::state::TaskWord;

const ON: PortValue = PortValue::Switch(true);

async fn shown(cell: &Stepped) -> Vec<String> {
    let state = cell.controller.state().await.expect("it runs");
    let ports = state.ports.iter();
    ports
        .map(|view| format!("{}={}", view.port, view.value))
        .collect()
}

#[tokio::test]
async fn a_program_waits_for_an_input_and_sets_outputs() {
    let program = "PROGRAM t\nBEGIN\nDOUT[1] = ON\nWAIT FOR DIN[7], GIN[2] = 5\nDOUT[1] = OFF\n\
        RDO[3] = ON\nGOUT[1] = GIN[2] + 1\nEND t\n";
    let cell = Stepped::start(&config_of(program, &[]));
    cell.advance(1.0).await;
    assert_eq!(shown(&cell).await, ["DOUT[1]=1"]);
    cell.controller
        .set_input(Port::DigitalIn, 7, ON)
        .await
        .unwrap();
    cell.advance(1.0).await;
    assert_eq!(cell.task_word().await, TaskWord::Waiting, "both must hold");
    let five = PortValue::Number(5);
    cell.controller
        .set_input(Port::GroupIn, 2, five)
        .await
        .unwrap();
    cell.advance(0.1).await;
    assert_eq!(cell.task_word().await, TaskWord::Ended);
    assert_eq!(
        shown(&cell).await,
        ["DIN[7]=1", "RDO[3]=1", "GIN[2]=5", "GOUT[1]=6"]
    );
}

#[tokio::test]
async fn a_port_beyond_the_hardware_aborts_the_task_with_prio_002() {
    let cell = Stepped::start(&config_of("PROGRAM t\nBEGIN\nRDO[9] = ON\nEND t\n", &[]));
    cell.advance(0.1).await;
    assert_eq!(cell.task_word().await, TaskWord::Aborted);
    let alarms = cell.controller.alarms().await.unwrap();
    let headline = alarms.last().unwrap().headline();
    assert!(headline.contains("PRIO-002"), "{headline}");
}

#[tokio::test]
async fn only_inputs_that_exist_can_be_set_from_outside() {
    let cell = Stepped::start(&config_of("PROGRAM t\nBEGIN\nEND t\n", &[]));
    let set = |port, number, value| cell.controller.set_input(port, number, value);
    let refused = set(Port::DigitalOut, 1, ON).await.unwrap_err();
    assert_eq!(refused.to_string(), "DOUT is not an input");
    let refused = set(Port::RobotIn, 9, ON).await.unwrap_err();
    assert_eq!(
        refused.to_string(),
        "there is no RDI[9], the last is RDI[8]"
    );
    let refused = set(Port::DigitalIn, 1, PortValue::Number(3)).await;
    assert!(matches!(refused, Err(SetInputError::Value { .. })));
}
