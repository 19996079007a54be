//! How close a posture is to a singularity.

use std::fmt;

/// The three singularities of an arm with a spherical wrist.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SingularityKind {
    /// Axes 4 and 6 in one line: J4 and J6 turn the tool alike.
    Wrist,
    /// The wrist center on axis 1: J1 does not move it.
    Shoulder,
    /// Upper arm and forearm in one line: the arm reaches no farther.
    Elbow,
}

impl fmt::Display for SingularityKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            SingularityKind::Wrist => "wrist",
            SingularityKind::Shoulder => "shoulder",
            SingularityKind::Elbow => "elbow",
        })
    }
}

/// How far a posture is from each singularity: 0 is singular, 1 is as far as can be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Singularity {
    /// `|sin J5|`.
    pub wrist: f64,
    /// The distance of the wrist center from axis 1 (from the plane's offset, if there is one) as a
    /// part of the reach.
    pub shoulder: f64,
    /// The sine of the angle between upper arm and forearm.
    pub elbow: f64,
}

impl Singularity {
    /// A wrist closer than this is near a singularity: about 3 degrees of J5.
    pub const NEAR_WRIST: f64 = 0.05;
    /// A wrist center closer to axis 1 than this part of the reach is near a singularity.
    pub const NEAR_SHOULDER: f64 = 0.02;
    /// An elbow straighter than this is near a singularity: about 3 degrees of J3.
    pub const NEAR_ELBOW: f64 = 0.05;

    /// The singularity this posture is closest to, and the measure of it.
    #[must_use]
    pub fn nearest(&self) -> (SingularityKind, f64) {
        let mut nearest = (SingularityKind::Wrist, self.wrist);
        for candidate in [
            (SingularityKind::Shoulder, self.shoulder),
            (SingularityKind::Elbow, self.elbow),
        ] {
            if candidate.1 < nearest.1 {
                nearest = candidate;
            }
        }
        nearest
    }

    /// The singularities nearer than their thresholds.
    pub fn near(&self) -> impl Iterator<Item = SingularityKind> {
        [
            (SingularityKind::Wrist, self.wrist < Self::NEAR_WRIST),
            (
                SingularityKind::Shoulder,
                self.shoulder < Self::NEAR_SHOULDER,
            ),
            (SingularityKind::Elbow, self.elbow < Self::NEAR_ELBOW),
        ]
        .into_iter()
        .filter_map(|(kind, near)| near.then_some(kind))
    }
}
