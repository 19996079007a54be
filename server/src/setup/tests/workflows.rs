use units::Millimeters;
use workflow::{BasePose, Location, PlaceRef, Target};

use super::support::{DEMO, PAIR, setup};
use crate::setup::resolve::{Dock, ResolveError};

#[test]
fn the_workflows_find_nothing_wrong_with_a_set_up_that_was_checked() {
    for text in [DEMO, PAIR] {
        let known = setup(text).for_workflows();
        assert_eq!(known.check(), []);
    }
    let known = setup(PAIR).for_workflows();
    assert_eq!(known.points.len(), 2, "the warehouse is a destination");
    assert_eq!(known.destinations, ["warehouse/gate"]);
    assert_eq!(
        known.loads[2].at,
        Location::Delivered {
            destination: "warehouse/gate".to_owned()
        }
    );
    assert_eq!(
        (known.timers.arrival_ms, known.timers.grip_ms),
        (240_000, 2_000)
    );
    assert_eq!(known.timers.dock_ms, workflow::Timers::default().dock_ms);
    assert!(known.is_taught(
        "r2",
        &PlaceRef::MobileRobot {
            point: "aisle/two".to_owned(),
            slot: "left".to_owned()
        }
    ));
    assert!(!known.is_taught("r1", &PlaceRef::fixed("rack-2/a")));
    let toward: Vec<_> = known.points[0]
        .route
        .iter()
        .map(|at| (at.x_mm, at.y_mm))
        .collect();
    assert_eq!(
        toward,
        [(1800.0, -2200.0), (1100.0, -1500.0)],
        "the way from the gate, backward"
    );
    assert!((known.points[0].route[1].heading_deg - 90.0).abs() < 1e-9);
}

#[test]
fn a_target_of_a_workflow_is_a_pose_of_the_arm() {
    let setup = setup(DEMO);
    let left = PlaceRef::MobileRobot {
        point: "handover/front".to_owned(),
        slot: "left".to_owned(),
    };
    let docked = BasePose {
        x_mm: 1105.0,
        y_mm: 2.0,
        heading_deg: 91.0,
    };
    let at = Target::At {
        place: left.clone(),
    };
    let told = setup.resolve_for("r1", &at, Some(docked)).unwrap();
    let same = setup.resolve(
        "r1",
        crate::setup::resolve::Target::At("front/left"),
        Dock::Measured(crate::setup::geometry::DockPose {
            x: Millimeters(1105.0),
            y: Millimeters(2.0),
            heading: units::Degrees(91.0),
        }),
    );
    assert_eq!(told.X_CT, same.unwrap().X_CT);
    let off = BasePose {
        x_mm: 1140.0,
        ..docked
    };
    let refused = setup.resolve_for("r1", &Target::LiftOf { place: left }, Some(off));
    assert!(matches!(
        refused,
        Err(ResolveError::DockOutsideTolerance { .. })
    ));
    let nowhere = Target::ApproachOf {
        place: PlaceRef::fixed("attic"),
    };
    assert!(matches!(
        setup.resolve_for("r1", &nowhere, None),
        Err(ResolveError::NoPlace { .. })
    ));
    assert!(setup.resolve_for("r1", &Target::Safe, None).is_ok());
}

#[test]
fn a_way_leads_there_and_back_unless_it_is_one_way_or_for_others() {
    let setup = setup(PAIR);
    let there = setup.way("mr1", "aisle/one", "warehouse/gate").unwrap();
    let mut back = setup.way("mr1", "warehouse/gate", "aisle/one").unwrap();
    back.reverse();
    assert_eq!(there, back);
    assert!(setup.way("mr2", "aisle/one", "aisle/two").is_some());
    assert!(setup.way("mr2", "aisle/two", "aisle/one").is_none());
    assert!(setup.way("mr1", "aisle/one", "aisle/two").is_none());
}
