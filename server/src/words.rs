//! The workflows' enums by the words their JSON has, and sentences for people.

use serde::Serialize;
use workflow::{Action, GripAction, Speed, Target};

/// An enum of plain words, as it is written in JSON.
pub(crate) fn word(value: &impl Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(word)) => word,
        Ok(other) => other.to_string(),
        Err(_) => String::new(),
    }
}

/// What an arm does.
pub(crate) fn action(action: &Action) -> String {
    match action {
        Action::Move { target, speed, .. } => {
            let how = match speed {
                Speed::Free => "",
                Speed::Reduced => ", slowly",
            };
            format!("move to {}{how}", target_text(target))
        }
        Action::Grip {
            action: GripAction::Close,
        } => "close the gripper".to_owned(),
        Action::Grip {
            action: GripAction::Open,
        } => "open the gripper".to_owned(),
        Action::Precheck { targets } => format!("plan {} poses", targets.len()),
    }
}

fn target_text(target: &Target) -> String {
    match target {
        Target::ApproachOf { place } => format!("before {place}"),
        Target::At { place } => place.to_string(),
        Target::LiftOf { place } => format!("above {place}"),
        Target::Safe => "the safe pose".to_owned(),
    }
}

/// A sentence's end: the text behind a colon, where there is one.
pub(crate) fn because(text: &str) -> String {
    if text.is_empty() {
        String::new()
    } else {
        format!(": {text}")
    }
}
