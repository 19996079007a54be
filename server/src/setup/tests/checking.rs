use api::setup::{SetupCheck, Severity};
use kinematics::PendantJoints;

use super::support::{DEMO, PAIR, setup, with};
use crate::setup::path::joint_path;

fn of<'a>(check: &'a SetupCheck, place: &str) -> &'a api::setup::TaughtPoseCheck {
    let mut all = check.taught_poses.iter();
    all.find(|taught| taught.place == place).unwrap()
}

/// The messages of everything wrong.
fn wrong(check: &SetupCheck) -> Vec<String> {
    let taught = check
        .taught_poses
        .iter()
        .flat_map(|taught| &taught.findings);
    let routes = check.routes.iter().flat_map(|route| &route.findings);
    taught
        .chain(routes)
        .chain(&check.findings)
        .filter(|found| found.severity == Severity::Error)
        .map(|found| format!("{}: {}", found.item, found.message))
        .collect()
}

#[test]
fn the_demo_cell_has_room_everywhere() {
    let check = setup(DEMO).check();
    assert_eq!(wrong(&check), Vec::<String>::new());
    assert!(check.passed);
    assert_eq!(check.taught_poses.len(), 9);
    for taught in &check.taught_poses {
        assert!(
            taught.joint.as_ref().unwrap().margin_deg > 20.0,
            "{taught:?}"
        );
        assert!(taught.singularity.unwrap() > 0.5, "{taught:?}");
        assert!(
            taught.keep_out.as_ref().unwrap().margin_mm > 100.0,
            "{taught:?}"
        );
        assert!(
            taught.work.as_ref().unwrap().margin_mm > 150.0,
            "{taught:?}"
        );
        assert_eq!(taught.findings, []);
    }
    assert_eq!(of(&check, "rack/a").dock_poses, 1);
    assert_eq!(of(&check, "front/left").dock_poses, 9);
}

#[test]
fn the_example_of_two_arms_has_room_everywhere() {
    let check = setup(PAIR).check();
    assert_eq!(wrong(&check), Vec::<String>::new());
    assert!(check.passed);
}

#[test]
fn a_pose_out_of_reach_is_found() {
    let text = with(DEMO, "x_mm = 500, y_mm = 1000", "x_mm = 1500, y_mm = 1390");
    let check = setup(&text).check();
    assert!(!check.passed && !of(&check, "rack/a").passed);
    let found = wrong(&check).join("\n");
    assert!(
        found.contains("taught-poses/r1/rack/a: approach, 0 mm along"),
        "{found}"
    );
    assert!(found.contains("beyond the stretched arm"), "{found}");
    assert!(of(&check, "rack/b").passed);
}

#[test]
fn a_pose_reached_only_with_another_configuration_is_found() {
    let text = with(DEMO, "N U T, 0, 0, 0", "N U T, 0, 0, 1");
    let found = wrong(&setup(&text).check()).join("\n");
    assert!(found.contains("rack/a"), "{found}");
}

#[test]
fn h4_a_way_through_a_keep_out_zone_between_two_fine_ends_is_found() {
    // A post between the safe pose and the reject bin: neither end touches it.
    let post = r#"
[[zones]]
id = "post"
kind = "KEEP_OUT"
robots = ["r1"]
box.min = { x_mm = -520, y_mm = 800, z_mm = 700 }
box.max = { x_mm = -420, y_mm = 900, z_mm = 1500 }
"#;
    let text = format!("{DEMO}{post}");
    let setup = setup(&text);
    let arm = setup.arm("r1").unwrap();
    let reject = setup.resolve(
        "r1",
        crate::setup::resolve::Target::ApproachOf("reject"),
        crate::setup::resolve::Dock::Nominal,
    );
    let reject = reject.unwrap().joints;
    assert_eq!(setup.check_path(arm, &[arm.safe]), Ok(()));
    assert_eq!(setup.check_path(arm, &[reject]), Ok(()));
    let path = joint_path(&arm.safe, &reject);
    let violation = setup.check_path(arm, &path).unwrap_err();
    assert_eq!(violation.zone, "post");
    assert!(
        violation.at > 0 && violation.at < path.len() - 1,
        "{violation:?}"
    );
    assert!(violation.depth.0 > 50.0, "{violation}");

    let found = wrong(&setup.check()).join("\n");
    assert!(
        found.contains("taught-poses/r1/reject: the way from the safe pose to the approach: the arm enters the keep-out zone `post`"),
        "{found}"
    );
}

#[test]
fn h4_who_stands_in_a_zone_may_go_out_of_it_and_no_deeper() {
    // The safe pose has the tip at x 0, y 985, z 1315 of the cell: 50 mm inside.
    let shelf = r#"
[[zones]]
id = "shelf"
kind = "KEEP_OUT"
robots = ["r1"]
box.min = { x_mm = -300, y_mm = 700, z_mm = 1000 }
box.max = { x_mm = 300, y_mm = 1300, z_mm = 1365 }
"#;
    let setup = setup(&format!("{DEMO}{shelf}"));
    let arm = setup.arm("r1").unwrap();
    let inside = arm.safe;
    let out = PendantJoints::from_degrees([30.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    let deeper = PendantJoints::from_degrees([90.0, 10.0, -10.0, 0.0, -90.0, 0.0]);
    let zones = |start: Option<&PendantJoints>, to: &PendantJoints| {
        let way = joint_path(start.unwrap_or(to), to);
        let found = setup.trespasses(arm, start, &way);
        found
            .into_iter()
            .map(|found| found.zone)
            .collect::<Vec<_>>()
    };
    assert_eq!(zones(Some(&inside), &out), Vec::<String>::new());
    assert_eq!(zones(Some(&inside), &inside), Vec::<String>::new());
    assert_eq!(zones(Some(&inside), &deeper), ["shelf"]);
    assert_eq!(zones(Some(&out), &inside), ["shelf"]);
    assert_eq!(zones(None, &inside), ["shelf"], "an end alone is looked at");
    assert_eq!(zones(None, &out), Vec::<String>::new());
}

#[test]
fn an_elbow_counts_as_much_as_the_tool() {
    // Above the shoulder, where only the upper arm and the elbow are.
    let beam = r#"
[[zones]]
id = "beam"
kind = "KEEP_OUT"
box.min = { x_mm = -50, y_mm = 100, z_mm = 1250 }
box.max = { x_mm = 50, y_mm = 200, z_mm = 1350 }
"#;
    let found = wrong(&setup(&format!("{DEMO}{beam}")).check()).join("\n");
    assert!(
        found.contains("arms/r1 safe: the arm enters `beam`"),
        "{found}"
    );
}

#[test]
fn a_corner_of_the_dock_tolerance_that_is_too_far_is_found() {
    // 1650 mm at most in the work area: the nominal pose is inside, a corner is not.
    let text = with(
        DEMO,
        "box.max = { x_mm = 1600, y_mm = 1400, z_mm = 2000 }",
        "box.max = { x_mm = 1117, y_mm = 1400, z_mm = 2000 }",
    );
    let check = setup(&text).check();
    let found = wrong(&check).join("\n");
    assert!(found.contains("front/left, docked at corner"), "{found}");
    assert!(!found.contains("docked as nominal"), "{found}");
    assert!(found.contains("leaves the work area `r1-work`"), "{found}");
}

#[test]
fn a_place_outside_a_hand_over_zone_is_not_reached_through_it() {
    let text = with(
        DEMO,
        "box.min = { x_mm = 650, y_mm = -700, z_mm = 0 }",
        "box.min = { x_mm = 400, y_mm = -700, z_mm = 0 }",
    );
    let text = with(
        &text,
        "box.max = { x_mm = 1600, y_mm = 700, z_mm = 1100 }",
        "box.max = { x_mm = 1600, y_mm = 1100, z_mm = 1100 }",
    );
    let found = wrong(&setup(&text).check()).join("\n");
    assert!(found.contains("rack/a"), "{found}");
    assert!(
        found.contains("enters the hand-over zone `front`, which this place has no part in"),
        "{found}"
    );
    assert!(!found.contains("front/left"), "{found}");
}

#[test]
fn a_route_through_a_keep_out_zone_or_off_the_floor_is_found() {
    let text = with(
        DEMO,
        "waypoints = [{ x_mm = 1100, y_mm = -1200 }",
        "waypoints = [{ x_mm = 700, y_mm = -1200 }",
    );
    let check = setup(&text).check();
    let found = wrong(&check).join("\n");
    assert!(
        found.contains("`mr1` leaves its work areas at x "),
        "{found}"
    );
    let text = with(
        DEMO,
        "waypoints = [{ x_mm = 1100, y_mm = -1200 }",
        "waypoints = [{ x_mm = 0, y_mm = 0 }",
    );
    let found = wrong(&setup(&text).check()).join("\n");
    assert!(
        found.contains("routes/front-gate leg 0: `mr1` comes into the keep-out zone `pedestal`"),
        "{found}"
    );
}

#[test]
fn what_nobody_can_use_is_a_warning() {
    let extra = "\n[[places]]\nid = \"shelf\"\nkind = \"FIXED\"\naccepts = [\"crate\"]\n";
    let text = with(
        DEMO,
        "[[routes]]\nid = \"front-gate\"",
        "[[routes]]\nid = \"gate-front\"\ndirection = \"ONE_WAY\"",
    );
    let text = with(
        &text,
        "from = \"handover/front\"\nto = \"warehouse/gate\"",
        "from = \"warehouse/gate\"\nto = \"handover/front\"",
    );
    let text = with(
        &text,
        "slot = \"left\"\naccepts = [\"crate\"]",
        "slot = \"left\"\naccepts = [\"crate\", \"drum\"]",
    );
    let check = setup(&format!("{text}{extra}")).check();
    assert!(check.passed);
    let said: Vec<_> = check
        .findings
        .iter()
        .map(|found| found.item.as_str())
        .collect();
    assert_eq!(
        said,
        [
            "places/shelf",
            "places/front/left",
            "destinations/warehouse"
        ]
    );
}

#[test]
fn the_samples_of_a_way_are_close_together_and_hold_both_ends() {
    let from = PendantJoints::from_degrees([0.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    let to = PendantJoints::from_degrees([90.5, -10.0, 5.0, 0.0, -80.0, 180.0]);
    let path = joint_path(&from, &to);
    let ends = [path.first().unwrap(), path.last().unwrap()];
    for (end, wanted) in ends.iter().zip([from, to]) {
        for (a, b) in end.degrees().iter().zip(wanted.degrees()) {
            assert!((a - b).abs() < 1e-9);
        }
    }
    for pair in path.windows(2) {
        let steps = pair[0].degrees().into_iter().zip(pair[1].degrees());
        assert!(steps.map(|(a, b)| (b - a).abs()).fold(0.0, f64::max) <= 1.0 + 1e-9);
    }
    assert_eq!(joint_path(&from, &from).len(), 2);
}

/// A way of a job, right before it is sent: the line to the load, and the hand-over zones on the way.
#[test]
fn h4_a_way_of_a_job_respects_every_zone_but_that_of_its_own_place() {
    use crate::setup::ways::Shape;
    use workflow::{PlaceRef, Target};

    let text = |id: &str, kind: &str, x: f64, y: f64, z: [f64; 2]| {
        let [low, high] = z;
        format!(
            "\n[[zones]]\nid = \"{id}\"\nkind = \"{kind}\"\n\
             box.min = {{ x_mm = {:.1}, y_mm = {:.1}, z_mm = {low:.1} }}\n\
             box.max = {{ x_mm = {:.1}, y_mm = {:.1}, z_mm = {high:.1} }}\n",
            x - 50.0,
            y - 50.0,
            x + 50.0,
            y + 50.0
        )
    };
    let rack = PlaceRef::fixed("rack/d");
    let left = PlaceRef::MobileRobot {
        point: "handover/front".into(),
        slot: "left".into(),
    };
    let said = |more: &str, place: &PlaceRef, goal: fn(PlaceRef) -> Target, shape: Shape| {
        let setup = setup(&format!("{DEMO}{more}"));
        let arm = setup.arm("r1").unwrap();
        let to = |target: &Target| setup.resolve_for("r1", target, None).unwrap();
        let from = match shape {
            Shape::Joint => to(&Target::Safe),
            Shape::Straight => to(&Target::ApproachOf {
                place: place.clone(),
            }),
        };
        let goal = goal(place.clone());
        let samples = shape.samples(arm, &from.joints, &to(&goal)).unwrap();
        let found = setup.check_way(arm, &from.joints, &samples, &goal);
        found.err().map_or(String::new(), |found| found.to_string())
    };
    let at: fn(PlaceRef) -> Target = |place| Target::At { place };
    let before: fn(PlaceRef) -> Target = |place| Target::ApproachOf { place };
    let lower = [660.0, 700.0];
    let post = text("post", "KEEP_OUT", -100.0, 1_000.0, lower);
    let foreign = text("foreign", "HANDOVER", -100.0, 1_000.0, lower);
    assert_eq!(said("", &rack, at, Shape::Straight), "");
    assert_eq!(said("", &left, at, Shape::Straight), "", "its own zone");
    assert_eq!(said("", &left, before, Shape::Joint), "", "its own zone");
    assert_eq!(said(&post, &rack, before, Shape::Joint), "");
    let found = said(&post, &rack, at, Shape::Straight);
    assert!(
        found.contains("the keep-out zone `post` by ") && found.contains(" mm, at x "),
        "{found}"
    );
    let found = said(&foreign, &rack, at, Shape::Straight);
    assert!(found.contains("the hand-over zone `foreign`"), "{found}");
    // In the way of the arm to the mobile robot, at the height of its approach.
    let beside = text("foreign", "HANDOVER", 800.0, 600.0, [700.0, 1_300.0]);
    let found = said(&beside, &left, before, Shape::Joint);
    assert!(found.contains("the hand-over zone `foreign`"), "{found}");
}

/// The way out of a hand-over zone, lifted over its edge, is no way into one.
#[test]
fn h4_who_was_lifted_over_the_edge_of_its_zone_goes_back_through_it() {
    use workflow::Target;

    // The zone ends below the lifted arm's tip, and the arm turns down again on its way.
    let low = with(
        DEMO,
        "x_mm = 1600, y_mm = 700, z_mm = 1100",
        "x_mm = 1600, y_mm = 700, z_mm = 800",
    );
    let setup = setup(&low);
    let arm = setup.arm("r1").unwrap();
    let above = PendantJoints::from_degrees([0.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    let body = arm.capsules(&above);
    let front = setup.zones.iter().find(|zone| zone.id == "front").unwrap();
    assert!(body.iter().all(|part| front.bounds.gap(part).0 > 0.0));
    let dips = PendantJoints::from_degrees([0.0, 45.0, -30.0, 0.0, -60.0, 0.0]);
    let samples = joint_path(&above, &dips);
    let trespass = setup.trespasses(arm, Some(&above), &samples);
    assert!(
        trespass.iter().any(|found| found.zone == "front"),
        "{trespass:?}"
    );
    assert_eq!(
        setup.check_way(arm, &above, &samples, &Target::Safe),
        Ok(())
    );
    // From beside it, it is a way into it.
    let aside = PendantJoints::from_degrees([90.0, 0.0, 0.0, 0.0, -90.0, 0.0]);
    let samples = joint_path(&aside, &dips);
    let found = setup.check_way(arm, &aside, &samples, &Target::Safe);
    assert_eq!(found.unwrap_err().zone, "front");
}
