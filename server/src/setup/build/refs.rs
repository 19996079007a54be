use std::sync::Arc;

use api::setup::{
    DestinationBody, LoadPointBody, MobileRobotSetup, PlaceBody, SetupFile, StationBody, ToolSetup,
    ZoneBody,
};

use crate::config::RobotPlan;
use crate::setup::faults::Faults;
use crate::setup::model::Scope;
use crate::state::shown;

/// What entries of a file refer to: other entries as they are written, and the cell's robots.
pub(super) struct Refs<'a> {
    pub(super) file: &'a SetupFile,
    pub(super) robots: &'a [Arc<RobotPlan>],
}

impl<'a> Refs<'a> {
    pub(super) fn new(file: &'a SetupFile, robots: &'a [Arc<RobotPlan>]) -> Self {
        Self { file, robots }
    }

    /// The configured robot behind an arm of the set-up.
    pub(super) fn arm(&self, faults: &mut Faults, item: String, id: &str) -> Option<&'a RobotPlan> {
        let known = self.file.arms.iter().any(|arm| arm.id == id);
        if !known {
            let all = self.file.arms.iter().map(|arm| arm.id.as_str());
            faults.add(item, no_such("arm of the set-up", id, all));
            return None;
        }
        self.robot(id)
    }

    pub(super) fn robot(&self, id: &str) -> Option<&'a RobotPlan> {
        self.robots
            .iter()
            .find(|robot| robot.id == id)
            .map(Arc::as_ref)
    }

    pub(super) fn tool(&self, arm: &str, number: u8) -> Option<&'a ToolSetup> {
        let mut tools = self.file.tools.iter();
        tools.find(|tool| tool.arm == arm && tool.number == number)
    }

    pub(super) fn zone(&self, faults: &mut Faults, item: String, id: &str) -> Option<&'a ZoneBody> {
        let zones = &self.file.zones;
        let found = zones.iter().find(|zone| zone.id == id);
        if found.is_none() {
            let all = zones.iter().map(|zone| zone.id.as_str());
            faults.add(item, no_such("zone", id, all));
        }
        found
    }

    pub(super) fn place(
        &self,
        faults: &mut Faults,
        item: String,
        id: &str,
    ) -> Option<&'a PlaceBody> {
        let places = &self.file.places;
        let found = places.iter().find(|place| place.id == id);
        if found.is_none() {
            let all = places.iter().map(|place| place.id.as_str());
            faults.add(item, no_such("place", id, all));
        }
        found
    }

    pub(super) fn destination(
        &self,
        faults: &mut Faults,
        item: String,
        id: &str,
    ) -> Option<&'a DestinationBody> {
        let all = &self.file.destinations;
        let found = all.iter().find(|destination| destination.id == id);
        if found.is_none() {
            let all = all.iter().map(|destination| destination.id.as_str());
            faults.add(item, no_such("destination", id, all));
        }
        found
    }

    pub(super) fn mobile_robot(
        &self,
        faults: &mut Faults,
        item: String,
        id: &str,
    ) -> Option<&'a MobileRobotSetup> {
        let all = &self.file.mobile_robots;
        let found = all.iter().find(|robot| robot.id == id);
        if found.is_none() {
            let all = all.iter().map(|robot| robot.id.as_str());
            faults.add(item, no_such("mobile robot", id, all));
        }
        found
    }

    pub(super) fn station(
        &self,
        faults: &mut Faults,
        item: String,
        id: &str,
    ) -> Option<&'a StationBody> {
        let all = &self.file.stations;
        let found = all.iter().find(|station| station.id == id);
        if found.is_none() {
            let all = all.iter().map(|station| station.id.as_str());
            faults.add(item, no_such("station", id, all));
        }
        found
    }

    /// A load-handling point by `station/point`.
    pub(super) fn point(
        &self,
        faults: &mut Faults,
        item: String,
        id: &str,
    ) -> Option<&'a LoadPointBody> {
        let points = || {
            self.file.stations.iter().flat_map(|station| {
                let points = station.points.iter();
                points.map(move |point| (format!("{}/{}", station.id, point.id), point))
            })
        };
        let found = points()
            .find(|(name, _)| name == id)
            .map(|(_, point)| point);
        if found.is_none() {
            let all: Vec<String> = points().map(|(name, _)| name).collect();
            let message = no_such("load-handling point", id, all.iter().map(String::as_str));
            faults.add(item, message);
        }
        found
    }

    /// Robots something is for: absent means all of them.
    pub(super) fn scope(
        &self,
        faults: &mut Faults,
        item: &str,
        robots: Option<&Vec<String>>,
        which: Which,
    ) -> Scope {
        let Some(robots) = robots else {
            return Scope::All;
        };
        if robots.is_empty() {
            faults.add(
                item,
                "is empty: it would be for no robot. Leave it out for all of them",
            );
        }
        let mobile = self
            .file
            .mobile_robots
            .iter()
            .map(|robot| robot.id.as_str());
        let arms = self.file.arms.iter().map(|arm| arm.id.as_str());
        let (what, all): (_, Vec<&str>) = match which {
            Which::Any => ("robot", arms.chain(mobile).collect()),
            Which::Mobile => ("mobile robot", mobile.collect()),
        };
        for (index, id) in robots.iter().enumerate() {
            if !all.contains(&id.as_str()) {
                let message = no_such(what, id, all.iter().copied());
                faults.add(format!("{item}[{index}]"), message);
            }
        }
        Scope::Only(robots.clone())
    }
}

/// Which robots a scope may name.
#[derive(Clone, Copy, Debug)]
pub(super) enum Which {
    Any,
    Mobile,
}

/// That something is not there, and what is; no more of it than a person reads.
fn no_such<'a>(what: &str, id: &str, all: impl Iterator<Item = &'a str>) -> String {
    const MOST: usize = 12;
    let mut known: Vec<String> = all.map(shown).collect();
    let more = known.len().saturating_sub(MOST);
    known.truncate(MOST);
    let known = match (known.is_empty(), more) {
        (true, _) => "there is none".to_owned(),
        (false, 0) => format!("there are {}", known.join(", ")),
        (false, more) => format!("there are {} and {more} more", known.join(", ")),
    };
    format!("`{}` is no {what}; {known}", shown(id))
}
