//! A motion that somebody asks for, against the zones of its cell: no part of the arm goes into a keep-out zone, the
//! tool stays in its work area, and nobody's hand puts the arm where a mobile robot may be.
//!
//! Jobs enter hand-over zones by permits, which this is not asked about. What is looked at is the way, every degree of
//! the joint that turns farthest; where the controller does not report where the arm is, it is the end alone.

use api::setup::ZoneKind;
use api::trajectory::MotionProfile;
use api::{MotionType, ProblemCode, Violation};
use kinematics::PendantJoints;

use super::preview_profile;
use crate::motions::Asked;
use crate::problem::Problem;
use crate::setup::path::joint_path;
use crate::setup::trespass::Trespass;
use crate::state::{App, Robot, RobotLink};
use crate::wire_bodies::shown;

/// Refuses a motion that a zone does not allow.
///
/// # Errors
/// `zone-violation` with every zone that is in the way; `interlock-violation` for a hand-over zone whose point has an
/// open hand-over.
pub(super) fn check(app: &App, robot: &Robot, asked: &Asked) -> Result<(), Problem> {
    check_with(app, robot, asked, None)
}

/// As [`check`], where it has been calculated already how the motion would go from where the arm stands.
pub(super) fn check_with(
    app: &App,
    robot: &Robot,
    asked: &Asked,
    profile: Option<&MotionProfile>,
) -> Result<(), Problem> {
    let plan = &robot.plan;
    let cell = app.cell(&plan.cell)?;
    let kept = cell.setup.current();
    let Some(arm) = kept.setup.arm(&plan.id) else {
        return Ok(());
    };
    if !kept.setup.has_zones_of(&plan.id) {
        // A way is hundreds of postures: they are not calculated for nothing.
        return Ok(());
    }
    let start = start_of(robot);
    let way = way(robot, start.as_ref(), asked, profile);
    let found = kept.setup.trespasses(arm, start.as_ref(), &way);
    let (shared, forbidden): (Vec<_>, Vec<_>) = found
        .iter()
        .partition(|trespass| trespass.kind == ZoneKind::Handover);
    if let Some(first) = forbidden.first() {
        let violations = forbidden.iter().map(|trespass| violation(trespass));
        return Err(
            Problem::not_sent(ProblemCode::ZoneViolation, first.to_string())
                .violations(violations.collect())
                .hint("Another target, or a point between, may lead around it."),
        );
    }
    if shared.is_empty() {
        return Ok(());
    }
    let known = cell.work.view();
    let sessions = known.sessions(cell.work.clock().now());
    for session in sessions.iter().filter(|session| !session.state.is_closed()) {
        let zone = known.setup().point(&session.point).map(|point| &point.zone);
        if let Some(entered) = shared.iter().find(|found| Some(&found.zone) == zone) {
            let detail = format!(
                "{}, and {} may be in it: the hand-over at {} is open",
                entered, session.mobile_robot, session.point
            );
            return Err(Problem::not_sent(ProblemCode::InterlockViolation, detail)
                .violations(vec![violation(entered)])
                .hint("End the hand-over's job first, or move the arm elsewhere."));
        }
    }
    Ok(())
}

/// Where the motion begins: where the one before it ends, or where the controller says that the arm is.
fn start_of(robot: &Robot) -> Option<PendantJoints> {
    let RobotLink::CellServer(link) = &robot.link else {
        return None;
    };
    let book = &robot.motions.book;
    let before = book.open().last().and_then(|id| book.get(*id));
    before.map(|before| before.asked.joints).or_else(|| {
        let seen = link.view().status?;
        let degrees = seen.line.joints.degrees().map(|joint| joint.0);
        Some(PendantJoints::from_degrees(degrees))
    })
}

fn way(
    robot: &Robot,
    start: Option<&PendantJoints>,
    asked: &Asked,
    profile: Option<&MotionProfile>,
) -> Vec<PendantJoints> {
    let Some(start) = start else {
        return vec![asked.joints];
    };
    if asked.motion_type != MotionType::Linear {
        return joint_path(start, &asked.joints);
    }
    let own = match profile {
        Some(_) => None,
        None => preview_profile::profile(&robot.plan, start, asked),
    };
    let profile = profile.or(own.as_ref());
    let samples = profile.into_iter().flat_map(|profile| &profile.samples);
    let mut way: Vec<_> = samples
        .filter_map(|sample| <[f64; 6]>::try_from(&*sample.position_deg_mm).ok())
        .map(PendantJoints::from_degrees)
        .collect();
    way.push(asked.joints);
    way
}

/// How far outside of what is allowed, in millimeters: at least 0 would be.
fn violation(trespass: &Trespass) -> Violation {
    Violation {
        item: trespass.zone.clone(),
        message: trespass.to_string(),
        value: Some(shown(-trespass.by.0)),
        min: Some(0.0),
        ..Violation::default()
    }
}
