//! Joints in time.

mod kinds;

use api::trajectory::{JointStates, TrajectoryBody, TrajectoryResult, TrajectoryVia};
use planning::State;
use planning::jerk::MotionLimits;

use crate::arm::Arm;
use crate::convert::{frames_of, shown};
use crate::refusal::{Refusal, RefusalKind, length, within};
use crate::sampled::{MOST_SAMPLES, Moment, peaks, samples, within_limits};
use kinds::Curve;

/// How much jerk a joint may have where nobody says: full acceleration after a tenth of a second.
const JERK_OF_ACCELERATION: f64 = 10.0;
const PERIOD_S: [f64; 2] = [0.0005, 10.0];
const MOST_VIA: usize = 998;
/// Over this time an acceleration is compared with itself to get the jerk, s.
const JERK_OVER: f64 = 1e-6;

/// The joints of a model from start to goal in time: polynomials, jerk-limited, or past via points.
///
/// Textbook (2.16) to (2.23) for `quintic`, (2.24) to (2.42) for `4-3-4` and `3-5-3`; the other two are the product's
/// own (see `planning`). Polynomials know no limits: `peaks` and `within_limits` tell whether the joints can do it.
///
/// # Errors
/// Names the joint, via point, duration or limit that is wrong: a start, goal or via point outside the ranges, a state
/// that the limits exclude, a duration that is impossible (and the next one that is not), more samples than are told.
pub fn trajectory(model: &str, body: &TrajectoryBody) -> Result<TrajectoryResult, Refusal> {
    let arm = Arm::named(model)?;
    let frames = frames_of(&body.frames)?;
    let limits = limits(&arm, body)?;
    let start = states(&arm, "start", &body.start)?;
    let goal = states(&arm, "goal", &body.goal)?;
    length(
        "via_deg_mm",
        body.via_deg_mm.len(),
        [0, MOST_VIA],
        "via points",
    )?;
    let mut via = Vec::new();
    for (index, point) in body.via_deg_mm.iter().enumerate() {
        let path = format!("via_deg_mm[{index}]");
        via.push(arm.joints_inside(&path, point)?.as_slice().to_vec());
    }
    let curve = Curve::try_new(&arm, body, &start, &via, &goal, &limits)?;
    let moments = moments(&curve, body.period_s)?;
    let mut peaks = peaks(&arm, &moments, &limits);
    curve.refine(&arm, &mut peaks);
    let joints = arm.serial.joint_list();
    let name = |index: usize| joints.get(index).map(|joint| joint.name.clone());
    let passed = curve.via(&via);
    Ok(TrajectoryResult {
        kind: body.kind,
        joints: joints.iter().map(|joint| joint.name.clone()).collect(),
        duration_s: curve.duration(),
        samples: samples(&arm, &arm.serial.with_frames(&frames), &moments),
        within_limits: within_limits(&peaks),
        peaks,
        slowest: curve.slowest().and_then(name),
        via: passed
            .into_iter()
            .map(|(time, deviation)| TrajectoryVia {
                time_s: shown(time),
                deviation_deg_mm: joints
                    .iter()
                    .zip(deviation)
                    .map(|(joint, value)| shown(joint.kind.shown(value)))
                    .collect(),
            })
            .collect(),
    })
}

fn moments(curve: &Curve, period: Option<f64>) -> Result<Vec<Moment>, Refusal> {
    let duration = curve.duration();
    let period = match period {
        Some(period) => within("period_s", period, PERIOD_S, "s")?,
        // A hundredth of the whole, whatever that is.
        None => (duration / 100.0).max(1e-9),
    };
    let most = u32::try_from(MOST_SAMPLES).unwrap_or(u32::MAX);
    let needed = (duration / period - 1e-9).ceil().max(1.0);
    if needed + 1.0 > f64::from(most) {
        let detail = format!(
            "{duration:.3} s in steps of {period} s are {needed:.0} samples; at most {MOST_SAMPLES} are told"
        );
        return Err(Refusal::invalid("period_s", detail).with_value(period));
    }
    let mut moments = Vec::new();
    for step in 0..most {
        let time = (f64::from(step) * period).min(duration);
        let last = f64::from(step) >= needed;
        let time = if last { duration } else { time };
        // Both sides of the moment, inside the trajectory.
        let (before, after) = (
            (time - JERK_OVER).max(0.0),
            (time + JERK_OVER).min(duration),
        );
        let (then, later) = (curve.at(before), curve.at(after));
        let jerks = then
            .iter()
            .zip(&later)
            .map(|(a, b)| (b.acceleration - a.acceleration) / (after - before).max(1e-12));
        moments.push(Moment {
            time,
            jerks: jerks.collect(),
            states: curve.at(time),
        });
        if last {
            break;
        }
    }
    Ok(moments)
}

fn states(arm: &Arm, end: &str, body: &JointStates) -> Result<Vec<State>, Refusal> {
    let positions = arm.joints_inside(&format!("{end}.position_deg_mm"), &body.position_deg_mm)?;
    let rates = |key: &str, values: &Option<Vec<f64>>| -> Result<Vec<f64>, Refusal> {
        let path = format!("{end}.{key}");
        own_units(arm, &path, values.as_deref(), [-1e6, 1e6])
            .map(|given| given.unwrap_or_else(|| vec![0.0; positions.len()]))
    };
    let velocities = rates("velocity_deg_mm_s", &body.velocity_deg_mm_s)?;
    let accelerations = rates("acceleration_deg_mm_s2", &body.acceleration_deg_mm_s2)?;
    let all = positions
        .as_slice()
        .iter()
        .zip(velocities)
        .zip(accelerations);
    Ok(all
        .map(|((position, velocity), acceleration)| State {
            position: *position,
            velocity,
            acceleration,
        })
        .collect())
}

/// One number for each joint, out of the units of the edge.
fn own_units(
    arm: &Arm,
    path: &str,
    values: Option<&[f64]>,
    range: [f64; 2],
) -> Result<Option<Vec<f64>>, Refusal> {
    let Some(values) = values else {
        return Ok(None);
    };
    let joints = arm.serial.joint_list();
    length(path, values.len(), [joints.len(); 2], "numbers")?;
    let mut own = Vec::new();
    for (index, (joint, value)) in joints.iter().zip(values).enumerate() {
        let value = within(&format!("{path}[{index}]"), *value, range, "")?;
        own.push(joint.kind.inside(value));
    }
    Ok(Some(own))
}

fn limits(arm: &Arm, body: &TrajectoryBody) -> Result<Vec<MotionLimits>, Refusal> {
    const RANGE: [f64; 2] = [1e-6, 1e8];
    let given =
        |path: &str, values: &Option<Vec<f64>>| own_units(arm, path, values.as_deref(), RANGE);
    let velocities = given("max_velocity_deg_mm_s", &body.max_velocity_deg_mm_s)?;
    let accelerations = given(
        "max_acceleration_deg_mm_s2",
        &body.max_acceleration_deg_mm_s2,
    )?;
    let jerks = given("max_jerk_deg_mm_s3", &body.max_jerk_deg_mm_s3)?;
    let of =
        |list: &Option<Vec<f64>>, index: usize| list.as_ref().and_then(|l| l.get(index).copied());
    let joints = arm.serial.joint_list().iter().enumerate();
    Ok(joints
        .map(|(index, joint)| {
            let acceleration = of(&accelerations, index).unwrap_or(joint.max_acceleration);
            MotionLimits {
                velocity: of(&velocities, index).unwrap_or(joint.max_speed),
                acceleration,
                jerk: of(&jerks, index).unwrap_or(JERK_OF_ACCELERATION * acceleration),
            }
        })
        .collect())
}

/// Of a duration that the joints cannot keep.
fn impossible(path: &str, detail: impl std::fmt::Display) -> Refusal {
    Refusal::new(RefusalKind::Invalid, path, detail)
}
