//! Sentences for people; the workflows' enums stand in them by the words their JSON has.

pub(crate) use workflow::word;
use workflow::{Action, GripAction, Speed, Target};

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
