//! Routines of other programs: found by program and name when programs are loaded.
//!
//! Programs may be loaded in any order, so each new one is also looked at from those that are there.

use super::{
    LoadError, Loaded, Machine,
    cell::{Address, Cell},
};
use crate::{ir::External, program::Program};

/// Where an external routine is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Link {
    /// An index of the machine.
    pub(crate) program: usize,
    pub(crate) routine: u32,
}

impl Machine {
    /// Links a program that is about to be loaded with those that are. Changes nothing on an error.
    pub(super) fn link(&mut self, new: &Program) -> Result<Vec<Option<Link>>, LoadError> {
        let index = self.programs.len();
        let mut links = Vec::new();
        for external in &new.code.externals {
            let home = self.find_program(&external.program);
            let home = home.and_then(|index| Some((index, &self.programs.get(index)?.program)));
            links.push(match home {
                Some((index, program)) => resolve(new, external, index, program)?,
                None => None,
            });
        }
        let mut found = Vec::new();
        for (caller, Loaded { program, links, .. }) in self.programs.iter().enumerate() {
            for (row, (external, link)) in program.code.externals.iter().zip(links).enumerate() {
                if link.is_none() && external.program == new.name() {
                    found.push((caller, row, resolve(program, external, index, new)?));
                }
            }
        }
        for (caller, row, link) in found {
            let links = self
                .programs
                .get_mut(caller)
                .map(|loaded| &mut loaded.links);
            if let Some(slot) = links.and_then(|links| links.get_mut(row)) {
                *slot = link;
            }
        }
        Ok(links)
    }

    /// Refuses a program that shares a variable with another under two types.
    pub(super) fn check_shared(&self, new: &Program) -> Result<(), LoadError> {
        let loaded = || self.programs.iter().map(|loaded| &loaded.program);
        let all = || loaded().chain(std::iter::once(new));
        for user in all() {
            for shared in &user.shared {
                let mut homes = all().filter(|home| home.name() == shared.program);
                let found = homes.find_map(|home| home.globals.get(&shared.name));
                if found.is_some_and(|(_, ty)| *ty != shared.ty) {
                    return Err(LoadError::Variable {
                        user: user.name().to_owned(),
                        variable: shared.name.clone(),
                        program: shared.program.clone(),
                    });
                }
            }
        }
        Ok(())
    }

    /// Gives the cells of shared variables their addresses, as far as their programs are loaded.
    pub(super) fn link_variables(&mut self) {
        let mut found = Vec::new();
        for user in &self.programs {
            for shared in &user.program.shared {
                let home = self.programs.iter();
                let mut home = home.filter(|home| home.name() == shared.program);
                let Some(home) = home.next() else { continue };
                if let Some((cell, _)) = home.program.globals.get(&shared.name) {
                    found.push((user.base + shared.cell, home.base + cell));
                }
            }
        }
        for (slot, cell) in found {
            if let Some(slot) = self.globals.get_mut(slot as usize) {
                *slot = Cell::Address(Address::global(cell));
            }
        }
    }

    /// Routines that programs call and no program has, as `ROUTINE FROM PROGRAM, called by CALLER`.
    /// Calling one ends the task with INTP-316.
    pub fn unresolved(&self) -> impl Iterator<Item = String> + '_ {
        self.programs.iter().flat_map(|loaded| {
            let externals = loaded.program.code.externals.iter().zip(&loaded.links);
            externals
                .filter(|(_, link)| link.is_none())
                .map(|(external, _)| {
                    let External {
                        program, routine, ..
                    } = external;
                    format!(
                        "{routine} FROM {program}, called by {}",
                        loaded.program.name()
                    )
                })
        })
    }
}

/// The routine's number in `home`, `None` if that program has no routine of this name.
fn resolve(
    caller: &Program,
    external: &External,
    index: usize,
    home: &Program,
) -> Result<Option<Link>, LoadError> {
    // The main body is no routine.
    let mut routines = home.code.routines.iter().zip(0_u32..).skip(1);
    let found = routines.find(|(code, _)| *code.name == *external.routine);
    let Some((code, routine)) = found else {
        return Ok(None);
    };
    if code.signature != external.signature {
        return Err(LoadError::Signature {
            caller: caller.name().to_owned(),
            routine: external.routine.clone(),
            program: home.name().to_owned(),
        });
    }
    Ok(Some(Link {
        program: index,
        routine,
    }))
}
