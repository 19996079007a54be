//! Random histories of commands, lost clients, stops, fences, operators and power failures: whatever happens, no
//! command moves the arm twice, out of order, or after it was killed.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a helper that fails stops its test"
)]

mod common;

use std::time::Duration;

use common::wire::joints;
use common::world::{COMMANDS, STATUS, World};
use karel_emulator::{LedgerEvent, OperatingMode, Operation};
use proptest::prelude::*;

/// What happens next.
#[derive(Clone, Debug)]
enum Step {
    /// A client connects to the command port, if none is there.
    Connect,
    /// It sends a motion; the nonce may be that of an earlier greeting.
    Move {
        epoch: u32,
        seq: u32,
        target: usize,
        percent: u32,
        old_nonce: bool,
    },
    /// It sends the first part of a command and nothing more.
    Half,
    /// It is gone.
    Leave,
    Status(String),
    LeaveStatus,
    Pass(u64),
    PowerCycle,
    Operate(Operation),
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let command = (1..5_u32, 1..4_u32, 0..3_usize, 1..100_u32, any::<bool>()).prop_map(
        |(epoch, seq, target, percent, old)| Step::Move {
            epoch,
            seq,
            target,
            percent,
            old_nonce: old && seq == 3,
        },
    );
    let verb = prop_oneof![
        4 => (1..6_u32).prop_map(|e| format!("S {e}")),
        2 => (1..6_u32).prop_map(|e| format!("F {e}")),
        2 => Just("X".to_owned()),
        1 => Just("P".to_owned()),
        1 => Just("C".to_owned()),
        1 => (1..101_u32).prop_map(|p| format!("G {p}")),
    ];
    let operation = prop_oneof![
        Just(Operation::Hold),
        Just(Operation::CycleStart),
        Just(Operation::EmergencyStop(true)),
        Just(Operation::EmergencyStop(false)),
        Just(Operation::Reset),
        Just(Operation::SetPendant(true)),
        Just(Operation::SetPendant(false)),
        Just(Operation::SetMode(OperatingMode::T1)),
        Just(Operation::SetMode(OperatingMode::Auto)),
        Just(Operation::SetOverride(0)),
        Just(Operation::SetOverride(100)),
    ];
    let step = prop_oneof![
        6 => Just(Step::Connect),
        8 => command,
        1 => Just(Step::Half),
        2 => Just(Step::Leave),
        6 => verb.prop_map(Step::Status),
        1 => Just(Step::LeaveStatus),
        8 => (0..400_u64).prop_map(Step::Pass),
        1 => Just(Step::PowerCycle),
        2 => operation.prop_map(Step::Operate),
    ];
    proptest::collection::vec(step, 1..60)
}

/// Status of a motion that was stopped because its commander had gone silent.
const DEAD_MAN: i32 = 3;

const TARGETS: [[f64; 6]; 3] = [
    [20.0, 10.0, -10.0, 5.0, -60.0, 15.0],
    [0.0, 0.0, 0.0, 0.0, -90.0, 0.0],
    [-5.0, 0.0, 5.0, 0.0, -70.0, 0.0],
];

fn take(world: &mut World, step: &Step) {
    match step {
        Step::Connect => world.connect(COMMANDS),
        Step::Move {
            epoch,
            seq,
            target,
            percent,
            old_nonce,
        } => {
            let mut nonces = world.nonces.iter().rev();
            let nonce = nonces.nth(usize::from(*old_nonce)).cloned();
            let nonce = nonce.unwrap_or_else(|| "1".to_owned());
            let id = (*epoch, *seq);
            let text = joints(id, &nonce, TARGETS[*target], *percent);
            world.command(id, &text);
        }
        Step::Half => world.send(COMMANDS, "M 1 1 "),
        Step::Leave => world.leave(COMMANDS),
        Step::Status(verb) => world.status(verb),
        Step::LeaveStatus => world.leave(STATUS),
        Step::Pass(ms) => world.pass(Duration::from_millis(*ms)),
        Step::PowerCycle => world.power_cycle(),
        Step::Operate(operation) => world.operate(operation.clone()),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, max_shrink_iters: 2_000, ..ProptestConfig::default() })]

    #[test]
    fn no_history_moves_the_arm_twice_out_of_order_or_after_a_kill(
        steps in steps(), speed in prop_oneof![2 => Just(2_000_u32), 3 => 60..300_u32],
    ) {
        let mut world = World::new(speed);
        for step in &steps {
            take(&mut world, step);
            world.judge();
        }
        world.pass(Duration::from_secs(3));
        let state = world.core.state();
        for task in state.tasks.iter().filter(|task| task.name.starts_with("CELL_S") || task.name == "CELL_WATCH") {
            prop_assert!(
                matches!(task.state, karel_emulator::state::TaskWord::Waiting | karel_emulator::state::TaskWord::Running),
                "{task:?}"
            );
        }
        // What was reported as arrived was: the ledger has its end. What the ledger has and was reported otherwise had
        // been interrupted at its very end, or the dead-man had struck.
        let ledger = world.core.ledger(0);
        for (id, status) in &world.done {
            let end = ledger.iter().find(|entry| {
                entry.event == LedgerEvent::Finished
                    && entry.command.is_some_and(|c| (c.epoch, c.seq) == *id)
            });
            match end {
                None => prop_assert_ne!(*status, 0, "{:?}", id),
                Some(_) if [0, DEAD_MAN].contains(status) => {}
                Some(end) => prop_assert!(world.was_interrupted_near(end.time_s), "{id:?}: {status}, {end:?}"),
            }
        }
    }
}
