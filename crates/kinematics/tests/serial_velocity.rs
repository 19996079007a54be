//! Joint rates, rank and singular directions, and the damped-least-squares solver.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

use kinematics::serial::{DlsError, DlsOptions, SerialArm, Task, Twist, VelocityError, WristError};
use kinematics::{Pose, Xyzwpr};
use nalgebra::Vector3;
use units::{Degrees, Millimeters};

fn arm(name: &str) -> &'static SerialArm {
    SerialArm::builtin(name).unwrap()
}

fn twist(linear: [f64; 3], angular: [f64; 3]) -> Twist {
    Twist {
        linear: Vector3::from(linear),
        angular: Vector3::from(angular),
    }
}

/// (1.92), by hand: the M-20iA at home, J1 turns its flange about Z: 985 mm from the axis, 98.5 mm/s
/// along Y are 0.1 rad/s and turn the flange as well.
#[test]
fn six_joints_make_any_velocity() {
    let arm = arm("fanuc-m20ia");
    let velocity = twist([0.0, 98.5, 0.0], [0.0, 0.0, 0.1]);
    let rates = arm.rates(&arm.home(), &velocity, Task::Pose, None).unwrap();
    let wanted = [0.1, 0.0, 0.0, 0.0, 0.0, 0.0];
    for (rate, wanted) in rates.rates.iter().zip(wanted) {
        assert!((rate - wanted).abs() < 1e-12, "{rates:?}");
    }
    // 0.1 of 195 deg/s.
    assert!((rates.load - 0.1 / 195_f64.to_radians()).abs() < 1e-12);
    assert_eq!(rates.rank, 6);
}

/// By hand: the M-20iA with all joints at 0 but J5 = -90: the wrist center is 985 from axis 1, 835
/// before and 1040 - 790 = 250 above the elbow. J1 moves it along Y by 985; J2 alone, the forearm
/// keeping its direction, along X by 790; J3 turns the forearm: (-250, 0, 835). So `det J11 = +-
/// 985 * 790 * 835`. Axes 4, 5 and 6 are at right angles: `det J22 = +-1`.
#[test]
fn the_determinant_is_the_arms_times_the_wrists() {
    let arm = arm("fanuc-m20ia");
    let home = arm.home();
    let parts = arm.singularity_decomposition(&home).unwrap();
    assert!((parts.arm_determinant().abs() - 985.0 * 790.0 * 835.0).abs() < 1e-3);
    assert!((parts.wrist_determinant().abs() - 1.0).abs() < 1e-12);
    assert!(!parts.is_singular());

    let mut seen = 0;
    for name in ["fanuc-m20ia", "fanuc-m20ia-machine", "textbook-6r"] {
        let arm = SerialArm::builtin(name).unwrap();
        for k in 1..200_u32 {
            let part =
                |i: usize| (f64::from(k) * 0.618_034 * [1.0, 2.0, 3.0, 5.0, 7.0, 11.0][i]).fract();
            let shown: Vec<f64> = arm
                .joint_list()
                .iter()
                .enumerate()
                .map(|(i, joint)| {
                    joint
                        .kind
                        .shown(joint.min + part(i) * (joint.max - joint.min))
                })
                .collect();
            let joints = arm.joints(&shown).unwrap();
            let parts = arm.singularity_decomposition(&joints).unwrap();
            let whole: nalgebra::Matrix6<f64> = arm
                .jacobian(&joints)
                .unwrap()
                .fixed_columns::<6>(0)
                .into_owned();
            let (product, whole) = (parts.determinant(), whole.determinant());
            let scale = arm.span().powi(3);
            assert!((product - whole).abs() < 1e-12 * scale, "{product} {whole}");
            let rank = arm.dexterity(&joints, Task::Pose).unwrap().rank;
            assert_eq!(parts.is_singular(), rank < 6);
            seen += 1;
        }
    }
    assert_eq!(seen, 3 * 199);
}

#[test]
fn the_decomposition_says_what_is_singular() {
    let serial = arm("fanuc-m20ia");
    let ranks = |degrees: [f64; 6]| {
        let joints = serial.joints(&degrees).unwrap();
        let parts = serial.singularity_decomposition(&joints).unwrap();
        let rank = serial.dexterity(&joints, Task::Pose).unwrap().rank;
        assert_eq!(parts.is_singular(), rank < 6, "{degrees:?}");
        (parts.arm_rank, parts.wrist_rank)
    };
    assert_eq!(ranks([10.0, 20.0, 30.0, 40.0, 0.0, 60.0]), (3, 2));
    // Stretched: the forearm, 835 along and 250 across, points along the upper arm.
    let stretched = 835.0_f64.atan2(250.0).to_degrees();
    assert_eq!(ranks([10.0, 0.0, stretched, 40.0, 50.0, 60.0]), (2, 3));
    assert_eq!(ranks([10.0, 0.0, stretched, 40.0, 0.0, 60.0]), (2, 2));
    // The wrist center on axis 1: 100 below a flange that looks up.
    let closed = kinematics::ArmModel::builtin("fanuc-m20ia").unwrap();
    let above = Xyzwpr::new(
        [0.0, 0.0, 1000.0].map(Millimeters),
        [30.0, 0.0, 0.0].map(Degrees),
    );
    let mut above = *Pose::try_from_xyzwpr(&above).unwrap().isometry();
    above.translation.vector =
        Vector3::new(0.0, 0.0, 900.0) + above.rotation * Vector3::z() * 100.0;
    let above = Pose::try_from_isometry(above).unwrap();
    for solution in &closed.inverse_all(&above).unwrap() {
        assert_eq!(ranks(solution.joints.degrees()), (2, 3));
    }
}

#[test]
fn an_arm_without_a_spherical_wrist_has_no_decomposition() {
    let seven = arm("seven-joint");
    let error = seven.singularity_decomposition(&seven.home()).unwrap_err();
    assert!(matches!(error, WristError::NotCovered { .. }), "{error}");
    let five = arm("five-link");
    let other = seven.home();
    let error = five.singularity_decomposition(&other).unwrap_err();
    assert!(matches!(error, WristError::Joints(_)), "{error}");
}

/// (1.91): five joints can move so only if the velocity lies in what they can do.
#[test]
fn fewer_joints_make_the_velocities_that_are_compatible() {
    let five = arm("five-link");
    let home = five.home();
    let wish = twist([10.0, -5.0, 8.0], [0.0; 3]);
    let rates = five
        .rates(&home, &wish, Task::PositionAndAxis, None)
        .unwrap();
    let made = five.jacobian(&home).unwrap() * nalgebra::DVector::from_vec(rates.rates);
    assert!((made.fixed_rows::<3>(0) - wish.linear).norm() < 1e-9);
    // The direction EF is kept.
    let pose = five.forward(&home).unwrap();
    let axis = pose.isometry().rotation * Vector3::z();
    let omega = made.fixed_rows::<3>(3).into_owned();
    assert!(omega.cross(&axis).norm() < 1e-9, "{omega}");
    // A full twist has six numbers; what one of these arms makes is compatible, another is not.
    let made = twist(made.fixed_rows::<3>(0).into_owned().into(), omega.into());
    assert!(five.rates(&home, &made, Task::Pose, None).is_ok());
    let error = five.rates(&home, &wish, Task::Pose, None).unwrap_err();
    assert!(
        matches!(
            error,
            VelocityError::Incompatible {
                rank: 5,
                wanted: 6,
                ..
            }
        ),
        "{error}"
    );
}

/// (1.93): the null-space part moves the joints and not the flange; without it the rates are the
/// smallest.
#[test]
fn seven_joints_have_motion_to_spare() {
    let seven = arm("seven-joint");
    let home = seven.home();
    let wish = twist([20.0, 30.0, -10.0], [0.1, 0.0, -0.2]);
    let least = seven.rates(&home, &wish, Task::Pose, None).unwrap();
    let rho = [0.5, -0.2, 0.3, 0.1, 0.0, 0.2, -0.4];
    let with = seven.rates(&home, &wish, Task::Pose, Some(&rho)).unwrap();
    let jacobian = seven.jacobian(&home).unwrap();
    let vector = |rates: &[f64]| nalgebra::DVector::from_column_slice(rates);
    for rates in [&least, &with] {
        let made = &jacobian * vector(&rates.rates);
        assert!((made.fixed_rows::<3>(0) - wish.linear).norm() < 1e-9);
        assert!((made.fixed_rows::<3>(3) - wish.angular).norm() < 1e-9);
    }
    assert!(vector(&with.rates).norm() > vector(&least.rates).norm() + 0.01);
    // rho as it is, as far as it does not move the flange: the free direction's share of it.
    let free = &seven.dexterity(&home, Task::Pose).unwrap().free;
    assert_eq!(free.len(), 1);
    let free = vector(&free[0]).normalize();
    let share = &free * free.dot(&vector(&rho));
    let difference = vector(&with.rates) - vector(&least.rates) - share;
    assert!(difference.norm() < 1e-9, "{difference}");
}

/// J4 and J6 of the textbook's arm in line: the rank is 5, and what is lost is the turn about the
/// axis across axis 5.
#[test]
fn a_singular_wrist_loses_one_direction_and_frees_one_motion() {
    let textbook = arm("textbook-6r");
    let joints = textbook.joints(&[0.0, 90.0, -90.0, 0.0, 0.0, 0.0]).unwrap();
    let found = textbook.dexterity(&joints, Task::Pose).unwrap();
    assert_eq!(found.rank, 5);
    assert!(found.condition.is_infinite() && found.manipulability < 1e-12);
    // Free: J4 against J6.
    let free: Vec<f64> = found.free[0].clone();
    assert!(
        (free[3] + free[5]).abs() < 1e-9 && free[3].abs() > 0.7,
        "{free:?}"
    );
    // Lost: no joint turns the flange about Z except J1, which also carries it along Y.
    let lost = &found.lost[0];
    let jacobian = textbook.jacobian(&joints).unwrap();
    let span = textbook.span();
    for column in jacobian.column_iter() {
        let linear = column.fixed_rows::<3>(0).dot(&lost.linear) / (span * span);
        let angular = column.fixed_rows::<3>(3).dot(&lost.angular);
        assert!((linear + angular).abs() < 1e-9, "{lost:?}");
    }
    // Along the lost direction nothing goes; along another all does.
    let error = textbook.rates(&joints, lost, Task::Pose, None).unwrap_err();
    assert!(
        matches!(error, VelocityError::Incompatible { rank: 5, .. }),
        "{error}"
    );
    let along_x = twist([10.0, 0.0, 0.0], [0.0; 3]);
    assert!(textbook.rates(&joints, &along_x, Task::Pose, None).is_ok());
}

/// A planar arm of two links has the manipulability l1 l2 |sin q2| (Yoshikawa); the SCARA's first
/// two joints are one.
#[test]
fn manipulability_of_a_planar_arm_is_as_in_the_books() {
    let text = |b: f64| {
        let joint = |name: &str, a: f64| {
            format!(
                "[[joints]]\naxis = \"{name}\"\nd_mm = 0.0\na_mm = {a:?}\nalpha_deg = 0.0\nmin_deg = -170.0\n\
                 max_deg = 170.0\nmax_speed_deg_s = 90.0\nmax_acceleration_deg_s2 = 90.0\nhome_deg = 0.0\n"
            )
        };
        format!(
            "name = \"planar\"\nmanufacturer = \"test\"\n{}{}",
            joint("J1", 300.0),
            joint("J2", b)
        )
    };
    let planar = SerialArm::from_toml(&text(200.0)).unwrap();
    let joints = planar.joints(&[20.0, 50.0]).unwrap();
    let found = planar.dexterity(&joints, Task::Position).unwrap();
    let wanted = 300.0 * 200.0 * 50_f64.to_radians().sin() / (500.0 * 500.0);
    assert!((found.manipulability - wanted).abs() < 1e-12);
    let straight = planar.joints(&[20.0, 0.0]).unwrap();
    assert_eq!(planar.dexterity(&straight, Task::Position).unwrap().rank, 1);
}

#[test]
fn velocities_that_are_none_are_refused_by_name() {
    let arm = arm("fanuc-m20ia");
    let error = arm
        .rates(
            &arm.home(),
            &twist([f64::NAN, 0.0, 0.0], [0.0; 3]),
            Task::Pose,
            None,
        )
        .unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("linear of the velocity is NaN")
    );
    let error = arm
        .rates(
            &arm.home(),
            &twist([0.0; 3], [0.0; 3]),
            Task::Pose,
            Some(&[1.0, f64::NAN]),
        )
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "the null-space motion has 1 finite rates; the arm has 6 joints"
    );
}

/// From home to a hundred poses that each arm reaches, inside the ranges.
#[test]
fn damped_least_squares_reaches_what_can_be_reached() {
    for (name, task) in [
        ("fanuc-m20ia", Task::Pose),
        ("textbook-6r", Task::Pose),
        ("five-link", Task::PositionAndAxis),
        ("scara", Task::PositionAndHeading),
        ("seven-joint", Task::Pose),
    ] {
        let arm = arm(name);
        let mut reached = 0;
        for k in 1..=40_u32 {
            let values = arm.joint_list().iter().zip(1_u32..).map(|(joint, i)| {
                let part = (f64::from(k) * 0.618_034 * f64::from(i) + f64::from(i) * 0.27).fract();
                joint.min + (0.05 + 0.9 * part) * (joint.max - joint.min)
            });
            let values: Vec<f64> = values.collect();
            let joints = arm.joints_from_radians(&values).unwrap();
            let target = arm.forward(&joints).unwrap();
            let options = DlsOptions {
                starts: 60,
                ..DlsOptions::default()
            };
            if let Ok(found) = arm.solve(&target, task, &arm.home(), &options) {
                reached += 1;
                let there = arm.forward(&found.joints).unwrap();
                let (apart, _) = there.distance_to(&target);
                assert!(apart.0 < 1e-6, "{name}: {apart}");
                assert!(arm.check_ranges(&found.joints).unwrap().is_empty());
            }
        }
        assert!(reached >= 38, "{name}: {reached} of 40");
    }
}

#[test]
fn damped_least_squares_says_how_far_it_got() {
    let scara = arm("scara");
    // 600 mm of reach; 100 beyond it along X, and the quill 50 mm too low.
    let far = Xyzwpr::new(
        [Millimeters(700.0), Millimeters(0.0), Millimeters(130.0)],
        [Degrees(180.0), Degrees(0.0), Degrees(0.0)],
    );
    let far = Pose::try_from_xyzwpr(&far).unwrap();
    let error = scara
        .solve(&far, Task::Position, &scara.home(), &DlsOptions::default())
        .unwrap_err();
    let DlsError::NotReached { nearest, at_limits } = error else {
        panic!("{error}");
    };
    // By hand: the stretched arm at (600, 0, 180), the quill at its end: 100 and 50 off.
    assert!(
        (nearest.position_error_mm - 100_f64.hypot(50.0)).abs() < 1e-3,
        "{nearest:?}"
    );
    assert_eq!(at_limits, ["Z"]);
    let outside = scara.joints(&[0.0, 0.0, 300.0, 0.0]).unwrap();
    let error = scara.solve(&far, Task::Position, &outside, &DlsOptions::default());
    assert_eq!(
        error.unwrap_err().to_string(),
        "the start is outside the ranges: Z would be 300.00 mm, its range is 0.00 to 200.00"
    );
    let options = DlsOptions {
        position_tolerance_mm: f64::NAN,
        ..DlsOptions::default()
    };
    let error = scara
        .solve(&far, Task::Position, &scara.home(), &options)
        .unwrap_err();
    assert_eq!(
        error.to_string(),
        "position_tolerance_mm is NaN; it must be above 0"
    );
}
