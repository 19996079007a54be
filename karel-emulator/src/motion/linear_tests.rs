use kinematics::{Axis, Seed, Xyzwpr};
use units::{Degrees, Millimeters};

use super::*;

fn pose(x: f64, y: f64, z: f64) -> Pose {
    let place = [x, y, z].map(Millimeters);
    let turn = [180.0, 0.0, 0.0].map(Degrees);
    Pose::try_from_xyzwpr(&Xyzwpr::new(place, turn)).unwrap()
}

/// The M-20iA with this acceleration of each joint, deg/s².
fn arm(acceleration: f64) -> ArmModel {
    let text = include_str!("../../../crates/kinematics/models/fanuc_m20ia.toml");
    let lines = text.lines().map(|line| {
        if line.starts_with("max_acceleration_deg_s2") {
            format!("max_acceleration_deg_s2 = {acceleration:?}\n")
        } else {
            format!("{line}\n")
        }
    });
    ArmModel::from_toml(&lines.collect::<String>()).unwrap()
}

fn sideways(arm: &ArmModel, speed: f64) -> Result<Path, Refusal> {
    sideways_at(arm, ToolSpeed::MmPerSec(speed))
}

fn sideways_at(arm: &ArmModel, speed: ToolSpeed) -> Result<Path, Refusal> {
    let start = arm.inverse(&pose(900.0, -200.0, 700.0), Seed::Near(arm.home()));
    let start = start.unwrap();
    let target = LinearTarget {
        tcp: pose(900.0, 200.0, 700.0),
        configuration: start.configuration,
        wrist: None,
    };
    let pace = Pace {
        speed,
        rotation_deg_s: f64::INFINITY,
        acceleration: 1.0,
    };
    plan(arm, &Frames::default(), start.joints, &target, &pace)
}

#[test]
fn a_line_is_slow_enough_for_the_accelerations_of_the_joints() {
    // The tool's 3000 mm/s² at 922 mm from axis 1 are 186 deg/s² of J1.
    let (strong, weak) = (arm(390.0), arm(40.0));
    let usual = sideways(&strong, 500.0).unwrap();
    // way / v + v / a + a / j
    assert!((usual.duration() - (400.0 / 500.0 + 500.0 / 3000.0 + 0.1)).abs() < 1e-9);
    let slow = sideways(&weak, 500.0).unwrap();
    assert!(
        slow.duration() > 1.5 * usual.duration(),
        "{}",
        slow.duration()
    );
    let period = INTERPOLATION_PERIOD_S;
    let mut t = period;
    while t < slow.duration() {
        let [a, b, c] = [t - period, t, t + period].map(|t| slow.at_time(t).degrees());
        for (n, axis) in Axis::ALL.into_iter().enumerate() {
            let acceleration = (c[n] - 2.0 * b[n] + a[n]) / (period * period);
            assert!(
                acceleration.abs() < 1.1 * 40.0,
                "{axis}: {acceleration} at {t}"
            );
        }
        t += period;
    }
}

#[test]
fn a_line_on_which_a_joint_is_too_fast_is_an_alarm() {
    // Right above axis 1, almost.
    let arm = arm(390.0);
    let start = arm.inverse(&pose(300.0, -400.0, 700.0), Seed::Near(arm.home()));
    let start = start.unwrap();
    let target = LinearTarget {
        tcp: pose(300.0, 400.0, 700.0),
        configuration: start.configuration,
        wrist: None,
    };
    let pace = Pace {
        speed: ToolSpeed::MmPerSec(1999.0),
        rotation_deg_s: f64::INFINITY,
        acceleration: 1.5,
    };
    let along = |pace: &Pace| plan(&arm, &Frames::default(), start.joints, &target, pace);
    let refusal = along(&pace).unwrap_err();
    assert_eq!(refusal.status, MOTN_JOINT_SPEED, "{}", refusal.text);
    assert!(
        refusal.text.contains("J1 would turn with"),
        "{}",
        refusal.text
    );
    // `max_speed` says that the joints say how fast it is.
    let speed = ToolSpeed::Greatest;
    let fastest = along(&Pace { speed, ..pace }).unwrap();
    let period = INTERPOLATION_PERIOD_S;
    let mut share = 0.0_f64;
    let mut t = period;
    while t < fastest.duration() {
        let [a, b] = [t - period, t].map(|t| fastest.at_time(t).degrees());
        for (n, axis) in Axis::ALL.into_iter().enumerate() {
            let speed = (b[n] - a[n]).abs() / period;
            share = share.max(speed / arm.max_speed(axis).0);
        }
        t += period;
    }
    assert!((0.6..=1.001).contains(&share), "{share}");
}
