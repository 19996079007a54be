//! What a path asks of the joints at a given pace.

use kinematics::{ArmModel, Axis, PendantJoints};

use crate::jerk::Progress;

/// The most that is asked of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// The joint.
    pub joint: Axis,
    /// Where on the path, from 0 to 1.
    pub parameter: f64,
    /// As a part of what it can.
    pub share: f64,
}

/// The hardest demands of a move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demands {
    /// Of the speeds.
    pub speed: Demand,
    /// Of the accelerations.
    pub acceleration: Demand,
}

impl Demands {
    /// Of a move that goes through `joints`, which are equally far apart on its path, with this progress.
    ///
    /// With the joints' derivatives by the parameter, measured between neighbors, the speeds are `q' s.` and the
    /// accelerations `q'' s.^2 + q' s..`. The bend `q''` is a mean over the time in which a joint builds its acceleration
    /// up: what is shorter, such as the step of the turning at the via point of an arc, its jerk limit smooths.
    #[must_use]
    pub fn of(arm: &ArmModel, joints: &[PendantJoints], progress: &Progress) -> Demands {
        let pace = Pace { arm, progress };
        Demands {
            speed: pace.hardest_speed(joints),
            acceleration: pace.hardest_acceleration(joints),
        }
    }
}

struct Pace<'a> {
    arm: &'a ArmModel,
    progress: &'a Progress,
}

impl Pace<'_> {
    /// Of the parameter: per second, and per second squared.
    fn at(&self, parameter: f64) -> (f64, f64) {
        let way = self.progress.way();
        let state = self.progress.at(self.progress.reaches(parameter * way));
        (state.velocity / way, state.acceleration / way)
    }

    fn hardest_speed(&self, joints: &[PendantJoints]) -> Demand {
        let mut hardest = Demand::none();
        let steps = steps_of(joints);
        let mut place = 0.5;
        for (a, b) in joints.iter().zip(joints.iter().skip(1)) {
            let parameter = place / steps;
            let (rate, _) = self.at(parameter);
            for joint in Axis::ALL {
                let change = (b.of(joint).0 - a.of(joint).0) * steps;
                let share = change.abs() * rate / self.arm.max_speed(joint).0;
                hardest.raise(joint, parameter, share);
            }
            place += 1.0;
        }
        hardest
    }

    fn hardest_acceleration(&self, joints: &[PendantJoints]) -> Demand {
        let mut hardest = Demand::none();
        let steps = steps_of(joints);
        let builds_up = Axis::ALL
            .map(|joint| self.arm.max_acceleration(joint).0 / self.arm.max_jerk(joint).0)
            .into_iter()
            .fold(0.0, f64::max);
        let window = builds_up * self.progress.peak() / self.progress.way() * steps;
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "not negative, and clamped to the number of joints"
        )]
        let stride = (window.ceil() as usize).clamp(1, (joints.len() / 4).max(1));
        #[expect(clippy::cast_precision_loss, reason = "a few thousand joints")]
        let part = stride as f64 / steps;
        let mut place = 1.0;
        let threes = joints
            .iter()
            .zip(joints.iter().skip(1))
            .zip(joints.iter().skip(2));
        for (index, ((before, here), after)) in threes.enumerate() {
            // The way bends at an end as it does a stride from there.
            let least = (index + 1).saturating_sub(stride);
            let first = least.min(joints.len().saturating_sub(2 * stride + 1));
            let at = |strides: usize| joints.get(first + strides * stride).unwrap_or(here);
            let (a, b, c) = (at(0), at(1), at(2));
            let parameter = place / steps;
            let (rate, slope) = self.at(parameter);
            for joint in Axis::ALL {
                let first = 0.5 * (after.of(joint).0 - before.of(joint).0) * steps;
                let bend = c.of(joint).0 - 2.0 * b.of(joint).0 + a.of(joint).0;
                let needed = bend / (part * part) * rate * rate + first * slope;
                let share = needed.abs() / self.arm.max_acceleration(joint).0;
                hardest.raise(joint, parameter, share);
            }
            place += 1.0;
        }
        hardest
    }
}

impl Demand {
    fn none() -> Demand {
        Demand {
            joint: Axis::J1,
            parameter: 0.0,
            share: 0.0,
        }
    }

    fn raise(&mut self, joint: Axis, parameter: f64, share: f64) {
        if share > self.share {
            *self = Demand {
                joint,
                parameter,
                share,
            };
        }
    }
}

#[expect(clippy::cast_precision_loss, reason = "a few thousand joints")]
fn steps_of(joints: &[PendantJoints]) -> f64 {
    joints.len().saturating_sub(1) as f64
}
