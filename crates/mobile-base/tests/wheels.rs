//! Wheel speeds and body velocity: thesis (1), (2), (3), checked by hand and by the rollers.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use mobile_base::{Dimensions, MecanumBase, Wheel, WheelSpeeds};
use proptest::prelude::*;
use support::{assert_near, base, numbers, pose, twist, wheels, world};
use units::{Millimeters, RadPerSec, Radians};

fn plain(speeds: &WheelSpeeds) -> [f64; 4] {
    speeds.0.map(|speed| speed.0)
}

#[test]
fn wheel_speeds_of_plain_motions_are_as_by_hand() {
    let base = base();
    // 1000 mm/s ahead on 100 mm wheels: 10 rad/s each.
    let ahead = base.inverse(&twist(1000.0, 0.0, 0.0));
    assert_near(plain(&ahead), [10.0, 10.0, 10.0, 10.0], 1e-12);
    // To the left: the front left and the rear right wheel turn backward.
    let left = base.inverse(&twist(0.0, 1000.0, 0.0));
    assert_near(plain(&left), [-10.0, 10.0, 10.0, -10.0], 1e-12);
    // 2 rad/s counterclockwise with a lever of 500 mm: 1000 mm/s at each rim.
    let turn = base.inverse(&twist(0.0, 0.0, 2.0));
    assert_near(plain(&turn), [-10.0, 10.0, -10.0, 10.0], 1e-12);
    // All at once: 300 -/+ 100 -/+ 500 * 0.4, over 100.
    let all = base.inverse(&twist(300.0, 100.0, 0.4));
    assert_near(plain(&all), [0.0, 6.0, 2.0, 4.0], 1e-12);
}

#[test]
fn body_velocities_of_single_wheels_are_as_by_hand() {
    let base = base();
    // One wheel at 4 rad/s: r/4 * 4 = 100 mm/s ahead and aside, 100 / 500 = 0.2 rad/s.
    let one = |wheel: usize| {
        let mut speeds = [0.0; 4];
        speeds[wheel] = 4.0;
        numbers(&base.forward(&wheels(speeds)))
    };
    assert_near(one(0), [100.0, -100.0, -0.2], 1e-12);
    assert_near(one(1), [100.0, 100.0, 0.2], 1e-12);
    assert_near(one(2), [100.0, 100.0, -0.2], 1e-12);
    assert_near(one(3), [100.0, -100.0, 0.2], 1e-12);
}

#[test]
fn the_wheel_speeds_of_3_follow_from_the_rollers() {
    // A wheel at (a, b) with the roller's axis u on the floor rolls freely only across u; along u
    // the wheel's center moves as the rim pushes it: v . u = r w (x . u).
    let base = base();
    let motion = [317.0, -45.0, 0.83];
    let speeds = base.inverse(&twist(motion[0], motion[1], motion[2]));
    let half = (300.0, 200.0);
    let places = [
        (Wheel::FrontLeft, (half.0, half.1), (1.0, -1.0)),
        (Wheel::FrontRight, (half.0, -half.1), (1.0, 1.0)),
        (Wheel::RearLeft, (-half.0, half.1), (1.0, 1.0)),
        (Wheel::RearRight, (-half.0, -half.1), (1.0, -1.0)),
    ];
    for (wheel, (a, b), (ux, uy)) in places {
        let (vx, vy) = (motion[0] - motion[2] * b, motion[1] + motion[2] * a);
        let rim = (vx * ux + vy * uy) / ux;
        assert!((speeds.of(wheel).0 - rim / 100.0).abs() < 1e-12, "{wheel}");
    }
}

#[test]
fn wheels_that_fight_each_other_slip_and_do_not_move_the_base() {
    let base = base();
    let fighting = wheels([3.0, 3.0, -3.0, -3.0]);
    assert_near(numbers(&base.forward(&fighting)), [0.0; 3], 1e-12);
    assert!((base.slip(&fighting).0 - 3.0).abs() < 1e-12);
}

#[test]
fn equation_2_turns_the_velocity_with_the_base() {
    // Looking along Y of the world, ahead is Y and left is -X.
    let seen = pose(0.0, 0.0, std::f64::consts::FRAC_PI_2).world_twist(twist(3.0, 4.0, 0.5));
    assert_near([seen.x.0, seen.y.0, seen.turn.0], [-4.0, 3.0, 0.5], 1e-12);
}

#[test]
fn speeds_beyond_the_limit_are_refused_with_wheel_value_and_limit() {
    let base = base();
    let too_fast = base.inverse(&twist(1500.0, -1000.0, 0.0));
    assert_eq!(
        base.check(&too_fast).unwrap_err().to_string(),
        "the front left wheel would turn at 25 rad/s; its limit is 20 rad/s either way"
    );
    assert!(base.check(&wheels([20.0, -20.0, 20.0, -20.0])).is_ok());
    assert!(base.check(&wheels([0.0, 0.0, f64::NAN, 0.0])).is_err());
}

#[test]
fn scaling_keeps_the_path_and_says_by_how_much() {
    let base = base();
    // 25 rad/s is wanted of the front left wheel, 20 can be had: four fifths.
    let scaled = base.scale_to_limits(&twist(1500.0, -1000.0, 0.0)).unwrap();
    assert!((scaled.factor - 0.8).abs() < 1e-12);
    assert_near(numbers(&scaled.twist), [1200.0, -800.0, 0.0], 1e-9);
    let slow = base.scale_to_limits(&twist(1.0, 2.0, 0.1)).unwrap();
    assert!((slow.factor - 1.0).abs() < f64::EPSILON);
}

#[test]
fn impossible_measures_are_refused_by_name() {
    let good = *base().dimensions();
    let refused = |change: fn(&mut Dimensions)| {
        let mut bad = good;
        change(&mut bad);
        MecanumBase::try_new(&bad).unwrap_err().to_string()
    };
    let message = refused(|bad| bad.wheel_radius = Millimeters(0.0));
    assert_eq!(
        message,
        "wheel radius is 0 mm; it must be from 1 mm to 100000 mm"
    );
    assert!(refused(|bad| bad.wheelbase = Millimeters(f64::NAN)).starts_with("wheelbase is NaN"));
    assert!(refused(|bad| bad.track = Millimeters(f64::INFINITY)).starts_with("track is inf"));
    let message = refused(|bad| bad.max_wheel_speed = RadPerSec(-1.0));
    assert!(message.starts_with("highest wheel speed is -1 rad/s"));
}

fn any_base() -> impl Strategy<Value = MecanumBase> {
    (20.0..500.0, 100.0..3000.0, 100.0..3000.0, 1.0..100.0).prop_map(
        |(radius, wheelbase, track, limit)| {
            MecanumBase::try_new(&Dimensions {
                wheel_radius: Millimeters(radius),
                wheelbase: Millimeters(wheelbase),
                track: Millimeters(track),
                max_wheel_speed: RadPerSec(limit),
            })
            .unwrap()
        },
    )
}

proptest! {
    #[test]
    fn the_wheels_reproduce_the_body_velocity(
        base in any_base(), x in -3e3..3e3, y in -3e3..3e3, turn in -5.0..5.0
    ) {
        let back = base.forward(&base.inverse(&twist(x, y, turn)));
        prop_assert!((back.forward.0 - x).abs() < 1e-9 && (back.left.0 - y).abs() < 1e-9);
        prop_assert!((back.turn.0 - turn).abs() < 1e-11);
    }

    #[test]
    fn wheel_speeds_without_slip_are_reproduced(
        base in any_base(), w1 in -50.0..50.0, w2 in -50.0..50.0, w3 in -50.0..50.0
    ) {
        // Without slip w1 + w2 = w3 + w4.
        let speeds = [w1, w2, w3, w1 + w2 - w3];
        prop_assert!(base.slip(&wheels(speeds)).0.abs() < 1e-12);
        let back = base.inverse(&base.forward(&wheels(speeds)));
        for (back, speed) in plain(&back).into_iter().zip(speeds) {
            prop_assert!((back - speed).abs() < 1e-10);
        }
    }

    #[test]
    fn any_wheel_speeds_are_their_motion_and_their_slip(
        base in any_base(), speeds in prop::array::uniform4(-50.0..50.0)
    ) {
        let slip = base.slip(&wheels(speeds)).0;
        let rolling = plain(&base.inverse(&base.forward(&wheels(speeds))));
        let fighting = [slip, slip, -slip, -slip];
        for ((speed, rolls), fights) in speeds.into_iter().zip(rolling).zip(fighting) {
            prop_assert!((speed - rolls - fights).abs() < 1e-10);
        }
    }

    #[test]
    fn the_world_and_the_body_see_the_same_velocity(
        heading in -10.0..10.0, x in -3e3..3e3, y in -3e3..3e3, turn in -5.0..5.0
    ) {
        let heading = Radians(heading);
        let back = world(x, y, turn).in_body(heading).in_world(heading);
        prop_assert!((back.x.0 - x).abs() < 1e-9 && (back.y.0 - y).abs() < 1e-9);
        prop_assert!((world(x, y, 0.0).in_body(heading).speed().0 - x.hypot(y)).abs() < 1e-9);
    }

    #[test]
    fn a_scaled_twist_is_within_the_limits_and_on_the_same_path(
        base in any_base(), x in any::<f64>(), y in any::<f64>(), turn in any::<f64>()
    ) {
        let wanted = twist(x, y, turn);
        if let Ok(scaled) = base.scale_to_limits(&wanted) {
            prop_assert!(base.check(&base.inverse(&scaled.twist)).is_ok());
            prop_assert!((0.0..=1.0).contains(&scaled.factor));
            prop_assert_eq!(scaled.twist, wanted * scaled.factor);
        } else {
            prop_assert!(!base.inverse(&wanted).fastest().1.is_finite());
        }
    }
}
