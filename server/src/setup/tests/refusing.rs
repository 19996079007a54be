use super::support::{DEMO, PAIR, errors, file, robots, with};
use crate::setup::model::Setup;

/// One thing exchanged in a file that fits, and the beginning of what is said about it.
const CASES: &[(&str, &str, &str)] = &[
    ("format = 1", "format = 2", "format: is 2; it must be 1"),
    (
        "name = \"Demo cell\"",
        "name = \"<b>Demo</b>\"",
        "name: holds \\u{3c}",
    ),
    (
        "id = \"r1\"\ntool",
        "id = \"r7\"\ntool",
        "arms[0].id: `r7` is no robot of the cell's configuration; there are r1, r2",
    ),
    (
        "tool = 1",
        "tool = 2",
        "arms[0].tool: 2 is no tool of `r1`; there are 1",
    ),
    (
        "body_radius_mm = 110",
        "body_radius_mm = -1",
        "arms[0].body_radius_mm: is -1; it must be from 0 to 1000",
    ),
    (
        "z_mm = 525",
        "z_mm = nan",
        "arms[0].base.z_mm: is NaN; it must be from -1000000 to 1000000",
    ),
    (
        "j1_deg = 90",
        "j1_deg = 171",
        "arms[0].safe.j1_deg: J1 would be 171.00",
    ),
    (
        "j1_deg = 90, j2_deg = 0, j3_deg = 0",
        "j1_deg = 0, j2_deg = 30, j3_deg = -20",
        "arms[0].safe: the tool center point at x 1329.6",
    ),
    (
        "number = 1",
        "number = 11",
        "tools[0].number: is 11; it must be from 1 to 10",
    ),
    (
        "z_mm = 150, w_deg = 0",
        "z_mm = 150, w_deg = 1e9",
        "tools[0].frame.w_deg: is 1000000000; it must be from -36000 to 36000",
    ),
    (
        "z_mm = 150, w_deg",
        "z_mm = 5000, w_deg",
        "tools[0].frame: its center point is 5000.0 mm from the flange",
    ),
    (
        "radius_mm = 60",
        "radius_mm = inf",
        "tools[0].radius_mm: is inf; it must be",
    ),
    (
        "id = \"floor\"",
        "id = \"r1-work\"",
        "zones[1].id: `r1-work` stands in an earlier entry, too",
    ),
    (
        "id = \"floor\"",
        "id = \"Floor 1\"",
        "zones[1].id: `Floor 1` does not match [a-z0-9][a-z0-9_-]{0,63}",
    ),
    (
        "robots = [\"mr1\"]\nbox.min = { x_mm = 500",
        "robots = [\"mr9\"]\nbox.min = { x_mm = 500",
        "zones[1].robots[0]: `mr9` is no robot; there are r1, mr1",
    ),
    (
        "robots = [\"mr1\"]\nbox.min = { x_mm = 500",
        "robots = []\nbox.min = { x_mm = 500",
        "zones[1].robots: is empty",
    ),
    (
        "box.max = { x_mm = 5000, y_mm = 1500",
        "box.max = { x_mm = 500, y_mm = 1500",
        "zones[1].box.max.x_mm: is 500, which is not above min.x_mm 500",
    ),
    (
        "arms = [\"r1\"]\nzone",
        "arms = [\"r2\"]\nzone",
        "stations[0].points[0].arms[0]: `r2` is no arm of the set-up; there are r1",
    ),
    (
        "zone = \"front\"",
        "zone = \"back\"",
        "stations[0].points[0].zone: `back` is no zone; there are r1-work, floor",
    ),
    (
        "zone = \"front\"",
        "zone = \"floor\"",
        "stations[0].points[0].zone: `floor` is no HANDOVER zone",
    ),
    (
        "zone = \"front\"\n",
        "",
        "stations[0].points[0].zone: is absent",
    ),
    (
        "dock = { x_mm = 1100",
        "dock = { x_mm = 1700",
        "stations[0].points[0].dock: x 1700, y 0 mm is outside of its zone `front`",
    ),
    (
        "heading_deg = 90",
        "heading_deg = 40000",
        "stations[0].points[0].dock.heading_deg: is 40000",
    ),
    (
        "position_mm = 15",
        "position_mm = 0",
        "stations[0].points[0].dock_tolerance.position_mm: is 0; it must be from 0.1 to 500",
    ),
    (
        "angle_deg = 2",
        "angle_deg = 90",
        "stations[0].points[0].dock_tolerance.angle_deg: is 90; it must be from 0.1 to 45",
    ),
    (
        "point = \"warehouse/gate\"",
        "point = \"warehouse/door\"",
        "destinations[0].point: `warehouse/door` is no load-handling point; there are handover/front, warehouse/gate",
    ),
    (
        "id = \"rack/b\"",
        "id = \"rack/a\"",
        "places[1].id: `rack/a` stands in an earlier entry, too",
    ),
    (
        "id = \"rack/b\"",
        "id = \"../b\"",
        "places[1].id: `../b` is neither",
    ),
    (
        "kind = \"FIXED\"\naccepts = [\"crate\"]",
        "kind = \"FIXED\"\naccepts = []",
        "places[0].accepts: is empty",
    ),
    (
        "kind = \"FIXED\"\naccepts = [\"crate\"]",
        "kind = \"FIXED\"\nslot = \"left\"\naccepts = [\"crate\"]",
        "places[0].slot: belongs to ON_MOBILE_ROBOT",
    ),
    (
        "slot = \"left\"\naccepts",
        "accepts",
        "places[7].slot: is absent",
    ),
    (
        "slot = \"left\"\naccepts",
        "slot = \"top\"\naccepts",
        "places[7].slot: `top` is a slot of no mobile robot",
    ),
    (
        "slot = \"left\"\naccepts",
        "slot = \"right\"\naccepts",
        "places[8]: slot `right` at `handover/front` stands in an earlier entry, too",
    ),
    (
        "point = \"handover/front\"\nslot",
        "point = \"warehouse/gate\"\nslot",
        "places[7].point: no arm works at `warehouse/gate`",
    ),
    (
        "place = \"rack/b\"\nconfiguration",
        "place = \"rack/a\"\nconfiguration",
        "taught_poses[1]: `rack/a` for `r1` stands in an earlier entry, too",
    ),
    (
        "place = \"rack/b\"\nconfiguration",
        "place = \"rack/z\"\nconfiguration",
        "taught_poses[1].place: `rack/z` is no place; there are rack/a",
    ),
    (
        "configuration = \"N U T, 0, 0, 0\"",
        "configuration = \"N X T\"",
        "taught_poses[0].configuration: ",
    ),
    (
        "approach_mm = 150",
        "approach_mm = 0",
        "taught_poses[0].approach_mm: is 0; it must be from 1 to 1000",
    ),
    (
        "length_mm = 800",
        "length_mm = 0",
        "mobile_robots[0].footprint.length_mm: is 0; it must be from 1 to 10000",
    ),
    (
        "id = \"mr1\"",
        "id = \"r1\"",
        "mobile_robots[0].id: `r1` stands in an earlier entry, too",
    ),
    (
        "{ id = \"right\", accepts",
        "{ id = \"left\", accepts",
        "mobile_robots[0].slots[1].id: `left` stands in an earlier entry, too",
    ),
    (
        "home = \"warehouse/gate\"",
        "home = \"nowhere\"",
        "mobile_robots[0].home: `nowhere` is no load-handling point",
    ),
    (
        "to = \"warehouse/gate\"",
        "to = \"handover/front\"",
        "routes[0].to: `handover/front` is where the route begins",
    ),
    (
        "{ x_mm = 1100, y_mm = -1200 }",
        "{ x_mm = 1e300, y_mm = -1200 }",
        "routes[0].waypoints[0].x_mm: is 1e300; it must be",
    ),
    (
        "type = \"crate\"\nplace",
        "type = \"barrel\"\nplace",
        "loads[1].type: `barrel` is not accepted there; accepted are crate",
    ),
    (
        "place = \"rack/b\"\n\n[[loads]]",
        "place = \"rack/a\"\n\n[[loads]]",
        "loads[2].place: an earlier load is in the same place",
    ),
    (
        "place = \"rack/b\"\n\n[[loads]]",
        "place = \"front/right\"\n\n[[loads]]",
        "loads[2].place: `front/right` is on whichever robot is docked",
    ),
    (
        "place = \"rack/b\"\n\n[[loads]]",
        "\n[[loads]]",
        "loads[2]: has 0 of `place`, `destination` and `on`",
    ),
    (
        "place = \"rack/b\"\n\n[[loads]]",
        "place = \"rack/b\"\ndestination = \"warehouse\"\n\n[[loads]]",
        "loads[2]: has 2 of",
    ),
    (
        "on = { mobile_robot = \"mr1\", slot = \"left\" }",
        "on = { mobile_robot = \"mr1\", slot = \"x\" }",
        "loads[0].on.slot: `x` is no slot of `mr1`; there are left, right",
    ),
    (
        "on = { mobile_robot = \"mr1\", slot = \"left\" }",
        "on = { mobile_robot = \"mr2\", slot = \"left\" }",
        "loads[0].on.mobile_robot: `mr2` is no mobile robot; there are mr1",
    ),
];

#[test]
fn what_does_not_fit_is_named_by_its_path_with_the_value_and_what_is_allowed() {
    for (good, bad, begin) in CASES {
        let said: Vec<_> = errors(&with(DEMO, good, bad))
            .to_string()
            .lines()
            .map(str::to_owned)
            .collect();
        assert!(
            said.iter().any(|line| line.starts_with(begin)),
            "{begin}\nwas said as\n{said:#?}"
        );
    }
}

#[test]
fn everything_wrong_is_told_of_at_once() {
    let text = with(DEMO, "tool = 1", "tool = 2");
    let text = with(&text, "zone = \"front\"", "zone = \"back\"");
    let text = with(&text, "approach_mm = 150", "approach_mm = 0");
    let said = errors(&text);
    let items: Vec<_> = said
        .violations()
        .iter()
        .map(|found| found.item.as_str())
        .collect();
    assert_eq!(
        items,
        [
            "arms[0].tool",
            "stations[0].points[0].zone",
            "taught_poses[0].approach_mm"
        ]
    );
    let limited = said.violations().last().unwrap();
    assert_eq!(
        (limited.value, limited.min, limited.max),
        (Some(0.0), Some(1.0), Some(1000.0))
    );
}

#[test]
fn two_arms_do_not_share_a_hand_over_zone_and_each_works_where_it_stands() {
    let text = with(PAIR, "zone = \"aisle-2\"", "zone = \"aisle-1\"");
    let said = errors(&text).to_string();
    assert!(
        said.contains(
            "stations[0].points[1].zone: the zone `aisle-1` stands in an earlier entry, too"
        ),
        "{said}"
    );
    let text = with(
        PAIR,
        "arm = \"r1\"\nplace = \"aisle-1/left\"",
        "arm = \"r1\"\nplace = \"aisle-2/left\"",
    );
    let said = errors(&text).to_string();
    assert!(
        said.contains("`r1` does not work at `aisle/two`, where `aisle-2/left` is; there work r2"),
        "{said}"
    );
    let said = errors(&with(PAIR, "grip_ms = 2000", "grip_ms = 0")).to_string();
    assert!(
        said.contains("timers.grip_ms: is 0; it must be from 1 to 86400000"),
        "{said}"
    );
}

#[test]
fn a_list_that_is_too_long_is_refused_and_a_thousand_faults_are_not_all_told() {
    let mut setup = file(DEMO);
    let load = setup.loads[0].clone();
    setup.loads = (0..1_001)
        .map(|number| api::setup::LoadBody {
            id: format!("Load {number}"),
            ..load.clone()
        })
        .collect();
    let errors = Setup::try_new(&setup, &robots()).unwrap_err();
    assert_eq!(errors.violations()[0].item, "loads");
    assert_eq!(errors.violations().len(), 101);
    assert!(errors.to_string().contains(" more"));
}

#[test]
fn x11_what_is_repeated_in_a_message_is_harmless() {
    let text = with(DEMO, "id = \"floor\"", "id = \"\\u001B[2J<script>\"");
    let said = errors(&text).to_string();
    assert!(!said.contains('\u{1b}'), "{said:?}");
}
