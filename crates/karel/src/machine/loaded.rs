//! A program that is loaded, and what others may know of it.

use std::{collections::BTreeMap, sync::Arc};

use super::link::Link;
use crate::{
    program::Program,
    tp::{Instruction, Taught},
    types::Type,
};

/// The name of a deleted program: no program can say it, its strings are Latin-1.
const DELETED: &str = "\u{2205}";

#[derive(Debug)]
pub(crate) struct Loaded {
    pub(super) program: Program,
    /// Where its variables start in `globals`.
    pub(super) base: u32,
    /// Where its external routines are; `None` while their program is not loaded.
    pub(super) links: Vec<Option<Link>>,
}

impl Loaded {
    pub(crate) fn name(&self) -> &str {
        self.program.name()
    }

    /// Whether `CLEAR` deleted it: only its place is left, for the next TP program.
    pub(crate) fn is_deleted(&self) -> bool {
        self.name() == DELETED
    }

    /// Its place stays: tasks and links name programs by their places.
    pub(super) fn delete(&mut self) {
        self.program = Program::of_listing(DELETED, Vec::new(), BTreeMap::new());
    }

    /// Whether it is a TP program.
    pub(crate) fn is_listing(&self) -> bool {
        self.program.is_listing
    }

    /// Instructions and positions of a TP program.
    pub(crate) fn listing(&self) -> (Vec<Instruction>, BTreeMap<i32, Arc<Taught>>) {
        let code = &self.program.code;
        (code.tp.clone(), code.positions.clone())
    }

    /// How many instructions a TP program has.
    pub(crate) fn lines(&self) -> usize {
        self.program.code.tp.len()
    }

    /// A position of a TP program.
    pub(crate) fn taught(&self, number: i32) -> Option<&Taught> {
        let position = self.program.code.positions.get(&number);
        position.map(Arc::as_ref)
    }

    /// Its instructions.
    pub(crate) fn size(&self) -> i32 {
        i32::try_from(self.program.code.ops.len()).unwrap_or(i32::MAX)
    }

    /// A type that the program declares.
    pub(crate) fn named_type(&self, name: &str) -> Option<&Type> {
        self.program.types.get(name)
    }

    /// Names and types of its variables; those of other programs are among them.
    pub(crate) fn variables(&self) -> impl Iterator<Item = (&str, &Type)> {
        let variables = self.program.globals.iter();
        variables.map(|(name, (_, ty))| (name.as_str(), ty))
    }

    pub(crate) fn is_pausable_by_error(&self) -> bool {
        self.program
            .is_pausable(crate::program::Interruption::Error)
    }

    pub(crate) fn locks_group(&self) -> bool {
        self.program.locks_group()
    }

    pub(crate) fn is_abortable_by_error(&self) -> bool {
        self.program.is_abortable_by_error()
    }

    /// Name and source line of an instruction.
    pub(crate) fn place(&self, pc: usize) -> (String, u32) {
        let line = self.program.code.lines.get(pc).copied().unwrap_or(0);
        (self.name().to_owned(), line)
    }
}
