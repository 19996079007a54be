//! Poses from outside: the source thesis's table, a pendant, and a table made with another program.
#![expect(non_snake_case, reason = "frames are part of a pose's name")]

mod support;

use support::{arm, joints, pose};
use units::Degrees;

/// The expected numbers are rounded to `rounding`.
fn assert_pose(degrees: [f64; 6], expected: [f64; 6], rounding: f64) {
    let X_WF = arm().forward(&joints(degrees));
    let (apart, turned) = X_WF.distance_to(&pose(expected));
    assert!(
        apart.0 < 2.0 * rounding && Degrees::from(turned).0 < 2.0 * rounding,
        "{degrees:?}: {apart} and {turned} from {expected:?}: {:.6}",
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
    let shown = arm().forward(&joints([0.0; 6])).xyzwpr();
    assert_eq!(
        format!("{shown:.4}"),
        "X 1085.0000 mm, Y 0.0000 mm, Z 1040.0000 mm, W 180.0000\u{b0}, P -90.0000\u{b0}, R 0.0000\u{b0}"
    );
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

#[test]
fn the_reach_is_the_data_sheets() {
    assert!((arm().reach().0 - 1811.0).abs() < 1.0, "{}", arm().reach());
}
