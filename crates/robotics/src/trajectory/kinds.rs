//! The five kinds of trajectories, behind one face.

use api::trajectory::{TrajectoryBody, TrajectoryKind, TrajectoryPeaks};
use planning::State;
use planning::blend::{BlendError, BlendedMove};
use planning::jerk::{JointMove, MotionLimits, MoveError, Quantity};
use planning::trajectory::{Degrees, Extremes, Quintic, ThreeSegments, TrajectoryError};

use super::impossible;
use crate::arm::Arm;
use crate::convert::shown;
use crate::refusal::{Refusal, RefusalKind, length, within};

/// The longest trajectory, in seconds.
const LONGEST_S: f64 = 3600.0;

/// A trajectory of any number of joints.
pub(super) enum Curve {
    Quintic(Vec<Quintic>),
    Three(Vec<ThreeSegments>),
    Timed(Box<dyn Timed>),
}

/// Joints that are planned together.
pub(super) trait Timed {
    fn duration(&self) -> f64;
    fn at(&self, time: f64) -> Vec<State>;
    /// The joint that the others wait for.
    fn slowest(&self) -> Option<usize>;
    /// When the points between start and goal are passed, and how far away each joint is then.
    fn passed(&self) -> Vec<(f64, Vec<f64>)>;
}

impl<const N: usize> Timed for JointMove<N> {
    fn duration(&self) -> f64 {
        JointMove::duration(self)
    }

    fn at(&self, time: f64) -> Vec<State> {
        JointMove::at(self, time).to_vec()
    }

    fn slowest(&self) -> Option<usize> {
        Some(JointMove::slowest(self))
    }

    fn passed(&self) -> Vec<(f64, Vec<f64>)> {
        Vec::new()
    }
}

impl<const N: usize> Timed for BlendedMove<N> {
    fn duration(&self) -> f64 {
        BlendedMove::duration(self)
    }

    fn at(&self, time: f64) -> Vec<State> {
        BlendedMove::at(self, time).to_vec()
    }

    fn slowest(&self) -> Option<usize> {
        None
    }

    fn passed(&self) -> Vec<(f64, Vec<f64>)> {
        let deviations = self.deviations();
        let points = self.times().iter().zip(deviations);
        let inner = points.skip(1).take(self.times().len().saturating_sub(2));
        inner.map(|(time, off)| (*time, off.to_vec())).collect()
    }
}

/// What is planned: between `start` and `goal`, past `via`.
struct Ends<'a> {
    start: &'a [State],
    via: &'a [Vec<f64>],
    goal: &'a [State],
    ranges: &'a [(f64, f64)],
    limits: &'a [MotionLimits],
    duration: Option<f64>,
}

impl Curve {
    pub(super) fn try_new(
        arm: &Arm,
        body: &TrajectoryBody,
        start: &[State],
        via: &[Vec<f64>],
        goal: &[State],
        limits: &[MotionLimits],
    ) -> Result<Curve, Refusal> {
        let kind = body.kind;
        let durations = &body.durations_s;
        let (vias, times) = match kind {
            TrajectoryKind::Quintic => ([0, 0], [1, 1]),
            TrajectoryKind::FourThreeFour | TrajectoryKind::ThreeFiveThree => ([2, 2], [3, 3]),
            TrajectoryKind::JerkLimited => ([0, 0], [0, 1]),
            TrajectoryKind::Blended => ([0, super::MOST_VIA], [0, 0]),
        };
        length("via_deg_mm", via.len(), vias, "via points of this kind")?;
        length(
            "durations_s",
            durations.len(),
            times,
            "durations of this kind",
        )?;
        for (index, duration) in durations.iter().enumerate() {
            let path = format!("durations_s[{index}]");
            let _ = within(&path, *duration, [1e-3, LONGEST_S], "s")?;
        }
        let ranges: Vec<(f64, f64)> = arm
            .serial
            .joint_list()
            .iter()
            .map(|joint| (joint.min, joint.max))
            .collect();
        let ends = Ends {
            start,
            via,
            goal,
            ranges: &ranges,
            limits,
            duration: durations.first().copied(),
        };
        match kind {
            TrajectoryKind::Quintic => ends.quintic(),
            TrajectoryKind::FourThreeFour => ends.three(Degrees::FourThreeFour, durations),
            TrajectoryKind::ThreeFiveThree => ends.three(Degrees::ThreeFiveThree, durations),
            TrajectoryKind::JerkLimited | TrajectoryKind::Blended => {
                ends.together(arm, kind).map(Curve::Timed)
            }
        }
    }

    pub(super) fn duration(&self) -> f64 {
        match self {
            Curve::Quintic(joints) => joints.first().map_or(0.0, Quintic::duration),
            Curve::Three(joints) => joints.first().map_or(0.0, |joint| joint.times()[3]),
            Curve::Timed(joints) => joints.duration(),
        }
    }

    pub(super) fn at(&self, time: f64) -> Vec<State> {
        match self {
            Curve::Quintic(joints) => joints.iter().map(|joint| joint.at(time)).collect(),
            Curve::Three(joints) => joints.iter().map(|joint| joint.at(time)).collect(),
            Curve::Timed(joints) => joints.at(time),
        }
    }

    pub(super) fn slowest(&self) -> Option<usize> {
        match self {
            Curve::Quintic(_) | Curve::Three(_) => None,
            Curve::Timed(joints) => joints.slowest(),
        }
    }

    /// When the via points are passed, and how far away.
    pub(super) fn via(&self, via: &[Vec<f64>]) -> Vec<(f64, Vec<f64>)> {
        match self {
            Curve::Quintic(_) => Vec::new(),
            Curve::Three(joints) => {
                let times = joints.first().map_or([0.0; 4], ThreeSegments::times);
                let inner = times.into_iter().skip(1).zip(via);
                inner
                    .map(|(time, point)| {
                        let states = self.at(time);
                        let off = states.iter().zip(point);
                        (time, off.map(|(s, p)| (s.position - p).abs()).collect())
                    })
                    .collect()
            }
            Curve::Timed(joints) => joints.passed(),
        }
    }

    /// The exact peaks where they are known: between two samples there may be more.
    pub(super) fn refine(&self, arm: &Arm, peaks: &mut [TrajectoryPeaks]) {
        let extremes: Vec<Extremes> = match self {
            Curve::Quintic(joints) => joints.iter().map(Quintic::extremes).collect(),
            Curve::Three(joints) => joints.iter().map(ThreeSegments::extremes).collect(),
            Curve::Timed(_) => return,
        };
        let joints = arm.serial.joint_list().iter().zip(extremes);
        for (peaks, (joint, extremes)) in peaks.iter_mut().zip(joints) {
            let own = |value: f64| shown(joint.kind.shown(value));
            peaks.velocity_deg_mm_s = own(extremes.velocity);
            peaks.acceleration_deg_mm_s2 = own(extremes.acceleration);
        }
    }
}

impl Ends<'_> {
    fn quintic(&self) -> Result<Curve, Refusal> {
        let duration = self.duration.unwrap_or(0.0);
        let all = self.start.iter().zip(self.goal).enumerate();
        let joints = all.map(|(index, (start, goal))| {
            Quintic::try_new(*start, *goal, 0.0, duration)
                .map_err(|error| polynomial_refusal(index, &error))
        });
        Ok(Curve::Quintic(joints.collect::<Result<_, _>>()?))
    }

    fn three(&self, degrees: Degrees, durations: &[f64]) -> Result<Curve, Refusal> {
        let [first, second, third] = *durations else {
            return Err(impossible("durations_s", "three are needed"));
        };
        let times = [0.0, first, first + second, first + second + third];
        let all = self.start.iter().zip(self.goal).enumerate();
        let joints = all.map(|(index, (start, goal))| {
            let via = |point: usize| {
                let point = self.via.get(point).and_then(|point| point.get(index));
                point.copied().unwrap_or(start.position)
            };
            ThreeSegments::try_new(degrees, *start, [via(0), via(1)], *goal, times)
                .map_err(|error| polynomial_refusal(index, &error))
        });
        Ok(Curve::Three(joints.collect::<Result<_, _>>()?))
    }

    /// By the number of joints, which the planners know at compile time.
    fn together(&self, arm: &Arm, kind: TrajectoryKind) -> Result<Box<dyn Timed>, Refusal> {
        match self.start.len() {
            4 => self.of::<4>(arm, kind),
            5 => self.of::<5>(arm, kind),
            6 => self.of::<6>(arm, kind),
            7 => self.of::<7>(arm, kind),
            joints => {
                let detail = format!("{} has {joints} joints; it must be 4 to 7", arm.name());
                Err(Refusal::invalid("kind", detail))
            }
        }
    }

    fn of<const N: usize>(
        &self,
        arm: &Arm,
        kind: TrajectoryKind,
    ) -> Result<Box<dyn Timed>, Refusal> {
        let limits: [MotionLimits; N] = fixed(self.limits)?;
        if kind == TrajectoryKind::Blended {
            for (end, states) in [("start", self.start), ("goal", self.goal)] {
                at_rest(end, states)?;
            }
            let place = |states: &[State]| -> Vec<f64> {
                states.iter().map(|state| state.position).collect()
            };
            let mut points: Vec<[f64; N]> = vec![fixed(&place(self.start))?];
            for via in self.via {
                points.push(fixed(via)?);
            }
            points.push(fixed(&place(self.goal))?);
            let planned = BlendedMove::try_new(&points, &fixed(self.ranges)?, &limits)
                .map_err(|error| blend_refusal(&error))?;
            return Ok(Box::new(planned));
        }
        let (start, goal): ([State; N], [State; N]) = (fixed(self.start)?, fixed(self.goal)?);
        let planned = match self.duration {
            None => JointMove::try_new(&start, &goal, &limits),
            Some(duration) => JointMove::try_lasting(&start, &goal, &limits, duration),
        };
        let planned = planned.map_err(|error| move_refusal(arm, &error))?;
        Ok(Box::new(planned))
    }
}

fn fixed<T: Copy, const N: usize>(list: &[T]) -> Result<[T; N], Refusal> {
    // All lists were made one number a joint.
    list.try_into()
        .map_err(|_| Refusal::invalid("", format!("{} numbers for {N} joints", list.len())))
}

fn at_rest(end: &str, states: &[State]) -> Result<(), Refusal> {
    for (index, state) in states.iter().enumerate() {
        for (key, value) in [
            ("velocity_deg_mm_s", state.velocity),
            ("acceleration_deg_mm_s2", state.acceleration),
        ] {
            if value != 0.0 {
                let path = format!("{end}.{key}[{index}]");
                return Err(Refusal::invalid(
                    path,
                    "a blended trajectory is at rest at both ends",
                ));
            }
        }
    }
    Ok(())
}

fn polynomial_refusal(index: usize, error: &TrajectoryError) -> Refusal {
    let detail = format!("joint {}: {error}", index + 1);
    impossible("durations_s", detail)
}

/// The joint's name in the place of its number, and numbers in the units of the edge.
fn move_refusal(arm: &Arm, error: &MoveError) -> Refusal {
    let joint_of = |number: usize| arm.serial.joint_list().get(number.saturating_sub(1));
    match *error {
        MoveError::Impossible {
            joint,
            duration,
            next,
        } => {
            let name = joint_of(joint).map_or("", |joint| joint.name.as_str());
            let detail = format!(
                "{name} cannot arrive after {duration} s; the next time it can is {next:.6} s"
            );
            Refusal {
                min: Some(next),
                ..impossible("durations_s[0]", detail).with_value(duration)
            }
        }
        MoveError::OutsideLimits {
            joint,
            end,
            quantity,
            value,
            limit,
        } => {
            let Some(of) = joint_of(joint) else {
                return Refusal::invalid(end, error);
            };
            let (key, unit) = match quantity {
                Quantity::Velocity | Quantity::UnavoidableVelocity => ("velocity_deg_mm_s", "/s"),
                Quantity::Acceleration => ("acceleration_deg_mm_s2", "/s2"),
                Quantity::Jerk => ("acceleration_deg_mm_s2", "/s3"),
            };
            let (value, limit) = (shown(of.kind.shown(value)), shown(of.kind.shown(limit)));
            let unit = format!("{}{unit}", of.kind.unit());
            let detail = format!(
                "{}: the {quantity} is {value} {unit}, its limit is {limit} {unit}",
                of.name
            );
            Refusal {
                min: Some(-limit),
                max: Some(limit),
                ..Refusal::new(
                    RefusalKind::JointLimit,
                    format!("{end}.{key}[{}]", joint.saturating_sub(1)),
                    detail,
                )
                .with_value(value)
            }
        }
        MoveError::NoJoints
        | MoveError::NotFinite { .. }
        | MoveError::Limit { .. }
        | MoveError::Duration { .. }
        | MoveError::Digits { .. } => Refusal::invalid("", error),
    }
}

/// Points count from 1, start first.
fn blend_refusal(error: &BlendError) -> Refusal {
    match error {
        BlendError::SamePoint { first } => {
            let path = match first {
                1 => "via_deg_mm[0]".to_owned(),
                later => format!("via_deg_mm[{}]", later - 1),
            };
            Refusal::invalid(path, error)
        }
        BlendError::Points { .. }
        | BlendError::NoJoints
        | BlendError::NotFinite { .. }
        | BlendError::Unreachable { .. }
        | BlendError::Limit { .. }
        | BlendError::Range { .. } => Refusal::invalid("via_deg_mm", error),
    }
}
