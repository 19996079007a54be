//! The parts of a set-up as resources: their names, where they stand in the file, which of them a change touches.

use std::fmt;

use api::setup::{
    ArmSetup, DestinationBody, LoadBody, MobileRobotSetup, PlaceBody, RouteBody, SetupFile,
    StationBody, TaughtPoseBody, ToolSetup, TriggerBody, ZoneBody,
};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The name of a part of a set-up: its path below `…/setup/`.
#[derive(Clone, Debug, Eq, Hash, PartialEq)]
pub(crate) enum Resource {
    /// What is in no part of its own: the format and the cell's name.
    Header,
    Timers,
    Arm(String),
    Tool {
        arm: String,
        number: u8,
    },
    Zone(String),
    Station(String),
    Place(String),
    TaughtPose {
        arm: String,
        place: String,
    },
    Destination(String),
    MobileRobot(String),
    Route(String),
    Load(String),
    Trigger(String),
}

/// `taught-poses/r1/rack/a`
impl fmt::Display for Resource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Header => f.write_str("name"),
            Self::Timers => f.write_str("timers"),
            Self::Arm(id) => write!(f, "arms/{id}"),
            Self::Tool { arm, number } => write!(f, "tools/{arm}/{number}"),
            Self::Zone(id) => write!(f, "zones/{id}"),
            Self::Station(id) => write!(f, "stations/{id}"),
            Self::Place(id) => write!(f, "places/{id}"),
            Self::TaughtPose { arm, place } => write!(f, "taught-poses/{arm}/{place}"),
            Self::Destination(id) => write!(f, "destinations/{id}"),
            Self::MobileRobot(id) => write!(f, "mobile-robots/{id}"),
            Self::Route(id) => write!(f, "routes/{id}"),
            Self::Load(id) => write!(f, "loads/{id}"),
            Self::Trigger(id) => write!(f, "triggers/{id}"),
        }
    }
}

/// A part that is a resource of its own.
pub(crate) trait Part:
    Clone + PartialEq + Serialize + DeserializeOwned + Send + 'static
{
    /// Its name.
    fn resource(&self) -> Resource;
    /// The list it stands in.
    fn all(file: &SetupFile) -> &Vec<Self>;
    fn all_mut(file: &mut SetupFile) -> &mut Vec<Self>;
}

macro_rules! parts {
    ($($part:ty, $list:ident, $this:ident => $resource:expr;)*) => {
        $(impl Part for $part {
            fn resource(&self) -> Resource {
                let $this = self;
                $resource
            }

            fn all(file: &SetupFile) -> &Vec<Self> {
                &file.$list
            }

            fn all_mut(file: &mut SetupFile) -> &mut Vec<Self> {
                &mut file.$list
            }
        })*

        /// The parts that differ between two set-ups, each once.
        pub(crate) fn touched(before: &SetupFile, after: &SetupFile) -> Vec<Resource> {
            let mut touched = Vec::new();
            if (before.format, &before.name) != (after.format, &after.name) {
                touched.push(Resource::Header);
            }
            if before.timers != after.timers {
                touched.push(Resource::Timers);
            }
            $(differences::<$part>(before, after, &mut touched);)*
            touched
        }
    };
}

parts! {
    ArmSetup, arms, arm => Resource::Arm(arm.id.clone());
    ToolSetup, tools, tool => Resource::Tool { arm: tool.arm.clone(), number: tool.number };
    ZoneBody, zones, zone => Resource::Zone(zone.id.clone());
    StationBody, stations, station => Resource::Station(station.id.clone());
    PlaceBody, places, place => Resource::Place(place.id.clone());
    TaughtPoseBody, taught_poses, taught => Resource::TaughtPose {
        arm: taught.arm.clone(),
        place: taught.place.clone(),
    };
    DestinationBody, destinations, destination => Resource::Destination(destination.id.clone());
    MobileRobotSetup, mobile_robots, robot => Resource::MobileRobot(robot.id.clone());
    RouteBody, routes, route => Resource::Route(route.id.clone());
    LoadBody, loads, load => Resource::Load(load.id.clone());
    TriggerBody, triggers, trigger => Resource::Trigger(trigger.id.clone());
}

/// Adds the parts of one list that were added, changed or deleted.
fn differences<P: Part>(before: &SetupFile, after: &SetupFile, touched: &mut Vec<Resource>) {
    let (before, after) = (P::all(before), P::all(after));
    for part in after {
        let known = before
            .iter()
            .find(|known| known.resource() == part.resource());
        if known != Some(part) {
            touched.push(part.resource());
        }
    }
    for part in before {
        if !after.iter().any(|left| left.resource() == part.resource()) {
            touched.push(part.resource());
        }
    }
}

/// A part by its name.
pub(crate) fn find<'a, P: Part>(file: &'a SetupFile, resource: &Resource) -> Option<&'a P> {
    P::all(file)
        .iter()
        .find(|part| part.resource() == *resource)
}

/// Puts a part in the place of the one with its name, or behind the others.
pub(crate) fn put<P: Part>(file: &mut SetupFile, part: P) {
    let resource = part.resource();
    let list = P::all_mut(file);
    match list.iter_mut().find(|known| known.resource() == resource) {
        Some(known) => *known = part,
        None => list.push(part),
    }
}

/// Takes a part out; whether there was one.
pub(crate) fn remove<P: Part>(file: &mut SetupFile, resource: &Resource) -> bool {
    let list = P::all_mut(file);
    let before = list.len();
    list.retain(|part| part.resource() != *resource);
    list.len() < before
}
