//! What people read: values by the names that the API has for them.

use std::fmt::{Debug, Write as _};

use crate::setup::BasePose;
use crate::signal::SlotLoad;

/// A state, a phase, a mode: `TransferReady` is `TRANSFER_READY`.
pub(crate) fn capitals(value: impl Debug) -> String {
    apart(&format!("{value:?}")).to_uppercase()
}

/// An answer or an action: `DidNotHappen` is `did_not_happen`.
pub(crate) fn small(value: impl Debug) -> String {
    apart(&format!("{value:?}")).to_lowercase()
}

/// The words of a variant's name, with underscores between.
fn apart(name: &str) -> String {
    let mut text = String::new();
    for (index, letter) in name.chars().enumerate() {
        if index > 0 && letter.is_uppercase() {
            text.push('_');
        }
        text.push(letter);
    }
    text
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
    use crate::{Answer, JobState, SessionState};

    #[test]
    fn a_value_is_called_as_the_api_calls_it() {
        assert_eq!(capitals(SessionState::TransferReady), "TRANSFER_READY");
        assert_eq!(capitals(JobState::Held), "HELD");
        assert_eq!(small(Answer::DidNotHappen), "did_not_happen");
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
