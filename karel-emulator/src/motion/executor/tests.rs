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
        rounding: None,
        tag,
    }
}

fn add(executor: &mut Executor<u32>, now: Duration, motion: Motion<u32>) -> Added {
    executor.add(now, motion, |_, _, _| Some(Blend::Joints))
}

/// The next thing that happens, when it happens.
fn next(executor: &mut Executor<u32>) -> (Duration, Happening<u32>) {
    let at = executor.next_due().unwrap();
    (at, executor.due(at).unwrap())
}

fn ended(happening: Happening<u32>) -> MotionEnd<u32> {
    match happening {
        Happening::Ended(end) => *end,
        other @ (Happening::Started(_) | Happening::Passes(_) | Happening::Held(_)) => {
            panic!("{other:?}")
        }
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
    let _added = add(&mut executor, Duration::ZERO, motion(START, TARGET, 1));
    let end = executor.next_due().unwrap();
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
    let done = ended(executor.due(end).unwrap());
    assert_eq!(done.outcome, Outcome::Finished);
    assert!(close(executor.joints(end).degrees(), TARGET));
}

#[test]
fn no_axis_exceeds_its_speed_acceleration_or_jerk() {
    let path = motion(START, TARGET, 1).path;
    let h = path.duration() / 2000.0;
    let mut previous = [0.0; 6];
    let mut accelerations = [0.0; 6];
    for step in 0..2000 {
        let t = f64::from(step) * h;
        let (a, b) = (path.at_time(t), path.at_time(t + h));
        for (index, axis) in kinematics::Axis::ALL.into_iter().enumerate() {
            let speed = (b.degrees()[index] - a.degrees()[index]) / h;
            assert!(speed.abs() <= arm().max_speed(axis).0 * 0.25 * (1.0 + 1e-6));
            let acceleration = (speed - previous[index]) / h;
            assert!(acceleration.abs() <= arm().max_acceleration(axis).0 * (1.0 + 1e-3));
            let jerk = (acceleration - accelerations[index]) / h;
            assert!(
                jerk.abs() <= arm().max_jerk(axis).0 * (1.0 + 1e-2),
                "{jerk}"
            );
            accelerations[index] = acceleration;
            previous[index] = speed;
        }
    }
}

#[test]
fn half_the_override_takes_twice_the_time_on_the_same_path() {
    let mut full = executor();
    let mut half = Executor::new(PendantJoints::from_degrees(START), 0.5);
    let _added = add(&mut full, Duration::ZERO, motion(START, TARGET, 1));
    let _added = add(&mut half, Duration::ZERO, motion(START, TARGET, 1));
    let (a, b) = (
        full.next_due().unwrap().as_secs_f64(),
        half.next_due().unwrap().as_secs_f64(),
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
    let _added = add(&mut executor, Duration::ZERO, motion(START, TARGET, 1));
    let whole = executor.next_due().unwrap();
    let middle = whole / 2;
    let before = executor.joints(middle);
    executor.set_rate(middle, 0.25);
    assert!(
        close(executor.joints(middle).degrees(), before.degrees()),
        "the arm does not jump"
    );
    // It gets slower with its acceleration, and is at a quarter then.
    let rates = [0.0, 0.02, 2.0].map(|later| executor.rate(middle + seconds(later)));
    assert!(
        (rates[0] - 1.0).abs() < 1e-9 && rates[1] < 1.0 && rates[1] > 0.25,
        "{rates:?}"
    );
    assert!((rates[2] - 0.25).abs() < 1e-9);
    let end = executor.next_due().unwrap().as_secs_f64();
    let at_once = middle.as_secs_f64() + 4.0 * whole.saturating_sub(middle).as_secs_f64();
    // A change within 0.2 s wins 0.4 of the rate on average for so long, four times.
    assert!(end < at_once && end > 0.85 * at_once, "{end} of {at_once}");
}

/// Covers: K8.
#[test]
fn one_motion_waits_and_a_third_finds_no_room() {
    let mut executor = executor();
    assert_eq!(
        add(&mut executor, Duration::ZERO, motion(START, TARGET, 1)),
        Added::Started
    );
    assert_eq!(
        add(&mut executor, Duration::ZERO, motion(TARGET, START, 2)),
        Added::Waits
    );
    assert_eq!(
        add(&mut executor, Duration::ZERO, motion(START, TARGET, 3)),
        Added::NoRoom
    );
    assert!(close(executor.tail().degrees(), START));
    let (first, end) = next(&mut executor);
    assert_eq!(ended(end).motion.tag, 1);
    assert!(matches!(executor.due(first), Some(Happening::Started(2))));
    assert!(executor.has_room());
    let (_, end) = next(&mut executor);
    assert_eq!(ended(end).motion.tag, 2);
    assert!(!executor.is_moving());
}

#[test]
fn a_stop_brakes_on_the_path_and_drops_what_waits() {
    let mut executor = executor();
    let _added = add(&mut executor, Duration::ZERO, motion(START, TARGET, 1));
    let _added = add(&mut executor, Duration::ZERO, motion(TARGET, START, 2));
    let middle = executor.next_due().unwrap() / 2;
    let dropped = executor.stop(middle, Brake::Controlled).unwrap();
    assert_eq!(
        (dropped.motion.tag, dropped.outcome),
        (2, Outcome::Cancelled)
    );
    let still = executor.next_due().unwrap();
    assert!(still > middle, "an arm does not stop at once");
    let end = ended(executor.due(still).unwrap());
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
    let _added = add(&mut executor, Duration::ZERO, motion(START, START, 1));
    let end = executor.next_due().unwrap();
    assert!((end.as_secs_f64() - 0.008).abs() < 1e-6);
    let end = ended(executor.due(end).unwrap());
    assert_eq!(end.outcome, Outcome::Finished);
}

/// The velocity of J1 at `now`, deg/s.
fn velocity(executor: &Executor<u32>, now: Duration) -> f64 {
    let later = now + seconds(1e-5);
    let joints = [now, later].map(|at| executor.joints(at).degrees()[0]);
    (joints[1] - joints[0]) / 1e-5
}

#[test]
fn a_hold_brakes_on_the_path_and_a_resume_goes_on_there_without_a_jump() {
    let mut executor = executor();
    let _added = add(&mut executor, Duration::ZERO, motion(START, TARGET, 1));
    let whole = executor.next_due().unwrap();
    let middle = whole / 2;
    let speed = velocity(&executor, middle);
    executor.hold(middle, false, Brake::Controlled);
    assert!((velocity(&executor, middle) - speed).abs() < 0.1, "no jump");
    let (rest, held) = next(&mut executor);
    assert!(matches!(held, Happening::Held(1)) && rest > middle);
    assert!(!executor.is_moving() && executor.is_held());
    let there = executor.joints(rest).degrees();
    let later = rest + seconds(5.0);
    assert!(close(executor.joints(later).degrees(), there));
    // On the straight line between both ends.
    let share = (there[0] - START[0]) / (TARGET[0] - START[0]);
    for axis in 1..6 {
        let here = (there[axis] - START[axis]) / (TARGET[axis] - START[axis]);
        assert!((here - share).abs() < 1e-9);
    }
    assert_eq!(executor.resume(later), Some(&1));
    assert!(velocity(&executor, later) < 0.1, "it starts slowly");
    let (end, happened) = next(&mut executor);
    assert_eq!(ended(happened).outcome, Outcome::Finished);
    let held_for = later.saturating_sub(middle);
    assert!(end > whole + held_for.saturating_sub(seconds(0.2)));
}

#[test]
fn brakes_stop_harder_than_drives() {
    let way = |brake| {
        let mut executor = executor();
        let _added = add(&mut executor, Duration::ZERO, motion(START, TARGET, 1));
        let middle = executor.next_due().unwrap() / 2;
        executor.hold(middle, false, brake);
        let (rest, _) = next(&mut executor);
        rest.saturating_sub(middle).as_secs_f64()
    };
    let (drives, brakes) = (way(Brake::Controlled), way(Brake::PowerOff));
    assert!((drives - 2.0 * brakes).abs() < 1e-6, "{drives} {brakes}");
}

#[test]
fn a_hold_in_a_corner_stays_on_the_round_way() {
    let pass = |hold: bool| {
        let mut executor = executor();
        let corner = Motion {
            rounding: Some(100.0),
            ..motion(START, TARGET, 1)
        };
        let _added = add(&mut executor, Duration::ZERO, corner);
        let back = [40.0, -20.0, -5.0, 20.0, -60.0, 1.0];
        let _added = add(&mut executor, Duration::ZERO, motion(TARGET, back, 2));
        let mut way = Vec::new();
        let (mut resumes, mut names) = (None, Vec::new());
        for step in 0..4000 {
            let now = seconds(f64::from(step) * 0.001);
            while let Some(happened) = executor.due(now) {
                let name = match happened {
                    Happening::Started(_) => "start",
                    Happening::Passes(_) => "pass",
                    Happening::Held(_) => "held",
                    Happening::Ended(end) if end.outcome == Outcome::Passed => "passed",
                    Happening::Ended(_) => "end",
                };
                if hold && name == "start" {
                    executor.hold(now, false, Brake::Controlled);
                    resumes = Some(now + seconds(1.0));
                }
                names.push(name);
            }
            if resumes.is_some_and(|at| now >= at) {
                resumes = None;
                let _tag = executor.resume(now);
            }
            way.push(executor.joints(now).degrees());
        }
        (way, names)
    };
    let ((free, names), (held, more)) = (pass(false), pass(true));
    assert_eq!(names, ["pass", "start", "passed", "end"]);
    assert_eq!(more, ["pass", "start", "held", "passed", "end"]);
    for place in &held {
        let distance = |other: &[f64; 6]| {
            let squares = place.iter().zip(other).map(|(a, b)| (a - b) * (a - b));
            squares.sum::<f64>()
        };
        let nearest = free.iter().map(distance).fold(f64::INFINITY, f64::min);
        assert!(
            nearest.sqrt() < 0.1,
            "{} degrees beside the way",
            nearest.sqrt()
        );
    }
}

#[test]
fn a_stop_in_a_corner_ends_both_motions_there() {
    let mut executor = executor();
    let corner = Motion {
        rounding: Some(100.0),
        ..motion(START, TARGET, 1)
    };
    let _added = add(&mut executor, Duration::ZERO, corner);
    let _added = add(&mut executor, Duration::ZERO, motion(TARGET, START, 2));
    let (_, first) = next(&mut executor);
    assert!(matches!(first, Happening::Passes(1)));
    let (at, second) = next(&mut executor);
    assert!(matches!(second, Happening::Started(2)));
    assert!(executor.stop(at, Brake::Controlled).is_none());
    let (rest, one) = next(&mut executor);
    let (_, two) = next(&mut executor);
    let (one, two) = (ended(one), ended(two));
    assert_eq!([one.motion.tag, two.motion.tag], [1, 2]);
    assert_eq!([one.outcome, two.outcome], [Outcome::Cancelled; 2]);
    assert!(close(one.joints.degrees(), two.joints.degrees()));
    assert!(close(executor.joints(rest).degrees(), one.joints.degrees()));
    assert!(executor.next_due().is_none() && executor.has_room());
}
