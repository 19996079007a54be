//! What a way of an arm does to the zones of the cell, compared with where the arm is before it.
//!
//! An arm that stands where it may not be has to get out again: a way that leads no deeper than its start is not held
//! against it.

use std::fmt;

use api::setup::ZoneKind;
use kinematics::PendantJoints;
use nalgebra::Point3;
use units::Millimeters;

use super::model::{Arm, Setup, Zone};
use super::path::{Closest, bodies, closest, least_inside};

/// Deeper than at the start by less than this is not deeper: the joints that are sent are rounded.
const SLACK_MM: f64 = 1.0;

/// A zone that a way does not respect.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Trespass {
    /// The zone's id.
    pub(crate) zone: String,
    /// What it is for. A hand-over zone is only entered, which somebody else may forbid.
    pub(crate) kind: ZoneKind,
    /// The deepest point, in the cell frame, in millimeters.
    pub(crate) point: Point3<f64>,
    /// How deep a part of the arm is inside, or how far its tip is outside its work area.
    pub(crate) by: Millimeters,
}

impl fmt::Display for Trespass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            zone,
            kind,
            point,
            by,
        } = self;
        let what = match kind {
            ZoneKind::KeepOut => "the arm would enter the keep-out zone",
            ZoneKind::Handover => "the arm would enter the hand-over zone",
            ZoneKind::Work => "the tool center point would leave the work area",
        };
        write!(
            f,
            "{what} `{zone}` by {:.1} mm, at x {:.1}, y {:.1}, z {:.1} mm of the cell",
            by.0, point.x, point.y, point.z
        )
    }
}

impl Setup {
    /// The zones that the samples of a way do not respect: keep-out zones that any part of the arm enters, hand-over
    /// zones that it enters from outside, and the work area, if its tool center point leaves that. `start` is where
    /// the arm is before, if that is known.
    pub(crate) fn trespasses(
        &self,
        arm: &Arm,
        start: Option<&PendantJoints>,
        samples: &[PendantJoints],
    ) -> Vec<Trespass> {
        let way = bodies(arm, samples);
        let before = start.map(|joints| [arm.capsules(joints)]);
        let near = |zone: &Zone| {
            let found = closest(&way, std::iter::once(zone))?;
            let before = before.as_ref();
            let before = before.and_then(|at| closest(at, std::iter::once(zone)));
            Some((found, before.map_or(f64::INFINITY, |at| at.gap.0)))
        };
        let mut all = Vec::new();
        for zone in self.zones_of(&arm.id, ZoneKind::KeepOut) {
            if let Some((found, before)) = near(zone)
                && found.gap.0 < 0.0
                && found.gap.0 < before - SLACK_MM
            {
                all.push(trespass(ZoneKind::KeepOut, found));
            }
        }
        for zone in self.zones_of(&arm.id, ZoneKind::Handover) {
            if let Some((found, before)) = near(zone)
                && found.gap.0 <= 0.0
                && before > 0.0
            {
                all.push(trespass(ZoneKind::Handover, found));
            }
        }
        let work = || self.zones_of(&arm.id, ZoneKind::Work);
        let before = before.and_then(|at| least_inside(&at, work()));
        let before = before.map_or(f64::INFINITY, |at| at.gap.0);
        if let Some(found) = least_inside(&way, work())
            && found.gap.0 < 0.0
            && found.gap.0 < before - SLACK_MM
        {
            all.push(trespass(ZoneKind::Work, found));
        }
        all
    }
}

fn trespass(kind: ZoneKind, found: Closest) -> Trespass {
    let Closest {
        zone,
        at: _,
        point,
        gap,
    } = found;
    Trespass {
        zone,
        kind,
        point,
        by: -gap,
    }
}
