//! What an operator's data screen shows, and ending a task with an error from outside.

use std::sync::Arc;

use super::{
    Loaded, Machine, Names,
    cell::{Address, Cell, Memory},
    fault::Fault,
    is_alive, runtime_error,
};
use crate::{
    host::{Host, TaskId},
    run::TaskState,
    status::Status,
    types::{PathType, TextLength, Type},
    value::Value,
};

/// One variable of a program, or one part of it that has a value of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct VariableView {
    /// Its path from the program, `CFG_.CHECKED` or `TABLE[2,3]`.
    pub path: String,
    /// Its type, `INTEGER` or `STRING[20]`.
    pub type_name: String,
    /// Its value, `None` if it is uninitialized or a FILE.
    pub value: Option<Value>,
}

impl Machine {
    /// The variables of a program by name; arrays and structures as their parts. At most `limit`,
    /// and whether there are more.
    ///
    /// Variables that the program takes from others are shown with those.
    ///
    /// # Errors
    /// MEMO-073 if the program is not loaded.
    pub fn variables_of(
        &mut self,
        program: &str,
        limit: usize,
    ) -> Result<(Vec<VariableView>, bool), Status> {
        let index = self.find_program(program).ok_or(Status::MEMO_NO_PROGRAM)?;
        let loaded = self.programs.get(index).ok_or(Status::MEMO_NO_PROGRAM)?;
        let mut parts = parts_of(self.names(), loaded, limit);
        let more = parts.len() > limit;
        parts.truncate(limit);
        let mut no_frames = Vec::new();
        let memory = Memory {
            globals: &mut self.globals,
            frames: &mut no_frames,
        };
        let views = parts.into_iter().map(|(path, cell, ty)| VariableView {
            value: memory.value(address(cell, &ty), &ty),
            type_name: ty.to_string(),
            path,
        });
        Ok((views.collect(), more))
    }

    /// Ends a task with an error as if its present statement had failed, posts the alarm, and says
    /// whether the task was alive. What moves is the host's business.
    pub fn fail(
        &mut self,
        id: TaskId,
        status: Status,
        message: String,
        host: &mut dyn Host,
    ) -> bool {
        let alive = |task: &&super::Task| is_alive(&task.state);
        let Some(task) = self.tasks.get(id).filter(alive) else {
            return false;
        };
        let error = runtime_error(Fault::new(status, message), task, &self.programs);
        let _was_alive = self.tasks.end(id, host);
        host.post_alarm(id, &error);
        self.tasks.set_state(id, TaskState::Aborted(error));
        true
    }
}

/// Path, cell and type of everything of a program that has a value of its own, up to one more than
/// `limit`. What it takes from other programs is not among it.
pub(crate) fn parts_of(
    names: Names<'_>,
    loaded: &Loaded,
    limit: usize,
) -> Vec<(String, u32, Type)> {
    let taken = |name: &str| loaded.program.shared.iter().any(|own| own.name == name);
    let declared = loaded.program.globals.iter();
    let declared = declared.map(|(name, (cell, ty))| (name.as_str(), loaded.base + cell, ty));
    let mut variables: Vec<(&str, u32, &Type)> = declared.collect();
    variables.extend(names.created.of(loaded.name()));
    variables.retain(|(name, ..)| !taken(name));
    variables.sort_unstable_by_key(|(name, ..)| *name);
    let mut parts = Vec::new();
    for (name, cell, ty) in variables {
        if !split(names, name.to_owned(), (cell, ty), limit, &mut parts) {
            break;
        }
    }
    parts
}

pub(crate) fn address(cell: u32, ty: &Type) -> Address {
    let at = Address::global(cell);
    if let Type::Text(TextLength::AtMost(length)) = ty {
        at.with_extra(*length)
    } else {
        at
    }
}

/// The parts of a variable that have values of their own. `false` once there are more than `limit`.
fn split(
    names: Names<'_>,
    path: String,
    (cell, ty): (u32, &Type),
    limit: usize,
    parts: &mut Vec<(String, u32, Type)>,
) -> bool {
    match ty {
        Type::Structure(structure) => structure.fields.iter().all(|field| {
            let path = format!("{path}.{}", field.name);
            split(names, path, (cell + field.offset, &field.ty), limit, parts)
        }),
        Type::Array(array) => {
            let count: u32 = array.dims.iter().product();
            (0..count).all(|index| {
                let path = format!("{path}[{}]", subscripts(index, &array.dims));
                let at = cell + index * array.element.size();
                split(names, path, (at, &array.element), limit, parts)
            })
        }
        Type::Path(nodes) => {
            let Some(Cell::Path(id)) = names.globals.get(cell as usize) else {
                return true;
            };
            let header = nodes.header.as_ref();
            if !header
                .is_none_or(|header| split(names, path.clone(), (cell + 1, header), limit, parts))
            {
                return false;
            }
            let numbers = 1..=i32::try_from(names.paths.len(*id)).unwrap_or(i32::MAX);
            numbers.into_iter().all(|number| {
                let Some(at) = names.paths.node(*id, number) else {
                    return true;
                };
                let cell = u32::try_from(at.global_index()).unwrap_or(u32::MAX);
                let path = format!("{path}[{number}]");
                split(names, path, (cell, &nodes.node), limit, parts)
            })
        }
        Type::Integer
        | Type::Real
        | Type::Boolean
        | Type::Text(_)
        | Type::File
        | Type::Config
        | Type::Position(_)
        | Type::Joints(_)
        | Type::Small(_)
        | Type::Error => {
            parts.push((path, cell, ty.clone()));
            parts.len() <= limit
        }
    }
}

/// The PATHs of a variable as programs name them, each with its first cell and its type.
pub(crate) fn paths_in(name: &str, cell: u32, ty: &Type) -> Vec<(String, u32, Arc<PathType>)> {
    if !ty.holds_path() {
        return Vec::new();
    }
    if let Type::Path(path) = ty {
        return vec![(name.to_owned(), cell, path.clone())];
    }
    if let Type::Structure(structure) = ty {
        let fields = structure.fields.iter();
        let paths = fields.flat_map(|field| {
            let name = format!("{name}.{}", field.name);
            paths_in(&name, cell + field.offset, &field.ty)
        });
        return paths.collect();
    }
    let Type::Array(array) = ty else {
        return Vec::new();
    };
    let count: u32 = array.dims.iter().product();
    let paths = (0..count).flat_map(|index| {
        let name = format!("{name}[{}]", subscripts(index, &array.dims));
        paths_in(&name, cell + index * array.element.size(), &array.element)
    });
    paths.collect()
}

/// `2,3` for the sixth element of an array of 2 by 4: the last subscript runs fastest.
fn subscripts(mut index: u32, dims: &[u32]) -> String {
    let mut texts = Vec::new();
    for dim in dims.iter().rev() {
        let dim = (*dim).max(1);
        texts.push((index % dim + 1).to_string());
        index /= dim;
    }
    texts.reverse();
    texts.join(",")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Limits, Program};

    #[test]
    fn variables_are_listed_in_parts_up_to_a_limit() {
        let source = b"PROGRAM shown
TYPE
  pair_t = STRUCTURE
    ok : BOOLEAN
    n : ARRAY[2] OF INTEGER
  ENDSTRUCTURE
VAR
  grid : ARRAY[2,2] OF REAL
  cfg : pair_t
  name : STRING[8]
BEGIN
END shown
";
        let program = Program::parse_and_check(source, "shown.kl").unwrap();
        let mut machine = Machine::new(Limits::default());
        machine.load(program).unwrap();
        let (views, more) = machine.variables_of("shown", 100).unwrap();
        let paths: Vec<&str> = views.iter().map(|view| view.path.as_str()).collect();
        let expected = [
            "CFG.OK",
            "CFG.N[1]",
            "CFG.N[2]",
            "GRID[1,1]",
            "GRID[1,2]",
            "GRID[2,1]",
            "GRID[2,2]",
            "NAME",
        ];
        assert_eq!((paths.as_slice(), more), (&expected[..], false));
        for view in &views {
            let path = crate::SysPath::parse(&view.path).unwrap();
            assert_eq!(machine.variable("shown", &path), Ok(None), "{}", view.path);
        }
        let path = crate::SysPath::parse("grid[2,1]").unwrap();
        machine
            .set_variable("shown", &path, Some(&Value::Real(7.5)))
            .unwrap();
        let (views, more) = machine.variables_of("SHOWN", 6).unwrap();
        assert_eq!((views.len(), more), (6, true));
        assert_eq!(views[5].value, Some(Value::Real(7.5)));
        assert_eq!(views[5].type_name, "REAL");
        let missing = machine.variables_of("none", 6);
        assert_eq!(missing, Err(Status::MEMO_NO_PROGRAM));
    }
}
