//! Plans every taught pose of a set-up, and measures every route.
//!
//! For each taught pose: the way from the safe pose to the approach, the straight line to the pose, the straight lift,
//! and the way back to the safe pose. For a place on a mobile robot all of it at the nominal dock pose and at every
//! corner of the tolerance. Samples are checked against joint limits, singularities, keep-out zones, the hand-over
//! zones of other points, and the arm's work areas.

#![expect(
    non_snake_case,
    reason = "frames are part of a pose's name: X_CT is the tool T in the cell C"
)]

use std::sync::atomic::{AtomicBool, Ordering};

use api::setup::{
    CheckFinding, JointMarginBody, RouteCheck, SetupCheck, Severity, TaughtPoseCheck, ZoneKind,
    ZoneMargin,
};
use kinematics::{Axis, PendantJoints};
use units::Millimeters;

use super::model::{Arm, Place, Route, Setup, Site, Taught, Zone};
use super::path::{Closest, bodies, closest};
use super::ways::{Line, Ways};
use crate::wire_bodies::shown;

/// Below these a finding is a warning.
const SMALL_MARGIN_DEG: f64 = 5.0;
const SMALL_GAP_MM: f64 = 25.0;
/// The findings of one taught pose that are told of.
const MOST_FINDINGS: usize = 10;

impl Setup {
    /// Plans and measures everything in the set-up, or, for a caller who has given up, no more than was begun.
    pub(crate) fn check_for(&self, given_up: &AtomicBool) -> SetupCheck {
        let taught_poses: Vec<_> = self
            .taught
            .iter()
            .take_while(|_| !given_up.load(Ordering::Relaxed))
            .map(|taught| self.plan(taught))
            .collect();
        let routes: Vec<_> = self
            .routes
            .iter()
            .map(|route| self.measure(route))
            .collect();
        let findings = self.whole();
        let no_error = findings
            .iter()
            .all(|found| found.severity != Severity::Error);
        SetupCheck {
            passed: no_error
                && taught_poses.iter().all(|taught| taught.passed)
                && routes.iter().all(|route| route.passed),
            revision: None,
            taught_poses,
            routes,
            findings,
        }
    }

    /// Plans and measures everything in the set-up.
    #[cfg(test)]
    pub(crate) fn check(&self) -> SetupCheck {
        self.check_for(&AtomicBool::new(false))
    }

    fn plan(&self, taught: &Taught) -> TaughtPoseCheck {
        let mut planner = Planner::new(taught);
        let (Some(arm), Some(place)) = (self.arm(&taught.arm), self.place(&taught.place)) else {
            unreachable!("a taught pose of a checked set-up has an arm and a place");
        };
        let docks = self.docks(place);
        for (where_docked, dock) in &docks {
            match self.grip_pose(taught, *dock) {
                Ok(X_CT) => {
                    let ways = Ways::of(arm, taught, &X_CT);
                    planner.line("approach", &ways.approach, where_docked);
                    planner.line("lift", &ways.lift, where_docked);
                    for (what, samples) in &ways.paths {
                        self.look(&mut planner, arm, place, samples, what, where_docked);
                    }
                }
                Err(error) => planner.error("", where_docked, error.to_string()),
            }
        }
        planner.finish(docks.len())
    }

    /// Looks at the samples of a path.
    fn look(
        &self,
        planner: &mut Planner<'_>,
        arm: &Arm,
        place: &Place,
        samples: &[PendantJoints],
        what: &str,
        where_docked: &str,
    ) {
        planner.samples += u32::try_from(samples.len()).unwrap_or(u32::MAX);
        for joints in samples {
            planner.joints(arm, joints);
        }
        let met = self.met(arm, place, samples);
        for forbidden in met.forbidden() {
            planner.error(what, where_docked, forbidden.to_string());
        }
        if let Some(found) = met.keep_out {
            planner.keep_out(found);
        }
        if let Some(found) = met.work {
            planner.work(found);
        }
    }

    fn measure(&self, route: &Route) -> RouteCheck {
        let end = |id: &str| self.point(id).map(|point| [point.dock.x, point.dock.y]);
        let points: Vec<[f64; 2]> = end(&route.from)
            .into_iter()
            .chain(route.waypoints.iter().copied())
            .chain(end(&route.to))
            .map(|[x, y]| [x.0, y.0])
            .collect();
        let legs = || points.iter().zip(points.iter().skip(1));
        let mut check = RouteCheck {
            route: route.id.clone(),
            passed: true,
            length_mm: shown(legs().map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1])).sum()),
            keep_out: None,
            findings: Vec::new(),
        };
        let robots = self.mobile_robots.iter();
        for robot in robots.filter(|robot| route.robots.includes(&robot.id)) {
            // A mecanum robot may face anywhere on its way: the circle about its footprint is what has to pass.
            let radius = robot.length.0.hypot(robot.width.0) / 2.0;
            for zone in self.zones_of(&robot.id, ZoneKind::KeepOut) {
                for (leg, (from, to)) in legs().enumerate() {
                    let gap = zone.bounds.gap_on_floor(*from, *to, radius, robot.height.0);
                    let Some(gap) = gap else { continue };
                    if gap < 0.0 {
                        check.passed = false;
                        check.findings.push(CheckFinding {
                            severity: Severity::Error,
                            item: format!("routes/{} leg {leg}", route.id),
                            message: format!(
                                "`{}` comes into the keep-out zone `{}` by {:.1} mm, measured at its corners",
                                robot.id, zone.id, -gap
                            ),
                        });
                    }
                    if check
                        .keep_out
                        .as_ref()
                        .is_none_or(|known| gap < known.margin_mm)
                    {
                        check.keep_out = Some(ZoneMargin {
                            zone: zone.id.clone(),
                            margin_mm: thousandths(gap),
                        });
                    }
                }
            }
            self.stays_on_its_floor(&mut check, &robot.id, radius, &points);
        }
        check.findings.truncate(MOST_FINDINGS);
        check
    }

    /// Whether a mobile robot stays inside its work areas all along, with its whole footprint.
    fn stays_on_its_floor(
        &self,
        check: &mut RouteCheck,
        robot: &str,
        radius: f64,
        points: &[[f64; 2]],
    ) {
        let areas: Vec<_> = self.zones_of(robot, ZoneKind::Work).collect();
        if areas.is_empty() {
            return;
        }
        let legs = points.iter().zip(points.iter().skip(1));
        for [x, y] in legs.flat_map(|(from, to)| along(*from, *to)) {
            let inside = |zone: &&Zone| zone.bounds.holds_circle([x, y], radius);
            if !areas.iter().any(inside) {
                check.passed = false;
                check.findings.push(CheckFinding {
                    severity: Severity::Error,
                    item: format!("routes/{}", check.route),
                    message: format!(
                        "`{robot}` leaves its work areas at x {x:.1}, y {y:.1} mm, measured at its corners"
                    ),
                });
                return;
            }
        }
    }

    /// What belongs to no taught pose and no route.
    fn whole(&self) -> Vec<CheckFinding> {
        let mut findings = Vec::new();
        let mut found = |severity, item: String, message: String| {
            findings.push(CheckFinding {
                severity,
                item,
                message,
            });
        };
        for place in &self.places {
            if !self.taught.iter().any(|taught| taught.place == place.id) {
                found(
                    Severity::Warning,
                    format!("places/{}", place.id),
                    "no arm has a taught pose there: nothing can be brought or fetched".to_owned(),
                );
            }
        }
        for place in &self.places {
            let Site::OnMobileRobot { point: _, slot } = &place.site else {
                continue;
            };
            for load in &place.accepts {
                let slots = self.mobile_robots.iter().flat_map(|robot| &robot.slots);
                if !slots
                    .filter(|known| known.id == *slot)
                    .any(|known| known.accepts.contains(load))
                {
                    found(
                        Severity::Warning,
                        format!("places/{}", place.id),
                        format!("no mobile robot takes `{load}` in its slot `{slot}`"),
                    );
                }
            }
        }
        for arm in &self.arms {
            let at_safe = [arm.safe];
            if let Err(violation) = self.check_path(arm, &at_safe) {
                found(
                    Severity::Error,
                    format!("arms/{} safe", arm.id),
                    violation.to_string(),
                );
            }
            let handover = self.zones_of(&arm.id, ZoneKind::Handover);
            let inside =
                closest(&bodies(arm, &at_safe), handover).filter(|found| found.gap.0 < 0.0);
            if let Some(inside) = inside {
                found(
                    Severity::Error,
                    format!("arms/{} safe", arm.id),
                    format!(
                        "the arm is inside the hand-over zone `{}` by {:.1} mm at {}",
                        inside.zone,
                        -inside.gap.0,
                        inside.spot()
                    ),
                );
            }
        }
        for destination in &self.destinations {
            let served = self.points.iter().filter(|point| !point.arms.is_empty());
            for point in served.filter(|point| point.id != destination.point) {
                if !self.is_connected(&point.id, &destination.point) {
                    found(
                        Severity::Warning,
                        format!("destinations/{}", destination.id),
                        format!("no route leads there from `{}`", point.id),
                    );
                }
            }
        }
        for (trigger, message) in self.untaught_triggers() {
            found(Severity::Warning, format!("triggers/{trigger}"), message);
        }
        findings
    }

    /// Triggers whose jobs no arm could do: the signal would come, and the job be refused, when nobody looks.
    fn untaught_triggers(&self) -> Vec<(String, String)> {
        let known = self.for_workflows();
        let mut found = Vec::new();
        for trigger in &self.triggers {
            let job = &trigger.job;
            let Some(point) = known.point(&job.point) else {
                continue;
            };
            let mut arms: Vec<_> = point.arms.iter().collect();
            if let Some(only) = &job.arm {
                arms.retain(|arm| *arm == only);
            }
            let places = job.items.iter().flat_map(|item| {
                let slot = workflow::PlaceRef::MobileRobot {
                    point: job.point.clone(),
                    slot: item.mr_slot.clone(),
                };
                [slot, workflow::PlaceRef::fixed(item.place.clone())]
            });
            let places: Vec<_> = places.collect();
            let missing = |arm: &str| places.iter().find(|place| !known.is_taught(arm, place));
            let missing: Vec<_> = arms
                .iter()
                .map(|arm| missing(arm).map(|place| format!("{arm} was not taught `{place}`")))
                .collect();
            if missing.iter().all(Option::is_some) {
                let missing: Vec<_> = missing.into_iter().flatten().collect();
                found.push((
                    trigger.id.clone(),
                    format!("its job would be refused: {}", missing.join(", ")),
                ));
            }
        }
        found
    }

    /// Whether some route leads from one point to another, over any number of points between.
    fn is_connected(&self, from: &str, to: &str) -> bool {
        use api::setup::RouteDirection::{BothWays, OneWay};
        let mut reached = vec![from];
        let mut next = 0;
        while let Some(here) = reached.get(next).copied() {
            next += 1;
            for route in &self.routes {
                let onward = match route.direction {
                    _ if route.from == here => Some(route.to.as_str()),
                    BothWays if route.to == here => Some(route.from.as_str()),
                    BothWays | OneWay => None,
                };
                reached.extend(onward.filter(|onward| !reached.contains(onward)));
            }
        }
        reached.contains(&to)
    }
}

/// Points of a leg of a route, both ends included.
fn along([x, y]: [f64; 2], [to_x, to_y]: [f64; 2]) -> Vec<[f64; 2]> {
    const STEP_MM: f64 = 50.0;
    let steps = ((to_x - x).hypot(to_y - y) / STEP_MM)
        .ceil()
        .clamp(1.0, 1e5);
    let mut points = Vec::new();
    let mut step = 0.0;
    while step <= steps {
        let share = step / steps;
        points.push([x + (to_x - x) * share, y + (to_y - y) * share]);
        step += 1.0;
    }
    points
}

/// Gathers what is found about one taught pose.
struct Planner<'a> {
    taught: &'a Taught,
    samples: u32,
    joint: Option<JointMarginBody>,
    singularity: Option<f64>,
    keep_out: Option<Closest>,
    work: Option<Closest>,
    findings: Vec<CheckFinding>,
}

impl<'a> Planner<'a> {
    fn new(taught: &'a Taught) -> Self {
        Self {
            taught,
            samples: 0,
            joint: None,
            singularity: None,
            keep_out: None,
            work: None,
            findings: Vec::new(),
        }
    }

    fn item(&self) -> String {
        format!("taught-poses/{}/{}", self.taught.arm, self.taught.place)
    }

    /// What is wrong. The same thing in the same words at several dock poses is told of once for each of them.
    fn error(&mut self, what: &str, where_docked: &str, message: String) {
        let message = match what {
            "" => message,
            what => format!("{what}: {message}"),
        };
        let item = format!("{}{where_docked}", self.item());
        self.findings.push(CheckFinding {
            severity: Severity::Error,
            item,
            message,
        });
    }

    /// Notes what is wrong with a straight line, and how near it comes to a singularity.
    fn line(&mut self, what: &str, line: &Line, where_docked: &str) {
        for point in &line.points {
            let (_, measure) = point.singularity.nearest();
            if self.singularity.is_none_or(|known| measure < known) {
                self.singularity = Some(measure);
            }
        }
        if let Some(broken) = &line.broken {
            let at = format!("{what}, {:.0} mm along", broken.along_mm);
            self.error(&at, where_docked, broken.why.clone());
        }
    }

    fn joints(&mut self, arm: &Arm, joints: &PendantJoints) {
        for axis in Axis::ALL {
            let value = joints.of(axis);
            let margin = arm.model.limits(axis).margin(value).0;
            if self
                .joint
                .as_ref()
                .is_none_or(|known| margin < known.margin_deg)
            {
                self.joint = Some(JointMarginBody {
                    joint: axis.to_string(),
                    value_deg: thousandths(value.0),
                    margin_deg: thousandths(margin),
                });
            }
        }
    }

    fn keep_out(&mut self, found: Closest) {
        if self
            .keep_out
            .as_ref()
            .is_none_or(|known| found.gap < known.gap)
        {
            self.keep_out = Some(found);
        }
    }

    fn work(&mut self, found: Closest) {
        if self.work.as_ref().is_none_or(|known| found.gap < known.gap) {
            self.work = Some(found);
        }
    }

    /// Adds the warnings, and gives the line of the report.
    fn finish(mut self, docks: usize) -> TaughtPoseCheck {
        let passed = self.findings.is_empty();
        let mut warnings = Vec::new();
        if let Some(joint) = &self.joint
            && (0.0..SMALL_MARGIN_DEG).contains(&joint.margin_deg)
        {
            warnings.push(format!(
                "{} comes within {:.1} degrees of its limit",
                joint.joint, joint.margin_deg
            ));
        }
        if let Some(close) = &self.keep_out
            && (0.0..SMALL_GAP_MM).contains(&close.gap.0)
        {
            warnings.push(format!(
                "the arm comes within {:.1} mm of `{}`",
                close.gap.0, close.zone
            ));
        }
        self.findings.truncate(MOST_FINDINGS);
        let item = self.item();
        self.findings
            .extend(warnings.into_iter().map(|message| CheckFinding {
                severity: Severity::Warning,
                item: item.clone(),
                message,
            }));
        TaughtPoseCheck {
            arm: self.taught.arm.clone(),
            place: self.taught.place.clone(),
            passed,
            dock_poses: u32::try_from(docks).unwrap_or(u32::MAX),
            samples: self.samples,
            joint: self.joint,
            singularity: self.singularity.map(thousandths),
            keep_out: self.keep_out.as_ref().map(margin),
            work: self.work.as_ref().map(margin),
            findings: self.findings,
        }
    }
}

fn margin(found: &Closest) -> ZoneMargin {
    let Millimeters(gap) = found.gap;
    ZoneMargin {
        zone: found.zone.clone(),
        margin_mm: thousandths(gap),
    }
}

/// A margin, to the thousandth: more is not known.
fn thousandths(value: f64) -> f64 {
    (value * 1e3).round() / 1e3 + 0.0
}
