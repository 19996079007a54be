//! A motion with its place in path time.

use std::time::Duration;

use kinematics::PendantJoints;

use super::super::corner::{Blend, overlap_of_a_corner, sum};
use super::super::path::{Path, along};

/// A planned motion with whatever its owner wants back when it ends.
#[derive(Clone, Debug)]
pub struct Motion<T> {
    /// Where to and how fast.
    pub path: Path,
    /// `CNT`: how much the corner behind it may be rounded, 0 to 100. `None` ends at a standstill.
    pub rounding: Option<f64>,
    /// The owner's notes: id, program, peer.
    pub tag: T,
}

/// A motion that runs, or is about to.
#[derive(Debug)]
pub(super) struct Leg<T> {
    pub(super) motion: Motion<T>,
    /// Path time of its start.
    pub(super) begin: f64,
    /// The way around the corner before it.
    blend: Option<Blend>,
    pub(super) started: Duration,
    /// Whether the program was told to go on.
    pub(super) passed: bool,
}

impl<T> Leg<T> {
    pub(super) fn first(motion: Motion<T>, now: Duration) -> Self {
        Self {
            motion,
            begin: 0.0,
            blend: None,
            started: now,
            passed: false,
        }
    }

    /// Behind the leg `before`, not earlier than path time `earliest`.
    ///
    /// `round` plans the way around the corner for so many seconds of overlap.
    pub(super) fn behind(
        before: &Leg<T>,
        motion: Motion<T>,
        earliest: f64,
        round: impl FnOnce(&Path, &Path, f64) -> Option<Blend>,
    ) -> Self {
        let end = before.end();
        let percent = before.motion.rounding;
        let (one, other) = (&before.motion.path, &motion.path);
        let overlap = percent.map_or(0.0, |n| overlap_of_a_corner(n, one, Some(other)));
        let begin = (end - overlap).max(earliest).min(end);
        let overlap = end - begin;
        let blend = (overlap > NO_OVERLAP)
            .then(|| round(one, other, overlap))
            .flatten();
        Self {
            begin: if blend.is_some() { begin } else { end },
            blend,
            started: Duration::ZERO,
            motion,
            passed: false,
        }
    }

    pub(super) fn end(&self) -> f64 {
        self.begin + self.motion.path.duration()
    }

    /// Path time from which on the program goes on and the next motion may begin.
    pub(super) fn pass(&self) -> Option<f64> {
        let percent = self.motion.rounding?;
        Some(self.end() - overlap_of_a_corner(percent, &self.motion.path, None))
    }

    pub(super) fn at(&self, path_time: f64) -> PendantJoints {
        self.motion.path.at_time(path_time - self.begin)
    }

    /// Where the arm is while it goes around the corner from `before` to this leg.
    pub(super) fn around(&self, before: &Leg<T>, path_time: f64) -> PendantJoints {
        if let Some(Blend::Sampled(samples)) = &self.blend {
            let share = (path_time - self.begin) / (before.end() - self.begin);
            if let Some(joints) = along(samples, share) {
                return joints;
            }
        }
        let corner = before.motion.path.to();
        sum(&before.at(path_time), &self.at(path_time), corner)
    }

    /// How long it would take to brake from this path time, as [`Path::braking`].
    pub(super) fn braking(&self, path_time: f64) -> (f64, f64) {
        self.motion.path.braking(path_time - self.begin)
    }
}

/// A shorter overlap is none, s.
const NO_OVERLAP: f64 = 1e-6;
