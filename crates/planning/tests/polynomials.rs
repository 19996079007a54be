//! Quintic, 4-3-4 and 3-5-3: numbers by hand, boundary states, continuity, the printed system.

use nalgebra::SMatrix;
use planning::State;
use planning::trajectory::{Degrees, Quintic, ThreeSegments, TrajectoryError};

fn near(a: State, b: State, tolerance: f64) -> bool {
    (a.position - b.position).abs() < tolerance
        && (a.velocity - b.velocity).abs() < tolerance
        && (a.acceleration - b.acceleration).abs() < tolerance
}

fn state(position: f64, velocity: f64, acceleration: f64) -> State {
    State {
        position,
        velocity,
        acceleration,
    }
}

#[test]
fn a_quintic_from_rest_to_rest_is_the_well_known_one() {
    // 10 s^3 - 15 s^4 + 6 s^5: half way at half time, there the velocity is 15/8 of the mean, and
    // the largest acceleration is 10 / sqrt 3 of way / T^2.
    let quintic = Quintic::try_new(State::at_rest(0.0), State::at_rest(8.0), 3.0, 5.0).unwrap();
    assert!(near(quintic.at(4.0), state(4.0, 7.5, 0.0), 1e-12));
    let extremes = quintic.extremes();
    assert!((extremes.velocity - 7.5).abs() < 1e-12);
    assert!((extremes.acceleration - 10.0 / 3.0_f64.sqrt() * 2.0).abs() < 1e-12);
    assert!((extremes.position - 8.0).abs() < 1e-12);
}

#[test]
fn a_quintic_has_the_states_it_was_given_even_late_on_the_clock() {
    let (start, goal) = (state(1.0, -2.0, 3.0), state(-4.0, 5.0, -6.0));
    for t0 in [0.0, 1e6] {
        let quintic = Quintic::try_new(start, goal, t0, t0 + 0.5).unwrap();
        assert!(near(quintic.at(t0), start, 1e-9));
        assert!(near(quintic.at(t0 + 0.5), goal, 1e-9));
    }
}

#[test]
fn three_segments_pass_their_points_smoothly_with_any_durations() {
    let (start, goal) = (state(0.0, 0.1, -0.2), state(2.0, -0.3, 0.4));
    let times = [10.0, 10.5, 12.0, 12.8];
    for degrees in [Degrees::FourThreeFour, Degrees::ThreeFiveThree] {
        let trajectory = ThreeSegments::try_new(degrees, start, [0.3, 1.6], goal, times).unwrap();
        assert!(near(trajectory.at(10.0), start, 1e-9));
        assert!(
            near(trajectory.at(12.8), goal, 1e-9),
            "{:?}",
            trajectory.at(12.8)
        );
        for (time, position) in [(10.5, 0.3), (12.0, 1.6)] {
            let (before, after) = (trajectory.at(time - 1e-9), trajectory.at(time));
            assert!((after.position - position).abs() < 1e-9);
            assert!(near(before, after, 1e-6), "{before:?} {after:?}");
        }
    }
}

#[test]
fn through_points_of_one_cubic_4_3_4_is_that_cubic() {
    // q = t^3 - 2 t + 1 from 0 to 3, via 1 and 2: the solution is unique, and the cubic is one.
    let q = |t: f64| state(t.powi(3) - 2.0 * t + 1.0, 3.0 * t * t - 2.0, 6.0 * t);
    for degrees in [Degrees::FourThreeFour, Degrees::ThreeFiveThree] {
        let via = [q(0.5).position, q(2.0).position];
        let times = [0.0, 0.5, 2.0, 3.0];
        let trajectory = ThreeSegments::try_new(degrees, q(0.0), via, q(3.0), times).unwrap();
        for t in [0.0, 0.2, 0.7, 1.3, 2.4, 3.0] {
            assert!(near(trajectory.at(t), q(t), 1e-9), "{t}");
        }
    }
}

#[test]
fn equation_2_40_without_the_durations_breaks_the_velocity() {
    // With the derivatives in normalised time made equal, as (2.40) prints it, the velocities at
    // the via point differ by the ratio of the durations: only equal durations are smooth.
    let (start, goal) = (State::at_rest(0.0), State::at_rest(3.0));
    let printed = |durations: [f64; 3]| {
        // What is printed is the solution for three durations of 1.
        let unit = ThreeSegments::try_new(
            Degrees::FourThreeFour,
            start,
            [1.0, 2.0],
            goal,
            [0.0, 1.0, 2.0, 3.0],
        )
        .unwrap();
        let slope = unit.at(1.0).velocity;
        (slope / durations[0], slope / durations[1])
    };
    let (before, after) = printed([0.5, 1.0, 0.5]);
    assert!((before - 2.0 * after).abs() < 1e-12 && after.abs() > 0.1);
    let (before, after) = printed([0.7, 0.7, 0.7]);
    assert!((before - after).abs() < 1e-12);
}

#[test]
fn the_matrix_of_2_42_is_singular_as_printed() {
    // Columns a4 .. a0, b3 .. b0, c4 .. c0. The ninth row, "theta_2 = c0", has its 1 under b0, as
    // the fifth has; the tenth has its -1 under c4 instead of c1.
    #[rustfmt::skip]
    let printed = SMatrix::<f64, 14, 14>::from_row_slice(&[
        0.,0.,0.,0.,1.,0.,0.,0.,0.,0.,0.,0.,0.,0.,
        0.,0.,0.,1.,0.,0.,0.,0.,0.,0.,0.,0.,0.,0.,
        0.,0.,2.,0.,0.,0.,0.,0.,0.,0.,0.,0.,0.,0.,
        1.,1.,1.,1.,1.,0.,0.,0.,0.,0.,0.,0.,0.,0.,
        0.,0.,0.,0.,0.,0.,0.,0.,1.,0.,0.,0.,0.,0.,
        4.,3.,2.,1.,0.,0.,0.,-1.,0.,0.,0.,0.,0.,0.,
        12.,6.,2.,0.,0.,0.,-2.,0.,0.,0.,0.,0.,0.,0.,
        0.,0.,0.,0.,0.,1.,1.,1.,1.,0.,0.,0.,0.,0.,
        0.,0.,0.,0.,0.,0.,0.,0.,1.,0.,0.,0.,0.,0.,
        0.,0.,0.,0.,0.,3.,2.,1.,0.,-1.,0.,0.,0.,0.,
        0.,0.,0.,0.,0.,6.,2.,0.,0.,0.,0.,-2.,0.,0.,
        0.,0.,0.,0.,0.,0.,0.,0.,0.,1.,1.,1.,1.,1.,
        0.,0.,0.,0.,0.,0.,0.,0.,0.,4.,3.,2.,1.,0.,
        0.,0.,0.,0.,0.,0.,0.,0.,0.,12.,6.,2.,0.,0.,
    ]);
    assert!(printed.determinant().abs() < 1e-12);
    let mut corrected = printed;
    corrected[(8, 8)] = 0.0;
    corrected[(8, 13)] = 1.0;
    corrected[(9, 9)] = 0.0;
    corrected[(9, 12)] = -1.0;
    assert!(corrected.determinant().abs() > 1.0);
}

#[test]
fn bad_input_is_refused_by_name() {
    let (start, goal) = (State::at_rest(0.0), State::at_rest(1.0));
    let refused = Quintic::try_new(start, goal, 2.0, 2.0).unwrap_err();
    assert_eq!(
        refused.to_string(),
        "end time is 2 s, which is not after 2 s by at least 0.000001 s"
    );
    let nan = Quintic::try_new(start, State::at_rest(f64::NAN), 0.0, 1.0).unwrap_err();
    assert_eq!(
        nan.to_string(),
        "goal: the position is NaN; it must be a finite number"
    );
    let infinite = Quintic::try_new(start, goal, 0.0, f64::INFINITY).unwrap_err();
    assert!(matches!(
        infinite,
        TrajectoryError::TimeNotFinite {
            item: "end time",
            ..
        }
    ));
    let huge = Quintic::try_new(start, State::at_rest(1e9), 0.0, 1e-5).unwrap_err();
    assert!(matches!(huge, TrajectoryError::Impossible { .. }), "{huge}");
    let three = |via: [f64; 2], times: [f64; 4]| {
        ThreeSegments::try_new(Degrees::FourThreeFour, start, via, goal, times).unwrap_err()
    };
    assert_eq!(
        three([0.1, f64::INFINITY], [0.0, 1.0, 2.0, 3.0]).to_string(),
        "second via point: the position is inf; it must be a finite number"
    );
    assert_eq!(
        three([0.1, 0.9], [0.0, 1.0, 0.5, 3.0]).to_string(),
        "time of the second via point is 0.5 s, which is not after 1 s by at least 0.000001 s"
    );
}
