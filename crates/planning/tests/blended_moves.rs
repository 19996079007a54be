//! Via-point blending: numbers by hand, continuity, limits, and bad input.

use planning::blend::{BlendError, BlendedMove};
use planning::jerk::MotionLimits;

const LIMITS: MotionLimits = MotionLimits {
    velocity: 1.0,
    acceleration: 3.0,
    jerk: 100.0,
};
const RANGE: (f64, f64) = (-5.0, 5.0);

#[test]
fn one_straight_piece_by_hand() {
    // 3 at the speed 1: 3 s from middle to middle of the blends, each 2h = 1.5 / 3 = 0.5 s (the jerk
    // alone would allow sqrt(6 / 100) = 0.245 s).
    let plan = BlendedMove::try_new(&[[0.0], [3.0]], &[RANGE], &[LIMITS]).unwrap();
    assert!((plan.duration() - 3.5).abs() < 1e-12);
    // In the middle of the first blend: 3/32 of 2h times the velocity.
    let [state] = plan.at(0.25);
    assert!((state.position - 3.0 / 64.0).abs() < 1e-12);
    assert!((state.velocity - 0.5).abs() < 1e-12 && (state.acceleration - 3.0).abs() < 1e-9);
}

#[test]
fn corners_are_rounded_smoothly_and_within_the_limits() {
    let points = [[0.0, 0.0], [2.0, 0.1], [2.0, 2.0], [1.9, 2.0], [-3.0, -1.0]];
    let limits = [
        LIMITS,
        MotionLimits {
            velocity: 0.5,
            acceleration: 1.0,
            jerk: 5.0,
        },
    ];
    let plan = BlendedMove::try_new(&points, &[RANGE; 2], &limits).unwrap();
    for (end, point) in [(0.0, points[0]), (plan.duration(), points[4])] {
        for (state, position) in plan.at(end).iter().zip(point) {
            assert!((state.position - position).abs() < 1e-9 && state.velocity.abs() < 1e-9);
        }
    }
    for ((time, deviation), point) in plan.times().iter().zip(plan.deviations()).zip(points) {
        for joint in 0..2 {
            let apart = (plan.at(*time)[joint].position - point[joint]).abs();
            assert!((apart - deviation[joint]).abs() < 1e-9);
        }
    }
    let steps = 20_000;
    let dt = plan.duration() / f64::from(steps);
    let mut before = plan.at(0.0);
    for step in 1..=steps {
        let now = plan.at(dt * f64::from(step));
        for joint in 0..2 {
            let (a, b, limit) = (before[joint], now[joint], limits[joint]);
            assert!(b.velocity.abs() <= limit.velocity + 1e-9);
            assert!(b.acceleration.abs() <= limit.acceleration + 1e-9);
            assert!((b.acceleration - a.acceleration).abs() <= 1.001 * limit.jerk * dt + 1e-9);
            let way = b.position - a.position - 0.5 * dt * (a.velocity + b.velocity);
            assert!(way.abs() < 1e-9, "{way}");
        }
        before = now;
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    let refused =
        |points: &[[f64; 2]]| BlendedMove::try_new(points, &[RANGE; 2], &[LIMITS; 2]).unwrap_err();
    assert_eq!(refused(&[[0.0; 2]]), BlendError::Points { count: 1 });
    assert_eq!(
        refused(&[[0.0; 2], [1.0, 7.0], [0.0; 2]]).to_string(),
        "point 2, joint 2 is at 7; it can be from -5 to 5"
    );
    assert_eq!(
        refused(&[[0.0; 2], [f64::NAN, 0.0]]).to_string(),
        "point 2, joint 1: the position is NaN; it must be a finite number"
    );
    assert_eq!(
        refused(&[[1.0; 2], [1.0; 2]]).to_string(),
        "points 1 and 2 are the same"
    );
    let stuck = MotionLimits {
        velocity: 0.0,
        ..LIMITS
    };
    let refused = BlendedMove::try_new(&[[0.0], [1.0]], &[RANGE], &[stuck]).unwrap_err();
    assert_eq!(
        refused,
        BlendError::Limit {
            joint: 1,
            value: 0.0
        }
    );
    let refused = BlendedMove::try_new(&[[0.0], [1.0]], &[(5.0, -5.0)], &[LIMITS]).unwrap_err();
    assert!(matches!(refused, BlendError::Range { joint: 1, .. }));
}
