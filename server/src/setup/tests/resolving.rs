use units::{Degrees, Millimeters};

use super::support::{DEMO, PAIR, setup};
use crate::setup::geometry::{DockPose, origin_of};
use crate::setup::resolve::{Dock, ResolveError, Target};

fn dock(x: f64, y: f64, heading: f64) -> Dock {
    Dock::Measured(DockPose {
        x: Millimeters(x),
        y: Millimeters(y),
        heading: Degrees(heading),
    })
}

#[test]
fn a_pose_on_a_mobile_robot_moves_rigidly_with_it() {
    let setup = setup(DEMO);
    let tip = |target, dock| origin_of(&setup.resolve("r1", target, dock).unwrap().X_CT);
    let at = tip(Target::At("front/left"), Dock::Nominal);
    assert!((at - nalgebra::Point3::new(1100.0, 180.0, 600.0)).norm() < 1e-9);
    // The slot is 180 mm ahead of the robot's middle, along its heading.
    let turned = tip(Target::At("front/left"), dock(1105.0, -8.0, 91.5));
    let heading = 91.5_f64.to_radians();
    let wanted = nalgebra::Point3::new(
        1105.0 + 180.0 * heading.cos(),
        -8.0 + 180.0 * heading.sin(),
        600.0,
    );
    assert!((turned - wanted).norm() < 1e-9, "{turned} {wanted}");
    let approach = tip(Target::ApproachOf("front/left"), dock(1105.0, -8.0, 91.5));
    assert!((approach - turned - nalgebra::Vector3::new(0.0, 0.0, 200.0)).norm() < 1e-6);
    // A place that stands still stands still.
    let rack = tip(Target::At("rack/a"), dock(1105.0, -8.0, 91.5));
    assert!((rack - nalgebra::Point3::new(500.0, 1000.0, 650.0)).norm() < 1e-9);
}

#[test]
fn a_mobile_robot_outside_its_tolerance_is_not_served() {
    let setup = setup(DEMO);
    for (x, y, heading, served) in [
        (1115.0, 15.0, 92.0, true),
        (1115.0, 15.0, 92.0 - 360.0, true),
        (1115.2, 0.0, 90.0, false),
        (1100.0, -15.2, 90.0, false),
        (1100.0, 0.0, 92.1, false),
        (1100.0, 0.0, -90.0, false),
        (f64::NAN, 0.0, 90.0, false),
        (1100.0, 0.0, f64::INFINITY, false),
    ] {
        let resolved = setup.resolve("r1", Target::At("front/left"), dock(x, y, heading));
        match resolved {
            Ok(_) => assert!(served, "{x} {y} {heading}"),
            Err(ResolveError::DockOutsideTolerance { point, .. }) => {
                assert!(!served && point == "handover/front", "{x} {y} {heading}");
            }
            Err(error) => panic!("{error}"),
        }
    }
}

#[test]
fn the_controller_is_told_the_point_in_its_own_frames() {
    // No tool and no user frame on the controller: it is told the flange in its own world, 525 mm above the floor, the
    // gripper of 150 mm above the crate.
    let setup = setup(DEMO);
    let told = setup
        .resolve("r1", Target::At("front/right"), Dock::Nominal)
        .unwrap();
    let point = told.controller_point;
    assert!((point.x.0 - 1100.0).abs() < 1e-9 && (point.y.0 + 180.0).abs() < 1e-9);
    assert!(
        (point.z.0 - (600.0 + 150.0 - 525.0)).abs() < 1e-9,
        "{point}"
    );
    assert_eq!(told.configuration.to_string(), "N U T, 0, 0, 0");
    let arm = setup.arm("r1").unwrap();
    let (apart, turned) = arm.tip(&told.joints).distance_to(&told.X_CT);
    assert!(apart.0 < 1e-6 && turned.0 < 1e-9);
}

#[test]
fn an_arm_that_stands_turned_is_told_the_same_as_one_that_does_not() {
    let setup = setup(PAIR);
    for (one, two) in [
        ("aisle-1/left", "aisle-2/left"),
        ("rack-1/a", "rack-2/a"),
        ("reject-1", "reject-2"),
    ] {
        let at = |arm, place| {
            setup
                .resolve(arm, Target::LiftOf(place), Dock::Nominal)
                .unwrap()
        };
        let (one, two) = (at("r1", one), at("r2", two));
        for (a, b) in one.joints.degrees().iter().zip(two.joints.degrees()) {
            assert!((a - b).abs() < 1e-6);
        }
    }
    let lift = setup
        .resolve("r1", Target::LiftOf("rack-1/b"), Dock::Nominal)
        .unwrap();
    assert!(
        (origin_of(&lift.X_CT).z - 750.0).abs() < 1e-9,
        "its own lift is 100 mm"
    );
}

#[test]
fn safe_and_home_are_joint_values_and_the_rest_must_be_taught() {
    let setup = setup(DEMO);
    let safe = setup.resolve("r1", Target::Safe, Dock::Nominal).unwrap();
    assert!((safe.joints.degrees()[0] - 90.0).abs() < 1e-9);
    let home = setup.resolve("r1", Target::Home, Dock::Nominal).unwrap();
    assert!(home.joints.degrees()[0].abs() < 1e-9);
    let error = |arm, place| {
        let resolved = setup.resolve(arm, Target::At(place), Dock::Nominal);
        resolved.unwrap_err().to_string()
    };
    assert_eq!(
        error("r1", "attic"),
        "no pose is taught at `attic` for `r1`"
    );
    assert_eq!(error("r9", "rack/a"), "`r9` is no arm of the set-up");
}
