//! Switching the machine off and on, and what it remembers of before.

use super::{Machine, cell::Cell};
use crate::{
    cmos::{self, Cmos, Scalar},
    registers::Registers,
    types::Type,
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
        refused
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
            *slot = cell;
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
        for cell in &mut self.globals {
            *cell = Cell::Uninit;
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
