//! The laws that drive to a point: thesis (4) to (10), against their closed solutions.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use std::f64::consts::{FRAC_PI_2, PI};
use std::time::Duration;

use mobile_base::{
    Approach, HeadingReference, PlanarPose, PointGains, PointLaw, Polar, runge_kutta,
};
use proptest::prelude::*;
use support::{assert_near, numbers, point, pose};
use units::{Millimeters, MmPerSec, PerMillimeter, PerSecond, RadPerSec, Radians};

const SPEED: f64 = 500.0;
const TURN: f64 = 1.5;
const TANH: Approach = Approach::Tanh {
    scale: Millimeters(250.0),
};
const EXPONENTIAL: Approach = Approach::Exponential {
    k: PerMillimeter(0.01),
};
const STEP: Duration = Duration::from_millis(5);

fn law(approach: Approach) -> PointLaw {
    PointLaw::try_new(&PointGains {
        speed: MmPerSec(SPEED),
        turn: PerSecond(TURN),
        approach,
    })
    .unwrap()
}

/// The poses of a base under `drive`, from `start`, one a step.
fn run(
    start: PlanarPose,
    steps: u32,
    drive: impl Fn(PlanarPose, Duration) -> mobile_base::BodyTwist,
) -> Vec<(f64, PlanarPose)> {
    let mut pose = start;
    let mut poses = vec![(0.0, pose)];
    for step in 0..steps {
        let now = STEP * step;
        pose = runge_kutta(pose, STEP, |pose, since| drive(pose, now + since)).unwrap();
        poses.push(((now + STEP).as_secs_f64(), pose));
    }
    poses
}

#[test]
fn the_first_line_of_6_has_a_squared_cosine() {
    // (5) in (4): rho' = -v cos(a) = -k_v f cos^2(a). At a = pi/3 this is -500 / 4; cos(2 a), as
    // printed, is -1/2 and would drive the base away.
    let polar = Polar::try_new(Millimeters(1e6), Radians(PI / 3.0), Radians(0.2)).unwrap();
    let law = law(Approach::Sign);
    let rates = polar.rates(&law.polar(&polar));
    assert!((rates.rho.0 - -125.0).abs() < 1e-9);
    // The other two lines hold as printed.
    assert!((rates.alpha.0 - -TURN * PI / 3.0).abs() < 1e-12);
    let around = -SPEED * (2.0 * PI / 3.0).sin() / (2.0 * 1e6);
    assert!((rates.theta.0 - around).abs() < 1e-15);
}

#[test]
fn a_base_that_looks_at_its_target_drives_straight_at_it() {
    // f = tanh(250 / 250) = 0.761594; straight to the left of the base, with the course to the left.
    let command =
        law(TANH).fixed_course(pose(0.0, 0.0, 0.0), point(0.0, 250.0), Radians(FRAC_PI_2));
    let f = 0.761_594_155_955_765;
    assert_near(numbers(&command), [0.0, SPEED * f, 0.0], 1e-9);
}

#[test]
fn in_mode_2_the_velocity_points_at_the_target_whatever_the_heading() {
    let heading = HeadingReference {
        angle: Radians(0.3),
        rate: RadPerSec(0.2),
    };
    let here = pose(100.0, 100.0, 0.3);
    let command = law(Approach::Sign).free_heading(here, point(400.0, 500.0), &heading);
    // The way is (300, 400) of 500: the velocity in the world is (300, 400) too.
    let seen = here.world_twist(command);
    assert_near([seen.x.0, seen.y.0, seen.turn.0], [300.0, 400.0, 0.2], 1e-9);
}

#[test]
fn turning_10_with_beta_misses_the_target_while_the_heading_is_not_beta() {
    // As printed, with beta for phi: here beta = 0 and phi = pi/2, the target is along X, and the
    // base would drive along Y. With phi it drives along X.
    let here = pose(0.0, 0.0, FRAC_PI_2);
    let target = point(1000.0, 0.0);
    let printed = here.world_twist(support::twist(SPEED, 0.0, 0.0));
    assert_near([printed.x.0, printed.y.0], [0.0, SPEED], 1e-9);
    let ours = law(Approach::Sign).free_heading(here, target, &HeadingReference::default());
    let ours = here.world_twist(ours);
    assert_near([ours.x.0, ours.y.0], [SPEED, 0.0], 1e-9);
    // And the heading goes to beta at the rate of the law.
    assert!((ours.turn.0 - -TURN * FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn at_the_target_every_law_commands_rest() {
    let here = pose(10.0, -20.0, 0.7);
    for approach in [Approach::Sign, EXPONENTIAL, TANH] {
        let command = law(approach).fixed_course(here, here.position(), Radians(0.4));
        assert_near(numbers(&command), [0.0; 3], 0.0);
        let heading = HeadingReference {
            angle: Radians(0.7),
            rate: RadPerSec(0.0),
        };
        let command = law(approach).free_heading(here, here.position(), &heading);
        assert_near(numbers(&command), [0.0; 3], 0.0);
    }
}

#[test]
fn with_the_sign_the_turn_of_5_grows_without_bound_near_the_target() {
    let turn = |approach, rho| {
        let polar = Polar::try_new(Millimeters(rho), Radians(0.5), Radians(0.0)).unwrap();
        law(approach).polar(&polar).turn.0
    };
    // k_v sin(2 * 0.5) / 2 = 210.4 mm/s over a millimeter, over a tenth, ..
    assert!((turn(Approach::Sign, 1.0) - (-0.75 - 210.367_746_2)).abs() < 1e-6);
    assert!(turn(Approach::Sign, 1e-3) < -2e5);
    // The others stay below k_phi alpha + k_v f'(0) sin(2 alpha) / 2.
    assert!(turn(TANH, 1e-3).abs() < 0.75 + 210.4 / 250.0);
    assert!(turn(EXPONENTIAL, 1e-3).abs() < 0.75 + 210.4 * 0.005);
}

#[test]
fn impossible_gains_are_refused_by_name() {
    let refused = |speed, turn, approach| {
        let gains = PointGains {
            speed: MmPerSec(speed),
            turn: PerSecond(turn),
            approach,
        };
        PointLaw::try_new(&gains).unwrap_err().to_string()
    };
    let message = refused(0.0, 1.0, TANH);
    assert_eq!(
        message,
        "speed of the law is 0 mm/s; it must be from 0.001 mm/s to 100000 mm/s"
    );
    assert!(refused(1.0, f64::NAN, TANH).starts_with("turn rate of the law is NaN /s"));
    let flat = Approach::Tanh {
        scale: Millimeters(0.0),
    };
    assert!(refused(1.0, 1.0, flat).starts_with("scale of the approach is 0 mm"));
    let steep = Approach::Exponential {
        k: PerMillimeter(f64::INFINITY),
    };
    assert!(refused(1.0, 1.0, steep).starts_with("k of the approach is inf /mm"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn alpha_decays_at_k_phi_in_mode_1(
        x in -5e3..5e3, y in -5e3..5e3, heading in -PI..PI, course in -PI..PI
    ) {
        let (start, target) = (pose(x, y, heading), point(0.0, 0.0));
        prop_assume!(start.position().distance_to(target).0 > 300.0);
        let alpha = |pose| Polar::of(pose, target, Radians(course)).alpha().0;
        prop_assume!(alpha(start).abs() < 3.1);
        for approach in [TANH, EXPONENTIAL] {
            let law = law(approach);
            let poses = run(start, 600, |pose, _| law.fixed_course(pose, target, Radians(course)));
            for (time, pose) in poses {
                let promised = alpha(start) * (-TURN * time).exp();
                prop_assert!((alpha(pose) - promised).abs() < 1e-5, "at {time} s");
            }
        }
    }

    #[test]
    fn the_distance_falls_in_mode_1_as_6_says(
        distance in 300.0..5e3_f64, direction in -PI..PI, alpha in -3.0..3.0_f64
    ) {
        // With f = tanh(rho / s): sinh(rho / s) = sinh(rho0 / s) e^(-C), where C is the integral of
        // k_v / s cos^2(alpha0 e^(-k_phi t)); by Simpson's rule.
        let target = point(distance * direction.cos(), distance * direction.sin());
        let start = pose(0.0, 0.0, direction + alpha);
        let law = law(TANH);
        let poses = run(start, 600, |pose, _| law.fixed_course(pose, target, Radians(0.0)));
        let density = |time: f64| {
            let angle: f64 = alpha * (-TURN * time).exp();
            let cos = angle.cos();
            SPEED / 250.0 * cos * cos
        };
        let h = STEP.as_secs_f64();
        let mut integral = 0.0;
        for pair in poses.windows(2) {
            let (time, pose) = pair[1];
            let middle = density(time - 0.5 * h);
            integral += h / 6.0 * (density(time - h) + 4.0 * middle + density(time));
            let promised = ((distance / 250.0).sinh() * (-integral).exp()).asinh() * 250.0;
            let rho = pose.position().distance_to(target).0;
            prop_assert!((rho - promised).abs() < 1e-3, "at {time} s: {rho} and {promised}");
        }
    }

    #[test]
    fn the_distance_falls_in_mode_2_as_9_says_on_a_straight_line(
        x in -5e3..5e3, y in -5e3..5e3, heading in -PI..PI, rate in -2.0..2.0
    ) {
        let (start, target) = (pose(x, y, heading), point(0.0, 0.0));
        let rho0 = start.position().distance_to(target).0;
        prop_assume!(rho0 > 1.0);
        let beta = |time: Duration| HeadingReference {
            angle: Radians(heading + rate * time.as_secs_f64()),
            rate: RadPerSec(rate),
        };
        // tanh(k rho / 2) with k = 0.01: the same as a scale of 200 mm.
        for (approach, scale) in [(TANH, 250.0), (EXPONENTIAL, 200.0)] {
            let law = law(approach);
            let poses = run(start, 600, |pose, now| law.free_heading(pose, target, &beta(now)));
            for (time, pose) in poses {
                let sinh = (rho0 / scale).sinh() * (-SPEED / scale * time).exp();
                let (rho, promised) = (pose.position().distance_to(target).0, sinh.asinh() * scale);
                prop_assert!((rho - promised).abs() < 1e-3, "at {time} s: {rho}, {promised}");
                // theta = const: the base stays on the line.
                let (px, py) = (pose.position().x().0, pose.position().y().0);
                prop_assert!((px * y - py * x).abs() / rho0 < 1e-5);
            }
        }
        // sign(rho): evenly, up to the target.
        let law = law(Approach::Sign);
        let steps = 1000.0 * rho0 / SPEED / 5.0;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 3000")]
        let poses = run(start, steps as u32, |pose, now| law.free_heading(pose, target, &beta(now)));
        for (time, pose) in poses {
            let rho = pose.position().distance_to(target).0;
            prop_assert!((rho - (rho0 - SPEED * time)).abs() < 1e-3);
        }
    }

    #[test]
    fn the_heading_of_mode_2_comes_back_at_k_phi(offset in -3.0..3.0_f64, rate in -2.0..2.0_f64) {
        let law = law(TANH);
        let beta = |time: f64| 0.4 + rate * time;
        let poses = run(pose(900.0, 0.0, 0.4 + offset), 400, |pose, now| {
            let heading = HeadingReference {
                angle: Radians(beta(now.as_secs_f64())),
                rate: RadPerSec(rate),
            };
            law.free_heading(pose, point(0.0, 0.0), &heading)
        });
        for (time, at) in poses {
            let error = pose(0.0, 0.0, beta(time)).heading_error_to(at).0;
            prop_assert!((error - offset * (-TURN * time).exp()).abs() < 1e-7);
        }
    }

    #[test]
    fn the_polar_rates_of_4_are_those_of_the_motion(
        x in -5e3..5e3, y in -5e3..5e3, heading in -3.0..3.0, course in -3.0..3.0
    ) {
        let target = point(0.0, 0.0);
        let here = pose(x, y, heading);
        let polar = Polar::of(here, target, Radians(course));
        prop_assume!(polar.rho().0 > 100.0 && polar.alpha().0.abs() < 3.1);
        prop_assume!(polar.theta().0.abs() < 3.1);
        let law = law(TANH);
        let rates = polar.rates(&law.polar(&polar));
        let command = law.fixed_course(here, target, Radians(course));
        let h = Duration::from_micros(100);
        let next = Polar::of(here.advanced(&command, h).unwrap(), target, Radians(course));
        let rate = |before: f64, after: f64| (after - before) / 1e-4;
        prop_assert!((rate(polar.rho().0, next.rho().0) - rates.rho.0).abs() < 1.0);
        prop_assert!((rate(polar.alpha().0, next.alpha().0) - rates.alpha.0).abs() < 0.01);
        prop_assert!((rate(polar.theta().0, next.theta().0) - rates.theta.0).abs() < 0.01);
    }

    #[test]
    fn commands_are_numbers_wherever_the_base_and_the_target_are(
        a in prop::array::uniform5(-1e7..1e7_f64), heading in -1e6..1e6, tiny in 0.0..1e-5
    ) {
        let here = pose(a[0], a[1], heading);
        let near = point(a[0] - tiny * a[0].signum(), a[1]);
        for approach in [Approach::Sign, EXPONENTIAL, TANH] {
            for target in [point(a[2], a[3]), near] {
                let law = law(approach);
                let first = law.fixed_course(here, target, Radians(a[4]));
                let second = law.free_heading(here, target, &HeadingReference {
                    angle: Radians(a[4]),
                    rate: RadPerSec(0.1),
                });
                for number in numbers(&first).into_iter().chain(numbers(&second)) {
                    prop_assert!(number.is_finite());
                }
            }
        }
    }
}
