use workflow::SignalKind;

use super::support::{DEMO, errors, file, setup, with};
use crate::setup::{Form, parse_setup, write_setup};

const TRIGGER: &str = r#"
[[triggers]]
id = "unload"
on = { signal = "MR_ARRIVED", station = "handover", mobile_robot = "mr1" }

[triggers.job]
workflow = "delivery-and-placement"
priority = 3
deadline_s = 600

[triggers.job.params]
point = "handover/front"
items = [{ type = "crate", mr_slot = "left", place = "rack/d" }]
"#;

fn text() -> String {
    format!("{DEMO}{TRIGGER}")
}

#[test]
fn a_trigger_becomes_one_of_the_workflows() {
    let known = setup(&text()).for_workflows();
    assert_eq!(known.check(), []);
    let [trigger] = &*known.triggers else {
        panic!("{:?}", known.triggers)
    };
    assert!(trigger.enabled);
    assert_eq!(
        (trigger.signal, trigger.deadline_ms, trigger.job.priority),
        (SignalKind::MrArrived, Some(600_000), 3)
    );
    assert_eq!(trigger.points, ["handover/front"]);
    assert_eq!(trigger.job.mobile_robot, None);
    let off = with(
        &text(),
        "id = \"unload\"",
        "id = \"unload\"\nenabled = false",
    );
    assert!(!setup(&off).for_workflows().triggers[0].enabled);
}

#[test]
fn a_trigger_is_exported_as_it_is_imported() {
    let read = file(&text());
    for form in [Form::Toml, Form::Json] {
        let written = write_setup(&read, form);
        assert_eq!(parse_setup(written.as_bytes(), form).unwrap(), read);
    }
}

#[test]
fn what_does_not_fit_is_named() {
    for (good, bad, wanted) in [
        (
            "station = \"handover\"",
            "station = \"harbor\"",
            "triggers[0].on.station: `harbor` is no station; there are handover, warehouse",
        ),
        (
            "station = \"handover\"",
            "point = \"handover/back\"",
            "triggers[0].on.point: `handover/back` is no load-handling point",
        ),
        (
            "station = \"handover\"",
            "station = \"handover\", point = \"handover/front\"",
            "triggers[0].on: has `station` and `point`",
        ),
        (
            "mobile_robot = \"mr1\" }",
            "mobile_robot = \"mr9\" }",
            "triggers[0].on.mobile_robot: `mr9` is no mobile robot; there are mr1",
        ),
        (
            "MR_ARRIVED",
            "MR_HEARTBEAT",
            "triggers[0].on.signal: `MR_HEARTBEAT` starts no job",
        ),
        (
            "deadline_s = 600",
            "deadline_s = 0",
            "triggers[0].job.deadline_s: is 0; it must be from 1 to 604800",
        ),
        (
            "[triggers.job.params]\npoint = \"handover/front\"",
            "[triggers.job.params]\npoint = \"warehouse/gate\"",
            "triggers[0].job.params.point: no arm works at `warehouse/gate`",
        ),
        (
            "place = \"rack/d\" }]",
            "place = \"rack/z\" }]",
            "triggers[0].job.params.items[0].place: `rack/z` is no place",
        ),
        (
            "mr_slot = \"left\"",
            "mr_slot = \"roof\"",
            "triggers[0].job.params.items[0].mr_slot: `roof` is no slot",
        ),
        (
            "items = [{ type",
            "max_attempts = 11\nitems = [{ type",
            "triggers[0].job.params.max_attempts: 11 is not from 1 to 10",
        ),
    ] {
        let said = errors(&with(&text(), good, bad)).to_string();
        assert!(said.contains(wanted), "{said}\ninstead of\n{wanted}");
    }
    let unknown = with(&text(), "delivery-and-placement", "teleport");
    let said = parse_setup(unknown.as_bytes(), Form::Toml).unwrap_err();
    let said = said.to_string();
    assert!(said.contains("triggers[0].job.workflow"), "{said}");
    let twice = format!("{}{TRIGGER}", text());
    let said = errors(&twice).to_string();
    assert!(said.contains("triggers[1].id: `unload` stands in an earlier entry"));
}

/// A job nobody asks for by hand is refused when nobody looks: the check says so before.
#[test]
fn a_trigger_whose_places_no_arm_was_taught_is_warned_of() {
    let said = |text: &str| {
        let check = setup(text).check();
        let mut findings = check.findings.into_iter();
        findings.find(|found| found.item == "triggers/unload")
    };
    assert_eq!(said(&text()), None);
    let mut file = file(&text());
    file.taught_poses
        .retain(|taught| taught.place != "rack/d" || taught.arm != "r1");
    let untaught = write_setup(&file, Form::Toml);
    let found = said(&untaught).unwrap();
    assert_eq!(found.severity, api::setup::Severity::Warning);
    assert_eq!(
        found.message,
        "its job would be refused: r1 was not taught `rack/d`"
    );
}
