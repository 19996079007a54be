//! Names of one scope: variables, constants and types.

use std::collections::{BTreeMap, HashMap};

use crate::{
    typed::{Constant, Root},
    types::Type,
};

#[derive(Clone, Debug)]
pub(super) enum Symbol {
    Variable { root: Root, ty: Type },
    Constant(Constant),
    Type(Type),
}

/// The program's names, or a routine's.
#[derive(Debug, Default)]
pub(super) struct Scope {
    pub(super) symbols: HashMap<String, Symbol>,
    /// Cells given to variables so far.
    pub(super) cells: u32,
    /// Cells of FILE variables.
    pub(super) files: Vec<u32>,
    /// Cells of PATH variables, and the size of a node.
    pub(super) paths: Vec<(u32, u32)>,
}

impl Scope {
    /// Reserves the cells of a value of `ty` and returns the first.
    pub(super) fn allocate(&mut self, ty: &Type) -> u32 {
        let cell = self.cells;
        self.cells = self.cells.saturating_add(ty.size());
        self.note_files(ty, cell);
        cell
    }

    fn note_files(&mut self, ty: &Type, cell: u32) {
        if ty.is_copied() || self.cells > crate::types::MAX_CELLS {
            return;
        }
        match ty {
            Type::File => self.files.push(cell),
            Type::Path(path) => self.paths.push((cell, path.node.size())),
            Type::Array(array) => {
                let size = array.element.size().max(1);
                let mut offset = cell;
                while offset < cell + ty.size() {
                    self.note_files(&array.element, offset);
                    offset += size;
                }
            }
            Type::Structure(structure) => {
                for field in &structure.fields {
                    self.note_files(&field.ty, cell + field.offset);
                }
            }
            Type::Integer
            | Type::Real
            | Type::Boolean
            | Type::Text(_)
            | Type::Config
            | Type::Position(_)
            | Type::Joints(_)
            | Type::Small(_)
            | Type::Error => {}
        }
    }

    /// The types, for look-up by name at run time, in an order that is always the same.
    pub(super) fn types(&self) -> BTreeMap<String, Type> {
        let types = self
            .symbols
            .iter()
            .filter_map(|(name, symbol)| match symbol {
                Symbol::Type(ty) => Some((name.clone(), ty.clone())),
                Symbol::Variable { .. } | Symbol::Constant(_) => None,
            });
        types.collect()
    }

    /// The global variables, for look-up by name at run time and for lists, in an order that is always the same.
    pub(super) fn into_variables(self) -> BTreeMap<String, (u32, Type)> {
        let variable = |(name, symbol)| match symbol {
            Symbol::Variable {
                root: Root::Global(cell),
                ty,
            } => Some((name, (cell, ty))),
            Symbol::Variable {
                root: Root::Local(_) | Root::Param(_) | Root::Shared(_),
                ..
            }
            | Symbol::Constant(_)
            | Symbol::Type(_) => None,
        };
        self.symbols.into_iter().filter_map(variable).collect()
    }
}

/// The name nearest to `wanted`, if it is near enough to be a slip of the keyboard.
pub(crate) fn nearest<'a>(wanted: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let limit = 1 + wanted.len() / 5;
    let scored = known.map(|name| (distance(wanted, name), name));
    scored
        .filter(|(score, _)| *score <= limit)
        .min()
        .map(|(_, name)| name)
}

/// Edits between two names (Levenshtein), names of absurd length excepted.
fn distance(a: &str, b: &str) -> usize {
    if a.len().abs_diff(b.len()) > 3 || a.len() > 64 {
        return usize::MAX;
    }
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.bytes().enumerate() {
        let mut diagonal = i;
        let mut left = i + 1;
        for (slot, y) in row.iter_mut().skip(1).zip(b.bytes()) {
            let substituted = diagonal + usize::from(x != y);
            diagonal = *slot;
            left = substituted.min(*slot + 1).min(left + 1);
            *slot = left;
        }
        if let Some(first) = row.first_mut() {
            *first = i + 1;
        }
    }
    row.last().copied().unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_a_slip_and_not_a_guess() {
        let known = ["STATUS", "SPEED", "X"];
        assert_eq!(nearest("STATSU", known.into_iter()), Some("STATUS"));
        assert_eq!(nearest("SPED", known.into_iter()), Some("SPEED"));
        assert_eq!(nearest("VELOCITY", known.into_iter()), None);
    }
}
