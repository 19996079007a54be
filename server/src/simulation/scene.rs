//! A cell as it is now, for a simulation to begin in.

use api::setup::{LoadBody, OnMobileRobot, SetupFile};
use api::{FloorPoseBody, JobBody, ProblemCode};
use jiff::Timestamp;
use workflow::view::{JobView, LoadView};
use workflow::{Holder, Location, Resource};

use super::{Scene, SceneArm, SceneMobileRobot};
use crate::problem::Problem;
use crate::state::{Cell, Robot, RobotLink};

/// The scene of a cell now. What other jobs are at is left out of it, and the scene says so.
///
/// # Errors
/// `custody-unknown` where nobody knows where a load is.
pub(crate) fn scene(cell: &Cell, job: JobBody, now: Timestamp) -> Result<Scene, Problem> {
    let view = cell.work.view();
    let jobs = view.jobs(cell.work.clock().now());
    let sessions = view.sessions(cell.work.clock().now());
    let claims = view.claims();
    let mut scene = Scene {
        cell: cell.id.clone(),
        setup: cell.setup.current().file.clone(),
        arms: Vec::new(),
        mobile_robots: Vec::new(),
        job,
        now,
        assumptions: Vec::new(),
    };
    let busy = |resource: &Resource| {
        let claim = claims.iter().find(|claim| claim.resource == *resource)?;
        let number = match claim.by {
            Holder::Job(id) => jobs.iter().find(|job| job.id == id).map(|job| job.number),
            Holder::Session(id) => sessions
                .iter()
                .find(|session| session.id == id)
                .and_then(|session| jobs.iter().find(|job| job.id == session.job))
                .map(|job| job.number),
        };
        Some(number.map_or_else(
            || "an open hand-over".to_owned(),
            |number| format!("job {number}"),
        ))
    };
    let open: Vec<_> = jobs.iter().filter(|job| is_open(job)).collect();
    if !open.is_empty() {
        let numbers: Vec<_> = open.iter().map(|job| job.number.to_string()).collect();
        let (jobs, are) = if open.len() == 1 {
            ("job", "is")
        } else {
            ("jobs", "are")
        };
        scene.assumptions.push(format!(
            "{jobs} {} {are} open in the cell and not part of the simulation: nothing waits for them",
            numbers.join(", ")
        ));
    }
    loads(&mut scene, &view.custody())?;
    for robot in &cell.robots {
        let id = &robot.plan.id;
        let joints_deg = match (busy(&Resource::Arm(id.clone())), joints(robot)) {
            (Some(by), _) => {
                let text = format!("{id} works for {by}: it begins at its safe pose");
                scene.assumptions.push(text);
                None
            }
            (None, Ok(joints)) => Some(joints),
            (None, Err(reason)) => {
                let text = format!("{id} begins at its safe pose: {reason}");
                scene.assumptions.push(text);
                None
            }
        };
        scene.arms.push(SceneArm {
            id: id.clone(),
            joints_deg,
            speed_override: speed_override(robot),
        });
    }
    if !view.mobile_robots().is_empty() {
        // Their speeds, radii and times to dock are nowhere in a set-up.
        scene.assumptions.push(
            "mobile robots drive and dock like the default mobile emulator, whatever the real ones do: the arm's times are \
             planned, theirs are not"
                .to_owned(),
        );
    }
    for mobile in view.mobile_robots() {
        let id = mobile.id;
        let resource = Resource::MobileRobot(id.clone());
        match (busy(&resource), mobile.state) {
            (Some(by), _) => {
                let text = format!("{id} works for {by}: it begins where it waits");
                scene.assumptions.push(text);
            }
            (None, None) => {
                let text = format!("{id} was never heard: it begins where it waits");
                scene.assumptions.push(text);
            }
            (None, Some(state)) => scene.mobile_robots.push(SceneMobileRobot {
                id,
                pose: FloorPoseBody {
                    x_mm: state.pose.x_mm,
                    y_mm: state.pose.y_mm,
                    heading_deg: state.pose.heading_deg,
                },
            }),
        }
    }
    Ok(scene)
}

fn is_open(job: &JobView) -> bool {
    !job.state.is_final()
}

/// Where the arm was last seen. No motion is counted from here, so it need not be of this moment.
fn joints(robot: &Robot) -> Result<[f64; 6], String> {
    match &robot.link {
        RobotLink::Seed(_) => robot.actual_joints().map(|joints| joints.degrees()),
        RobotLink::CellServer(link) => match link.view().status {
            Some(seen) => Ok(seen.line.joints.degrees().map(|joint| joint.0)),
            None => Err("its controller was never heard".to_owned()),
        },
    }
}

fn speed_override(robot: &Robot) -> Option<u8> {
    match &robot.link {
        RobotLink::Seed(_) => None,
        RobotLink::CellServer(link) => link.view().status.map(|seen| seen.line.speed_override),
    }
}

/// Puts every load where it is now.
fn loads(scene: &mut Scene, custody: &[LoadView]) -> Result<(), Problem> {
    let unknown: Vec<_> = custody
        .iter()
        .filter(|load| matches!(load.load.location, Location::Unknown { .. }))
        .map(|load| format!("`{}`", load.id))
        .collect();
    if !unknown.is_empty() {
        let detail = format!(
            "nobody knows where {} is, so there is no state to begin in",
            unknown.join(", ")
        );
        let hint = "look for it, and say where it is with PUT loads/{load}/custody";
        return Err(Problem::not_sent(ProblemCode::CustodyUnknown, detail).hint(hint));
    }
    let mut bodies = Vec::with_capacity(custody.len());
    for load in custody {
        let known = scene.setup.loads.iter().find(|body| body.id == load.id);
        let mut body = LoadBody {
            id: load.id.clone(),
            load_type: load.load.kind.clone(),
            name: known.and_then(|known| known.name.clone()),
            place: None,
            destination: None,
            on: None,
        };
        match &load.load.location {
            Location::Fixed { place } => body.place = Some(place.clone()),
            Location::MobileRobot { mobile_robot, slot } => {
                body.on = Some(OnMobileRobot {
                    mobile_robot: mobile_robot.clone(),
                    slot: slot.clone(),
                });
            }
            Location::Delivered { destination } => {
                // One that the set-up does not name is out of the cell for good.
                let Some(id) = destination_of(&scene.setup, destination) else {
                    continue;
                };
                body.destination = Some(id);
            }
            Location::Gripper { arm } => {
                // A job that names it was refused before.
                scene.assumptions.push(format!(
                    "{} is in the gripper of {arm}: it is left out",
                    load.id
                ));
                continue;
            }
            // They were looked for before.
            Location::Unknown { .. } => continue,
        }
        bodies.push(body);
    }
    scene.setup.loads = bodies;
    Ok(())
}

/// The destination that a workflow names by its id or its point.
fn destination_of(setup: &SetupFile, name: &str) -> Option<String> {
    let mut destinations = setup.destinations.iter();
    destinations
        .find(|known| known.id == name || known.point == name)
        .map(|known| known.id.clone())
}
