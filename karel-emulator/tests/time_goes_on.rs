//! Controller time goes on whatever a task with condition handlers is doing: each step of it costs the caller little.
//!
//! Tasks that have used up their share are among the former findings of `fuzz/`.

use std::time::Duration;

use karel_emulator::controller::Advance;
use karel_emulator::faults::{FaultBody, FaultKind};
use karel_emulator::{Controller, ControllerConfig, ProgramSource};
use kinematics::ArmModel;

/// A task that watches its timer while it does `body`.
fn watching(body: &str) -> Controller {
    let source = format!(
        "PROGRAM watching\nVAR\n  t, n : INTEGER\nBEGIN\n  t = 0\n  CONDITION[1]:\n    WHEN t > 30 DO\n      n = n + 1\n  \
         ENDCONDITION\n  n = 0\n  ENABLE CONDITION[1]\n  CONNECT TIMER TO t\n{body}\nEND watching\n"
    );
    let model = ArmModel::builtin("fanuc-m20ia").expect("the arm is built in");
    let mut config =
        ControllerConfig::new("c1", model).with_program(ProgramSource::new("watching.kl", source));
    config.limits.instructions_per_ms = 5;
    Controller::try_new(&config).expect("the program is correct")
}

/// Goes on to `until`, in at most a few steps for each millisecond.
fn advance(core: &mut Controller, until: Duration) {
    let most = 40 * until.as_millis();
    let mut steps = 0;
    while core.advance(until) == Advance::Worked {
        steps += 1;
        assert!(
            steps < most,
            "{:?} after {steps} steps, next {:?}",
            core.now(),
            core.next_wake()
        );
    }
    assert_eq!(core.now(), until);
}

#[test]
fn while_the_controller_is_frozen() {
    let mut core = watching("  DELAY 60000");
    advance(&mut core, Duration::from_millis(10));
    let freeze = FaultBody::new(FaultKind::Freeze).for_ms(100);
    let _id = core.inject(freeze).expect("it can be frozen");
    advance(&mut core, Duration::from_millis(500));
}
