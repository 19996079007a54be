//! A controller without sockets and clocks, and what has to hold of it at any time.

use std::collections::BTreeSet;
use std::time::Duration;

use karel_emulator::effects::Effect;
use karel_emulator::{Controller, ControllerConfig};
use kinematics::ArmModel;

/// A controller whose processor is slow: an endless loop costs an input little.
///
/// # Panics
/// If the arm is not built in.
#[must_use]
pub fn config() -> ControllerConfig {
    let model = ArmModel::builtin("fanuc-m20ia").expect("the arm is built in");
    let mut config = ControllerConfig::new("fuzz", model);
    config.limits.instructions_per_ms = 100;
    config.limits.ledger_entries = 200;
    config.limits.alarms = 50;
    config
}

/// What can be seen of a controller, for comparing two of them.
///
/// # Panics
/// If it cannot be written as JSON: that is a finding.
#[must_use]
pub fn seen(core: &mut Controller) -> String {
    let state = serde_json::to_string(&core.state()).expect("a state is JSON");
    let ledger = serde_json::to_string(&core.ledger(0)).expect("a ledger is JSON");
    let alarms = serde_json::to_string(&core.alarms()).expect("alarms are JSON");
    let screen = core.screen().join("\n");
    format!(
        "{state}\n{ledger}\n{alarms}\n{screen}\n{:?}\n{:?}\n{:?}",
        core.registers(),
        core.files(),
        core.io(),
    )
}

/// Nothing of a controller grows without bound.
///
/// # Panics
/// If something does: that is a finding.
pub fn check_bounds(core: &Controller) {
    assert!(core.ledger(0).len() <= 200, "the ledger grows");
    assert!(core.alarms().len() <= 50, "the alarms grow");
    assert!(core.screen().len() <= 200, "the screen grows");
    assert!(
        core.screen().iter().all(|line| line.chars().count() <= 256),
        "a line of the screen grows"
    );
    let bytes: usize = core.files().iter().map(|(_, bytes)| bytes.len()).sum();
    assert!(bytes <= 2 << 20, "the devices hold {bytes} bytes");
    let joints = core.joints_deg();
    assert!(joints.iter().all(|angle| angle.is_finite()), "{joints:?}");
}

/// Effects name only connections that there are.
///
/// # Panics
/// If one does not: that is a finding.
pub fn check_effects(effects: &[Effect], open: &BTreeSet<u64>) {
    for effect in effects {
        if let Effect::Send { connection, .. }
        | Effect::Close { connection }
        | Effect::Reset { connection } = effect
        {
            assert!(open.contains(&connection.0), "{effect:?} of {open:?}");
        }
    }
}

/// Milliseconds of controller time.
#[must_use]
pub fn ms(count: u64) -> Duration {
    Duration::from_millis(count)
}
