use api::setup::{ExplicitPose, PlanarPoseBody, PoseFrame, TaughtPoseBody, TeachBody};

use super::support::{DEMO, PAIR, file, setup};
use crate::setup::SetupErrors;
use crate::setup::resolve::{Dock, Target};
use crate::wire_bodies::joints_body;

fn body() -> TeachBody {
    TeachBody {
        approach_mm: None,
        lift_mm: None,
        frame: PoseFrame::Cell,
        measured_dock: None,
        at: None,
    }
}

fn teach(text: &str, place: &str, body: &TeachBody) -> Result<TaughtPoseBody, SetupErrors> {
    setup(text).teach(&file(text), "r1", place, body, None)
}

#[test]
fn the_pose_of_an_arm_that_stands_at_the_place_is_the_taught_one() {
    for text in [DEMO, PAIR] {
        let (setup, file) = (setup(text), file(text));
        for taught in &file.taught_poses {
            let at = setup.resolve(&taught.arm, Target::At(&taught.place), Dock::Nominal);
            let body = TeachBody {
                frame: taught.frame,
                ..body()
            };
            let actual = Some(at.unwrap().joints);
            let again = setup
                .teach(&file, &taught.arm, &taught.place, &body, actual)
                .unwrap();
            assert!((again.approach_mm - taught.approach_mm).abs() < 1e-12);
            assert_eq!(
                (again.lift_mm, &again.configuration),
                (taught.lift_mm, &taught.configuration)
            );
            let (a, b) = (again.pose, taught.pose);
            assert!(
                (a.x_mm - b.x_mm)
                    .hypot(a.y_mm - b.y_mm)
                    .hypot(a.z_mm - b.z_mm)
                    < 1e-6
            );
            assert!((a.r_deg - b.r_deg).abs() < 1e-6);
        }
    }
}

#[test]
fn a_pose_taught_while_the_mobile_robot_stands_off_is_kept_for_the_nominal_dock() {
    let setup = setup(DEMO);
    let measured = PlanarPoseBody {
        x_mm: 1108.0,
        y_mm: -5.0,
        heading_deg: 91.0,
    };
    let dock = crate::setup::geometry::DockPose {
        x: units::Millimeters(measured.x_mm),
        y: units::Millimeters(measured.y_mm),
        heading: units::Degrees(measured.heading_deg),
    };
    let there = setup
        .resolve("r1", Target::At("front/left"), Dock::Measured(dock))
        .unwrap();
    let taught = teach(
        DEMO,
        "front/left",
        &TeachBody {
            measured_dock: Some(measured),
            at: Some(ExplicitPose {
                joints: Some(joints_body(&there.joints)),
                pose: None,
                configuration: None,
            }),
            ..body()
        },
    );
    let pose = taught.unwrap().pose;
    assert!(
        (pose.x_mm - 1100.0).abs() < 1e-5 && (pose.y_mm - 180.0).abs() < 1e-5,
        "{pose:?}"
    );
    assert!(pose.r_deg.abs() < 1e-6, "{pose:?}");
}

#[test]
fn what_cannot_be_taught_is_named() {
    let said = |place: &str, body: TeachBody| teach(DEMO, place, &body).unwrap_err().to_string();
    let at = |joints: Option<[f64; 6]>| {
        Some(ExplicitPose {
            joints: joints.map(Into::into),
            pose: None,
            configuration: None,
        })
    };
    let fine = at(Some([60.0, 0.0, 0.0, 0.0, -90.0, 0.0]));
    assert_eq!(
        said("attic", body()),
        "place: `attic` is no place of the set-up"
    );
    assert_eq!(
        said("rack/a", body()),
        "at: is missing, and the arm's actual pose is not known"
    );
    let neither = TeachBody {
        at: at(None),
        ..body()
    };
    assert!(said("rack/a", neither).starts_with("at: must have either"));
    let beyond = TeachBody {
        at: at(Some([180.0, 0.0, 0.0, 0.0, -90.0, 0.0])),
        ..body()
    };
    assert!(said("rack/a", beyond).starts_with("at.joints.j1_deg: J1 would be 180.00"));
    let dock = Some(PlanarPoseBody {
        x_mm: 1200.0,
        y_mm: 0.0,
        heading_deg: 90.0,
    });
    let still = TeachBody {
        measured_dock: dock,
        at: fine.clone(),
        ..body()
    };
    assert!(said("rack/a", still.clone()).contains("`rack/a` stands still"));
    let off = said("front/left", still);
    assert!(
        off.starts_with("measured_dock: is 0.0 mm along, -100.0 mm across"),
        "{off}"
    );
}
