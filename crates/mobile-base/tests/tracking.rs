//! Following a trajectory: thesis (11) and the formula after it.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use std::time::Duration;

use mobile_base::{
    Deviation, PlanarPose, Reference, TrackingLaw, Trajectory, WorldTwist, runge_kutta,
};
use proptest::prelude::*;
use support::{assert_near, base, pose, world};
use units::{Millimeters, PerSecond, Radians};

const K: [f64; 3] = [0.8, 1.7, 2.5];

/// A figure of eight, driven while the heading swings on its own.
struct Eight;

impl Trajectory for Eight {
    fn reference(&self, time: Duration) -> Reference {
        let t = time.as_secs_f64();
        Reference {
            pose: pose(1500.0 * t.sin(), 700.0 * (2.0 * t).sin(), 0.3 * t * t),
            velocity: world(1500.0 * t.cos(), 1400.0 * (2.0 * t).cos(), 0.6 * t),
        }
    }
}

fn law() -> TrackingLaw {
    TrackingLaw::try_new(K.map(PerSecond)).unwrap()
}

fn deviation(pose: PlanarPose, time: Duration) -> [f64; 3] {
    let Deviation { x, y, heading } = Deviation::between(pose, Eight.reference(time).pose);
    [x.0, y.0, heading.0]
}

#[test]
fn the_wheels_are_those_of_the_last_formula() {
    // The matrix as printed, with r = 100 and (d + e) / 2 = 500.
    let (law, time) = (law(), Duration::from_millis(700));
    let here = pose(400.0, 300.0, 0.9);
    let reference = Eight.reference(time);
    let [dx, dy, dphi] = deviation(here, time);
    let WorldTwist { x, y, turn } = reference.velocity;
    let wanted = [x.0 - K[0] * dx, y.0 - K[1] * dy, turn.0 - K[2] * dphi];
    let (s, c) = 0.9_f64.sin_cos();
    let printed = [
        [c + s, -c + s, -500.0],
        [c - s, c + s, 500.0],
        [c - s, c + s, -500.0],
        [c + s, -c + s, 500.0],
    ]
    .map(|row| row.iter().zip(wanted).map(|(a, b)| a * b).sum::<f64>() / 100.0);
    let ours = base().inverse(&law.command(here, &reference));
    assert_near(ours.0.map(|speed| speed.0), printed, 1e-12);
}

#[test]
fn the_program_control_alone_stays_on_the_trajectory_it_begins_on() {
    let step = Duration::from_millis(5);
    let drive = |start: PlanarPose| {
        (0..400).fold(start, |at, number| {
            let now = step * number;
            let program = |_, since| Eight.reference(now + since).program_twist();
            runge_kutta(at, step, program).unwrap()
        })
    };
    let end = drive(Eight.reference(Duration::ZERO).pose);
    assert_near(deviation(end, step * 400), [0.0; 3], 1e-4);
    // Beside it, it stays beside: nothing feeds the deviation back.
    let beside = drive(pose(30.0, -40.0, 0.0));
    assert_near(deviation(beside, step * 400), [30.0, -40.0, 0.0], 1e-4);
}

#[test]
fn turning_the_velocity_with_the_heading_of_the_reference_breaks_the_decay() {
    // The text before (11) turns the wanted velocity with phi_ref. For the whole law that is wrong:
    // with a heading that is off by half a turn the base would be driven away.
    let (law, time) = (law(), Duration::ZERO);
    let reference = Eight.reference(time);
    let here = pose(100.0, 0.0, std::f64::consts::PI);
    let right = here.world_twist(law.command(here, &reference));
    assert!((right.x.0 - (1500.0 - 0.8 * 100.0)).abs() < 1e-9);
    let wanted = world(1500.0 - 80.0, 1400.0, 0.0);
    let wrong = here.world_twist(wanted.in_body(reference.pose.heading()));
    assert!((wrong.x.0 - -1420.0).abs() < 1e-9);
}

#[test]
fn impossible_rates_are_refused_by_name() {
    for (at, name) in ["k1", "k2", "k3"].into_iter().enumerate() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let mut gains = K.map(PerSecond);
            gains[at] = PerSecond(bad);
            let message = TrackingLaw::try_new(gains).unwrap_err().to_string();
            assert!(message.starts_with(name), "{message}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn each_deviation_decays_at_its_own_rate(
        x in -2e3..2e3, y in -2e3..2e3, heading in -3.1..3.1
    ) {
        let (law, step) = (law(), Duration::from_millis(5));
        let mut pose = pose(x, y, heading);
        let first = deviation(pose, Duration::ZERO);
        for number in 0..800 {
            let now = step * number;
            pose = runge_kutta(pose, step, |pose, since| {
                law.follow(pose, &Eight, now + since)
            })
            .unwrap();
            let t = (now + step).as_secs_f64();
            let left = deviation(pose, now + step);
            for ((left, first), k) in left.into_iter().zip(first).zip(K) {
                prop_assert!((left - first * (-k * t).exp()).abs() < 1e-4, "at {t} s");
            }
        }
    }

    #[test]
    fn the_law_is_exact_at_any_pose(
        x in -1e6..1e6, y in -1e6..1e6, heading in -10.0..10.0, millis in 0_u64..20_000
    ) {
        // z' - z_ref' + K (z - z_ref) = 0, (11), for the derivative that the command gives.
        let time = Duration::from_millis(millis);
        let here = PlanarPose::try_new(Millimeters(x), Millimeters(y), Radians(heading)).unwrap();
        let reference = Eight.reference(time);
        let rate = here.world_twist(law().command(here, &reference));
        let [dx, dy, dphi] = deviation(here, time);
        let wanted = reference.velocity;
        prop_assert!((rate.x.0 - wanted.x.0 + K[0] * dx).abs() < 1e-8);
        prop_assert!((rate.y.0 - wanted.y.0 + K[1] * dy).abs() < 1e-8);
        prop_assert!((rate.turn.0 - wanted.turn.0 + K[2] * dphi).abs() < 1e-9);
    }
}
