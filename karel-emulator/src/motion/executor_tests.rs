use kinematics::{ArmModel, PendantJoints};
use units::MmPerSec;

use super::*;

const START: [f64; 6] = [0.0, 0.0, 0.0, 0.0, -30.0, 0.0];
const TARGET: [f64; 6] = [40.0, 10.0, -5.0, 20.0, -60.0, 1.0];

fn arm() -> &'static ArmModel {
    ArmModel::builtin("fanuc-m20ia").unwrap()
}

fn motion(from: [f64; 6], to: [f64; 6], tag: u32) -> Motion<u32> {
    let joints = PendantJoints::from_degrees;
    Motion {
        path: Path::joint(arm(), joints(from), joints(to), MmPerSec(500.0)),
        tag,
    }
}

fn executor() -> Executor<u32> {
    Executor::new(PendantJoints::from_degrees(START), 1.0)
}

fn seconds(s: f64) -> Duration {
    Duration::from_secs_f64(s)
}

fn close(a: [f64; 6], b: [f64; 6]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

#[test]
fn six_axes_start_and_stop_together() {
    let mut executor = executor();
    let _added = executor.add(Duration::ZERO, motion(START, TARGET, 1));
    let end = executor.next_end().unwrap();
    for step in 1..20 {
        let joints = executor
            .joints(end.mul_f64(f64::from(step) / 20.0))
            .degrees();
        let share = |axis: usize| (joints[axis] - START[axis]) / (TARGET[axis] - START[axis]);
        for axis in 1..6 {
            assert!(
                (share(axis) - share(0)).abs() < 1e-9,
                "axis {axis} at step {step}"
            );
        }
    }
    let (done, next) = executor.end_due(end).unwrap();
    assert_eq!((done.outcome, next), (Outcome::Finished, None));
    assert!(close(executor.joints(end).degrees(), TARGET));
}

#[test]
fn no_axis_exceeds_its_speed_or_acceleration() {
    let path = motion(START, TARGET, 1).path;
    let h = path.duration() / 2000.0;
    let mut previous = [0.0; 6];
    for step in 0..2000 {
        let t = f64::from(step) * h;
        let (a, b) = (path.at(path.progress(t)), path.at(path.progress(t + h)));
        for (index, axis) in kinematics::Axis::ALL.into_iter().enumerate() {
            let speed = (b.degrees()[index] - a.degrees()[index]) / h;
            assert!(speed.abs() <= arm().max_speed(axis).0 * 0.25 * (1.0 + 1e-6));
            let acceleration = (speed - previous[index]) / h;
            assert!(acceleration.abs() <= arm().max_acceleration(axis).0 * (1.0 + 1e-3));
            previous[index] = speed;
        }
    }
}

#[test]
fn half_the_override_takes_twice_the_time_on_the_same_path() {
    let mut full = executor();
    let mut half = Executor::new(PendantJoints::from_degrees(START), 0.5);
    let _added = full.add(Duration::ZERO, motion(START, TARGET, 1));
    let _added = half.add(Duration::ZERO, motion(START, TARGET, 1));
    let (a, b) = (
        full.next_end().unwrap().as_secs_f64(),
        half.next_end().unwrap().as_secs_f64(),
    );
    assert!((2.0 * a - b).abs() < 1e-6);
    assert!(close(
        full.joints(seconds(0.2)).degrees(),
        half.joints(seconds(0.4)).degrees()
    ));
}

#[test]
fn an_override_change_takes_effect_in_the_middle_of_a_motion() {
    let mut executor = executor();
    let _added = executor.add(Duration::ZERO, motion(START, TARGET, 1));
    let whole = executor.next_end().unwrap();
    let middle = whole / 2;
    let before = executor.joints(middle);
    executor.set_rate(middle, 0.25);
    assert!(
        close(executor.joints(middle).degrees(), before.degrees()),
        "the arm does not jump"
    );
    let end = executor.next_end().unwrap().as_secs_f64();
    let expected = middle.as_secs_f64() + 4.0 * whole.saturating_sub(middle).as_secs_f64();
    assert!((end - expected).abs() < 1e-6);
}

/// Covers: K8.
#[test]
fn one_motion_waits_and_a_third_finds_no_room() {
    let mut executor = executor();
    assert_eq!(
        executor.add(Duration::ZERO, motion(START, TARGET, 1)),
        Added::Started
    );
    assert_eq!(
        executor.add(Duration::ZERO, motion(TARGET, START, 2)),
        Added::Waits
    );
    assert_eq!(
        executor.add(Duration::ZERO, motion(START, TARGET, 3)),
        Added::NoRoom
    );
    assert!(close(executor.tail().degrees(), START));
    let first = executor.next_end().unwrap();
    let (_, started) = executor.end_due(first).unwrap();
    assert_eq!(started, Some(&2));
    assert!(executor.has_room());
    let second = executor.next_end().unwrap();
    assert!(executor.end_due(second).is_some());
    assert!(!executor.is_moving());
}

#[test]
fn a_stop_brakes_on_the_path_and_drops_what_waits() {
    let mut executor = executor();
    let _added = executor.add(Duration::ZERO, motion(START, TARGET, 1));
    let _added = executor.add(Duration::ZERO, motion(TARGET, START, 2));
    let middle = executor.next_end().unwrap() / 2;
    let dropped = executor.stop(middle).unwrap();
    assert_eq!(
        (dropped.motion.tag, dropped.outcome),
        (2, Outcome::Cancelled)
    );
    let still = executor.next_end().unwrap();
    assert!(still > middle, "an arm does not stop at once");
    let (end, _) = executor.end_due(still).unwrap();
    assert_eq!(end.outcome, Outcome::Cancelled);
    let travelled = end.joints.degrees()[0];
    assert!(
        travelled > 20.0 && travelled < 40.0,
        "J1 stopped at {travelled}"
    );
    assert!(close(
        executor.joints(still + seconds(9.0)).degrees(),
        end.joints.degrees()
    ));
}

#[test]
fn a_move_to_where_the_arm_stands_takes_one_interpolation_period() {
    let mut executor = executor();
    let _added = executor.add(Duration::ZERO, motion(START, START, 1));
    let end = executor.next_end().unwrap();
    assert!((end.as_secs_f64() - 0.008).abs() < 1e-6);
    assert_eq!(executor.end_due(end).unwrap().0.outcome, Outcome::Finished);
}
