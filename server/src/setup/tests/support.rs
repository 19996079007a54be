use std::sync::Arc;

use api::setup::SetupFile;

use crate::config::{CellSection, Plan, RobotPlan, RobotSection, ServerSection};
use crate::setup::model::Setup;
use crate::setup::{Form, SetupErrors, parse_setup};

/// The set-up of the demo cell.
pub(super) const DEMO: &str = include_str!("../../../../cell/demo.setup.toml");

/// Two arms and two mobile robots.
pub(super) const PAIR: &str = include_str!("../../../../cell/pair.example.setup.toml");

/// The robots `r1` and `r2`.
pub(crate) fn robots() -> Vec<Arc<RobotPlan>> {
    let robot = |id: &str| RobotSection::new(id, "fanuc-m20ia", "127.0.0.1:1");
    let cell = CellSection {
        id: "c1".to_owned(),
        name: None,
        robots: vec![robot("r1"), robot("r2")],
        setup: None,
        push_urls: std::collections::BTreeMap::new(),
    };
    let server = ServerSection {
        legacy_robot: Some("c1/r1".to_owned()),
        ..ServerSection::default()
    };
    let mut plan = Plan::try_new(&server, &[cell]).unwrap();
    plan.cells
        .remove(0)
        .robots
        .into_iter()
        .map(Arc::new)
        .collect()
}

/// The file of a text in TOML.
pub(super) fn file(text: &str) -> SetupFile {
    parse_setup(text.as_bytes(), Form::Toml).unwrap_or_else(|error| panic!("{error}"))
}

/// The checked set-up of a text in TOML.
pub(super) fn setup(text: &str) -> Setup {
    Setup::try_new(&file(text), &robots()).unwrap_or_else(|errors| panic!("{errors}"))
}

/// What is wrong with a text in TOML.
pub(super) fn errors(text: &str) -> SetupErrors {
    match Setup::try_new(&file(text), &robots()) {
        Ok(_) => panic!("nothing was found wrong"),
        Err(errors) => errors,
    }
}

/// A text with one thing exchanged, which must be there.
pub(super) fn with(text: &str, good: &str, bad: &str) -> String {
    assert!(text.contains(good), "{good}");
    text.replacen(good, bad, 1)
}
