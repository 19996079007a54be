//! Poses from outside: the source thesis's table, a pendant, and a table made with another program.
#![expect(non_snake_case, reason = "frames are part of a pose's name")]

use kinematics::{ArmModel, PendantJoints, Pose, Xyzwpr};
use units::{Degrees, Millimeters};

fn arm() -> &'static ArmModel {
    ArmModel::builtin("fanuc-m20ia").unwrap()
}

fn pose([x, y, z, w, p, r]: [f64; 6]) -> Pose {
    let pose = Xyzwpr::new([x, y, z].map(Millimeters), [w, p, r].map(Degrees));
    Pose::try_from_xyzwpr(&pose).unwrap()
}

/// The numbers are the pendant's, rounded to `digits` places.
fn assert_pose(joints: [f64; 6], expected: [f64; 6], rounding: f64) {
    let X_WF = arm().forward(&PendantJoints::from_degrees(joints));
    let (apart, turned) = X_WF.distance_to(&pose(expected));
    assert!(
        apart.0 < 2.0 * rounding && Degrees::from(turned).0 < 2.0 * rounding,
        "{joints:?}: {apart} and {turned} from {expected:?}: {:.6}",
        X_WF.xyzwpr()
    );
}

#[test]
fn the_pendant_shows_these_poses() {
    assert_pose([0.0; 6], [1085.0, 0.0, 1040.0, 180.0, -90.0, 0.0], 1e-9);
    assert_pose(
        [0.0, 0.0, 0.0, 0.0, -90.0, 0.0],
        [985.0, 0.0, 940.0, 180.0, 0.0, 0.0],
        1e-9,
    );
    assert_pose(
        [10.0, 20.0, 30.0, 40.0, 50.0, 60.0],
        [1020.2318, 229.8944, 1459.3234, 20.848, 27.4119, 111.4664],
        1e-4,
    );
}

#[test]
fn with_all_joints_at_zero_the_pendant_shows_r_as_zero() {
    let shown = arm().forward(&PendantJoints::default()).xyzwpr();
    assert!((shown.w.0 - 180.0).abs() < 1e-9, "{shown}");
    assert!((shown.p.0 + 90.0).abs() < 1e-6, "{shown}");
    assert!(shown.r.0.abs() < 1e-9, "{shown}");
}

#[test]
fn the_thousand_poses_of_the_outside_table_agree() {
    let table = include_str!("../testdata/m20ia_fk.csv");
    let mut rows = 0;
    for line in table.lines().skip(1) {
        let numbers: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [j1, j2, j3, j4, j5, j6, x, y, z, w, p, r] = numbers[..] else {
            panic!("12 columns: {line}")
        };
        assert_pose([j1, j2, j3, j4, j5, j6], [x, y, z, w, p, r], 1e-8);
        rows += 1;
    }
    assert_eq!(rows, 1000);
}
