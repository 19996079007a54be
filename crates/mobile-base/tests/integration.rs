//! Steps through time, and dead reckoning.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use std::f64::consts::TAU;
use std::time::Duration;

use mobile_base::{NoisyEncoders, Odometry, PlanarPose, WheelAngles, runge_kutta};
use proptest::prelude::*;
use support::{assert_near, base, pose, twist};
use units::Radians;

/// Where a base is after 2.048 seconds (whole nanoseconds a step) that accelerates and turns, in `steps` steps.
fn drive(
    steps: u32,
    advance: impl Fn(PlanarPose, Duration, &dyn Fn(Duration) -> mobile_base::BodyTwist) -> PlanarPose,
) -> PlanarPose {
    let step = Duration::from_millis(2048) / steps;
    let mut at = pose(0.0, 0.0, 0.0);
    for number in 0..steps {
        let now = step * number;
        at = advance(at, step, &|since| {
            let t = (now + since).as_secs_f64();
            twist(800.0 * t.cos(), 300.0 * t, 1.5 * (2.0 * t).sin())
        });
    }
    at
}

fn error(found: PlanarPose) -> f64 {
    let exact = drive(2048, |at, h, law| {
        runge_kutta(at, h, |_, since| law(since)).unwrap()
    });
    found.position().distance_to(exact.position()).0
}

#[test]
fn runge_kutta_is_of_order_four() {
    let errors = [16, 32, 64].map(|steps| {
        error(drive(steps, |at, h, law| {
            runge_kutta(at, h, |_, since| law(since)).unwrap()
        }))
    });
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((3.8..4.3).contains(&order), "{errors:?}: order {order}");
    }
}

#[test]
fn a_law_that_is_sampled_once_a_step_is_of_order_one() {
    let errors = [64, 128, 256].map(|steps| {
        error(drive(steps, |at, h, law| {
            at.advanced(&law(Duration::ZERO), h).unwrap()
        }))
    });
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((0.9..1.1).contains(&order), "{errors:?}: order {order}");
    }
}

#[test]
fn odometry_without_noise_follows_the_base_exactly() {
    let base = base();
    let mut truth = pose(100.0, -50.0, 1.0);
    let mut odometry = Odometry::new(base, truth);
    let step = Duration::from_millis(10);
    for number in 0..1000 {
        let t = f64::from(number) * 0.01;
        let wanted = twist(500.0 * t.sin(), 200.0, 0.8 * t.cos());
        truth = truth.advanced(&wanted, step).unwrap();
        let _ = odometry.add(&base.inverse(&wanted).over(step)).unwrap();
    }
    assert!(odometry.pose().position().distance_to(truth.position()).0 < 1e-8);
    assert!(odometry.pose().heading_error_to(truth).0.abs() < 1e-11);
}

#[test]
fn a_wheel_that_is_believed_too_large_makes_a_way_too_long() {
    // One percent of radius is one percent of way: 1000 mm are taken for 1010.
    let mut believed = *base().dimensions();
    believed.wheel_radius = believed.wheel_radius * 1.01;
    let believed = mobile_base::MecanumBase::try_new(&believed).unwrap();
    let mut odometry = Odometry::new(believed, PlanarPose::default());
    let second = Duration::from_secs(1);
    let at = odometry.add(&base().inverse(&twist(1000.0, 0.0, 0.0)).over(second));
    assert!((at.unwrap().position().x().0 - 1010.0).abs() < 1e-9);
}

/// What encoders with noise make of 4000 readings of half a radian each.
fn reckon(seed: u64) -> PlanarPose {
    let mut encoders = NoisyEncoders::try_new(Radians(0.01), seed).unwrap();
    let mut odometry = Odometry::new(base(), PlanarPose::default());
    for _ in 0..4000 {
        let read = encoders.read(&WheelAngles([Radians(0.5); 4]));
        let _ = odometry.add(&read).unwrap();
    }
    odometry.pose()
}

#[test]
fn the_same_seed_gives_the_same_errors() {
    assert_eq!(reckon(7), reckon(7));
    assert_ne!(reckon(7), reckon(8));
    assert_ne!(reckon(0), reckon(1));
}

#[test]
fn the_noise_grows_with_the_root_of_the_way() {
    // 2000 rad a wheel with 0.01 rad a root radian: 0.447 rad a wheel. The heading is r / 4 / 500 of
    // their sum of four, root 4 * 0.447 * 0.05 = 0.0447 rad.
    let headings: Vec<f64> = (0..400).map(|seed| reckon(seed).heading().0).collect();
    let square: f64 = headings.iter().map(|heading| heading * heading).sum();
    let mean: f64 = headings.iter().sum::<f64>() / 400.0;
    let deviation = (square / 400.0).sqrt();
    assert!((deviation - 0.0447).abs() < 0.005, "{deviation}");
    assert!(mean.abs() < 0.01, "{mean}");
}

#[test]
fn wheels_that_stand_are_read_without_error() {
    let mut encoders = NoisyEncoders::try_new(Radians(0.5), 1).unwrap();
    let standing = WheelAngles::default();
    assert_eq!(encoders.read(&standing), standing);
    assert_eq!(
        NoisyEncoders::try_new(Radians(-0.1), 1)
            .unwrap_err()
            .to_string(),
        "noise of the encoders is -5.729577951308233\u{b0}; it must be from 0\u{b0} to \
         57.29577951308232\u{b0}"
    );
}

proptest! {
    #[test]
    fn an_arc_is_the_sum_of_its_parts(
        x in -2e3..2e3, y in -2e3..2e3, turn in -8.0..8.0, share in 0.0..1.0
    ) {
        let motion = twist(x, y, turn);
        let second = Duration::from_secs(1);
        let part = second.mul_f64(share);
        let start = pose(10.0, 20.0, 0.3);
        let whole = start.advanced(&motion, second).unwrap();
        let parts = start.advanced(&motion, part).unwrap();
        let parts = parts.advanced(&motion, second.checked_sub(part).unwrap()).unwrap();
        prop_assert!(whole.position().distance_to(parts.position()).0 < 1e-6);
        prop_assert!(whole.heading_error_to(parts).0.abs() < 1e-9);
    }

    #[test]
    fn an_arc_is_what_small_steps_converge_to(
        x in -2e3..2e3, y in -2e3..2e3, turn in -3.0..3.0
    ) {
        let motion = twist(x, y, turn);
        let exact = pose(0.0, 0.0, 0.5).advanced(&motion, Duration::from_secs(1)).unwrap();
        let mut small = pose(0.0, 0.0, 0.5);
        for _ in 0..200 {
            small = runge_kutta(small, Duration::from_millis(5), |_, _| motion).unwrap();
        }
        prop_assert!(small.position().distance_to(exact.position()).0 < 1e-5);
    }

    #[test]
    fn no_twist_and_no_time_makes_a_pose_that_is_not_a_number(
        a in prop::array::uniform3(any::<f64>()), nanos in any::<u64>()
    ) {
        let time = Duration::from_nanos(nanos);
        let motion = twist(a[0], a[1], a[2]);
        let arc = pose(1.0, 2.0, 3.0).advanced(&motion, time);
        let stepped = runge_kutta(pose(1.0, 2.0, 3.0), time, |_, _| motion);
        for moved in [arc, stepped].into_iter().flatten() {
            let (at, heading) = (moved.position(), moved.heading());
            prop_assert!(at.x().is_finite() && at.y().is_finite());
            prop_assert!(heading.0.abs() <= TAU / 2.0 + 1e-9);
        }
    }
}

#[test]
fn half_a_turn_and_back_is_no_turn() {
    let there = pose(0.0, 0.0, 0.0).advanced(&twist(10.0, 0.0, 2.0), Duration::from_secs(3));
    let back = there
        .unwrap()
        .advanced(&twist(-10.0, 0.0, -2.0), Duration::from_secs(3));
    let at = back.unwrap();
    assert_near([at.position().x().0, at.heading().0], [0.0, 0.0], 1e-12);
}
