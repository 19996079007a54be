//! An order on its way: where the robot is in the hand-over.

use std::time::Duration;

use api::{FloorPoseBody, RoutePointBody, TransportOrderBody};
use mobile_base::PlanarPose;
use serde::Serialize;
use uuid::Uuid;

use crate::error::{id, number};
use crate::floor::{Zone, before, body_of, pose_of, shifted};
use crate::plan::Plan;

/// Where a robot is in its order.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum Phase {
    /// It drives to the point.
    Approach,
    /// It stands before the dock and waits for its permit.
    AtEntry,
    /// It docks.
    Docking,
    /// It stands beside the dock and waits to be told what to do.
    DockFailed,
    /// It stands docked, and its permit to move is not withdrawn yet.
    Docked,
    /// It stands docked without a permit: the arm may come.
    Ready,
    /// It drives out of the zone.
    Leaving,
    /// It drives to the destination.
    Delivering,
    /// Its loads are taken off at the destination.
    Unloading,
}

/// An order that is being carried out.
#[derive(Clone, Debug)]
#[expect(
    clippy::struct_excessive_bools,
    reason = "what was told and what was heard, each on its own; the state is `phase`"
)]
pub(crate) struct Mission {
    pub(crate) order: TransportOrderBody,
    pub(crate) session: Option<Uuid>,
    pub(crate) phase: Phase,
    /// Where it was when it took the order.
    pub(crate) from: PlanarPose,
    /// What it takes for the dock.
    pub(crate) dock: PlanarPose,
    /// What it was told.
    pub(crate) ordered_dock: PlanarPose,
    /// Where it looks for the dock.
    pub(crate) approach: PlanarPose,
    pub(crate) tolerance: (f64, f64),
    pub(crate) zone: Zone,
    pub(crate) destination: Option<Destination>,
    /// The cell's word: it may move in the zone.
    ///
    /// ASSUMPTION: it holds while the cell is away, as a released base does in VDA 5050.
    pub(crate) permit: bool,
    /// The cell's word: it may leave.
    pub(crate) exit: bool,
    pub(crate) arrived_told: bool,
    pub(crate) clear_told: bool,
    /// It does not go on to the destination.
    pub(crate) aborted: Option<Aborted>,
    pub(crate) docked_at: Option<Duration>,
    /// It goes where it wants: a fault.
    pub(crate) runaway: bool,
    /// Its marker is not to be trusted: a fault.
    pub(crate) marker_blind: bool,
    /// A slide that is to come in this docking: what is left of the way then, and the slide.
    pub(crate) slide: Option<Slide>,
    pub(crate) unloaded_at: Option<Duration>,
}

/// Why an order is not carried on.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Aborted {
    Cancelled,
    Failed,
}

/// A slide during docking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slide {
    pub(crate) at_left_mm: f64,
    pub(crate) forward_left_turn: (f64, f64, f64),
    pub(crate) noticed: bool,
}

/// Where the order ends.
#[derive(Clone, Debug)]
pub(crate) struct Destination {
    pub(crate) name: String,
    pub(crate) pose: PlanarPose,
    pub(crate) unload: Option<Duration>,
}

impl Mission {
    /// The order as the robot understands it.
    ///
    /// # Errors
    /// A sentence for the refusal.
    pub(crate) fn try_new(
        plan: &Plan,
        order: TransportOrderBody,
        session: Option<Uuid>,
        from: PlanarPose,
        dock: Option<FloorPoseBody>,
    ) -> Result<Self, String> {
        let text = |error: crate::error::Refusal| error.to_string();
        let _ = id("goal", &order.goal).map_err(text)?;
        let ordered_dock = pose_of(&order.dock).map_err(|error| format!("dock: {error}"))?;
        let dock = match dock {
            Some(other) => pose_of(&other).map_err(|error| format!("dock: {error}"))?,
            None => ordered_dock,
        };
        let tolerance = match order.dock_tolerance {
            Some(given) => (
                number("dock_tolerance.mm", given.mm, (0.1, 1e3)).map_err(text)?,
                number("dock_tolerance.deg", given.deg, (0.01, 45.0)).map_err(text)?,
            ),
            None => (plan.tolerance_mm, plan.tolerance_deg),
        };
        let place = plan.places.get(&order.goal);
        let zone = match (order.zone, place.and_then(|place| place.zone.clone())) {
            (Some(area), _) => Zone::try_new(area).map_err(|reason| format!("zone: {reason}"))?,
            (None, Some(zone)) => zone,
            (None, None) => Zone::around(&order.dock, plan.default_zone_mm)?,
        };
        let destination = destination(plan, &order)?;
        // What is taken off where there is no arm needs no hand-over: the whole order is its last leg.
        let transport = order.unload.is_some() && order.then_to.is_none();
        let destination = if transport {
            Some(Destination {
                name: order.goal.clone(),
                pose: dock,
                unload: place.and_then(|place| place.unload),
            })
        } else {
            destination
        };
        let last = match order.route.last() {
            Some(RoutePointBody { x_mm, y_mm, .. }) => pose_of(&FloorPoseBody {
                x_mm: *x_mm,
                y_mm: *y_mm,
                heading_deg: 0.0,
            })
            .map_err(|error| format!("route: {error}"))?,
            None => from,
        };
        Ok(Self {
            approach: before(dock, last, plan.standoff_mm),
            phase: if transport {
                Phase::Delivering
            } else {
                Phase::Approach
            },
            session: session.filter(|_| !transport),
            from,
            dock,
            ordered_dock,
            tolerance,
            zone,
            destination,
            permit: false,
            exit: false,
            arrived_told: false,
            clear_told: transport,
            aborted: None,
            docked_at: None,
            runaway: false,
            marker_blind: false,
            slide: None,
            unloaded_at: None,
            order,
        })
    }

    /// What changes with an update of the same order.
    pub(crate) fn update(&mut self, plan: &Plan, order: TransportOrderBody) -> Result<(), String> {
        if order.goal != self.order.goal || order.dock != self.order.dock {
            return Err(format!(
                "update {} changes the goal of an order that is being carried out; cancel it first",
                order.update
            ));
        }
        if matches!(
            self.phase,
            Phase::Leaving | Phase::Delivering | Phase::Unloading
        ) {
            return Err(format!(
                "update {} comes after the robot has set out for its destination",
                order.update
            ));
        }
        self.destination = destination(plan, &order)?;
        self.order = order;
        Ok(())
    }

    /// Places and end of the way out of the zone, to the destination if there is one.
    pub(crate) fn way_out(&self, plan: &Plan) -> (Vec<RoutePointBody>, PlanarPose) {
        let approach = route_point(self.approach);
        if let (Some(destination), None) = (&self.destination, self.aborted) {
            let mut places = vec![approach];
            places.extend(&self.order.then_route);
            return (places, destination.pose);
        }
        // Back the way it came, until it is clear.
        let clear = |pose: PlanarPose| {
            self.zone.clearance(&plan.footprint, pose).0 > plan.guard.resume_distance.0 + 50.0
        };
        let mut places = vec![approach];
        for place in self.order.route.iter().rev() {
            let back = pose_of(&FloorPoseBody {
                x_mm: place.x_mm,
                y_mm: place.y_mm,
                heading_deg: body_of(self.approach).heading_deg,
            });
            match back {
                Ok(pose) if clear(pose) => return (places, pose),
                Ok(_) => places.push(*place),
                Err(_) => break,
            }
        }
        if clear(self.from) {
            return (places, self.from);
        }
        (places, self.straight_out(clear))
    }

    /// Straight away from the dock, until it is clear.
    fn straight_out(&self, clear: impl Fn(PlanarPose) -> bool) -> PlanarPose {
        let (x, y) = (
            self.approach.position().x().0 - self.dock.position().x().0,
            self.approach.position().y().0 - self.dock.position().y().0,
        );
        let way = x.hypot(y);
        let (x, y) = if way > 1.0 {
            (x / way, y / way)
        } else {
            // It docked from where it stood: backward, then.
            let (sin, cos) = self.dock.heading().0.sin_cos();
            (-cos, -sin)
        };
        let mut pose = self.approach;
        for _ in 0..2000 {
            if clear(pose) {
                break;
            }
            pose = shifted(pose, (100.0 * x, 100.0 * y, 0.0));
        }
        pose
    }
}

fn route_point(pose: PlanarPose) -> RoutePointBody {
    let body = body_of(pose);
    RoutePointBody {
        x_mm: body.x_mm,
        y_mm: body.y_mm,
        heading_deg: Some(body.heading_deg),
    }
}

fn destination(plan: &Plan, order: &TransportOrderBody) -> Result<Option<Destination>, String> {
    let Some(name) = &order.then_to else {
        return Ok(None);
    };
    let _ = id("then_to", name).map_err(|error| error.to_string())?;
    let place = plan.places.get(name);
    let pose = match (&order.then_pose, place) {
        (Some(pose), _) => pose_of(pose).map_err(|error| format!("then_pose: {error}"))?,
        (None, Some(place)) => place.pose,
        (None, None) => {
            return Err(format!(
                "then_to is `{name}`, which is not on the robot's map, and there is no then_pose"
            ));
        }
    };
    Ok(Some(Destination {
        name: name.clone(),
        pose,
        unload: place.and_then(|place| place.unload),
    }))
}
