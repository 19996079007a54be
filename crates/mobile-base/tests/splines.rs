//! Splines and the speed along them.
#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests, where clippy.toml's exception does not reach"
)]

mod support;

use std::f64::consts::{FRAC_PI_2, PI};

use mobile_base::{PathHeading, PathLimits, PlannedPath, Point, Spline, SplineEnds, SplineError};
use proptest::prelude::*;
use support::{base, point};
use units::{Millimeters, MmPerSec, MmPerSec2, Radians};

/// Points of a quarter circle with the radius 1000 mm, which begins along X.
fn quarter_circle() -> Spline {
    let points: Vec<Point> = (0..=8)
        .map(|number| {
            let angle = f64::from(number) / 8.0 * FRAC_PI_2;
            point(1000.0 * angle.sin(), 1000.0 * (1.0 - angle.cos()))
        })
        .collect();
    let ends = SplineEnds::Clamped {
        start: Radians(0.0),
        end: Radians(FRAC_PI_2),
    };
    Spline::try_new(&points, ends).unwrap()
}

fn limits() -> PathLimits {
    PathLimits {
        speed: MmPerSec(800.0),
        acceleration: MmPerSec2(500.0),
        lateral_acceleration: MmPerSec2(250.0),
        min_radius: Millimeters(200.0),
    }
}

fn forward() -> PathHeading {
    PathHeading::FixedCourse {
        course: Radians(0.0),
    }
}

#[test]
fn a_spline_through_a_circle_is_nearly_the_circle() {
    let spline = quarter_circle();
    assert!((spline.length().0 - 1000.0 * FRAC_PI_2).abs() < 0.01);
    for along in 0..=157 {
        let along = f64::from(along) * 10.0;
        let at = spline.at(Millimeters(along)).unwrap();
        let angle = along / 1000.0;
        let circle = point(1000.0 * angle.sin(), 1000.0 * (1.0 - angle.cos()));
        assert!(at.point.distance_to(circle).0 < 0.02);
        assert!((at.direction.0 - angle).abs() < 1e-3);
        assert!(
            (at.radius().0 - 1000.0).abs() < 10.0,
            "{along}: {}",
            at.radius()
        );
    }
}

#[test]
fn off_the_path_there_is_no_place() {
    let spline = quarter_circle();
    let behind = spline.length() + Millimeters(1e-6);
    for along in [Millimeters(-1e-6), behind, Millimeters(f64::NAN)] {
        assert_eq!(spline.at(along), None);
    }
}

#[test]
fn two_points_make_a_straight_line() {
    let spline = Spline::try_new(&[point(0.0, 0.0), point(300.0, 400.0)], SplineEnds::Natural);
    let spline = spline.unwrap();
    assert!((spline.length().0 - 500.0).abs() < 1e-9);
    let middle = spline.at(Millimeters(250.0)).unwrap();
    assert!(middle.point.distance_to(point(150.0, 200.0)).0 < 1e-9);
    assert!(middle.curvature.0.abs() < 1e-12);
}

#[test]
fn points_that_make_no_spline_are_refused() {
    let refused = |points: &[Point], ends| Spline::try_new(points, ends).unwrap_err();
    let one = refused(&[point(0.0, 0.0)], SplineEnds::Natural);
    assert_eq!(
        one.to_string(),
        "the spline has 1 points; it must have from 2 to 10000"
    );
    let twice = [point(0.0, 0.0), point(9.0, 0.0), point(9.0, 0.5)];
    assert_eq!(
        refused(&twice, SplineEnds::Natural).to_string(),
        "point 2 of the spline is 0.5 mm from the one before; it must be at least 1 mm"
    );
    let nowhere = SplineEnds::Clamped {
        start: Radians(0.0),
        end: Radians(f64::NAN),
    };
    let error = refused(&[point(0.0, 0.0), point(9.0, 0.0)], nowhere);
    assert!(matches!(error, SplineError::Direction { end: "end", .. }));
    // There and back on a line: the spline stops dead at the turning point.
    let back = [point(0.0, 0.0), point(100.0, 0.0), point(0.0, 0.0)];
    let error = refused(&back, SplineEnds::Natural);
    assert!(matches!(error, SplineError::Cusp { .. }), "{error}");
}

#[test]
fn the_bend_sets_the_speed() {
    // Lateral 250 mm/s^2 on a radius of 1000 mm: root of 250,000, 500 mm/s. Braking from there with
    // 500 mm/s^2 takes 250 mm: 100 mm before the end root(2 * 500 * 100) = 316 mm/s.
    let plan = PlannedPath::try_new(quarter_circle(), forward(), &limits(), &base()).unwrap();
    let length = plan.spline().length().0;
    let at = |along| plan.speed_at(Millimeters(along)).unwrap().0;
    assert!((at(700.0) - 500.0).abs() < 2.0);
    assert!((at(length - 100.0) - 316.2).abs() < 0.5);
    assert!(at(length).abs() < f64::EPSILON);
    assert_eq!(plan.speed_at(Millimeters(length + 1.0)), None);
}

#[test]
fn the_wheels_set_the_speed_where_they_are_the_limit() {
    // 20 rad/s on 100 mm wheels is 2000 mm/s ahead, and half of it at 45 degrees, where two wheels do
    // all the work: each rim moves with cos 45 + sin 45 times the speed.
    let mut fast = limits();
    fast.speed = MmPerSec(5000.0);
    fast.acceleration = MmPerSec2(1e6);
    let line =
        || Spline::try_new(&[point(0.0, 0.0), point(9000.0, 0.0)], SplineEnds::Natural).unwrap();
    let middle = |course| {
        let heading = PathHeading::FixedCourse {
            course: Radians(course),
        };
        let plan = PlannedPath::try_new(line(), heading, &fast, &base()).unwrap();
        plan.speed_at(Millimeters(4500.0)).unwrap().0
    };
    assert!((middle(0.0) - 2000.0).abs() < 1e-6);
    assert!((middle(PI / 4.0) - 2000.0 / 2.0_f64.sqrt()).abs() < 1e-6);
}

#[test]
fn bends_that_are_too_tight_are_refused_with_place_and_radius() {
    let mut wide = limits();
    wide.min_radius = Millimeters(1500.0);
    let error = PlannedPath::try_new(quarter_circle(), forward(), &wide, &base()).unwrap_err();
    let message = error.to_string();
    assert!(
        message.contains("along the path the radius is"),
        "{message}"
    );
    assert!(
        message.ends_with("it must be at least 1500 mm"),
        "{message}"
    );
}

proptest! {
    #[test]
    fn position_direction_and_curvature_have_no_jumps(
        steps in prop::collection::vec((300.0..1500.0, -1.0..1.0_f64), 2..8)
    ) {
        let (mut x, mut y, mut direction) = (0.0, 0.0, 0.0_f64);
        let mut points = vec![point(x, y)];
        for (length, turn) in steps {
            direction += turn;
            (x, y) = (x + length * direction.cos(), y + length * direction.sin());
            points.push(point(x, y));
        }
        let spline = Spline::try_new(&points, SplineEnds::Natural).unwrap();
        let step = 0.5;
        let mut along = 0.0;
        let mut last = spline.at(Millimeters(0.0)).unwrap();
        prop_assert!(last.point.distance_to(points[0]).0 < 1e-9);
        while along + step < spline.length().0 {
            along += step;
            let here = spline.at(Millimeters(along)).unwrap();
            // Chords are as long as the way, to second order in the curvature.
            let chord = here.point.distance_to(last.point).0;
            prop_assert!((chord - step).abs() < 1e-4, "{along}: {chord}");
            let turned = (here.direction.0 - last.direction.0).sin();
            let mean = 0.5 * (here.curvature.0 + last.curvature.0);
            prop_assert!((turned - mean * step).abs() < 1e-4, "{along}");
            prop_assert!((here.curvature.0 - last.curvature.0).abs() < 2e-3, "{along}");
            last = here;
        }
        let end = spline.at(spline.length()).unwrap();
        prop_assert!(end.point.distance_to(*points.last().unwrap()).0 < 1e-6);
    }

    #[test]
    fn the_planned_speed_never_needs_more_than_the_limits(
        bends in prop::collection::vec(-600.0..600.0, 2..6)
    ) {
        let points: Vec<Point> = bends
            .iter()
            .zip(1..)
            .map(|(y, number)| point(f64::from(number) * 1500.0, *y))
            .collect();
        let mut all = vec![point(0.0, 0.0)];
        all.extend(points);
        let spline = Spline::try_new(&all, SplineEnds::Natural).unwrap();
        let Ok(plan) = PlannedPath::try_new(spline, forward(), &limits(), &base()) else {
            return Ok(());
        };
        let length = plan.spline().length().0;
        let mut along = 0.0;
        while along + 1.0 < length {
            let here = plan.speed_at(Millimeters(along)).unwrap().0;
            let next = plan.speed_at(Millimeters(along + 1.0)).unwrap().0;
            // Braking: v^2 falls by 2 a s at most.
            prop_assert!(here * here - next * next <= 2.0 * 500.0 * 1.0 + 1e-6);
            prop_assert!(here <= 800.0 + 1e-9);
            along += 1.0;
        }
    }
}
