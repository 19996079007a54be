//! Joints in time, as samples and peaks.

use api::trajectory::{TrajectoryPeaks, TrajectorySample};
use kinematics::serial::SerialArm;
use planning::State;
use planning::jerk::MotionLimits;

use crate::arm::Arm;
use crate::convert::shown;
use crate::forward::tcp;

/// Samples of one answer.
pub(crate) const MOST_SAMPLES: usize = 5000;

/// The joints at one moment, in radians and millimeters.
#[derive(Clone, Debug)]
pub(crate) struct Moment {
    pub(crate) time: f64,
    pub(crate) states: Vec<State>,
    pub(crate) jerks: Vec<f64>,
}

/// The samples of an answer, positions of the tool by `framed`.
pub(crate) fn samples(arm: &Arm, framed: &SerialArm, moments: &[Moment]) -> Vec<TrajectorySample> {
    let units = || arm.serial.joint_list().iter().map(|joint| joint.kind);
    let own = |values: Vec<f64>| -> Vec<f64> {
        let pairs = units().zip(values);
        pairs
            .map(|(kind, value)| shown(kind.shown(value)))
            .collect()
    };
    moments
        .iter()
        .map(|moment| {
            let part = |get: fn(&State) -> f64| own(moment.states.iter().map(get).collect());
            let (tcp_mm, tcp_speed_mm_s) = tool(framed, moment);
            TrajectorySample {
                time_s: shown(moment.time),
                position_deg_mm: part(|state| state.position),
                velocity_deg_mm_s: part(|state| state.velocity),
                acceleration_deg_mm_s2: part(|state| state.acceleration),
                jerk_deg_mm_s3: own(moment.jerks.clone()),
                tcp_mm,
                tcp_speed_mm_s,
            }
        })
        .collect()
}

/// Where the tool is, and how fast: the Jacobian times the joints' velocities.
fn tool(framed: &SerialArm, moment: &Moment) -> ([f64; 3], f64) {
    let positions: Vec<f64> = moment.states.iter().map(|state| state.position).collect();
    let Ok(joints) = framed.joints_from_radians(&positions) else {
        return ([0.0; 3], 0.0);
    };
    let speed = framed.jacobian(&joints).map_or(0.0, |jacobian| {
        let rates = nalgebra::DVector::from_iterator(
            moment.states.len(),
            moment.states.iter().map(|state| state.velocity),
        );
        (jacobian.fixed_rows::<3>(0) * rates).norm()
    });
    (tcp(framed, &joints), shown(speed))
}

/// The largest of each joint's numbers along the moments, beside its limits.
pub(crate) fn peaks(
    arm: &Arm,
    moments: &[Moment],
    limits: &[MotionLimits],
) -> Vec<TrajectoryPeaks> {
    let joints = arm.serial.joint_list().iter().zip(limits).enumerate();
    joints
        .map(|(index, (joint, limits))| {
            let own = |value: f64| shown(joint.kind.shown(value));
            let states = || moments.iter().filter_map(|moment| moment.states.get(index));
            let most =
                |get: fn(&State) -> f64| states().map(get).fold(0.0, |a, b| larger(a, b.abs()));
            let positions = states().map(|state| state.position);
            let (min, max) = positions.fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), p| {
                (p.min(min), p.max(max))
            });
            let jerks = moments.iter().filter_map(|moment| moment.jerks.get(index));
            TrajectoryPeaks {
                joint: joint.name.clone(),
                min_deg_mm: own(min),
                max_deg_mm: own(max),
                range_deg_mm: [own(joint.min), own(joint.max)],
                velocity_deg_mm_s: own(most(|state| state.velocity)),
                max_velocity_deg_mm_s: own(limits.velocity),
                acceleration_deg_mm_s2: own(most(|state| state.acceleration)),
                max_acceleration_deg_mm_s2: own(limits.acceleration),
                jerk_deg_mm_s3: own(jerks.fold(0.0, |a, b| larger(a, b.abs()))),
                max_jerk_deg_mm_s3: limits.jerk.is_finite().then(|| own(limits.jerk)),
            }
        })
        .collect()
}

fn larger(a: f64, b: f64) -> f64 {
    if a >= b { a } else { b }
}

/// Do the joints keep what they can do? Numbers were rounded to be shown.
pub(crate) fn within_limits(peaks: &[TrajectoryPeaks]) -> bool {
    let keeps = |is: f64, most: f64| is <= most * (1.0 + 1e-6) + 1e-6;
    peaks.iter().all(|p| {
        let [least, most] = p.range_deg_mm;
        keeps(least - p.min_deg_mm, 0.0)
            && keeps(p.max_deg_mm - most, 0.0)
            && keeps(p.velocity_deg_mm_s, p.max_velocity_deg_mm_s)
            && keeps(p.acceleration_deg_mm_s2, p.max_acceleration_deg_mm_s2)
            && p.max_jerk_deg_mm_s3
                .is_none_or(|most| keeps(p.jerk_deg_mm_s3, most))
    })
}
