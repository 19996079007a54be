//! Variables of programs by name: what `GET_VAR`, `SET_VAR` and an operator reach from outside.

use super::{
    Loaded, Machine,
    cell::{Address, Cell, Memory},
    created::Created,
    paths::Paths,
    system::Found,
};
use crate::{
    host::TaskId,
    status::Status,
    syspath::{Step, SysPath},
    types::{PathType, TextLength, Type},
    value::Value,
};

impl Machine {
    /// The value of a program's variable, `None` if it is uninitialized.
    ///
    /// # Errors
    /// MEMO-073 if the program is not loaded, VARS-011 for an unknown name, VARS-024 for a
    /// subscript out of range, VARS-012 for a whole array or structure.
    pub fn variable(&mut self, program: &str, path: &SysPath) -> Result<Option<Value>, Status> {
        let found = find(self.names(), program, path)?;
        let mut no_frames = Vec::new();
        let memory = Memory {
            globals: &mut self.globals,
            frames: &mut no_frames,
        };
        Ok(memory.value(found.at, &found.ty))
    }

    /// Sets a program's variable, as an operator does on the pendant's data screen; `None` makes
    /// it uninitialized.
    ///
    /// # Errors
    /// As [`Machine::variable`]; VARS-012 if the value's type does not fit.
    pub fn set_variable(
        &mut self,
        program: &str,
        path: &SysPath,
        value: Option<&Value>,
    ) -> Result<(), Status> {
        let found = find(self.names(), program, path)?;
        let mut no_frames = Vec::new();
        let mut memory = Memory {
            globals: &mut self.globals,
            frames: &mut no_frames,
        };
        match value {
            None => memory.clear(found.at, &found.ty),
            Some(value) => {
                if !memory.set_value(found.at, &found.ty, value) {
                    return Err(Status::VARS_TYPE);
                }
            }
        }
        Ok(())
    }

    pub(super) fn names(&self) -> Names<'_> {
        Names {
            programs: &self.programs,
            paths: &self.paths,
            created: &self.created,
            globals: &self.globals,
        }
    }

    /// The task that runs a program, if there is one.
    #[must_use]
    pub fn task_of(&self, program: &str) -> Option<TaskId> {
        self.tasks.named(program).map(|(id, _)| id)
    }
}

/// What is needed to find a variable by its name.
#[derive(Clone, Copy)]
pub(crate) struct Names<'a> {
    pub(crate) programs: &'a [Loaded],
    pub(crate) paths: &'a Paths,
    pub(crate) created: &'a Created,
    pub(crate) globals: &'a [Cell],
}

/// Follows a path from a program's variable to what has a value of its own.
pub(crate) fn find(names: Names<'_>, program: &str, path: &SysPath) -> Result<Found, Status> {
    let found = locate(names, program, path)?;
    match &found.ty {
        Type::Array(_) | Type::Structure(_) | Type::Path(_) | Type::File => Err(Status::VARS_TYPE),
        Type::Text(TextLength::AtMost(length)) => Ok(Found {
            at: found.at.with_extra(*length),
            ty: found.ty,
        }),
        Type::Integer
        | Type::Real
        | Type::Boolean
        | Type::Text(TextLength::Any)
        | Type::Config
        | Type::Position(_)
        | Type::Joints(_)
        | Type::Small(_)
        | Type::Error => Ok(found),
    }
}

/// Follows a path from a program's variable to anything.
pub(crate) fn locate(names: Names<'_>, program: &str, path: &SysPath) -> Result<Found, Status> {
    let mut programs = names.programs.iter();
    let loaded = programs.find(|loaded| loaded.program.name().eq_ignore_ascii_case(program));
    let loaded = loaded.ok_or(Status::MEMO_NO_PROGRAM)?;
    let (cell, ty) = match loaded.program.globals.get(path.root()) {
        Some((cell, ty)) => (loaded.base + cell, ty),
        None => names
            .created
            .get(loaded.program.name(), path.root())
            .ok_or(Status::VARS_UNKNOWN)?,
    };
    let mut found = Found {
        at: Address::global(cell),
        ty: ty.clone(),
    };
    for step in path.steps().iter().skip(1) {
        found = match step {
            Step::Name(name) => {
                let (offset, ty) = found.ty.field(name).ok_or(Status::VARS_UNKNOWN)?;
                Found {
                    at: found.at.plus(offset),
                    ty,
                }
            }
            Step::Index(subscripts) => {
                if let Type::Path(path) = &found.ty {
                    node(names, found.at, path, subscripts)?
                } else {
                    element(&found, subscripts)?
                }
            }
        };
    }
    Ok(found)
}

fn node(
    names: Names<'_>,
    at: Address,
    path: &PathType,
    subscripts: &[i32],
) -> Result<Found, Status> {
    let ([number], Some(Cell::Path(id))) = (subscripts, names.globals.get(at.global_index()))
    else {
        return Err(Status::VARS_INDEX);
    };
    let at = names.paths.node(*id, *number).ok_or(Status::VARS_INDEX)?;
    Ok(Found {
        at,
        ty: path.node.clone(),
    })
}

fn element(found: &Found, subscripts: &[i32]) -> Result<Found, Status> {
    let Type::Array(array) = &found.ty else {
        return Err(Status::VARS_INDEX);
    };
    if subscripts.len() != array.dims.len() {
        return Err(Status::VARS_INDEX);
    }
    let mut offset = 0;
    for (subscript, dim) in subscripts.iter().zip(&array.dims) {
        let index = u32::try_from(*subscript)
            .ok()
            .and_then(|index| index.checked_sub(1));
        let index = index
            .filter(|index| index < dim)
            .ok_or(Status::VARS_INDEX)?;
        offset = offset * dim + index;
    }
    let at = found.at.plus(offset * array.element.size());
    Ok(Found {
        at,
        ty: array.element.clone(),
    })
}
