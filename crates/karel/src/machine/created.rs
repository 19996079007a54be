//! Variables that programs make while they run: `CREATE_VAR`.
//!
//! They are never given back, as programs are never unloaded; a power cycle takes their values.

use std::collections::BTreeMap;

use super::{
    cell::{Cell, Memory},
    paths::Paths,
};
use crate::types::{MAX_CELLS, Type};

/// Most of them.
const MAX_VARIABLES: usize = 1000;

/// By program and name.
#[derive(Debug, Default)]
pub(crate) struct Created {
    variables: BTreeMap<(String, String), (u32, Type)>,
    /// Cells of all of them.
    cells: u32,
}

impl Created {
    /// First cell and type.
    pub(crate) fn get(&self, program: &str, name: &str) -> Option<(u32, &Type)> {
        let key = (program.to_owned(), name.to_owned());
        self.variables.get(&key).map(|(cell, ty)| (*cell, ty))
    }

    /// Those of a program, by name.
    pub(crate) fn of<'a>(
        &'a self,
        program: &'a str,
    ) -> impl Iterator<Item = (&'a str, u32, &'a Type)> {
        let all = self.variables.iter();
        let own = all.filter(move |((of, _), _)| of == program);
        own.map(|((_, name), (cell, ty))| (name.as_str(), *cell, ty))
    }

    /// Makes one, uninitialized. `false` if there is no room for it.
    pub(crate) fn create(
        &mut self,
        (program, name): (&str, &str),
        ty: &Type,
        paths: &mut Paths,
        memory: &mut Memory<'_>,
    ) -> bool {
        let cells = self.cells.saturating_add(ty.size());
        let Ok(first) = u32::try_from(memory.globals.len()) else {
            return false;
        };
        if cells > MAX_CELLS || self.variables.len() >= MAX_VARIABLES {
            return false;
        }
        self.cells = cells;
        let end = memory.globals.len() + ty.size() as usize;
        memory.globals.resize(end, Cell::Uninit);
        if let Type::Path(path) = ty
            && let Some(cell) = memory.globals.get_mut(first as usize)
        {
            *cell = paths.add(path.node.size());
        }
        let key = (program.to_owned(), name.to_owned());
        let _new = self.variables.insert(key, (first, ty.clone()));
        true
    }

    /// Gives one another name. `false` if there is none of the old name.
    pub(crate) fn rename(&mut self, program: &str, old: &str, new: &str) -> bool {
        let key = (program.to_owned(), old.to_owned());
        let Some(variable) = self.variables.remove(&key) else {
            return false;
        };
        let key = (program.to_owned(), new.to_owned());
        let _new = self.variables.insert(key, variable);
        true
    }
}
