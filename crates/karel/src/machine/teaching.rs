//! What programs do to TP programs while they run: positions, new programs, lines.
//!
//! A slice runs with the programs as they are; what changes them is done when it ends, and a
//! built-in that makes a program ends its slice.

use std::collections::BTreeMap;

use crate::{program::Program, tp::Taught, value::Text};

/// Most programs that are open at a time, and most positions that programs changed.
const MOST_OPEN: usize = 16;
const MOST_TAUGHT: usize = 1 << 14;

#[derive(Debug, Default)]
pub(crate) struct Teaching {
    open: BTreeMap<i32, Open>,
    last_id: i32,
    taught: BTreeMap<(String, i32), Taught>,
    comments: BTreeMap<(String, i32), Text>,
    /// Comments of programs.
    notes: BTreeMap<String, Text>,
    /// Programs that are to be loaded.
    pub(crate) made: Vec<Program>,
    /// Programs that are to be deleted.
    pub(crate) deleted: Vec<String>,
    /// Lines that are to become empty ones.
    pub(crate) blanked: Vec<(String, u32)>,
}

/// A program that `OPEN_TPE` opened.
#[derive(Clone, Debug)]
pub(crate) struct Open {
    pub(crate) program: String,
    pub(crate) writes: bool,
}

impl Teaching {
    /// The number of the opened program; `None` if there are too many.
    pub(crate) fn open(&mut self, program: String, writes: bool) -> Option<i32> {
        if self.open.len() >= MOST_OPEN {
            return None;
        }
        self.last_id = self.last_id.checked_add(1)?;
        let _new = self.open.insert(self.last_id, Open { program, writes });
        Some(self.last_id)
    }

    pub(crate) fn opened(&self, id: i32) -> Option<&Open> {
        self.open.get(&id)
    }

    /// Whether somebody writes the program.
    pub(crate) fn is_written(&self, program: &str) -> bool {
        let mut open = self.open.values();
        open.any(|open| open.writes && open.program == program)
    }

    /// Whether somebody reads or writes the program.
    pub(crate) fn is_open(&self, program: &str) -> bool {
        self.open.values().any(|open| open.program == program)
    }

    /// Forgets what was taught of a program.
    pub(crate) fn forget(&mut self, program: &str) {
        self.taught.retain(|(of, _), _| of != program);
        self.comments.retain(|(of, _), _| of != program);
        let _note = self.notes.remove(program);
    }

    /// Whether there is something to do between two slices.
    pub(crate) fn is_due(&self) -> bool {
        !(self.made.is_empty() && self.blanked.is_empty() && self.deleted.is_empty())
    }

    pub(crate) fn close(&mut self, id: i32) -> bool {
        self.open.remove(&id).is_some()
    }

    /// A position that a program changed.
    pub(crate) fn changed(&self, program: &str, number: i32) -> Option<&Taught> {
        if self.taught.is_empty() {
            return None;
        }
        self.taught.get(&(program.to_owned(), number))
    }

    /// `false` if there are too many.
    pub(crate) fn change(&mut self, program: &str, taught: Taught) -> bool {
        let key = (program.to_owned(), taught.number);
        let fits = self.taught.len() < MOST_TAUGHT || self.taught.contains_key(&key);
        if fits {
            let _before = self.taught.insert(key, taught);
        }
        fits
    }

    pub(crate) fn comment(&self, program: &str, number: i32) -> Text {
        let comment = self.comments.get(&(program.to_owned(), number));
        comment.cloned().unwrap_or_default()
    }

    /// `false` if there are too many.
    pub(crate) fn set_comment(&mut self, program: &str, number: i32, comment: Text) -> bool {
        let fits = self.comments.len() < MOST_TAUGHT;
        if fits {
            let _before = self.comments.insert((program.to_owned(), number), comment);
        }
        fits
    }

    pub(crate) fn note(&self, program: &str) -> Text {
        self.notes.get(program).cloned().unwrap_or_default()
    }

    pub(crate) fn set_note(&mut self, program: &str, note: Text) {
        let _before = self.notes.insert(program.to_owned(), note);
    }
}
