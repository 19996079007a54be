//! What people read: values by the names that the API has for them.

use std::fmt::{self, Write as _};

use serde::Serialize;

use crate::setup::BasePose;
use crate::signal::SlotLoad;

/// An enum of plain words, as it is written in JSON: `TransferReady` is `TRANSFER_READY`. Empty for what is no plain word.
#[must_use]
pub fn word(value: &impl Serialize) -> String {
    let mut text = String::new();
    match write!(text, "{}", Plain(value)) {
        Ok(()) => text,
        Err(fmt::Error) => String::new(),
    }
}

/// A formatter is a serializer of plain words, and of nothing else.
struct Plain<'a, T>(&'a T);

impl<T: Serialize> fmt::Display for Plain<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.serialize(f)
    }
}

/// A pose on the floor.
pub(crate) fn pose(pose: &BasePose) -> String {
    let BasePose {
        x_mm,
        y_mm,
        heading_deg,
    } = pose;
    format!("x {x_mm:.1} mm, y {y_mm:.1} mm, {heading_deg:.2} deg")
}

/// What a mobile robot says that it carries.
pub(crate) fn loads(report: &[SlotLoad]) -> String {
    let mut text = String::new();
    for SlotLoad { slot, load } in report {
        let load = load.as_deref().unwrap_or("a load it does not know");
        let comma = if text.is_empty() { "" } else { ", " };
        // Writing to a string cannot fail.
        let _ = write!(text, "{comma}{load} in {slot}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Answer, JobState, SessionState, Workflow};

    #[test]
    fn a_value_is_called_as_the_api_calls_it() {
        assert_eq!(word(&SessionState::TransferReady), "TRANSFER_READY");
        assert_eq!(word(&JobState::Held), "HELD");
        assert_eq!(word(&Answer::DidNotHappen), "did_not_happen");
        // Its name in the source is `PickupAndDelivery`, and in JSON it is not written with underscores.
        assert_eq!(word(&Workflow::PickupAndDelivery), "pickup-and-delivery");
        let many = word(&["no", "word"]);
        assert_eq!(many, "", "{many}");
    }

    #[test]
    fn poses_and_loads_are_read_without_knowing_the_source() {
        let at = BasePose {
            x_mm: 1_099.96,
            y_mm: -2.0,
            heading_deg: 90.004,
        };
        assert_eq!(pose(&at), "x 1100.0 mm, y -2.0 mm, 90.00 deg");
        let on = |slot: &str, load: Option<&str>| SlotLoad {
            slot: slot.into(),
            load: load.map(Into::into),
        };
        let report = [on("left", Some("load-1")), on("right", None)];
        assert_eq!(
            loads(&report),
            "load-1 in left, a load it does not know in right"
        );
    }
}
