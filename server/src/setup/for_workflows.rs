//! What the state machines of the workflows need of a set-up, and the way back from what they ask for.

use api::setup::RouteDirection;
use units::{Degrees, Millimeters};
use workflow::{
    BasePose, LoadSetup, Location, MobileRobotSetup, PlaceKind, PlaceRef, Point, Timers, Tolerance,
};

use super::geometry::DockPose;
use super::model::{LoadPoint, Place, Setup, Site, Whereabouts};
use super::resolve::{Dock, ResolveError, Resolved, Target};

impl Setup {
    /// The set-up as the workflows know it.
    ///
    /// Their points are the ones where an arm works; a destination is named by its point, `station/point`, because that
    /// is the goal of the order that takes loads there. Their tolerance is a distance: the circle inside the square of
    /// the set-up, all of which was planned.
    pub(crate) fn for_workflows(&self) -> workflow::Setup {
        let served = |point: &&LoadPoint| !point.arms.is_empty();
        workflow::Setup {
            arms: self.arms.iter().map(|arm| arm.id.clone()).collect(),
            mobile_robots: self
                .mobile_robots
                .iter()
                .map(|robot| MobileRobotSetup {
                    id: robot.id.clone(),
                    slots: robot.slots.iter().map(|slot| slot.id.clone()).collect(),
                    max_speed_mm_s: robot.max_speed_mm_s,
                })
                .collect(),
            points: self
                .points
                .iter()
                .filter(served)
                .map(|point| self.point_for(point))
                .collect(),
            places: self.places.iter().filter_map(place_for).collect(),
            taught: self
                .taught
                .iter()
                .filter_map(|taught| {
                    Some(workflow::Taught {
                        arm: taught.arm.clone(),
                        place: reference_of(self.place(&taught.place)?),
                    })
                })
                .collect(),
            loads: self
                .loads
                .iter()
                .map(|load| LoadSetup {
                    id: load.id.clone(),
                    kind: load.kind.clone(),
                    at: self.location_of(&load.at),
                })
                .collect(),
            destinations: self
                .destinations
                .iter()
                .map(|destination| destination.point.clone())
                .collect(),
            triggers: self.triggers.clone(),
            timers: self.timers_for(),
        }
    }

    /// What an arm is told for a target of a workflow, with the mobile robot docked as the workflow was told.
    ///
    /// # Errors
    /// As [`Setup::resolve`].
    pub(crate) fn resolve_for(
        &self,
        arm: &str,
        target: &workflow::Target,
        docked: Option<BasePose>,
    ) -> Result<Resolved, ResolveError> {
        let dock = match docked {
            None => Dock::Nominal,
            Some(pose) => Dock::Measured(DockPose {
                x: Millimeters(pose.x_mm),
                y: Millimeters(pose.y_mm),
                heading: Degrees(pose.heading_deg),
            }),
        };
        let target = match target {
            workflow::Target::Safe => Target::Safe,
            workflow::Target::ApproachOf { place } => Target::ApproachOf(self.id_of(place)?),
            workflow::Target::At { place } => Target::At(self.id_of(place)?),
            workflow::Target::LiftOf { place } => Target::LiftOf(self.id_of(place)?),
        };
        self.resolve(arm, target, dock)
    }

    /// The waypoints of a mobile robot's way from one point to another, where one route leads there.
    pub(crate) fn way(&self, robot: &str, from: &str, to: &str) -> Option<Vec<[Millimeters; 2]>> {
        let mut routes = self.routes.iter();
        routes.find_map(|route| {
            let there = route.from == from && route.to == to;
            let back =
                route.direction == RouteDirection::BothWays && route.from == to && route.to == from;
            if !route.robots.includes(robot) || !(there || back) {
                return None;
            }
            let mut waypoints = route.waypoints.clone();
            if !there {
                waypoints.reverse();
            }
            Some(waypoints)
        })
    }

    fn point_for(&self, point: &LoadPoint) -> Point {
        Point {
            id: point.id.clone(),
            arms: point.arms.clone(),
            // A checked set-up has one wherever an arm works.
            zone: point.zone.clone().unwrap_or_default(),
            dock: BasePose {
                x_mm: point.dock.x.0,
                y_mm: point.dock.y.0,
                heading_deg: point.dock.heading.0,
            },
            tolerance: Tolerance {
                mm: point.tolerance.position.0,
                deg: point.tolerance.angle.0,
            },
            route: self.way_toward(point),
        }
    }

    /// The waypoints of the first route that leads to a point, each with the heading of the way onward.
    fn way_toward(&self, point: &LoadPoint) -> Vec<BasePose> {
        let first = self.routes.iter().find_map(|route| {
            if route.to == point.id {
                Some(route.waypoints.clone())
            } else if route.from == point.id && route.direction == RouteDirection::BothWays {
                Some(route.waypoints.iter().rev().copied().collect())
            } else {
                None
            }
        });
        let waypoints = first.unwrap_or_default();
        let end = [point.dock.x, point.dock.y];
        let onward = waypoints.iter().skip(1).copied().chain([end]);
        waypoints
            .iter()
            .zip(onward)
            .map(|([x, y], [to_x, to_y])| BasePose {
                x_mm: x.0,
                y_mm: y.0,
                heading_deg: (to_y.0 - y.0).atan2(to_x.0 - x.0).to_degrees(),
            })
            .collect()
    }

    fn location_of(&self, at: &Whereabouts) -> Location {
        match at {
            Whereabouts::Place(place) => Location::Fixed {
                place: place.clone(),
            },
            Whereabouts::OnMobileRobot { mobile_robot, slot } => Location::MobileRobot {
                mobile_robot: mobile_robot.clone(),
                slot: slot.clone(),
            },
            Whereabouts::Destination(id) => {
                let mut all = self.destinations.iter();
                let point = all.find(|known| known.id == *id).map(|known| &known.point);
                Location::Delivered {
                    destination: point.unwrap_or(id).clone(),
                }
            }
        }
    }

    /// The taught pose of an arm at the place that a workflow means.
    pub(crate) fn taught_at(&self, arm: &str, place: &PlaceRef) -> Option<usize> {
        let id = self.id_of(place).ok()?;
        let mut all = self.taught.iter();
        all.position(|taught| taught.arm == arm && taught.place == id)
    }

    /// The id of the place that a workflow means.
    fn id_of(&self, place: &PlaceRef) -> Result<&str, ResolveError> {
        let mut places = self.places.iter();
        let found = places.find(|known| known.is(place));
        found
            .map(|known| known.id.as_str())
            .ok_or_else(|| ResolveError::NoPlace {
                place: place.to_string(),
            })
    }

    fn timers_for(&self) -> Timers {
        let mut timers = Timers::default();
        let own = &self.timers;
        for (timer, value) in [
            (&mut timers.reserve_ms, own.reserve_ms),
            (&mut timers.precheck_ms, own.precheck_ms),
            (&mut timers.acknowledge_ms, own.acknowledge_ms),
            (&mut timers.arrival_ms, own.arrive_ms),
            (&mut timers.dock_ms, own.dock_ms),
            (&mut timers.verify_ms, own.verify_ms),
            (&mut timers.ready_ms, own.ready_ms),
            (&mut timers.grip_ms, own.grip_ms),
            (&mut timers.exit_ms, own.exit_ms),
            (&mut timers.clear_ms, own.clear_ms),
            (&mut timers.prefetch_hold_ms, own.hold_ms),
            (&mut timers.safe_ms, own.safe_ms),
            (&mut timers.transport_ms, own.transport_ms),
            (&mut timers.heartbeat_ms, own.heartbeat_ms),
            (&mut timers.arm_silence_ms, own.arm_silence_ms),
            (&mut timers.motion_margin_ms, own.motion_margin_ms),
        ] {
            if let Some(value) = value {
                *timer = value;
            }
        }
        timers
    }
}

impl Place {
    /// Whether it is the one that a workflow means.
    pub(super) fn is(&self, place: &PlaceRef) -> bool {
        reference_of(self) == *place
    }
}

/// A place as the workflows name it.
fn reference_of(place: &Place) -> PlaceRef {
    match &place.site {
        Site::Fixed | Site::Buffer | Site::Reject => PlaceRef::fixed(place.id.clone()),
        Site::OnMobileRobot { point, slot } => PlaceRef::MobileRobot {
            point: point.clone(),
            slot: slot.clone(),
        },
    }
}

/// A place that stands still; the ones on mobile robots follow from points and slots.
fn place_for(place: &Place) -> Option<workflow::Place> {
    let kind = match place.site {
        Site::Fixed | Site::Buffer => PlaceKind::Fixed,
        Site::Reject => PlaceKind::Reject,
        Site::OnMobileRobot { .. } => return None,
    };
    Some(workflow::Place {
        id: place.id.clone(),
        kind,
        accepts: place.accepts.clone(),
    })
}
