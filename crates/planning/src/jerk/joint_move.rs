//! Several joints that start and arrive together.

use std::fmt;

use super::axis::{Axis, Profile};
use super::side::Task;
use crate::state::{NotFinite, State};

/// What a joint may do at most, in either direction: rad/s, rad/s², rad/s³ (or mm).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionLimits {
    /// The highest speed.
    pub velocity: f64,
    /// The highest acceleration.
    pub acceleration: f64,
    /// The highest jerk.
    pub jerk: f64,
}

/// What a limit is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The velocity of a state.
    Velocity,
    /// The acceleration of a state.
    Acceleration,
    /// The jerk.
    Jerk,
    /// The velocity that a state cannot avoid: the one a start's acceleration still leads to, or a
    /// goal's acceleration came from.
    UnavoidableVelocity,
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Quantity::Velocity => "velocity",
            Quantity::Acceleration => "acceleration",
            Quantity::Jerk => "jerk",
            Quantity::UnavoidableVelocity => "velocity that its acceleration entails",
        })
    }
}

/// Why a move was refused. Joints count from 1.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MoveError {
    /// A move of no joints.
    #[error("a move needs at least one joint")]
    NoJoints,
    /// A state that is no state.
    #[error("joint {joint}, {end}: {source}")]
    NotFinite {
        /// Which joint.
        joint: usize,
        /// `start` or `goal`.
        end: &'static str,
        /// What is wrong with it.
        source: NotFinite,
    },
    /// A limit that is no limit.
    #[error(
        "joint {joint}: the limit of the {quantity} is {value}; it must be a number from 1e-9 to 1e9"
    )]
    Limit {
        /// Which joint.
        joint: usize,
        /// Of what.
        quantity: Quantity,
        /// What was given.
        value: f64,
    },
    /// A state that the limits exclude.
    #[error("joint {joint}, {end}: the {quantity} is {value}, its limit is {limit}")]
    OutsideLimits {
        /// Which joint.
        joint: usize,
        /// `start` or `goal`.
        end: &'static str,
        /// Of what.
        quantity: Quantity,
        /// What it is.
        value: f64,
        /// What it may be, in either direction.
        limit: f64,
    },
    /// A duration that is no duration.
    #[error("the duration is {value} s; it must be a positive, finite number")]
    Duration {
        /// What was given.
        value: f64,
    },
    /// No profile of this joint lasts exactly so long.
    #[error("joint {joint} cannot arrive after {duration} s; the next time it can is {next} s")]
    Impossible {
        /// Which joint.
        joint: usize,
        /// The time wanted.
        duration: f64,
        /// The shortest time that is longer and possible.
        next: f64,
    },
    /// The numbers are so far apart that nothing is left of the digits.
    #[error("joint {joint}: no profile was found; the states and limits span too many digits")]
    Digits {
        /// Which joint.
        joint: usize,
    },
}

/// A move of `N` joints from one set of states to another, within their limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointMove<const N: usize> {
    joints: [OneJoint; N],
    goal: [State; N],
    duration: f64,
    slowest: usize,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct OneJoint {
    start: State,
    jerk: f64,
    profile: Profile,
}

/// Limits and states are compared with this relative slack: they come out of other computations.
const ROUNDING: f64 = 1e-9;

impl<const N: usize> JointMove<N> {
    /// The shortest move.
    ///
    /// # Errors
    /// Names the joint and what is wrong with its state or limits; a state that its limits exclude
    /// is refused, not brought inside.
    pub fn try_new(
        start: &[State; N],
        goal: &[State; N],
        limits: &[MotionLimits; N],
    ) -> Result<JointMove<N>, MoveError> {
        let axes = axes(start, goal, limits)?;
        let mut found = [None; N];
        let (mut duration, mut slowest) = (0.0, 0);
        for (joint, (slot, axis)) in found.iter_mut().zip(&axes).enumerate() {
            let earliest = axis
                .earliest(0.0)
                .ok_or(MoveError::Digits { joint: joint + 1 })?;
            if earliest.time > duration {
                (duration, slowest) = (earliest.time, joint);
            }
            *slot = Some(earliest);
        }
        // A joint that starts or ends in motion may be unable to take exactly so long; the next
        // time it can may be too long for another one. The times only grow, and each joint has at
        // most a few gaps.
        'again: for _ in 0..8 * N + 8 {
            let mut joints = [OneJoint::nowhere(); N];
            let all = joints.iter_mut().zip(&mut found).zip(&axes).enumerate();
            for (joint, ((slot, found), axis)) in all {
                let earliest = found.ok_or(MoveError::Digits { joint: joint + 1 })?;
                let profile = if earliest.time.to_bits() == duration.to_bits() {
                    Some(earliest.profile)
                } else {
                    axis.lasting(duration)
                };
                let Some(profile) = profile else {
                    let next = axis
                        .earliest(duration)
                        .ok_or(MoveError::Digits { joint: joint + 1 })?;
                    *found = Some(next);
                    (duration, slowest) = (next.time, joint);
                    continue 'again;
                };
                slot.profile = profile;
            }
            return Ok(Self::from_profiles(
                joints, start, goal, limits, duration, slowest,
            ));
        }
        Err(MoveError::Digits { joint: slowest + 1 })
    }

    /// The move that takes exactly `duration` seconds.
    ///
    /// # Errors
    /// As [`Self::try_new`], and [`MoveError::Impossible`] with the next duration that the joint
    /// can keep.
    pub fn try_lasting(
        start: &[State; N],
        goal: &[State; N],
        limits: &[MotionLimits; N],
        duration: f64,
    ) -> Result<JointMove<N>, MoveError> {
        if !(duration > 0.0 && duration.is_finite()) {
            return Err(MoveError::Duration { value: duration });
        }
        let axes = axes(start, goal, limits)?;
        let mut joints = [OneJoint::nowhere(); N];
        for (joint, (slot, axis)) in joints.iter_mut().zip(&axes).enumerate() {
            let joint = joint + 1;
            slot.profile = if let Some(profile) = axis.lasting(duration) {
                profile
            } else {
                let next = axis.earliest(duration).ok_or(MoveError::Digits { joint })?;
                if next.time > duration * (1.0 + ROUNDING) {
                    return Err(MoveError::Impossible {
                        joint,
                        duration,
                        next: next.time,
                    });
                }
                next.profile
            };
        }
        Ok(Self::from_profiles(
            joints, start, goal, limits, duration, 0,
        ))
    }

    fn from_profiles(
        mut joints: [OneJoint; N],
        start: &[State; N],
        goal: &[State; N],
        limits: &[MotionLimits; N],
        duration: f64,
        slowest: usize,
    ) -> Self {
        for ((joint, start), limits) in joints.iter_mut().zip(start).zip(limits) {
            (joint.start, joint.jerk) = (*start, limits.jerk);
        }
        JointMove {
            joints,
            goal: *goal,
            duration,
            slowest,
        }
    }

    /// In seconds.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The joint, counted from 0, that the others wait for.
    #[must_use]
    pub fn slowest(&self) -> usize {
        self.slowest
    }

    /// The states `t` seconds after the start: before it the start, after the end the goal.
    #[must_use]
    pub fn at(&self, t: f64) -> [State; N] {
        if t >= self.duration {
            return self.goal;
        }
        self.joints.map(|joint| joint.at(t))
    }
}

impl OneJoint {
    fn nowhere() -> OneJoint {
        OneJoint {
            start: State::default(),
            jerk: 0.0,
            profile: Profile::Upper(super::phases::Phases::default()),
        }
    }

    fn at(&self, t: f64) -> State {
        let (start, jerk) = (self.start, self.jerk);
        let state = match &self.profile {
            Profile::Upper(phases) => phases.at(start, jerk, t),
            Profile::Lower(phases) => phases.at(start, -jerk, t),
            Profile::Mean {
                upper,
                lower,
                weight,
            } => {
                let (upper, lower) = (upper.at(start, jerk, t), lower.at(start, -jerk, t));
                let mean = |a: f64, b: f64| weight * a + (1.0 - weight) * b;
                State {
                    position: mean(upper.position, lower.position),
                    velocity: mean(upper.velocity, lower.velocity),
                    acceleration: mean(upper.acceleration, lower.acceleration),
                }
            }
        };
        if t <= 0.0 { start } else { state }
    }
}

fn axes<const N: usize>(
    start: &[State; N],
    goal: &[State; N],
    limits: &[MotionLimits; N],
) -> Result<[Axis; N], MoveError> {
    if N == 0 {
        return Err(MoveError::NoJoints);
    }
    let all = start.iter().zip(goal).zip(limits);
    for (index, ((start, goal), limits)) in all.clone().enumerate() {
        let joint = index + 1;
        check_limits(joint, limits)?;
        check_state(joint, "start", start, limits, 1.0)?;
        check_state(joint, "goal", goal, limits, -1.0)?;
    }
    let mut all = all.map(|((start, goal), limits)| {
        let task = Task {
            start: State {
                position: 0.0,
                ..*start
            },
            goal: *goal,
            velocity: limits.velocity,
            acceleration: limits.acceleration,
            jerk: limits.jerk,
        };
        Axis::new(task, goal.position - start.position)
    });
    // As many as there are places.
    Ok(std::array::from_fn(|_| {
        all.next().unwrap_or_else(Axis::nothing)
    }))
}

fn check_limits(joint: usize, limits: &MotionLimits) -> Result<(), MoveError> {
    let all = [
        (Quantity::Velocity, limits.velocity),
        (Quantity::Acceleration, limits.acceleration),
        (Quantity::Jerk, limits.jerk),
    ];
    all.into_iter().try_for_each(|(quantity, value)| {
        if (1e-9..=1e9).contains(&value) {
            Ok(())
        } else {
            Err(MoveError::Limit {
                joint,
                quantity,
                value,
            })
        }
    })
}

/// `sense` is 1 for a start, whose acceleration goes on, and -1 for a goal, whose came from before.
fn check_state(
    joint: usize,
    end: &'static str,
    state: &State,
    limits: &MotionLimits,
    sense: f64,
) -> Result<(), MoveError> {
    state
        .check_finite()
        .map_err(|source| MoveError::NotFinite { joint, end, source })?;
    let (v, a) = (state.velocity, state.acceleration);
    let entailed = v + 0.5 * sense * a * a.abs() / limits.jerk;
    let all = [
        (Quantity::Velocity, v, limits.velocity),
        (Quantity::Acceleration, a, limits.acceleration),
        (Quantity::UnavoidableVelocity, entailed, limits.velocity),
    ];
    all.into_iter().try_for_each(|(quantity, value, limit)| {
        if value.abs() <= limit * (1.0 + ROUNDING) {
            Ok(())
        } else {
            Err(MoveError::OutsideLimits {
                joint,
                end,
                quantity,
                value,
                limit,
            })
        }
    })
}
