//! The ways of a job to a taught pose and back: from the safe pose to the approach, the straight line to the pose, the
//! straight lift, and back to the safe pose; and what they do to the zones of the cell.

#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_CT is the tool T in the cell C"
)]

use std::fmt;

use api::setup::ZoneKind;
use kinematics::{Axis, Configuration, PendantJoints, Pose};

use super::geometry::DockPose;
use super::model::{Arm, Place, Setup, Site, Taught};
use super::path::{Closest, bodies, closest, joint_path, least_inside};
use super::resolve::{Dock, Resolved, reach};
use super::trespass::Trespass;

/// The distance between two samples of a straight line, in millimeters.
const STEP_MM: f64 = 5.0;
/// A joint that turns farther than this from one sample of a straight line to the next cannot follow it, in degrees.
const MAX_TURN_DEG: f64 = 15.0;

/// The samples of a straight line, as far as the arm can follow it.
#[derive(Debug)]
pub(super) struct Line {
    pub(super) points: Vec<Resolved>,
    pub(super) broken: Option<Broken>,
}

/// Where an arm cannot follow a straight line any farther, and why.
#[derive(Debug)]
pub(super) struct Broken {
    /// The distance from the beginning, in millimeters.
    pub(super) along_mm: f64,
    pub(super) why: String,
}

impl Line {
    pub(super) fn joints(&self) -> Vec<PendantJoints> {
        self.points.iter().map(|point| point.joints).collect()
    }
}

/// The straight line of the tool center point from one pose to another, in a configuration. The tool turns evenly.
pub(super) fn straight(
    arm: &Arm,
    from: &Pose,
    to: &Pose,
    configuration: Configuration,
    what: &'static str,
) -> Line {
    let length = (to.isometry().translation.vector - from.isometry().translation.vector).norm();
    let steps = (length / STEP_MM).ceil().max(1.0);
    let mut points: Vec<Resolved> = Vec::new();
    let mut step = 0.0;
    while step <= steps {
        let share = step / steps;
        let point = between(arm, [from, to], share, configuration, what).and_then(|point| {
            let jump = points
                .last()
                .and_then(|before| too_far(&before.joints, &point.joints));
            match jump {
                None => Ok(point),
                Some((axis, turn)) => Err(format!(
                    "{axis} would have to turn by {turn:.1} degrees within {:.1} mm",
                    length / steps
                )),
            }
        });
        match point {
            Ok(point) => points.push(point),
            Err(why) => {
                let along_mm = length * share;
                let broken = Some(Broken { along_mm, why });
                return Line { points, broken };
            }
        }
        step += 1.0;
    }
    Line {
        points,
        broken: None,
    }
}

/// A point of the line, after a share of its length.
fn between(
    arm: &Arm,
    [from, to]: [&Pose; 2],
    share: f64,
    configuration: Configuration,
    what: &'static str,
) -> Result<Resolved, String> {
    let between = from
        .isometry()
        .try_lerp_slerp(to.isometry(), share, 1e-9)
        .ok_or("the tool would turn by half a turn, and which way is not said")?;
    let X_CT = Pose::try_from_isometry(between).map_err(|error| error.to_string())?;
    reach(arm, &X_CT, configuration, what).map_err(|error| error.to_string())
}

/// The joint that turns too far from one sample to the next, if any does.
fn too_far(before: &PendantJoints, after: &PendantJoints) -> Option<(Axis, f64)> {
    Axis::ALL.into_iter().find_map(|axis| {
        let turn = (after.of(axis).0 - before.of(axis).0).abs();
        (turn > MAX_TURN_DEG).then_some((axis, turn))
    })
}

/// How an arm goes.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Shape {
    /// All joints together.
    Joint,
    /// The tool center point along a straight line.
    Straight,
}

impl Shape {
    /// The samples of the way from where an arm stands.
    ///
    /// # Errors
    /// Why the arm cannot follow the straight line.
    pub(crate) fn samples(
        self,
        arm: &Arm,
        start: &PendantJoints,
        to: &Resolved,
    ) -> Result<Vec<PendantJoints>, String> {
        match self {
            Self::Joint => Ok(joint_path(start, &to.joints)),
            Self::Straight => {
                let what = "the straight line";
                let line = straight(arm, &arm.tip(start), &to.X_CT, to.configuration, what);
                match &line.broken {
                    None => Ok(line.joints()),
                    Some(Broken { along_mm, why }) => {
                        Err(format!("{what}, {along_mm:.0} mm along: {why}"))
                    }
                }
            }
        }
    }
}

/// The ways to a taught pose and back.
#[derive(Debug)]
pub(super) struct Ways {
    pub(super) approach: Line,
    pub(super) lift: Line,
    /// All of them, as far as the arm can follow: what each is, and its samples.
    pub(super) paths: Vec<(&'static str, Vec<PendantJoints>)>,
}

impl Ways {
    /// The ways to a grip pose and back; where the arm cannot be, there is no way.
    pub(super) fn of(arm: &Arm, taught: &Taught, X_CT: &Pose) -> Self {
        let mut ways = Self::straight(arm, taught, X_CT);
        let mut paths = Vec::new();
        if let Some(first) = ways.approach.points.first() {
            let from_safe = joint_path(&arm.safe, &first.joints);
            paths.push(("the way from the safe pose to the approach", from_safe));
        }
        if let Some(last) = ways.lift.points.last() {
            let to_safe = joint_path(&last.joints, &arm.safe);
            paths.push(("the way from the lift to the safe pose", to_safe));
        }
        paths.append(&mut ways.paths);
        Self { paths, ..ways }
    }

    /// The straight ones of them.
    fn straight(arm: &Arm, taught: &Taught, X_CT: &Pose) -> Self {
        let line =
            |from: &Pose, to: &Pose, what| straight(arm, from, to, taught.configuration, what);
        let approach = line(&taught.approach_of(X_CT), X_CT, "approach");
        let lift = line(X_CT, &taught.lift_of(X_CT), "lift");
        let paths = vec![
            ("the approach", approach.joints()),
            ("the lift", lift.joints()),
        ];
        Self {
            approach,
            lift,
            paths,
        }
    }
}

/// How near a way comes to the zones that are none of its place's affair.
#[derive(Debug)]
pub(super) struct Met {
    pub(super) keep_out: Option<Closest>,
    /// Hand-over zones of other places.
    pub(super) foreign: Option<Closest>,
    /// Room in the work areas.
    pub(super) work: Option<Closest>,
}

/// A zone that a way does not respect.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Forbidden {
    pub(crate) kind: ZoneKind,
    /// The zone, the deepest point, and how deep: below 0.
    pub(crate) at: Closest,
}

impl fmt::Display for Forbidden {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let zone = &self.at.zone;
        match self.kind {
            ZoneKind::KeepOut => write!(f, "the arm enters the keep-out zone `{zone}`")?,
            ZoneKind::Handover => write!(
                f,
                "the arm enters the hand-over zone `{zone}`, which this place has no part in,"
            )?,
            ZoneKind::Work => {
                write!(f, "the tool center point leaves the work area `{zone}`")?;
            }
        }
        write!(f, " by {:.1} mm at {}", -self.at.gap.0, self.at.spot())
    }
}

impl Met {
    pub(super) fn forbidden(&self) -> impl Iterator<Item = Forbidden> {
        let all = [
            (ZoneKind::KeepOut, &self.keep_out),
            (ZoneKind::Handover, &self.foreign),
            (ZoneKind::Work, &self.work),
        ];
        all.into_iter().filter_map(|(kind, found)| {
            let at = found.as_ref().filter(|found| found.gap.0 < 0.0)?.clone();
            Some(Forbidden { kind, at })
        })
    }
}

/// A way of a job that leads where it may not.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ForbiddenWay {
    pub(crate) what: &'static str,
    /// Empty, or at which dock pose.
    pub(crate) docked: String,
    pub(crate) zone: Forbidden,
}

impl fmt::Display for ForbiddenWay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}: {}", self.what, self.docked, self.zone)
    }
}

impl Setup {
    /// What the samples of a way to or from a place do to the zones.
    pub(super) fn met(&self, arm: &Arm, place: &Place, samples: &[PendantJoints]) -> Met {
        let bodies = bodies(arm, samples);
        let own = self.zone_of(place);
        let foreign = self
            .zones_of(&arm.id, ZoneKind::Handover)
            .filter(|zone| Some(zone.id.as_str()) != own);
        Met {
            keep_out: closest(&bodies, self.zones_of(&arm.id, ZoneKind::KeepOut)),
            foreign: closest(&bodies, foreign),
            work: least_inside(&bodies, self.zones_of(&arm.id, ZoneKind::Work)),
        }
    }

    /// The first way of a job to a taught pose, or back, that leads where it may not; the straight lines also at every
    /// corner of the tolerance of the dock.
    ///
    /// Where the arm cannot be at all there is no way; that is said when the poses are planned.
    pub(super) fn forbidden_way(&self, taught: &Taught) -> Option<ForbiddenWay> {
        let (arm, place) = (self.arm(&taught.arm)?, self.place(&taught.place)?);
        if !self.has_zones_of(&arm.id) {
            return None;
        }
        let mut docks = self.docks(place).into_iter().enumerate();
        docks.find_map(|(corner, (docked, dock))| {
            let X_CT = self.grip_pose(taught, dock).ok()?;
            let ways = if corner == 0 {
                Ways::of(arm, taught, &X_CT)
            } else {
                Ways::straight(arm, taught, &X_CT)
            };
            ways.paths.iter().find_map(|(what, samples)| {
                let zone = self.met(arm, place, samples).forbidden().next()?;
                let docked = docked.clone();
                Some(ForbiddenWay { what, docked, zone })
            })
        })
    }

    /// Whether an arm that goes to a target over these samples respects the zones; the hand-over zone of the target itself
    /// is entered by a permit. A way that leads no deeper than its start is not held against it.
    ///
    /// # Errors
    /// What is in the way.
    pub(crate) fn check_way(
        &self,
        arm: &Arm,
        start: &PendantJoints,
        samples: &[PendantJoints],
        goal: &workflow::Target,
    ) -> Result<(), Trespass> {
        let own = match goal {
            workflow::Target::ApproachOf { place }
            | workflow::Target::At { place }
            | workflow::Target::LiftOf { place } => {
                let place = self.places.iter().find(|known| known.is(place));
                place.and_then(|place| self.zone_of(place))
            }
            // Out of wherever it is: it may have been lifted over the edge of its zone.
            workflow::Target::Safe => None,
        };
        let permitted = |zone: &str| {
            own == Some(zone)
                || *goal == workflow::Target::Safe && self.is_in_or_above(arm, start, zone)
        };
        let found = self.trespasses(arm, Some(start), samples);
        let forbidden = found
            .into_iter()
            .find(|found| found.kind != ZoneKind::Handover || !permitted(&found.zone));
        forbidden.map_or(Ok(()), Err)
    }

    fn is_in_or_above(&self, arm: &Arm, joints: &PendantJoints, zone: &str) -> bool {
        let zone = self.zones.iter().find(|known| known.id == zone);
        let bounds = zone.map(|zone| zone.bounds.and_above());
        let body = arm.capsules(joints);
        bounds.is_some_and(|bounds| body.iter().any(|part| bounds.gap(part).0 <= 0.0))
    }

    /// The dock poses to plan for, and how each is called.
    pub(super) fn docks(&self, place: &Place) -> Vec<(String, Dock)> {
        let point = match &place.site {
            Site::OnMobileRobot { point, .. } => self.point(point),
            Site::Fixed | Site::Buffer | Site::Reject => None,
        };
        let Some(point) = point else {
            return vec![(String::new(), Dock::Nominal)];
        };
        let corners: Vec<DockPose> = point.dock.corners(&point.tolerance);
        let count = corners.len();
        let named = corners.into_iter().enumerate().map(|(index, corner)| {
            let name = match (index, count) {
                (_, 1) => String::new(),
                (0, _) => ", docked as nominal".to_owned(),
                (corner, _) => format!(", docked at corner {corner} of the tolerance"),
            };
            (name, Dock::Measured(corner))
        });
        named.collect()
    }

    /// The hand-over zone a place is in.
    pub(super) fn zone_of(&self, place: &Place) -> Option<&str> {
        match &place.site {
            Site::OnMobileRobot { point, .. } => self.point(point)?.zone.as_deref(),
            Site::Fixed | Site::Buffer | Site::Reject => None,
        }
    }
}
