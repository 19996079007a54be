//! Reachability maps: which of many poses an arm reaches, and in how many ways.
#![expect(
    clippy::inline_always,
    reason = "a function with AVX2 is made of what is inlined into it"
)]

use std::num::NonZeroUsize;

use crate::batch::{Display, Group, solve_group_with};
use crate::joints::Axis;
use crate::lanes::{LANES, Simd, dispatch};
use crate::limits::ROUNDING_DEG;
use crate::model::ArmModel;
use crate::pose::Pose;

/// More threads than this are no help, and cost memory.
const MAX_THREADS: usize = 256;

/// How an arm reaches a pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Reach {
    /// Joint sets that reach it, inside the limits or not: 0 is out of reach.
    pub solutions: u8,
    /// Of these, the ones inside the limits, on whatever turn.
    pub inside: u8,
}

/// Why there is no map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReachError {
    /// Too many threads were asked for.
    #[error("{threads} threads were asked for; the most is {max}")]
    Threads {
        /// How many.
        threads: usize,
        /// How many are allowed.
        max: usize,
    },
}

impl ArmModel {
    /// How the arm reaches each of `poses`, in order, computed by `threads` threads.
    ///
    /// The same closed form as [`Self::inverse_batch`]; singular poses count the one joint set of
    /// each family that [`Self::inverse_all`] gives.
    ///
    /// # Errors
    /// More than 256 threads.
    pub fn reachability(
        &self,
        poses: &[Pose],
        threads: NonZeroUsize,
    ) -> Result<Vec<Reach>, ReachError> {
        if threads.get() > MAX_THREADS {
            return Err(ReachError::Threads {
                threads: threads.get(),
                max: MAX_THREADS,
            });
        }
        let mut map = vec![Reach::default(); poses.len()];
        let share = poses.len().div_ceil(threads.get()).next_multiple_of(LANES);
        if share >= poses.len() {
            self.fill(poses, &mut map);
            return Ok(map);
        }
        std::thread::scope(|scope| {
            for (poses, map) in poses.chunks(share).zip(map.chunks_mut(share)) {
                let _ = scope.spawn(move || self.fill(poses, map));
            }
        });
        Ok(map)
    }

    fn fill(&self, poses: &[Pose], map: &mut [Reach]) {
        dispatch!(self.level, simd => self.fill_with(simd, poses, map));
    }

    #[inline(always)]
    fn fill_with<S: Simd>(&self, simd: S, poses: &[Pose], map: &mut [Reach]) {
        let limits = Axis::ALL.map(|axis| {
            let limits = self.limits(axis);
            (
                (limits.min.0 - ROUNDING_DEG).to_radians(),
                (limits.max.0 + ROUNDING_DEG).to_radians(),
            )
        });
        let display = Display::of(self);
        let mut group = Group::none();
        for (poses, map) in poses.chunks(LANES).zip(map.chunks_mut(LANES)) {
            solve_group_with(simd, self, &display, poses, &mut group);
            for (reach, (solutions, inside)) in map.iter_mut().zip(group.count(simd, &limits)) {
                *reach = Reach { solutions, inside };
            }
        }
    }
}
