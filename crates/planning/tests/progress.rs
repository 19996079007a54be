//! The progress along a way and changes of speed: by hand, against the move of one joint, and within limits.
#![allow(
    clippy::unwrap_used,
    reason = "the helpers of tests, too, may fail loudly"
)]

use planning::State;
use planning::jerk::{JointMove, MotionLimits, Progress, SpeedChange};
use rand_pcg::Pcg64Mcg;
use rand_pcg::rand_core::{Rng, SeedableRng};

const ONES: MotionLimits = MotionLimits {
    velocity: 1.0,
    acceleration: 1.0,
    jerk: 1.0,
};

struct Draw(Pcg64Mcg);

impl Draw {
    fn new(seed: u64) -> Draw {
        Draw(Pcg64Mcg::seed_from_u64(seed))
    }

    /// Evenly between two numbers.
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.0.next_u32()) / f64::from(u32::MAX)
    }

    /// Evenly in the exponent.
    fn power(&mut self, low: f64, high: f64) -> f64 {
        10.0_f64.powf(self.between(low, high))
    }

    fn limits(&mut self) -> MotionLimits {
        MotionLimits {
            velocity: self.power(-3.0, 3.0),
            acceleration: self.power(-2.0, 4.0),
            jerk: self.power(-1.0, 5.0),
        }
    }
}

#[test]
fn a_progress_by_hand() {
    // 6 / 1 and 1 s each for the acceleration and for the jerk: accelerating takes 2 s, over 1.
    let long = Progress::try_new(6.0, ONES).unwrap();
    assert!((long.duration() - 8.0).abs() < 1e-12 && (long.ramp() - 2.0).abs() < 1e-12);
    assert!((long.at(2.0).position - 1.0).abs() < 1e-12 && (long.peak() - 1.0).abs() < 1e-12);
    assert!((long.reaches(1.0) - 2.0).abs() < 1e-9 && (long.reaches(3.0) - 4.0).abs() < 1e-9);
    // 1/6 in the first second, and the same before the end.
    assert!((long.reaches(1.0 / 6.0) - 1.0).abs() < 1e-9);
    assert!((long.reaches(6.0 - 1.0 / 6.0) - 7.0).abs() < 1e-9);
    assert!(
        (long.braking(4.0).0 - 2.0).abs() < 1e-12,
        "from the speed 1"
    );
    // Jerk alone: 32 way / j = t^3, so 2 s over 1/4, with the speed 1/4 in the middle.
    let short = Progress::try_new(0.25, ONES).unwrap();
    assert!((short.duration() - 2.0).abs() < 1e-12 && (short.peak() - 0.25).abs() < 1e-12);
    assert!((short.braking(1.0).0 - 1.0).abs() < 1e-12);
    assert!((short.ramp() - 1.0).abs() < 1e-12, "half of it");
}

#[test]
fn a_progress_is_the_move_of_one_joint_and_its_times_are_found_again() {
    let mut draw = Draw::new(1);
    for _ in 0..2000 {
        let (way, limits) = (draw.power(-9.0, 4.0), draw.limits());
        let progress = Progress::try_new(way, limits).unwrap();
        let start = [State::at_rest(0.0)];
        let joint = JointMove::try_new(&start, &[State::at_rest(way)], &[limits]).unwrap();
        let duration = progress.duration();
        assert!((duration - joint.duration()).abs() <= 1e-12 * duration);
        let mut before = 0.0;
        for step in 0..=40 {
            let t = duration * f64::from(step) / 40.0;
            let (state, [other]) = (progress.at(t), joint.at(t));
            assert!((state.position - other.position).abs() <= 1e-9 * way);
            assert!(state.velocity <= limits.velocity * (1.0 + 1e-9));
            assert!(state.acceleration.abs() <= limits.acceleration * (1.0 + 1e-9));
            assert!(state.position >= before - 1e-12 * way);
            let again = progress.at(progress.reaches(state.position)).position;
            assert!(
                (again - state.position).abs() <= 1e-9 * way,
                "{way} {limits:?}"
            );
            before = state.position;
        }
        let last = progress.at(duration);
        assert!(last.position.to_bits() == way.to_bits() && last.velocity == 0.0);
    }
}

#[test]
fn a_time_that_is_given_is_taken_within_the_limits() {
    let mut draw = Draw::new(2);
    for _ in 0..500 {
        let (way, limits) = (draw.power(-3.0, 4.0), draw.limits());
        let progress = Progress::try_new(way, limits).unwrap();
        let seconds = progress.duration() * draw.between(1.0, 9.0);
        for plan in [
            progress.lasting(seconds).unwrap(),
            progress.stretched(seconds / progress.duration()).unwrap(),
        ] {
            assert!((plan.duration() - seconds).abs() < 1e-9 * seconds);
            let near_end = plan.at(seconds * (1.0 - 1e-7)).position;
            assert!((near_end - way).abs() < 1e-3 * way, "{near_end} of {way}");
            for step in 1..40 {
                let state = plan.at(seconds * f64::from(step) / 40.0);
                assert!(state.velocity <= limits.velocity * (1.0 + 1e-9));
                assert!(state.acceleration.abs() <= limits.acceleration * (1.0 + 1e-9));
            }
        }
        let shortest = progress.lasting(progress.duration() * 0.99).unwrap_err();
        assert!((shortest - progress.duration()).abs() < 1e-9 * shortest);
        let half = progress.slower(0.5).unwrap();
        assert!((half.peak() - 0.5 * progress.peak()).abs() < 1e-9 * progress.peak());
    }
    let any = Progress::try_new(1.0, ONES).unwrap();
    assert!(any.lasting(f64::NAN).is_err() && any.lasting(f64::INFINITY).is_err());
}

#[test]
fn a_way_or_a_limit_that_is_none_has_no_progress() {
    for wrong in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(Progress::try_new(wrong, ONES), None);
        let limits = MotionLimits {
            jerk: wrong,
            ..ONES
        };
        assert_eq!(Progress::try_new(1.0, limits), None);
    }
}

#[test]
fn a_change_of_speed_by_hand() {
    // From 1 to 0 with 1 and 4: the acceleration is there after 1/4 s, so 1 + 1/4 s, and half of that way.
    let from = State {
        velocity: 1.0,
        ..State::default()
    };
    let brake = SpeedChange::new(from, 0.0, 1.0, 4.0);
    assert!((brake.duration() - 1.25).abs() < 1e-12);
    assert!((brake.at(9.0).position - 0.625).abs() < 1e-12 && brake.target() == 0.0);
    assert_eq!(brake.reaches(0.7), None);
    // Without time to get there: 2 sqrt(v / j).
    let gentle = SpeedChange::new(from, 0.0, 9.0, 4.0);
    assert!((gentle.duration() - 1.0).abs() < 1e-12);
    let steady = SpeedChange::steady(2.0, 0.5);
    assert!((steady.at(4.0).position - 4.0).abs() < 1e-12 && steady.reaches(3.0) == Some(2.0));
}

#[test]
fn changes_of_speed_are_smooth_within_their_limits_also_from_within_each_other() {
    let mut draw = Draw::new(3);
    for _ in 0..2000 {
        let (acceleration, jerk) = (draw.power(-1.0, 2.0), draw.power(-1.0, 4.0));
        let first = State {
            velocity: draw.between(0.0, 2.0),
            ..State::default()
        };
        let mut change = SpeedChange::new(first, draw.between(0.0, 2.0), acceleration, jerk);
        for _ in 0..3 {
            let from = change.at(draw.between(0.0, 1.2) * change.duration());
            let target = draw.between(0.0, 2.0);
            change = SpeedChange::new(from, target, acceleration, jerk);
            let start = change.at(0.0);
            assert!((start.velocity - from.velocity).abs() < 1e-9);
            assert!((start.acceleration - from.acceleration).abs() < 1e-9 * acceleration);
            let near_end = change.at(change.duration() * (1.0 - 1e-9));
            assert!(
                (near_end.velocity - target).abs() < 1e-6,
                "{near_end:?} {target}"
            );
            for step in 0..20 {
                let t = change.duration() * f64::from(step) / 20.0;
                let state = change.at(t);
                assert!(state.acceleration.abs() <= acceleration * (1.0 + 1e-9));
                // With one jerk, it never goes below zero or above the fastest.
                assert!((-1e-9..=2.0 + 1e-9).contains(&state.velocity), "{state:?}");
                let found = change.reaches(state.position).unwrap();
                let again = change.at(found).position;
                assert!((again - state.position).abs() < 1e-9 * (1.0 + again.abs()));
            }
        }
    }
}
