//! How much a controller says about itself, and which controller it is.

use std::collections::VecDeque;

use karel::{ByteOrder, Generation};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::faults::ControllerOption;

/// Notes that are kept; older ones are dropped.
const NOTES: usize = 500;

/// Whether the controller is as silent as a real one.
///
/// What programs see is the same either way, byte for byte, and so is everything that a client is sent. The only
/// difference on the wire: a kind controller closes the connections of a task that an error has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum Fidelity {
    /// Fault for fault: a server that an error has ended leaves its client waiting, and nobody says why.
    #[default]
    Faithful,
    /// It explains itself: notes say why a client hangs, a number is none, a variable was not set, a pose is out of
    /// reach; a client of a task that an error has ended is disconnected at once.
    Kind,
}

/// The generation of the controller.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ControllerGeneration {
    /// Whatever any of them accepts.
    #[default]
    Any,
    /// R-30iA, system software 7: KAREL moves the arm; strings of 128, names of 12 characters.
    V7,
    /// R-30iB Plus, system software 9: only TP programs move the arm; strings of 254, names of 36 characters.
    V9,
}

impl From<ControllerGeneration> for Generation {
    fn from(generation: ControllerGeneration) -> Self {
        match generation {
            ControllerGeneration::Any => Self::Any,
            ControllerGeneration::V7 => Self::V7,
            ControllerGeneration::V9 => Self::V9,
        }
    }
}

impl ControllerGeneration {
    /// `$SCR_GRP[1].$SV_CODE_ID`.
    ///
    /// ASSUMPTION: the minor versions.
    #[must_use]
    pub fn version(self) -> &'static str {
        match self {
            Self::Any | Self::V7 => "V7.70",
            Self::V9 => "V9.10",
        }
    }
}

/// The order of bytes in binary files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "lowercase")]
pub enum ByteOrderWord {
    /// Highest byte first, as controllers do.
    Big,
    /// Lowest byte first, as the vendor's simulator does.
    Little,
}

impl From<ByteOrder> for ByteOrderWord {
    fn from(order: ByteOrder) -> Self {
        match order {
            ByteOrder::Big => Self::Big,
            ByteOrder::Little => Self::Little,
        }
    }
}

/// Which controller this is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Profile {
    /// How much it says.
    pub fidelity: Fidelity,
    /// Its generation.
    pub generation: ControllerGeneration,
    /// What its programs read in `$SCR_GRP[1].$SV_CODE_ID`.
    pub version: String,
    /// The order of bytes in binary files.
    pub byte_order: ByteOrderWord,
    /// The period in which it interpolates; a `DELAY` lasts a whole number of these.
    pub interpolation_period_ms: f64,
    /// Options that it was delivered without.
    pub missing_options: Vec<ControllerOption>,
}

/// Something that the controller says about itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Note {
    /// Counts from 1.
    pub seq: u64,
    /// Controller time since the first power-on.
    pub time_s: f64,
    /// The program, if it is about one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
    /// Its source line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    /// One sentence.
    pub text: String,
    /// How often it was said in a row.
    pub times: u64,
}

/// What was said, oldest first.
#[derive(Debug, Default)]
pub(crate) struct Notes {
    notes: VecDeque<Note>,
    last_seq: u64,
}

impl Notes {
    /// Adds one. `false` if it only repeats the last one.
    pub(crate) fn add(&mut self, time_s: f64, place: Option<(&str, u32)>, text: String) -> bool {
        let program = place.map(|(program, _)| program.to_owned());
        let line = place.map(|(_, line)| line).filter(|line| *line > 0);
        if let Some(last) = self.notes.back_mut()
            && (&last.program, last.line, &last.text) == (&program, line, &text)
        {
            last.times += 1;
            return false;
        }
        self.last_seq += 1;
        if self.notes.len() >= NOTES {
            let _oldest = self.notes.pop_front();
        }
        self.notes.push_back(Note {
            seq: self.last_seq,
            time_s,
            program,
            line,
            text,
            times: 1,
        });
        true
    }

    /// Number of the newest one, 0 if there is none.
    pub(crate) fn last_seq(&self) -> u64 {
        self.last_seq
    }

    /// Those above a number, oldest first.
    pub(crate) fn after(&self, seq: u64) -> impl Iterator<Item = &Note> {
        self.notes.iter().filter(move |note| note.seq > seq)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_said_again_and_again_is_one_note_and_the_list_has_a_bound() {
        let mut notes = Notes::default();
        assert!(notes.add(1.0, Some(("A", 3)), "x".to_owned()));
        assert!(!notes.add(2.0, Some(("A", 3)), "x".to_owned()));
        assert!(notes.add(3.0, None, "x".to_owned()));
        let times: Vec<u64> = notes.after(0).map(|note| note.times).collect();
        assert_eq!(times, [2, 1]);
        for n in 0..2 * NOTES {
            let _new = notes.add(4.0, None, n.to_string());
        }
        assert_eq!(notes.after(0).count(), NOTES);
        assert_eq!(notes.after(0).last().unwrap().text, "999");
    }
}
