//! The three- and the six-point method with tools known beforehand.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use kinematics::{CalibrationError, Pose, calibrate_tip, calibrate_tool};
use nalgebra::Vector3;
use support::pose;

/// Flange poses with the tip of `tool` at (800, 100, 300), in these orientations.
fn touching(tool: &Pose, orientations: &[[f64; 3]]) -> Vec<Pose> {
    let flange = |[w, p, r]: &[f64; 3]| pose([800.0, 100.0, 300.0, *w, *p, *r]) * tool.inverse();
    orientations.iter().map(flange).collect()
}

const APART: [[f64; 3]; 3] = [[180.0, 0.0, 0.0], [150.0, 0.0, 40.0], [180.0, 35.0, -50.0]];

/// By hand: flange down, turned down by a quarter, and sideways, tip 100 in front of the flange.
#[test]
fn three_points_by_hand() {
    let flanges = [
        pose([500.0, 0.0, 400.0, 180.0, 0.0, 0.0]),
        pose([400.0, 0.0, 300.0, 0.0, 90.0, 0.0]),
        pose([500.0, 100.0, 300.0, 90.0, 0.0, 0.0]),
    ];
    let found = calibrate_tip(&flanges).unwrap();
    assert!((found.tip - Vector3::new(0.0, 0.0, 100.0)).norm() < 1e-9);
    assert!((found.place - Vector3::new(500.0, 0.0, 300.0)).norm() < 1e-9);
    assert!(found.worst.0 < 1e-9 && found.mean.0 < 1e-9);
}

#[test]
fn six_points_give_the_whole_tool() {
    let tool = pose([20.0, -35.0, 180.0, 10.0, 25.0, -40.0]);
    let tips = touching(&tool, &APART);
    let origin = pose([700.0, 0.0, 400.0, 170.0, 10.0, 5.0]);
    let turned = tool.isometry().rotation;
    // 60 along the tool's X, a little off towards Z, which is to be taken out; 80 along its Z.
    let moved = |by: Vector3<f64>| {
        let mut moved = *origin.isometry();
        moved.translation.vector += moved.rotation * (turned * by);
        Pose::try_from_isometry(moved).unwrap()
    };
    let along_x = moved(Vector3::new(60.0, 0.0, 4.0));
    let along_z = moved(Vector3::new(0.0, 0.0, 80.0));
    let (found, tip) = calibrate_tool(&tips, &origin, &along_x, &along_z).unwrap();
    let (apart, off) = found.distance_to(&tool);
    assert!(apart.0 < 1e-9 && off.0 < 1e-9, "{apart} {off}");
    assert!(tip.worst.0 < 1e-9);

    let error = calibrate_tool(
        &tips,
        &origin,
        &moved(Vector3::new(5.0, 0.0, 0.0)),
        &along_z,
    );
    assert!(matches!(
        error,
        Err(CalibrationError::TooNear { point: "X", .. })
    ));
    let error = calibrate_tool(
        &tips,
        &origin,
        &moved(Vector3::new(0.0, 0.0, 50.0)),
        &along_z,
    );
    assert!(matches!(error, Err(CalibrationError::Parallel { .. })));
    let mut bent = *along_x.isometry();
    bent.rotation *= nalgebra::UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 0.02);
    let bent = Pose::try_from_isometry(bent).unwrap();
    let error = calibrate_tool(&tips, &origin, &bent, &along_z);
    assert!(matches!(
        error,
        Err(CalibrationError::Turned { point: "X", .. })
    ));
}

#[test]
fn a_tip_that_slipped_shows_in_the_residual() {
    let tool = pose([0.0, 0.0, 150.0, 0.0, 0.0, 0.0]);
    let mut flanges = touching(&tool, &APART);
    let mut slipped = *flanges[2].isometry();
    slipped.translation.vector.x += 2.0;
    flanges[2] = Pose::try_from_isometry(slipped).unwrap();
    let found = calibrate_tip(&flanges).unwrap();
    assert!(found.worst.0 > 0.05 && found.worst.0 < 2.0, "{found:?}");
}

#[test]
fn orientations_that_do_not_determine_the_tip_are_refused() {
    let tool = pose([30.0, 0.0, 150.0, 0.0, 0.0, 0.0]);
    // All turned about one axis: how far along it the tip is cannot be seen.
    let one_axis = touching(
        &tool,
        &[[180.0, 0.0, 0.0], [180.0, 0.0, 60.0], [180.0, 0.0, 120.0]],
    );
    let error = calibrate_tip(&one_axis).unwrap_err();
    assert!(
        matches!(error, CalibrationError::TooAlike { spread, .. } if spread < 1e-6),
        "{error}"
    );
    let alike = touching(
        &tool,
        &[[180.0, 0.0, 0.0], [179.0, 0.0, 1.0], [180.0, 1.0, 0.0]],
    );
    assert!(matches!(
        calibrate_tip(&alike),
        Err(CalibrationError::TooAlike { .. })
    ));
    let error = calibrate_tip(&one_axis[..2]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "2 points were given; it must be 3 to 1000"
    );
}
