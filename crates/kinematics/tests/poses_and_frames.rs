//! W, P, R both ways, products of frames, and what a pose refuses.
#![expect(non_snake_case, reason = "frames are part of a pose's name")]

mod support;

use kinematics::{Frames, Pose, PoseError, Xyzwpr};
use proptest::prelude::*;
use support::pose;
use units::{Degrees, Millimeters, Radians};

fn assert_close(a: &Pose, b: &Pose) {
    let (apart, turned) = a.distance_to(b);
    assert!(
        apart.0 < 1e-9 && turned.0 < 1e-9,
        "{apart} and {turned}: {} {}",
        a.xyzwpr(),
        b.xyzwpr()
    );
}

fn angles(pose: &Pose) -> [f64; 3] {
    let shown = pose.xyzwpr();
    [shown.w.0, shown.p.0, shown.r.0]
}

#[test]
fn w_p_and_r_turn_about_the_fixed_axes() {
    // W first, about X, then P about the fixed Y, then R about the fixed Z: hand-made.
    let turned = pose([0.0, 0.0, 0.0, 90.0, 0.0, 90.0]);
    let along_y = turned.isometry() * nalgebra::Vector3::y();
    assert!(
        (along_y - nalgebra::Vector3::z()).norm() < 1e-12,
        "{along_y}"
    );
    let along_z = turned.isometry() * nalgebra::Vector3::z();
    assert!(
        (along_z - nalgebra::Vector3::x()).norm() < 1e-12,
        "{along_z}"
    );
}

#[test]
fn at_the_gimbal_r_is_shown_as_zero() {
    for (written, shown) in [
        ([180.0, -90.0, 0.0], [180.0, -90.0, 0.0]),
        ([100.0, -90.0, 30.0], [130.0, -90.0, 0.0]),
        ([100.0, 90.0, 30.0], [70.0, 90.0, 0.0]),
        ([0.0, 90.0, 0.0], [0.0, 90.0, 0.0]),
    ] {
        let [w, p, r] = written;
        let found = angles(&pose([0.0, 0.0, 0.0, w, p, r]));
        for (found, shown) in found.into_iter().zip(shown) {
            assert!((found - shown).abs() < 1e-6, "{written:?}: {found} {shown}");
        }
    }
}

#[test]
fn half_a_turn_is_shown_as_plus_180() {
    let shown = pose([0.0, 0.0, 0.0, -180.0, 0.0, 0.0]).xyzwpr();
    assert_eq!(
        (shown.w, shown.p, shown.r),
        (Degrees(180.0), Degrees(0.0), Degrees(0.0))
    );
}

#[test]
fn a_pose_refuses_what_is_not_a_number_or_too_large() {
    let good = Xyzwpr::default();
    let refused = |pose: Xyzwpr| Pose::try_from_xyzwpr(&pose).unwrap_err().to_string();
    assert_eq!(
        refused(Xyzwpr {
            z: Millimeters(f64::NAN),
            ..good
        }),
        "z is NaN mm; it must be a number from -1000000 mm to 1000000 mm"
    );
    assert_eq!(
        refused(Xyzwpr {
            x: Millimeters(-2e6),
            ..good
        }),
        "x is -2000000 mm; it must be a number from -1000000 mm to 1000000 mm"
    );
    assert_eq!(
        refused(Xyzwpr {
            p: Degrees(f64::INFINITY),
            ..good
        }),
        "p is inf\u{b0}; it must be a number from -36000\u{b0} to 36000\u{b0}"
    );
    let bent = nalgebra::Quaternion::new(1.0, 0.1, 0.0, 0.0);
    let isometry = nalgebra::Isometry3::from_parts(
        nalgebra::Translation3::identity(),
        nalgebra::UnitQuaternion::new_unchecked(bent),
    );
    assert!(matches!(
        Pose::try_from_isometry(isometry),
        Err(PoseError::Rotation { .. })
    ));
}

#[test]
fn the_distance_of_poses_is_exact_for_small_angles() {
    let (apart, turned) =
        pose([3.0, 4.0, 0.0, 0.0, 0.0, 0.0]).distance_to(&pose([0.0, 0.0, 0.0, 0.0, 0.0, 1e-7]));
    assert_eq!(apart, Millimeters(5.0));
    assert!(
        (turned - Radians::from(Degrees(1e-7))).0.abs() < 1e-20,
        "{turned}"
    );
}

#[test]
fn a_tool_100_mm_long_ends_100_mm_below_the_hanging_flange() {
    let frames = Frames {
        user_frame: pose([500.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        tool: pose([0.0, 0.0, 100.0, 0.0, 0.0, 0.0]),
    };
    let X_UT = frames.tcp_in_user_frame(&pose([985.0, 0.0, 940.0, 180.0, 0.0, 0.0]));
    assert_close(&X_UT, &pose([485.0, 0.0, 840.0, 180.0, 0.0, 0.0]));
}

prop_compose! {
    fn any_pose()(
        xyz in prop::array::uniform3(-2000.0..2000.0_f64),
        wpr in prop::array::uniform3(-360.0..360.0_f64),
    ) -> Pose {
        let ([x, y, z], [w, p, r]) = (xyz, wpr);
        pose([x, y, z, w, p, r])
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn a_pose_survives_being_shown(pose in any_pose()) {
        assert_close(&Pose::try_from_xyzwpr(&pose.xyzwpr()).unwrap(), &pose);
    }

    #[test]
    fn a_pose_near_the_gimbal_survives_being_shown(
        w in -180.0..180.0_f64,
        r in -180.0..180.0_f64,
        exponent in -16.0..0.0_f64,
        up in prop::sample::select(vec![-1.0, 1.0]),
    ) {
        let near = pose([1.0, 2.0, 3.0, w, up * (90.0 - 10.0_f64.powf(exponent)), r]);
        assert_close(&Pose::try_from_xyzwpr(&near.xyzwpr()).unwrap(), &near);
    }

    #[test]
    fn shown_angles_are_in_their_ranges(pose in any_pose()) {
        let [w, p, r] = angles(&pose);
        prop_assert!(-180.0 < w && w <= 180.0 && -180.0 < r && r <= 180.0);
        prop_assert!((-90.0..=90.0).contains(&p));
    }

    #[test]
    fn into_the_user_frame_and_back_is_no_way_at_all(
        X_WF in any_pose(),
        user_frame in any_pose(),
        tool in any_pose(),
    ) {
        let frames = Frames { user_frame, tool };
        assert_close(&frames.flange_in_world(&frames.tcp_in_user_frame(&X_WF)), &X_WF);
    }
}
