use std::time::Duration;

use kinematics::{Frames, Xyzwpr};
use proptest::prelude::*;
use units::{Degrees, Millimeters};

use super::*;
use crate::motion::linear::{self, LinearTarget, Pace, ToolSpeed};
use crate::motion::{Executor, Happening, Motion};

fn arm() -> &'static ArmModel {
    ArmModel::builtin("fanuc-m20ia").unwrap()
}

fn pose(x: f64, y: f64, z: f64) -> Pose {
    let place = [x, y, z].map(Millimeters);
    let turn = [180.0, 0.0, 0.0].map(Degrees);
    Pose::try_from_xyzwpr(&Xyzwpr::new(place, turn)).unwrap()
}

fn joints(degrees: [f64; 6]) -> PendantJoints {
    PendantJoints::from_degrees(degrees)
}

/// Straight lines from corner to corner, at this speed in mm/s.
fn lines(corners: &[Pose], speed: f64, acceleration: f64) -> Vec<Path> {
    let branch = arm().configuration(&joints([0.0, 0.0, 0.0, 0.0, -90.0, 0.0]));
    let frames = Frames::default();
    let wanted = kinematics::Seed::InConfiguration(branch);
    let start = arm().inverse(corners.first().unwrap(), wanted).unwrap();
    let mut from = start.joints;
    let mut paths = Vec::new();
    for corner in corners.iter().skip(1) {
        let target = LinearTarget {
            tcp: *corner,
            configuration: arm().configuration(&from),
            wrist: None,
        };
        let pace = Pace {
            speed: ToolSpeed::MmPerSec(speed),
            rotation_deg_s: f64::INFINITY,
            acceleration,
        };
        let path = linear::plan(arm(), &frames, from, &target, &pace).unwrap();
        from = *path.to();
        paths.push(path);
    }
    paths
}

fn tool_at(joints: &PendantJoints) -> [f64; 3] {
    let flange = arm().forward(joints);
    flange.isometry().translation.vector.into()
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b));
    squares.sum::<f64>().sqrt()
}

/// Drives the paths one behind the other with this CNT; the joints each `step` seconds.
fn drive(paths: &[Path], rounding: Option<f64>, step: f64) -> Vec<PendantJoints> {
    let first = *paths.first().unwrap().from();
    let mut executor = Executor::new(first, 1.0);
    let mut waiting: Vec<Path> = paths.iter().rev().cloned().collect();
    let mut seen = Vec::new();
    let mut n = 0.0;
    loop {
        let now = Duration::from_secs_f64(n * step);
        while let Some(_happened) = executor.due(now) {}
        while executor.has_room()
            && let Some(path) = waiting.pop()
        {
            let motion = Motion {
                path,
                rounding,
                tag: 0,
            };
            let round = |a: &Path, b: &Path, overlap| plan(arm(), a, b, overlap);
            let _added = executor.add(now, motion, round);
        }
        seen.push(executor.joints(now));
        if !executor.is_moving() {
            return seen;
        }
        n += 1.0;
        assert!(n < 1e6, "it moves for ever");
    }
}

/// How near the way comes to the corner, and the slowest it is within 60 mm of it, mm/s.
fn at_corner(way: &[PendantJoints], corner: [f64; 3], step: f64) -> (f64, f64) {
    let places: Vec<[f64; 3]> = way.iter().map(tool_at).collect();
    let near = places.iter().map(|place| distance(*place, corner));
    let near = near.fold(f64::INFINITY, f64::min);
    let pairs = places.iter().zip(places.iter().skip(1));
    let close = pairs.filter(|(a, _)| distance(**a, corner) < 60.0);
    let speeds = close.map(|(a, b)| distance(*a, *b) / step);
    (near, speeds.fold(f64::INFINITY, f64::min))
}

const STEP: f64 = 0.002;

#[test]
fn cnt_100_rounds_most_and_keeps_its_speed_and_cnt_0_nearly_stops() {
    let corner = [900.0, 0.0, 700.0];
    let corners = [
        pose(900.0, -200.0, 700.0),
        pose(900.0, 0.0, 700.0),
        pose(900.0, 0.0, 900.0),
    ];
    let paths = lines(&corners, 300.0, 1.0);
    let mut last = (0.0, 0.0);
    for percent in [0.0, 25.0, 50.0, 75.0, 100.0] {
        let found = at_corner(&drive(&paths, Some(percent), STEP), corner, STEP);
        assert!(
            found.0 > last.0,
            "CNT{percent}: {} mm of the corner",
            found.0
        );
        assert!(found.1 > last.1, "CNT{percent}: {} mm/s", found.1);
        last = found;
    }
    // At a right angle both speeds are half of 300 in the middle.
    assert!((last.1 - 300.0 / 2.0_f64.sqrt()).abs() < 10.0, "{last:?}");
    let (near, slowest) = at_corner(&drive(&paths, Some(0.0), STEP), corner, STEP);
    assert!(
        near < 0.05 && slowest < 20.0,
        "CNT0: {near} mm, {slowest} mm/s"
    );
    let (near, slowest) = at_corner(&drive(&paths, None, STEP), corner, STEP);
    assert!(
        near < 1e-3 && slowest < 3.0,
        "FINE: {near} mm, {slowest} mm/s"
    );
}

#[test]
fn a_straight_way_in_two_pieces_keeps_its_speed_at_cnt_100() {
    let corners = [
        pose(900.0, -200.0, 700.0),
        pose(900.0, 0.0, 700.0),
        pose(900.0, 200.0, 700.0),
    ];
    let way = drive(&lines(&corners, 300.0, 1.0), Some(100.0), STEP);
    let (_, slowest) = at_corner(&way, [900.0, 0.0, 700.0], STEP);
    assert!((slowest - 300.0).abs() < 2.0, "{slowest} mm/s");
}

#[test]
fn a_smaller_acc_makes_a_longer_rounding() {
    let corner = [900.0, 0.0, 700.0];
    let corners = [
        pose(900.0, -200.0, 700.0),
        pose(900.0, 0.0, 700.0),
        pose(900.0, 0.0, 900.0),
    ];
    let near = |acceleration| {
        let way = drive(&lines(&corners, 300.0, acceleration), Some(100.0), STEP);
        at_corner(&way, corner, STEP).0
    };
    // With ACC50 300 mm/s take v / a + a / j = 0.3 s instead of 0.2 s: both acceleration and jerk are half.
    assert!(near(0.5) > 1.4 * near(1.0));
}

#[test]
fn overlap_of_a_corner_is_never_more_than_half_of_the_shorter_leg() {
    // 200 mm, then 12 mm: the tool must not leave the first line before 6 mm in front of the corner.
    let corners = [
        pose(900.0, -200.0, 700.0),
        pose(900.0, 0.0, 700.0),
        pose(900.0, 0.0, 712.0),
        pose(900.0, 200.0, 712.0),
    ];
    let paths = lines(&corners, 500.0, 1.0);
    let [long, short, other] = paths.as_slice() else {
        panic!("three lines");
    };
    for (before, after) in [(long, short), (short, other)] {
        for percent in [0.0, 30.0, 100.0] {
            let overlap = overlap_of_a_corner(percent, before, Some(after));
            let place = tool_at(&before.at_time(before.duration() - overlap));
            assert!(distance(place, tool_at(before.to())) <= 6.0 + 1e-6);
            let place = tool_at(&after.at_time(overlap));
            assert!(distance(place, tool_at(after.from())) <= 6.0 + 1e-6);
            assert!(overlap <= overlap_of_a_corner(percent, before, None));
        }
    }
    let way = drive(&paths, Some(100.0), STEP);
    for [_, y, z] in way.iter().map(tool_at) {
        let on_first = (z - 700.0).abs() < 1e-3 && y < -5.99;
        let on_last = (z - 712.0).abs() < 1e-3 && y > 5.99;
        assert!(on_first || on_last || y.abs() <= 6.01, "{y}, {z}");
    }
}

#[test]
fn a_corner_is_only_rounded_with_the_program_in_time() {
    let corners = [
        pose(900.0, -200.0, 700.0),
        pose(900.0, 0.0, 700.0),
        pose(900.0, 0.0, 900.0),
    ];
    let paths = lines(&corners, 300.0, 1.0);
    let one = paths.first().unwrap();
    let motion = |path: &Path, tag| Motion {
        path: path.clone(),
        rounding: Some(100.0),
        tag,
    };
    let none = |_: &Path, _: &Path, _| -> Option<Blend> { panic!("nothing is to be rounded") };
    let mut executor = Executor::new(*one.from(), 1.0);
    let _added = executor.add(Duration::ZERO, motion(one, 1), none);
    let pass = executor.next_due().unwrap();
    assert!(matches!(executor.due(pass), Some(Happening::Passes(1))));
    let end = executor.next_due().unwrap();
    assert!((end.as_secs_f64() - one.duration()).abs() < 1e-6);
    assert!(end.saturating_sub(pass).as_secs_f64() - one.ramp() < 1e-6);
    assert!(matches!(executor.due(end), Some(Happening::Ended(_))));
    assert!(!executor.is_moving());
}

fn some_joints() -> impl Strategy<Value = [f64; 6]> {
    let angle = || -60.0..60.0f64;
    (
        angle(),
        -40.0..40.0f64,
        -40.0..40.0f64,
        angle(),
        angle(),
        angle(),
    )
        .prop_map(|(a, b, c, d, e, f)| [a, b, c, d, e, f])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// Continuous in velocity, within the speeds of the joints, and inside of the triangle of the corner.
    #[test]
    fn a_joint_corner_is_smooth_within_the_speeds_and_inside_of_its_triangle(
        a in some_joints(), b in some_joints(), c in some_joints(),
        speed in 0.1..1.0f64, acceleration in 0.2..1.0f64, percent in 0.0..100.0f64,
    ) {
        let path = |from, to| Path::joint_at(arm(), joints(from), joints(to), speed, acceleration);
        let way = drive(&[path(a, b), path(b, c)], Some(percent), STEP);
        let mut before = [0.0; 6];
        for (one, next) in way.iter().zip(way.iter().skip(1)) {
            let (one, next) = (one.degrees(), next.degrees());
            for (n, axis) in Axis::ALL.into_iter().enumerate() {
                let velocity = (next[n] - one[n]) / STEP;
                let most = arm().max_speed(axis).0 * speed;
                prop_assert!(velocity.abs() <= most * (1.0 + 1e-6) + 1e-6);
                // Both motions accelerate the axis at the same time.
                let jump = (velocity - before[n]).abs();
                let allowed = 2.0 * arm().max_acceleration(axis).0 * acceleration * STEP;
                prop_assert!(jump <= allowed * 1.01 + 1e-6, "{axis} jumps by {jump} deg/s");
                before[n] = velocity;
                let (low, high) = (a[n].min(b[n]).min(c[n]), a[n].max(b[n]).max(c[n]));
                prop_assert!((low - 1e-6..=high + 1e-6).contains(&one[n]));
            }
        }
    }

    /// Inside of the convex corner: between the two lines, never beyond one of them.
    #[test]
    fn the_tool_stays_inside_of_the_corner(
        y in -150.0..150.0f64, z in 60.0..200.0f64, percent in 0.0..100.0f64, speed in 50.0..700.0f64,
    ) {
        let corners = [pose(900.0, -200.0, 700.0), pose(900.0, 0.0, 700.0), pose(900.0, y, 700.0 + z)];
        let paths = lines(&corners, speed, 1.0);
        for [x, ty, tz] in drive(&paths, Some(percent), 0.004).iter().map(tool_at) {
            // As sums of the ways from the corner back and on: both at least 0, together at most 1.
            let on = (tz - 700.0) / z;
            let back = (y * on - ty) / 200.0;
            prop_assert!((x - 900.0).abs() < 0.05);
            prop_assert!(on > -1e-4 && back > -1e-4 && on + back < 1.0 + 1e-4, "{on} {back}");
        }
    }
}
