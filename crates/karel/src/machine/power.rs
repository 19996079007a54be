//! Switching the machine off and on, and what it remembers of before.

use std::sync::Arc;

use super::{
    Machine,
    cell::{Cell, Memory},
    inspect::paths_in,
};
use crate::{
    cmos::{self, Cmos, Scalar},
    registers::Registers,
    types::{PathType, Type},
};

impl Machine {
    /// The variables that keep their values without power: `IN CMOS`, `IN SHADOW`, or all of a
    /// program with `%CMOSVARS`.
    #[must_use]
    pub fn export_cmos(&self) -> Cmos {
        let mut memory = Cmos {
            registers: self.registers.clone(),
            ..Cmos::default()
        };
        for loaded in &self.programs {
            let mut variables = std::collections::BTreeMap::new();
            for (name, first, ty) in persistent(loaded) {
                let cells = self.globals.get(first..first + ty.size() as usize);
                let values = cells.unwrap_or_default().iter().map(Scalar::of).collect();
                let _new = variables.insert(name.to_owned(), values);
            }
            self.export_paths(loaded, &mut memory);
            if !variables.is_empty() {
                let name = loaded.name().to_owned();
                let _new = memory.programs.insert(name, variables);
            }
        }
        memory
    }

    /// Sets the variables that [`Machine::export_cmos`] has written. Returns those that are left as
    /// they are, as `[PROGRAM]VARIABLE`: their program is not loaded, or their type has changed.
    pub fn import_cmos(&mut self, memory: &Cmos) -> Vec<String> {
        self.registers.clone_from(&memory.registers);
        let mut refused = Vec::new();
        for (program, variables) in &memory.programs {
            for (name, values) in variables {
                if self.import_variable(program, name, values).is_none() {
                    refused.push(format!("[{program}]{name}"));
                }
            }
        }
        for (program, paths) in &memory.paths {
            for (name, nodes) in paths {
                let path = format!("[{program}]{name}");
                let refused_already = refused.contains(&path);
                if self.import_path(program, name, nodes).is_none() && !refused_already {
                    refused.push(path);
                }
            }
        }
        refused
    }

    /// The nodes of the paths that are kept.
    fn export_paths(&self, loaded: &super::Loaded, memory: &mut Cmos) {
        for (name, first, _) in persistent_paths(loaded) {
            if let Some(Cell::Path(id)) = self.globals.get(first) {
                let size = self.paths.node_cells(*id) as usize;
                let numbers = 1..=i32::try_from(self.paths.len(*id)).unwrap_or(i32::MAX);
                let nodes = numbers.filter_map(|number| {
                    let first = self.paths.node(*id, number)?.global_index();
                    let cells = self.globals.get(first..first + size)?;
                    Some(cells.iter().map(Scalar::of).collect())
                });
                let paths = memory.paths.entry(loaded.name().to_owned()).or_default();
                let _new = paths.insert(name, nodes.collect());
            }
        }
    }

    fn import_path(
        &mut self,
        program: &str,
        name: &str,
        nodes: &[Vec<Option<Scalar>>],
    ) -> Option<()> {
        let loaded = self.programs.get(self.find_program(program)?)?;
        let (_, first, path) = persistent_paths(loaded).find(|(known, ..)| *known == name)?;
        let rows = nodes.iter().map(|values| cmos::cells(values, &path.node));
        let rows = rows.collect::<Option<Vec<_>>>()?;
        let id = self.globals.get(first)?.expect_path();
        self.paths.clear(id);
        let mut no_frames = Vec::new();
        let mut memory = Memory {
            globals: &mut self.globals,
            frames: &mut no_frames,
        };
        for (row, number) in rows.into_iter().zip(1..) {
            let before = self.paths.len(id);
            if !self.paths.insert(id, before, &mut memory) {
                return None;
            }
            let at = self.paths.node(id, number)?;
            for (cell, offset) in row.into_iter().zip(0..) {
                memory.set(at.plus(offset), cell);
            }
        }
        Some(())
    }

    fn import_variable(
        &mut self,
        program: &str,
        name: &str,
        values: &[Option<Scalar>],
    ) -> Option<()> {
        let loaded = self.programs.get(self.find_program(program)?)?;
        let (_, first, ty) = persistent(loaded).find(|(known, ..)| *known == name)?;
        let cells = cmos::cells(values, ty)?;
        let target = self.globals.get_mut(first..first + cells.len())?;
        for (slot, cell) in target.iter_mut().zip(cells) {
            if !matches!(slot, Cell::Path(_)) {
                *slot = cell;
            }
        }
        Some(())
    }

    /// Switches off and on: tasks are gone, every variable is uninitialized. Nothing is asked of the
    /// host; what was open there is its own business.
    ///
    /// What shall survive is exported before and imported after.
    pub fn power_cycle(&mut self) {
        self.tasks.clear();
        self.registers = Registers::new(self.limits.registers);
        self.paths.clear_all();
        for cell in &mut self.globals {
            // A PATH stays one, without nodes.
            if !matches!(cell, Cell::Path(_)) {
                *cell = Cell::Uninit;
            }
        }
        for loaded in &self.programs {
            for file in &loaded.program.global_files {
                if let Some(cell) = self.globals.get_mut((loaded.base + file) as usize) {
                    *cell = Cell::File(loaded.program.closed_file(*file));
                }
            }
        }
        self.link_variables();
        self.timers.clear();
        self.pulses.clear();
        self.semaphores = super::Semaphores::default();
    }
}

/// Name, first cell and type of each variable that is kept.
fn persistent(loaded: &super::Loaded) -> impl Iterator<Item = (&str, usize, &Type)> {
    let program = &loaded.program;
    program.persistent.iter().filter_map(|name| {
        let (cell, ty) = program.globals.get(name)?;
        Some((name.as_str(), (loaded.base + cell) as usize, ty))
    })
}

/// Name, first cell and type of each PATH that is kept, also in an array or a structure.
fn persistent_paths(
    loaded: &super::Loaded,
) -> impl Iterator<Item = (String, usize, Arc<PathType>)> + '_ {
    persistent(loaded).flat_map(|(name, first, ty)| {
        let first = u32::try_from(first).unwrap_or(u32::MAX);
        let paths = paths_in(name, first, ty).into_iter();
        paths.map(|(name, cell, path)| (name, cell as usize, path))
    })
}
