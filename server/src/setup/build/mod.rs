//! From the file to the checked set-up. Every fault is found before any is told.

mod arms;
mod floor;
mod refs;
mod triggers;

use std::collections::HashSet;
use std::hash::Hash;
use std::sync::Arc;

use api::setup::{PlanarPoseBody, SETUP_FORMAT, SetupFile, TimersBody};
use api::{JointsBody, PoseBody};
use kinematics::{ArmModel, PendantJoints, Pose};

pub(super) use self::arms::in_cell;
use self::refs::Refs;
use super::faults::{Faults, SetupErrors};
use super::geometry::DockPose;
use super::model::Setup;
use super::text::check_name;
use crate::config::RobotPlan;
use crate::target::joints_of;
use crate::wire_bodies::point_of;

/// Lengths of lists. Each is far above any cell, and far below what a server has to fear.
const MAX_ARMS: usize = 16;
const MAX_FEW: usize = 200;
const MAX_MANY: usize = 1_000;
/// No cell is larger, in millimeters to each side.
const SIZE_MM: (f64, f64) = (-1e6, 1e6);
const ANGLE_DEG: (f64, f64) = (-36_000.0, 36_000.0);
const TIMER_MS: std::ops::RangeInclusive<u64> = 1..=86_400_000;

impl Setup {
    /// Checks a set-up for a cell with these robots.
    ///
    /// # Errors
    /// Everything wrong with it.
    pub(crate) fn try_new(
        file: &SetupFile,
        robots: &[Arc<RobotPlan>],
    ) -> Result<Self, SetupErrors> {
        let mut faults = Faults::default();
        let setup = Self::build(file, robots, &mut faults);
        match faults.into_errors() {
            None => Ok(setup),
            Some(errors) => Err(errors),
        }
    }

    /// What can be made of a set-up; complete where there are no faults.
    fn build(file: &SetupFile, robots: &[Arc<RobotPlan>], faults: &mut Faults) -> Self {
        if file.format != SETUP_FORMAT {
            let format = file.format;
            faults.add("format", format!("is {format}; it must be {SETUP_FORMAT}"));
        }
        check_name(faults, "name".to_owned(), file.name.as_deref());
        let refs = Refs::new(file, robots);
        for (list, len, max) in [
            ("arms", file.arms.len(), MAX_ARMS),
            ("tools", file.tools.len(), MAX_FEW),
            ("zones", file.zones.len(), MAX_FEW),
            ("stations", file.stations.len(), MAX_FEW),
            ("places", file.places.len(), MAX_MANY),
            ("taught_poses", file.taught_poses.len(), MAX_MANY),
            ("destinations", file.destinations.len(), MAX_FEW),
            ("mobile_robots", file.mobile_robots.len(), MAX_FEW),
            ("routes", file.routes.len(), MAX_FEW),
            ("loads", file.loads.len(), MAX_MANY),
            ("triggers", file.triggers.len(), MAX_FEW),
        ] {
            faults.count(list, len, max);
        }
        let timers = file.timers.unwrap_or_default();
        check_timers(faults, &timers);
        let zones = arms::zones(faults, &refs);
        let setup = Self {
            arms: arms::arms(faults, &refs, &zones),
            points: floor::points(faults, &refs, &zones),
            zones,
            places: floor::places(faults, &refs),
            taught: arms::taught(faults, &refs),
            destinations: floor::destinations(faults, &refs),
            mobile_robots: floor::mobile_robots(faults, &refs),
            routes: floor::routes(faults, &refs),
            loads: floor::loads(faults, &refs),
            triggers: triggers::triggers(faults, &refs),
            timers,
        };
        floor::handovers_have_their_own_zones(faults, &refs);
        setup
    }
}

fn check_timers(faults: &mut Faults, timers: &TimersBody) {
    let TimersBody {
        reserve_ms,
        precheck_ms,
        acknowledge_ms,
        arrive_ms,
        dock_ms,
        verify_ms,
        ready_ms,
        grip_ms,
        exit_ms,
        clear_ms,
        hold_ms,
        safe_ms,
        transport_ms,
        heartbeat_ms,
        arm_silence_ms,
        motion_margin_ms,
    } = *timers;
    for (name, value) in [
        ("reserve_ms", reserve_ms),
        ("precheck_ms", precheck_ms),
        ("acknowledge_ms", acknowledge_ms),
        ("arrive_ms", arrive_ms),
        ("dock_ms", dock_ms),
        ("verify_ms", verify_ms),
        ("ready_ms", ready_ms),
        ("grip_ms", grip_ms),
        ("exit_ms", exit_ms),
        ("clear_ms", clear_ms),
        ("hold_ms", hold_ms),
        ("safe_ms", safe_ms),
        ("transport_ms", transport_ms),
        ("heartbeat_ms", heartbeat_ms),
        ("arm_silence_ms", arm_silence_ms),
        ("motion_margin_ms", motion_margin_ms),
    ] {
        if let Some(value) = value.filter(|value| !TIMER_MS.contains(value)) {
            let (min, max) = (TIMER_MS.start(), TIMER_MS.end());
            faults.add(
                format!("timers.{name}"),
                format!("is {value}; it must be from {min} to {max}"),
            );
        }
    }
}

/// A pose, each of its numbers checked.
pub(in crate::setup) fn pose(faults: &mut Faults, item: &str, body: &PoseBody) -> Option<Pose> {
    let PoseBody {
        x_mm,
        y_mm,
        z_mm,
        w_deg,
        p_deg,
        r_deg,
    } = *body;
    let mut legal = true;
    for (name, value, range) in [
        ("x_mm", x_mm, SIZE_MM),
        ("y_mm", y_mm, SIZE_MM),
        ("z_mm", z_mm, SIZE_MM),
        ("w_deg", w_deg, ANGLE_DEG),
        ("p_deg", p_deg, ANGLE_DEG),
        ("r_deg", r_deg, ANGLE_DEG),
    ] {
        legal &= faults
            .number(format!("{item}.{name}"), value, range)
            .is_some();
    }
    if !legal {
        return None;
    }
    // The ranges are the kinematics' own; this cannot fail after them.
    Pose::try_from_xyzwpr(&point_of(body))
        .map_err(|error| faults.add(item, error.to_string()))
        .ok()
}

/// Joint values inside the arm's limits.
pub(in crate::setup) fn joints(
    faults: &mut Faults,
    item: &str,
    body: JointsBody,
    model: &ArmModel,
) -> Option<PendantJoints> {
    let joints = match joints_of(body.into()) {
        Ok(joints) => joints,
        Err(refusal) => {
            faults.add(item, refusal.to_string());
            return None;
        }
    };
    if let Err(violations) = model.check_limits(&joints) {
        for violation in violations.iter() {
            let joint = violation.joint.to_string().to_lowercase();
            faults.push(api::Violation {
                item: format!("{item}.{joint}_deg"),
                message: violation.to_string(),
                value: Some(violation.value.0),
                min: Some(violation.limits.min.0),
                max: Some(violation.limits.max.0),
            });
        }
        return None;
    }
    Some(joints)
}

/// A pose on the floor.
pub(in crate::setup) fn planar(
    faults: &mut Faults,
    item: &str,
    body: &PlanarPoseBody,
) -> Option<DockPose> {
    let x = faults.number(format!("{item}.x_mm"), body.x_mm, SIZE_MM);
    let y = faults.number(format!("{item}.y_mm"), body.y_mm, SIZE_MM);
    let heading = faults.number(format!("{item}.heading_deg"), body.heading_deg, ANGLE_DEG);
    Some(DockPose {
        x: units::Millimeters(x?),
        y: units::Millimeters(y?),
        heading: units::Degrees(heading?),
    })
}

/// Tells of keys that stand for several entries of a list.
pub(super) fn unique<K: Eq + Hash>(
    faults: &mut Faults,
    keys: impl IntoIterator<Item = (String, K)>,
    what: impl Fn(&K) -> String,
) {
    let mut known = HashSet::new();
    for (item, key) in keys {
        if known.contains(&key) {
            faults.add(
                item,
                format!("{} stands in an earlier entry, too", what(&key)),
            );
        } else {
            let _new = known.insert(key);
        }
    }
}
