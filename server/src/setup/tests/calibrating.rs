use kinematics::{ArmModel, PendantJoints, Pose, Xyzwpr};
use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use units::{Degrees, Millimeters};

use crate::setup::calibrate::{CalibrationError, four_point};

const TIP: [f64; 3] = [12.5, -30.25, 187.0];

/// Flanges that hold the tip of a known tool at one point, turned as said; the point is off by `noise` of the index.
fn flanges(turns: &[[f64; 3]], noise: impl Fn(usize) -> Vector3<f64>) -> Vec<Pose> {
    let held = Vector3::new(900.0, 150.0, 300.0);
    let each = turns.iter().enumerate();
    each.map(|(index, [w, p, r])| {
        let turned = Pose::try_from_xyzwpr(&Xyzwpr::new(
            [Millimeters(0.0); 3],
            [Degrees(*w), Degrees(*p), Degrees(*r)],
        ));
        let rotation = turned.unwrap().isometry().rotation;
        let at = held + noise(index) - rotation * Vector3::from(TIP);
        Pose::try_from_isometry(Isometry3::from_parts(Translation3::from(at), rotation)).unwrap()
    })
    .collect()
}

const TURNS: [[f64; 3]; 4] = [
    [180.0, 0.0, 0.0],
    [165.0, 10.0, 40.0],
    [190.0, -20.0, -35.0],
    [175.0, 25.0, 90.0],
];

#[test]
fn four_postures_give_a_known_tool_to_a_nanometer() {
    let found = four_point(&flanges(&TURNS, |_| Vector3::zeros()), 1.0).unwrap();
    assert!(
        (found.tip - Vector3::from(TIP)).norm() < 1e-6,
        "{}",
        found.tip
    );
    assert!(found.max < 1e-6 && found.uncertainty < 1e-6);
    assert_eq!(found.residuals.len(), 4);
}

#[test]
fn joint_readings_of_an_arm_give_its_tool() {
    // The arm itself holds the tip there; only its joints are read.
    let arm = ArmModel::builtin("fanuc-m20ia").unwrap();
    let read = flanges(&TURNS, |_| Vector3::zeros())
        .into_iter()
        .map(|flange| {
            let solution = arm
                .inverse(&flange, kinematics::Seed::Near(arm.home()))
                .unwrap();
            arm.forward(&PendantJoints::from_degrees(solution.joints.degrees()))
        });
    let found = four_point(&read.collect::<Vec<_>>(), 1.0).unwrap();
    assert!(
        (found.tip - Vector3::from(TIP)).norm() < 1e-6,
        "{}",
        found.tip
    );
}

/// A pseudo-random number from -1 to 1; the same ones every time.
fn noise(seed: u64) -> f64 {
    let mut state = seed
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(0x1234_5678);
    for _ in 0..3 {
        state ^= state >> 29;
        state = state.wrapping_mul(0xbf58_476d_1ce4_e5b9);
    }
    let bits = u32::try_from(state >> 33).unwrap();
    f64::from(bits) / f64::from(1_u32 << 30) - 1.0
}

#[test]
fn with_noise_the_tool_is_within_the_uncertainty_that_is_promised() {
    let mut inside = 0;
    for trial in 0..200_u64 {
        let off = |index: usize| {
            let seed = trial * 100 + u64::try_from(index).unwrap() * 3;
            0.3 * Vector3::new(noise(seed), noise(seed + 1), noise(seed + 2))
        };
        let turns: Vec<[f64; 3]> = TURNS
            .into_iter()
            .chain([[150.0, -15.0, 10.0], [200.0, 15.0, -70.0]])
            .collect();
        let found = four_point(&flanges(&turns, off), 1.0).unwrap();
        assert!(found.rms < 0.6 && found.max <= 1.0);
        let error = (found.tip - Vector3::from(TIP)).norm();
        assert!(error < 2.0, "{error}");
        inside += u32::from(error <= found.uncertainty);
    }
    // Three standard errors; the error itself is estimated from few postures.
    assert!(inside >= 190, "{inside} of 200");
}

#[test]
fn postures_that_do_not_determine_the_tool_are_named() {
    let few = four_point(&flanges(&TURNS[..3], |_| Vector3::zeros()), 1.0);
    assert_eq!(few, Err(CalibrationError::Count { count: 3 }));
    let twice = [TURNS[0], TURNS[1], TURNS[2], [181.0, 0.0, 0.0]];
    let Err(CalibrationError::Alike {
        first,
        second,
        angle_deg,
    }) = four_point(&flanges(&twice, |_| Vector3::zeros()), 1.0)
    else {
        panic!("two postures alike were taken");
    };
    assert_eq!((first, second), (0, 3));
    assert!((angle_deg - 1.0).abs() < 1e-6);
    // Only turned about the flange's own Z: how long the tool is cannot be seen.
    let about_z = [0.0, 50.0, 100.0, 200.0].map(|r| [180.0, 0.0, r]);
    let Err(CalibrationError::Degenerate { direction, .. }) =
        four_point(&flanges(&about_z, |_| Vector3::zeros()), 1.0)
    else {
        panic!("rotations about one axis were taken");
    };
    assert!((direction.z.abs() - 1.0).abs() < 1e-6, "{direction}");
    let off = |index| Vector3::new(if index == 2 { 4.0 } else { 0.0 }, 0.0, 0.0);
    let turns = [
        TURNS[0],
        TURNS[1],
        TURNS[2],
        TURNS[3],
        [150.0, -15.0, 10.0],
        [200.0, 15.0, -70.0],
    ];
    let Err(CalibrationError::Residual { worst, .. }) = four_point(&flanges(&turns, off), 1.0)
    else {
        panic!("a tip 4 mm off was taken");
    };
    assert_eq!(worst, 2);
}

#[test]
fn a_rotation_is_what_turns_the_flange_and_nothing_else() {
    // The residuals do not depend on where the arm stands.
    let shift = Isometry3::from_parts(
        Translation3::new(5_000.0, -300.0, 40.0),
        UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3),
    );
    let shift = Pose::try_from_isometry(shift).unwrap();
    let moved: Vec<Pose> = flanges(&TURNS, |_| Vector3::zeros())
        .into_iter()
        .map(|flange| shift * flange)
        .collect();
    let found = four_point(&moved, 1.0).unwrap();
    assert!((found.tip - Vector3::from(TIP)).norm() < 1e-6);
}
