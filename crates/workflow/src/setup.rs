//! What the integrator configured: arms, mobile robots, points, places, taught poses, loads.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::custody::Location;
use crate::job::params::NewJob;
use crate::signal::SignalKind;
use crate::timers::Timers;

/// The whole configuration. [`Setup::check`] says what does not fit together.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setup {
    /// The arms' ids.
    pub arms: Vec<String>,
    /// Mobile robots and their slots.
    pub mobile_robots: Vec<MobileRobotSetup>,
    /// Load handling points (LHP).
    pub points: Vec<Point>,
    /// Fixed slots and reject slots.
    pub places: Vec<Place>,
    /// Which arm was taught which place.
    pub taught: Vec<Taught>,
    /// Loads and where they are when the first fact is folded.
    pub loads: Vec<LoadSetup>,
    /// Where a mobile robot may be sent with loads.
    #[serde(default)]
    pub destinations: Vec<String>,
    /// Jobs that a signal starts.
    #[serde(default)]
    pub triggers: Vec<Trigger>,
    /// Durations and attempts.
    #[serde(default)]
    pub timers: Timers,
}

/// A mobile robot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MobileRobotSetup {
    /// Its id.
    pub id: String,
    /// Names of its slots.
    pub slots: Vec<String>,
    /// The fastest it can drive, in mm/s. Where its pose goes farther between two signals, it does not know where it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_speed_mm_s: Option<u32>,
}

/// A load handling point: where one mobile robot docks and the arms of `arms` reach its slots.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Point {
    /// `station/point`.
    pub id: String,
    /// Arms that reach it.
    pub arms: Vec<String>,
    /// The hand-over zone that arm and mobile robot share.
    pub zone: String,
    /// Nominal dock pose in the cell frame.
    pub dock: BasePose,
    /// How far a docked pose may be from `dock`.
    pub tolerance: Tolerance,
    /// Way points toward the point, passed on to the mobile robot.
    #[serde(default)]
    pub route: Vec<BasePose>,
}

/// Pose of a mobile robot in the cell frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BasePose {
    /// Along the cell's x, millimeters.
    pub x_mm: f64,
    /// Along the cell's y, millimeters.
    pub y_mm: f64,
    /// Counter-clockwise from the cell's x, degrees.
    pub heading_deg: f64,
}

impl BasePose {
    /// Whether `self` is within `tolerance` of `other`. A pose that is not finite is not.
    #[must_use]
    pub fn within(&self, other: &Self, tolerance: Tolerance) -> bool {
        let distance = (self.x_mm - other.x_mm).hypot(self.y_mm - other.y_mm);
        let turn = (self.heading_deg - other.heading_deg + 180.0).rem_euclid(360.0) - 180.0;
        distance <= tolerance.mm && turn.abs() <= tolerance.deg
    }
}

/// How far two poses may be apart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tolerance {
    /// Distance, millimeters.
    pub mm: f64,
    /// Angle, degrees.
    pub deg: f64,
}

/// A slot that does not move.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    /// For example `rack/a`.
    pub id: String,
    /// Fixed or reject.
    pub kind: PlaceKind,
    /// Types of loads it takes; empty: every type.
    #[serde(default)]
    pub accepts: Vec<String>,
}

/// What a place is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum PlaceKind {
    /// One load at a time.
    Fixed,
    /// A bin for loads nobody wants: takes any number.
    Reject,
}

/// A place as an arm sees it.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(tag = "on", rename_all = "snake_case")]
pub enum PlaceRef {
    /// A fixed or reject place.
    Fixed {
        /// Its id.
        place: String,
    },
    /// A slot of whatever mobile robot is docked at a point.
    MobileRobot {
        /// `station/point`.
        point: String,
        /// The slot's name.
        slot: String,
    },
}

impl PlaceRef {
    /// A fixed place.
    pub fn fixed(place: impl Into<String>) -> Self {
        Self::Fixed {
            place: place.into(),
        }
    }

    /// Whether an arm has to enter a hand-over zone to reach it.
    #[must_use]
    pub const fn in_zone(&self) -> bool {
        matches!(self, Self::MobileRobot { .. })
    }
}

impl std::fmt::Display for PlaceRef {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Fixed { place } => f.write_str(place),
            Self::MobileRobot { point, slot } => write!(f, "{slot} at {point}"),
        }
    }
}

/// An arm was taught a place.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Taught {
    /// The arm.
    pub arm: String,
    /// The place; a slot of a mobile robot at the nominal dock pose.
    pub place: PlaceRef,
}

/// A load that exists from the beginning.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadSetup {
    /// Its id.
    pub id: String,
    /// Its type, compared with [`Place::accepts`].
    #[serde(rename = "type")]
    pub kind: String,
    /// Where it is at first.
    pub at: Location,
}

/// A signal that starts a job: of a mobile robot that comes by itself, without an order of the cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Trigger {
    /// Its id, shown as the job's origin.
    pub id: String,
    /// It starts jobs.
    pub enabled: bool,
    /// The signal, usually `MR_ARRIVED`. Never a heartbeat: those are not kept, so nothing may follow from one.
    pub signal: SignalKind,
    /// Only of this mobile robot; `None`: of any.
    pub mobile_robot: Option<String>,
    /// The points of which the signal has to name one in `at_point`; empty: wherever it is.
    pub points: Vec<String>,
    /// How long after the signal the job has to have started.
    pub deadline_ms: Option<crate::ids::Millis>,
    /// The job. Where it names no mobile robot, it is for the one that signaled.
    pub job: NewJob,
}

impl Trigger {
    /// Whether it is meant.
    pub(crate) fn is_meant(&self, signal: &crate::signal::Signal) -> bool {
        let at = signal.state.at_point.as_ref();
        self.enabled
            && self.signal == signal.kind
            && self
                .mobile_robot
                .as_ref()
                .is_none_or(|only| *only == signal.mobile_robot)
            && (self.points.is_empty() || at.is_some_and(|at| self.points.contains(at)))
    }
}

/// Why a configuration cannot be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{item}: {problem}")]
pub struct SetupError {
    /// The item, as a path.
    pub item: String,
    /// What is wrong with it.
    pub problem: String,
}

impl Setup {
    /// Everything that does not fit together, all of it at once.
    #[must_use]
    pub fn check(&self) -> Vec<SetupError> {
        let mut errors = Vec::new();
        let mut say = |item: String, problem: &str| {
            errors.push(SetupError {
                item,
                problem: problem.to_owned(),
            });
        };
        for (name, ids) in [
            ("arms", self.arms.iter().collect::<Vec<_>>()),
            (
                "mobile_robots",
                self.mobile_robots.iter().map(|m| &m.id).collect(),
            ),
            ("points", self.points.iter().map(|p| &p.id).collect()),
            ("places", self.places.iter().map(|p| &p.id).collect()),
            ("loads", self.loads.iter().map(|l| &l.id).collect()),
            ("triggers", self.triggers.iter().map(|t| &t.id).collect()),
        ] {
            let mut seen = BTreeSet::new();
            for id in ids {
                if id.is_empty() {
                    say(name.to_owned(), "an id is empty");
                }
                if !seen.insert(id) {
                    say(format!("{name}.{id}"), "the id is used twice");
                }
            }
        }
        for point in &self.points {
            for arm in &point.arms {
                if !self.arms.contains(arm) {
                    say(
                        format!("points.{}.arms", point.id),
                        &format!("unknown arm {arm}"),
                    );
                }
            }
            let limits = [point.tolerance.mm, point.tolerance.deg];
            if limits.iter().any(|l| !l.is_finite() || *l <= 0.0) {
                say(
                    format!("points.{}.tolerance", point.id),
                    "has to be finite and above 0",
                );
            }
            let dock = [point.dock.x_mm, point.dock.y_mm, point.dock.heading_deg];
            if dock.iter().any(|v| !v.is_finite()) {
                say(format!("points.{}.dock", point.id), "has to be finite");
            }
        }
        for taught in &self.taught {
            if !self.arms.contains(&taught.arm) {
                say(
                    format!("taught.{}", taught.place),
                    &format!("unknown arm {}", taught.arm),
                );
            }
            if !self.knows(&taught.place) {
                say(format!("taught.{}", taught.place), "unknown place");
            }
        }
        let mut taken = BTreeSet::new();
        for load in &self.loads {
            let known = match &load.at {
                Location::Fixed { place } => self.place(place).is_some(),
                Location::MobileRobot { mobile_robot, slot } => self
                    .mobile_robot(mobile_robot)
                    .is_some_and(|m| m.slots.contains(slot)),
                Location::Gripper { arm } => self.arms.contains(arm),
                Location::Delivered { destination } => self.destinations.contains(destination),
                Location::Unknown { .. } => true,
            };
            if !known {
                say(format!("loads.{}.at", load.id), "unknown place");
            }
            if self.is_single(&load.at) && !taken.insert(&load.at) {
                say(format!("loads.{}.at", load.id), "another load is there");
            }
        }
        for trigger in &self.triggers {
            if self.point(&trigger.job.point).is_none() {
                say(
                    format!("triggers.{}.job.point", trigger.id),
                    "unknown point",
                );
            }
            if trigger.signal == SignalKind::MrHeartbeat {
                say(format!("triggers.{}.signal", trigger.id), "is not kept");
            }
            let robots = [&trigger.mobile_robot, &trigger.job.mobile_robot];
            let unknown = |id: &&String| self.mobile_robot(id).is_none();
            if robots.into_iter().flatten().any(|id| unknown(&id)) {
                say(
                    format!("triggers.{}.mobile_robot", trigger.id),
                    "unknown mobile robot",
                );
            }
        }
        errors
    }

    /// A point by its id.
    #[must_use]
    pub fn point(&self, id: &str) -> Option<&Point> {
        self.points.iter().find(|p| p.id == id)
    }

    /// A fixed place by its id.
    #[must_use]
    pub fn place(&self, id: &str) -> Option<&Place> {
        self.places.iter().find(|p| p.id == id)
    }

    /// A mobile robot by its id.
    #[must_use]
    pub fn mobile_robot(&self, id: &str) -> Option<&MobileRobotSetup> {
        self.mobile_robots.iter().find(|m| m.id == id)
    }

    /// Whether `arm` was taught `place`.
    #[must_use]
    pub fn is_taught(&self, arm: &str, place: &PlaceRef) -> bool {
        self.taught
            .iter()
            .any(|t| t.arm == arm && t.place == *place)
    }

    fn knows(&self, place: &PlaceRef) -> bool {
        match place {
            PlaceRef::Fixed { place } => self.place(place).is_some(),
            PlaceRef::MobileRobot { point, slot } => {
                self.point(point).is_some()
                    && self.mobile_robots.iter().any(|m| m.slots.contains(slot))
            }
        }
    }

    /// Whether a location holds one load only.
    pub(crate) fn is_single(&self, at: &Location) -> bool {
        match at {
            Location::Fixed { place } => {
                self.place(place).is_none_or(|p| p.kind == PlaceKind::Fixed)
            }
            Location::Gripper { .. } | Location::MobileRobot { .. } => true,
            Location::Delivered { .. } | Location::Unknown { .. } => false,
        }
    }
}
