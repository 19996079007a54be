//! Many controllers in one process.

mod common;

use common::{ACCEPTED, LINE, PORT, call, config_of, sock_server, wait_until, within};
use karel_emulator::state::TaskWord;
use karel_emulator::{
    Clock, ControllerConfig, LedgerEvent, PeerLabels, ProgramSource, VirtualController,
};

#[tokio::test]
async fn a_hundred_controllers_serve_in_one_process() {
    let controllers: Vec<_> = (0..100)
        .map(|_| {
            let clock = Clock::scaled(200.0).unwrap();
            VirtualController::start(&sock_server(), clock, PeerLabels::new()).unwrap()
        })
        .collect();
    for controller in &controllers {
        let address = within(controller.address_of_port(PORT)).await.unwrap();
        assert_eq!(call(address, LINE).await, ACCEPTED);
    }
    for controller in &controllers {
        wait_until(controller, |state| !state.moving && state.ledger_seq == 2).await;
    }
    for controller in controllers {
        within(controller.shutdown()).await;
    }
}

/// Never rests, beside the server.
const BUSY: &str = "PROGRAM busy
%NOLOCKGROUP
VAR n : INTEGER
BEGIN
  n = 0
  WHILE TRUE DO
    n = (n + 1) MOD 1000000
    FLG[1] = ON
  ENDWHILE
END busy
";

/// Commands that each controller gets.
const COMMANDS: u64 = 4;

/// Every controller has targets of its own; every third has a task that never rests.
fn loaded(number: u64) -> ControllerConfig {
    let server = include_str!("../../programs/sock_server.kl");
    let mut config = config_of(server, &[PORT]);
    config.name = format!("arm-{number}");
    if number.is_multiple_of(3) {
        config.programs.push(ProgramSource::new("busy.kl", BUSY));
        config.run = vec!["SOCK_SERVER".to_owned(), "BUSY".to_owned()];
        config.limits.instructions_per_ms = 100;
    }
    config
}

/// Thousandths of a millimeter: y tells the controller, z the command.
fn target(number: u64, command: u64) -> (u64, u64) {
    (100_000 + 1_000 * number, 500_000 + 20_000 * command)
}

/// Covers: K6, K8.
#[tokio::test]
async fn a_hundred_loaded_controllers_do_what_each_was_told_and_starve_nobody() {
    let controllers: Vec<_> = (0..100)
        .map(|number| {
            let clock = Clock::scaled(50.0).unwrap();
            VirtualController::start(&loaded(number), clock, PeerLabels::new()).unwrap()
        })
        .collect();
    let mut clients = tokio::task::JoinSet::new();
    for (controller, number) in controllers.iter().zip(0..) {
        let address = within(controller.address_of_port(PORT)).await.unwrap();
        let _client = clients.spawn(async move {
            for command in 1..=COMMANDS {
                let (y, z) = target(number, command);
                let line = format!("600000 {y} {z} -180000 30000 0 1500 1");
                assert_eq!(call(address, line.as_bytes()).await, ACCEPTED, "{number}");
            }
        });
    }
    while let Some(client) = clients.join_next().await {
        client.unwrap();
    }
    for (controller, number) in controllers.iter().zip(0..) {
        wait_until(controller, |state| {
            !state.moving && state.ledger_seq == 2 * COMMANDS
        })
        .await;
        let ledger = controller.ledger().await.unwrap();
        let told = (1..=COMMANDS).flat_map(|command| {
            let (y, z) = target(number, command);
            [true, false].map(|starts| (starts, command, y, z))
        });
        let thousandths = |mm: f64| (mm * 1000.0).round();
        // The program rounds its corners where the next command is there in time: then a motion is passed, and not
        // finished, after the next one has started.
        let mut done: Vec<_> = ledger
            .iter()
            .map(|entry| {
                let starts = entry.event == LedgerEvent::Started;
                let ends = [LedgerEvent::Finished, LedgerEvent::Passed].contains(&entry.event);
                assert!(starts || ends, "{entry:?}");
                let pose = entry.target_pose;
                let (y, z) = (thousandths(pose.y_mm), thousandths(pose.z_mm));
                (starts, entry.motion, y, z)
            })
            .collect();
        assert_eq!(ledger.last().unwrap().event, LedgerEvent::Finished);
        done.sort_by_key(|(starts, motion, ..)| (*motion, !starts));
        #[expect(clippy::cast_precision_loss, reason = "thousandths are below 2^52")]
        let told: Vec<_> = told
            .map(|(e, m, y, z)| (e, m, y as f64, z as f64))
            .collect();
        assert_eq!(done, told, "controller {number}");
        assert!(controller.alarms().await.unwrap().is_empty());
        let state = controller.state().await.unwrap();
        assert_eq!(state.controller, format!("arm-{number}"));
        if number.is_multiple_of(3) {
            let busy = state.tasks.iter().find(|task| task.name == "BUSY").unwrap();
            assert_eq!(busy.state, TaskWord::Running, "{busy:?}");
            assert!(state.ports.iter().any(|port| port.port == "FLG[1]"));
        }
    }
    for controller in controllers {
        within(controller.shutdown()).await;
    }
}
