//! What the controller does not do, and how it says so.

mod common;

use common::{Stepped, config_of};
use karel_emulator::{
    Clock, LedgerEvent, PeerLabels, ProgramSource, StartError, VirtualController,
};
use kinematics::PendantJoints;

/// A program that moves to the home pose with some components replaced.
fn moving(statements: &str) -> String {
    format!(
        "PROGRAM mover
VAR p : XYZWPR
BEGIN
  p = CURPOS(0, 0)
  {statements}
  MOVE TO p
END mover
"
    )
}

#[allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a failure stops the test"
)]
async fn refused(statements: &str) -> (Stepped, String) {
    let cell = Stepped::start(&config_of(&moving(statements), &[]));
    let before = cell.controller.state().await.unwrap().joints_deg;
    cell.advance(10.0).await;
    let state = cell.controller.state().await.unwrap();
    assert_eq!(state.joints_deg, before, "the arm did not move");
    assert_eq!(state.active_alarms, 1);
    let ledger = cell.controller.ledger().await.unwrap();
    assert_eq!(ledger.len(), 1, "{ledger:#?}");
    assert_eq!(ledger[0].event, LedgerEvent::Refused);
    assert_eq!(ledger[0].to_deg, None);
    let alarms = cell.controller.alarms().await.unwrap();
    assert_eq!(alarms.len(), 1, "{alarms:#?}");
    assert_eq!(alarms[0].program.as_deref(), Some("MOVER"));
    assert_eq!(Some(alarms[0].headline()), ledger[0].alarm);
    let task = serde_json::to_value(&state.tasks[0]).unwrap();
    assert_eq!(task["state"], "aborted");
    (cell, alarms[0].headline())
}

#[tokio::test]
async fn a_target_beyond_a_joint_limit_raises_motn_017_with_joint_value_and_limit() {
    // The home pose turned by 175 degrees about the base: J1 would be at 175, its limit is 170.
    let behind = "p.x = -981.25 ; p.y = 85.85 ; p.r = 175";
    let (cell, alarm) = refused(behind).await;
    assert!(alarm.starts_with("MOTN-017 "), "{alarm}");
    for word in ["J1", "175", "170"] {
        assert!(alarm.contains(word), "{word} in {alarm:?}");
    }
    cell.controller.reset().await.unwrap();
    assert_eq!(cell.controller.state().await.unwrap().active_alarms, 0);
}

#[tokio::test]
async fn a_target_out_of_reach_raises_motn_018() {
    let (_cell, alarm) = refused("p.x = 9000").await;
    assert!(alarm.starts_with("MOTN-018 "), "{alarm}");
}

#[tokio::test]
async fn a_circular_motion_without_a_via_is_refused_and_so_is_no_motion_type() {
    let (_cell, alarm) = refused("$MOTYPE = CIRCULAR ; p.z = p.z + 10").await;
    assert!(alarm.contains("needs a VIA"), "{alarm}");
    let (_cell, alarm) = refused("$MOTYPE = 3").await;
    assert!(alarm.contains("is no motion type"), "{alarm}");
}

#[tokio::test]
async fn a_bad_override_stops_the_program() {
    let program = "PROGRAM over\nBEGIN\n$MCR.$GENOVERRIDE = 101\nEND over\n";
    let cell = Stepped::start(&config_of(program, &[]));
    cell.advance(1.0).await;
    let alarms = cell.controller.alarms().await.unwrap();
    assert_eq!(alarms.len(), 1);
    assert_eq!(
        (alarms[0].facility.as_str(), alarms[0].number),
        ("VARS", 32)
    );
    assert_eq!(cell.controller.state().await.unwrap().override_percent, 100);
}

#[allow(clippy::unwrap_used, reason = "a failure stops the test")]
fn start_error(config: &karel_emulator::ControllerConfig) -> StartError {
    VirtualController::start(config, Clock::real(), PeerLabels::new()).unwrap_err()
}

#[tokio::test]
async fn what_cannot_start_says_why() {
    let good = "PROGRAM a\nBEGIN\nEND a\n";
    let mut config = config_of("this is not KAREL", &[]);
    let text = start_error(&config).to_string();
    assert!(text.contains("test.kl"), "{text}");

    config.programs.clear();
    assert!(matches!(start_error(&config), StartError::NoProgram));

    config.programs = vec![ProgramSource::new("big.kl", vec![b' '; (1 << 20) + 1])];
    assert!(matches!(
        start_error(&config),
        StartError::ProgramTooLong { .. }
    ));

    config.programs = vec![ProgramSource::new("a.kl", good); 17];
    assert!(matches!(
        start_error(&config),
        StartError::TooManyPrograms {
            count: 17,
            limit: 16
        }
    ));

    config.programs = vec![ProgramSource::new("a.kl", good); 2];
    assert!(matches!(start_error(&config), StartError::Load { .. }));

    config.programs.truncate(1);
    config.run = vec!["nosuch".to_owned()];
    assert!(
        start_error(&config)
            .to_string()
            .to_lowercase()
            .contains("nosuch")
    );

    config.run.clear();
    config.start_joints = PendantJoints::from_degrees([171.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    let text = start_error(&config).to_string();
    assert!(text.contains("J1") && text.contains("170"), "{text}");
}
