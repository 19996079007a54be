//! The set-up of the little world, and jobs for it.

use workflow::{
    ItemParams, LoadSetup, Location, MobileRobotSetup, NewJob, OnCancel, Place, PlaceKind,
    PlaceRef, Point, Principal, Role, Setup, Taught, Timers, Tolerance, Workflow,
};

use super::{DOCK, POINT, ZONE};

pub fn slot(name: &str) -> PlaceRef {
    PlaceRef::MobileRobot {
        point: POINT.into(),
        slot: name.into(),
    }
}

pub fn setup() -> Setup {
    let places = ["rack/a", "rack/b", "rack/c", "rack/d"];
    let mut all: Vec<_> = places
        .iter()
        .map(|id| Place {
            id: (*id).into(),
            kind: PlaceKind::Fixed,
            accepts: vec![],
        })
        .collect();
    all.push(Place {
        id: "bin".into(),
        kind: PlaceKind::Reject,
        accepts: vec![],
    });
    let mut taught = Vec::new();
    for arm in ["r1", "r2"] {
        for place in places.iter().chain(&["bin"]) {
            taught.push(Taught {
                arm: arm.into(),
                place: PlaceRef::fixed(*place),
            });
        }
        for name in ["s1", "s2", "s3"] {
            taught.push(Taught {
                arm: arm.into(),
                place: slot(name),
            });
        }
    }
    let load = |id: &str, at: Location| LoadSetup {
        id: id.into(),
        kind: "box".into(),
        at,
    };
    let on = |name: &str| Location::MobileRobot {
        mobile_robot: "m1".into(),
        slot: name.into(),
    };
    Setup {
        arms: vec!["r1".into(), "r2".into()],
        mobile_robots: ["m1", "m2"]
            .iter()
            .map(|id| MobileRobotSetup {
                id: (*id).into(),
                slots: vec!["s1".into(), "s2".into(), "s3".into()],
                max_speed_mm_s: None,
            })
            .collect(),
        points: vec![Point {
            id: POINT.into(),
            arms: vec!["r1".into(), "r2".into()],
            zone: ZONE.into(),
            dock: DOCK,
            tolerance: Tolerance { mm: 10.0, deg: 2.0 },
            route: vec![],
        }],
        places: all,
        taught,
        loads: vec![
            load("L1", on("s1")),
            load("L2", on("s2")),
            load("P1", fixed("rack/c")),
            load("P2", fixed("rack/d")),
        ],
        destinations: vec!["warehouse".into()],
        triggers: vec![],
        timers: Timers::default(),
    }
}

/// A place that does not drive away.
pub fn fixed(place: &str) -> Location {
    Location::Fixed {
        place: place.into(),
    }
}

pub fn item(load: Option<&str>, mr_slot: &str, place: &str) -> ItemParams {
    ItemParams {
        load_id: load.map(Into::into),
        kind: "box".into(),
        mr_slot: mr_slot.into(),
        place: place.into(),
        alternates: vec![],
    }
}

pub fn delivery() -> NewJob {
    NewJob {
        workflow: Workflow::DeliveryAndPlacement,
        mobile_robot: Some("m1".into()),
        arm: Some("r1".into()),
        point: POINT.into(),
        items: vec![item(Some("L1"), "s1", "rack/a")],
        early_release: false,
        prefetch: false,
        on_cancel_with_load: OnCancel::Hold,
        reject_slot: None,
        max_attempts: 2,
        destination: None,
        complete_on: workflow::CompleteOn::Departed,
        priority: 0,
        deadline: None,
        expected_arrival_ms: None,
        expected_transport_ms: None,
    }
}

pub fn pickup() -> NewJob {
    NewJob {
        workflow: Workflow::PickupAndDelivery,
        items: vec![item(Some("P1"), "s3", "rack/c")],
        destination: Some("warehouse".into()),
        complete_on: workflow::CompleteOn::Delivered,
        ..delivery()
    }
}

pub fn operator() -> Principal {
    Principal {
        name: "ada".into(),
        role: Role::Operator,
    }
}

pub fn integrator() -> Principal {
    Principal {
        name: "ivo".into(),
        role: Role::Integrator,
    }
}
