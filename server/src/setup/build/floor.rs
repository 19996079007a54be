//! Stations, places, destinations, mobile robots, routes and loads.

use api::setup::{LoadBody, OnMobileRobot, PlaceBody, PlaceKind, SlotBody, ZoneKind};
use nalgebra::Point3;
use units::{Degrees, Millimeters};

use super::arms::named;
use super::refs::{Refs, Which};
use super::{MAX_FEW, SIZE_MM, planar, unique};
use crate::setup::faults::Faults;
use crate::setup::geometry::DockTolerance;
use crate::setup::model::{
    Destination, Load, LoadPoint, MobileRobot, Place, Route, Site, Slot, Whereabouts, Zone,
};
use crate::setup::text::{check_id, check_name, check_place_id};
use crate::state::shown;

// No dock is met exactly: a tolerance of nothing would refuse every mobile robot.
const TOLERANCE_MM: (f64, f64) = (0.1, 500.0);
const TOLERANCE_DEG: (f64, f64) = (0.1, 45.0);
const FOOTPRINT_MM: (f64, f64) = (1.0, 10_000.0);
/// Tests run mobile robots many times faster than real ones.
const SPEED_MM_S: (f64, f64) = (1.0, 1_000_000.0);

pub(super) fn points(faults: &mut Faults, refs: &Refs<'_>, zones: &[Zone]) -> Vec<LoadPoint> {
    let stations = &refs.file.stations;
    unique(
        faults,
        named(stations, "stations", |station| station.id.as_str()),
        |id| format!("`{id}`"),
    );
    let mut checked = Vec::new();
    for (index, station) in stations.iter().enumerate() {
        let item = format!("stations[{index}]");
        check_id(faults, format!("{item}.id"), &station.id);
        check_name(faults, format!("{item}.name"), station.name.as_deref());
        let list = format!("{item}.points");
        if station.points.is_empty() {
            faults.add(
                &list,
                "is empty; a station has at least one load-handling point",
            );
        }
        faults.count(&list, station.points.len(), MAX_FEW);
        unique(
            faults,
            named(&station.points, &list, |point| point.id.as_str()),
            |id| format!("`{id}`"),
        );
        for (index, point) in station.points.iter().enumerate() {
            let item = format!("{list}[{index}]");
            check_id(faults, format!("{item}.id"), &point.id);
            for (index, arm) in point.arms.iter().enumerate() {
                let _robot = refs.arm(faults, format!("{item}.arms[{index}]"), arm);
            }
            let dock = planar(faults, &format!("{item}.dock"), &point.dock);
            let tolerance = &point.dock_tolerance;
            let at = format!("{item}.dock_tolerance");
            let position = faults.number(
                format!("{at}.position_mm"),
                tolerance.position_mm,
                TOLERANCE_MM,
            );
            let angle = faults.number(
                format!("{at}.angle_deg"),
                tolerance.angle_deg,
                TOLERANCE_DEG,
            );
            let zone = point.zone.as_deref();
            if let Some(zone) = zone
                && let Some(found) = refs.zone(faults, format!("{item}.zone"), zone)
                && found.kind != ZoneKind::Handover
            {
                faults.add(
                    format!("{item}.zone"),
                    format!("`{zone}` is no HANDOVER zone"),
                );
            }
            if zone.is_none() && !point.arms.is_empty() {
                faults.add(
                    format!("{item}.zone"),
                    "is absent; where an arm works there must be a HANDOVER zone, so that arm and mobile robot are never in it both",
                );
            }
            if let (Some(dock), Some(position), Some(angle)) = (dock, position, angle) {
                let around = zones.iter().find(|known| Some(known.id.as_str()) == zone);
                if let Some(around) = around {
                    let height = f64::midpoint(around.bounds.min.z, around.bounds.max.z);
                    if !around
                        .bounds
                        .contains(&Point3::new(dock.x.0, dock.y.0, height))
                    {
                        faults.add(
                            format!("{item}.dock"),
                            format!(
                                "x {}, y {} mm is outside of its zone `{}`",
                                dock.x.0, dock.y.0, around.id
                            ),
                        );
                    }
                }
                checked.push(LoadPoint {
                    id: format!("{}/{}", station.id, point.id),
                    arms: point.arms.clone(),
                    zone: point.zone.clone(),
                    dock,
                    tolerance: DockTolerance {
                        position: Millimeters(position),
                        angle: Degrees(angle),
                    },
                });
            }
        }
    }
    checked
}

/// Two points with one zone could give it to two mobile robots, or to an arm and a mobile robot.
pub(super) fn handovers_have_their_own_zones(faults: &mut Faults, refs: &Refs<'_>) {
    let zones = refs
        .file
        .stations
        .iter()
        .enumerate()
        .flat_map(|(s, station)| {
            let points = station.points.iter().enumerate();
            points.filter_map(move |(p, point)| {
                let zone = point.zone.as_deref()?;
                Some((format!("stations[{s}].points[{p}].zone"), zone))
            })
        });
    unique(faults, zones, |zone| format!("the zone `{zone}`"));
}

fn accepts(faults: &mut Faults, item: &str, types: &[String]) {
    if types.is_empty() {
        faults.add(item, "is empty; name at least one type of load");
    }
    faults.count(item, types.len(), MAX_FEW);
    for (index, load_type) in types.iter().enumerate() {
        check_id(faults, format!("{item}[{index}]"), load_type);
    }
    let each = types.iter().enumerate();
    unique(
        faults,
        each.map(|(index, load_type)| (format!("{item}[{index}]"), load_type.as_str())),
        |load_type| format!("`{load_type}`"),
    );
}

pub(super) fn places(faults: &mut Faults, refs: &Refs<'_>) -> Vec<Place> {
    let bodies = &refs.file.places;
    unique(
        faults,
        named(bodies, "places", |place| place.id.as_str()),
        |id| format!("`{id}`"),
    );
    let on_robots = bodies.iter().enumerate().filter_map(|(index, place)| {
        let key = (place.point.as_deref()?, place.slot.as_deref()?);
        Some((format!("places[{index}]"), key))
    });
    unique(faults, on_robots, |(point, slot)| {
        format!("slot `{slot}` at `{point}`")
    });
    let mut checked = Vec::with_capacity(bodies.len());
    for (index, body) in bodies.iter().enumerate() {
        let item = format!("places[{index}]");
        check_place_id(faults, format!("{item}.id"), &body.id);
        check_name(faults, format!("{item}.name"), body.name.as_deref());
        accepts(faults, &format!("{item}.accepts"), &body.accepts);
        if let Some(site) = site(faults, refs, &item, body) {
            checked.push(Place {
                id: body.id.clone(),
                site,
                accepts: body.accepts.clone(),
            });
        }
    }
    checked
}

fn site(faults: &mut Faults, refs: &Refs<'_>, item: &str, body: &PlaceBody) -> Option<Site> {
    let still = match body.kind {
        PlaceKind::Fixed => Some(Site::Fixed),
        PlaceKind::Buffer => Some(Site::Buffer),
        PlaceKind::Reject => Some(Site::Reject),
        PlaceKind::OnMobileRobot => None,
    };
    if still.is_some() {
        for (key, value) in [("point", &body.point), ("slot", &body.slot)] {
            if value.is_some() {
                faults.add(
                    format!("{item}.{key}"),
                    "belongs to ON_MOBILE_ROBOT; this place stands still",
                );
            }
        }
        return still;
    }
    for (key, value) in [("point", &body.point), ("slot", &body.slot)] {
        if value.is_none() {
            faults.add(
                format!("{item}.{key}"),
                "is absent; a place ON_MOBILE_ROBOT has a point and a slot",
            );
        }
    }
    let (point, slot) = (body.point.clone()?, body.slot.clone()?);
    let found = refs.point(faults, format!("{item}.point"), &point);
    if let Some(found) = found
        && found.arms.is_empty()
    {
        faults.add(
            format!("{item}.point"),
            format!("no arm works at `{point}`: nobody could reach this place"),
        );
    }
    let mut slots = refs
        .file
        .mobile_robots
        .iter()
        .flat_map(|robot| &robot.slots);
    if !slots.any(|known| known.id == slot) {
        faults.add(
            format!("{item}.slot"),
            format!("`{}` is a slot of no mobile robot", shown(&slot)),
        );
    }
    Some(Site::OnMobileRobot { point, slot })
}

pub(super) fn destinations(faults: &mut Faults, refs: &Refs<'_>) -> Vec<Destination> {
    let bodies = &refs.file.destinations;
    unique(
        faults,
        named(bodies, "destinations", |body| body.id.as_str()),
        |id| format!("`{id}`"),
    );
    let each = bodies.iter().enumerate();
    each.map(|(index, body)| {
        let item = format!("destinations[{index}]");
        check_id(faults, format!("{item}.id"), &body.id);
        check_name(faults, format!("{item}.name"), body.name.as_deref());
        let _point = refs.point(faults, format!("{item}.point"), &body.point);
        Destination {
            id: body.id.clone(),
            point: body.point.clone(),
        }
    })
    .collect()
}

pub(super) fn mobile_robots(faults: &mut Faults, refs: &Refs<'_>) -> Vec<MobileRobot> {
    let bodies = &refs.file.mobile_robots;
    let arms = named(&refs.file.arms, "arms", |arm| arm.id.as_str());
    let robots = named(bodies, "mobile_robots", |robot| robot.id.as_str());
    // One namespace: zones are for arms and mobile robots alike.
    let mobile = arms.filter(|(_, id)| bodies.iter().any(|robot| robot.id == *id));
    unique(faults, mobile.chain(robots), |id| format!("`{id}`"));
    let mut checked = Vec::with_capacity(bodies.len());
    for (index, body) in bodies.iter().enumerate() {
        let item = format!("mobile_robots[{index}]");
        check_id(faults, format!("{item}.id"), &body.id);
        check_name(faults, format!("{item}.name"), body.name.as_deref());
        if let Some(home) = &body.home {
            let _point = refs.point(faults, format!("{item}.home"), home);
        }
        let size = &body.footprint;
        let at = format!("{item}.footprint");
        let length = faults.number(format!("{at}.length_mm"), size.length_mm, FOOTPRINT_MM);
        let width = faults.number(format!("{at}.width_mm"), size.width_mm, FOOTPRINT_MM);
        let height = faults.number(format!("{at}.height_mm"), size.height_mm, FOOTPRINT_MM);
        if let Some(speed) = body.max_speed_mm_s {
            let item = format!("{item}.max_speed_mm_s");
            let _speed = faults.number(item, f64::from(speed), SPEED_MM_S);
        }
        let slots = slots(faults, &format!("{item}.slots"), &body.slots);
        if let (Some(length), Some(width), Some(height)) = (length, width, height) {
            checked.push(MobileRobot {
                id: body.id.clone(),
                home: body.home.clone(),
                length: Millimeters(length),
                width: Millimeters(width),
                height: Millimeters(height),
                max_speed_mm_s: body.max_speed_mm_s,
                slots,
            });
        }
    }
    checked
}

fn slots(faults: &mut Faults, list: &str, bodies: &[SlotBody]) -> Vec<Slot> {
    if bodies.is_empty() {
        faults.add(list, "is empty; a mobile robot has at least one slot");
    }
    faults.count(list, bodies.len(), MAX_FEW);
    unique(faults, named(bodies, list, |slot| slot.id.as_str()), |id| {
        format!("`{id}`")
    });
    let each = bodies.iter().enumerate();
    each.map(|(index, slot)| {
        check_id(faults, format!("{list}[{index}].id"), &slot.id);
        accepts(faults, &format!("{list}[{index}].accepts"), &slot.accepts);
        Slot {
            id: slot.id.clone(),
            accepts: slot.accepts.clone(),
        }
    })
    .collect()
}

pub(super) fn routes(faults: &mut Faults, refs: &Refs<'_>) -> Vec<Route> {
    let bodies = &refs.file.routes;
    unique(
        faults,
        named(bodies, "routes", |route| route.id.as_str()),
        |id| format!("`{id}`"),
    );
    let mut checked = Vec::with_capacity(bodies.len());
    for (index, body) in bodies.iter().enumerate() {
        let item = format!("routes[{index}]");
        check_id(faults, format!("{item}.id"), &body.id);
        let _point = refs.point(faults, format!("{item}.from"), &body.from);
        let _point = refs.point(faults, format!("{item}.to"), &body.to);
        if body.from == body.to {
            faults.add(
                format!("{item}.to"),
                format!("`{}` is where the route begins", shown(&body.to)),
            );
        }
        let robots = refs.scope(
            faults,
            &format!("{item}.robots"),
            body.robots.as_ref(),
            Which::Mobile,
        );
        let list = format!("{item}.waypoints");
        faults.count(&list, body.waypoints.len(), MAX_FEW);
        let mut waypoints = Vec::with_capacity(body.waypoints.len());
        for (index, waypoint) in body.waypoints.iter().enumerate() {
            let x = faults.number(format!("{list}[{index}].x_mm"), waypoint.x_mm, SIZE_MM);
            let y = faults.number(format!("{list}[{index}].y_mm"), waypoint.y_mm, SIZE_MM);
            waypoints.extend(x.zip(y).map(|(x, y)| [Millimeters(x), Millimeters(y)]));
        }
        checked.push(Route {
            id: body.id.clone(),
            from: body.from.clone(),
            to: body.to.clone(),
            direction: body.direction,
            robots,
            waypoints,
        });
    }
    checked
}

pub(super) fn loads(faults: &mut Faults, refs: &Refs<'_>) -> Vec<Load> {
    let bodies = &refs.file.loads;
    unique(
        faults,
        named(bodies, "loads", |load| load.id.as_str()),
        |id| format!("`{id}`"),
    );
    let mut checked = Vec::with_capacity(bodies.len());
    let mut taken: Vec<(String, Whereabouts)> = Vec::new();
    for (index, body) in bodies.iter().enumerate() {
        let item = format!("loads[{index}]");
        check_id(faults, format!("{item}.id"), &body.id);
        check_id(faults, format!("{item}.type"), &body.load_type);
        check_name(faults, format!("{item}.name"), body.name.as_deref());
        let Some((key, at, holds)) = whereabouts(faults, refs, &item, body) else {
            continue;
        };
        match holds {
            Holds::One => taken.push((format!("{item}.{key}"), at.clone())),
            Holds::Many => {}
        }
        checked.push(Load {
            id: body.id.clone(),
            kind: body.load_type.clone(),
            at,
        });
    }
    for (at, (item, place)) in taken.iter().enumerate() {
        if taken.iter().take(at).any(|(_, other)| other == place) {
            faults.add(item, "an earlier load is in the same place; it holds one");
        }
    }
    checked
}

/// How many loads a place holds.
#[derive(Clone, Copy, Debug)]
enum Holds {
    One,
    Many,
}

/// Where a load is at first, by which key, and how many loads there may be.
fn whereabouts(
    faults: &mut Faults,
    refs: &Refs<'_>,
    item: &str,
    body: &LoadBody,
) -> Option<(&'static str, Whereabouts, Holds)> {
    let (key, at, accepts, holds) = match (&body.place, &body.destination, &body.on) {
        (Some(place), None, None) => {
            let found = refs.place(faults, format!("{item}.place"), place)?;
            let holds = match found.kind {
                PlaceKind::Fixed | PlaceKind::Buffer => Holds::One,
                PlaceKind::Reject => Holds::Many,
                PlaceKind::OnMobileRobot => {
                    faults.add(
                        format!("{item}.place"),
                        format!("`{place}` is on whichever robot is docked; `on` names the robot and the slot"),
                    );
                    return None;
                }
            };
            let at = Whereabouts::Place(place.clone());
            ("place", at, Some(&found.accepts), holds)
        }
        (None, Some(destination), None) => {
            let _found = refs.destination(faults, format!("{item}.destination"), destination)?;
            let at = Whereabouts::Destination(destination.clone());
            ("destination", at, None, Holds::Many)
        }
        (None, None, Some(OnMobileRobot { mobile_robot, slot })) => {
            let robot =
                refs.mobile_robot(faults, format!("{item}.on.mobile_robot"), mobile_robot)?;
            let Some(found) = robot.slots.iter().find(|known| known.id == *slot) else {
                let known: Vec<_> = robot.slots.iter().map(|slot| shown(&slot.id)).collect();
                faults.add(
                    format!("{item}.on.slot"),
                    format!(
                        "`{}` is no slot of `{mobile_robot}`; there are {}",
                        shown(slot),
                        known.join(", ")
                    ),
                );
                return None;
            };
            let at = Whereabouts::OnMobileRobot {
                mobile_robot: mobile_robot.clone(),
                slot: slot.clone(),
            };
            ("on", at, Some(&found.accepts), Holds::One)
        }
        (place, destination, on) => {
            let given = [place.is_some(), destination.is_some(), on.is_some()];
            let count = given.into_iter().filter(|given| *given).count();
            faults.add(
                item,
                format!("has {count} of `place`, `destination` and `on`; exactly one says where the load is at first"),
            );
            return None;
        }
    };
    if let Some(accepts) = accepts.filter(|accepts| !accepts.contains(&body.load_type)) {
        faults.add(
            format!("{item}.type"),
            format!(
                "`{}` is not accepted there; accepted are {}",
                shown(&body.load_type),
                accepts.join(", ")
            ),
        );
    }
    Some((key, at, holds))
}
