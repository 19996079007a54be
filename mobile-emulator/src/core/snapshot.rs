//! The core as it stands, for people and tests.

use mobile_base::PlanarPose;

use super::Core;
use crate::config::RouteShape;
use crate::floor::{body_of, pose_of};
use crate::mission::Phase;
use crate::state::{CellLink, PlannedStop, State, ZoneState};

impl Core {
    pub(crate) fn state(&self) -> State {
        let mission = self.mission.as_ref();
        let zones = self.zone_states();
        State {
            id: self.plan.id.clone(),
            time_s: self.now.as_secs_f64(),
            boot: self.boot,
            down: self.down_until.is_some(),
            mode: self.mode,
            pose: body_of(self.motion.pose()),
            believed_pose: body_of(self.motion.believed()),
            told_pose: self.told_pose(),
            driving: self.driving(),
            stands_because: self.stands(),
            paused: self.paused,
            speed_mm_s: self.motion.speed().0,
            wheels_rad_s: self.motion.wheels().map(|speed| speed.0),
            fastest_wheel_rad_s: self.fastest_wheel,
            max_wheel_rad_s: self.plan.base.dimensions().max_wheel_speed.0,
            left_mm: self.motion.left().0,
            odometer_mm: self.motion.odometer_mm(),
            battery_percent: self.charge,
            slots: self.slots.list().to_vec(),
            order: mission.map(|mission| mission.order.order),
            update: mission.map(|mission| mission.order.update),
            session: mission.and_then(|mission| mission.session),
            phase: mission.map(|mission| mission.phase),
            goal: mission.map(|mission| mission.order.goal.clone()),
            move_permit: mission.is_some_and(|mission| mission.permit),
            exit_granted: mission.is_some_and(|mission| mission.exit),
            at_point: self.at_point.clone(),
            errors: self.errors.clone(),
            faults: self.faults.list(),
            zones,
            stops: self.stops(),
            footprint_mm: self.footprint(),
            obstacles: self.round_obstacles(),
            cell: CellLink {
                away: self.cell_away,
                last_seq: self.outbound.last_seq(),
                waiting_signals: self.outbound.waiting(),
                last_message: self.seen,
            },
        }
    }

    fn zone_states(&self) -> Vec<ZoneState> {
        let each = self
            .zones()
            .into_iter()
            .map(|(point, zone, free)| ZoneState {
                touched: self.touching.contains(&point),
                area: zone.area,
                may_move: free,
                point,
            });
        each.collect()
    }

    /// The places of the order that are still to come, for the floor plan.
    fn stops(&self) -> Vec<PlannedStop> {
        let Some(mission) = &self.mission else {
            return Vec::new();
        };
        let stop = |name: &str, pose: PlanarPose| PlannedStop {
            name: name.to_owned(),
            pose: body_of(pose),
        };
        let mut stops = Vec::new();
        let approaching = mission.phase == Phase::Approach;
        let (places, passed) = if mission.clear_told {
            (&mission.order.then_route, 0)
        } else if approaching && self.plan.route == RouteShape::Waypoints {
            // A leg for each place.
            (&mission.order.route, self.motion.leg())
        } else if approaching {
            (&mission.order.route, 0)
        } else {
            (&mission.order.then_route, mission.order.then_route.len())
        };
        for place in places.iter().skip(passed) {
            stops.extend(via(place));
        }
        if approaching {
            stops.push(stop("", mission.approach));
        }
        if !mission.clear_told {
            stops.push(stop(&mission.order.goal, mission.dock));
        }
        if let Some(destination) = &mission.destination {
            stops.push(stop(&destination.name, destination.pose));
        }
        stops
    }

    /// Length and width.
    fn footprint(&self) -> [f64; 2] {
        self.footprint_mm
    }

    fn round_obstacles(&self) -> Vec<[f64; 3]> {
        let mut all = self.obstacle_circles.clone();
        for fault in self.faults.iter() {
            if let crate::Fault::Obstacle {
                x_mm,
                y_mm,
                radius_mm,
                ..
            } = fault
            {
                all.push([*x_mm, *y_mm, *radius_mm]);
            }
        }
        all
    }
}

fn via(place: &api::RoutePointBody) -> Option<PlannedStop> {
    let body = api::FloorPoseBody {
        x_mm: place.x_mm,
        y_mm: place.y_mm,
        heading_deg: place.heading_deg.unwrap_or_default(),
    };
    let pose = pose_of(&body).ok()?;
    Some(PlannedStop {
        name: String::new(),
        pose: api::FloorPoseBody {
            heading_deg: body_of(pose).heading_deg,
            ..body
        },
    })
}
