//! System variables in expressions and assignments.
//!
//! The host keeps whole variables; a component such as `$UTOOL.x` is taken out of, or put into,
//! the whole value here.

use super::{
    cell::{Address, Cell},
    exec::{Exec, Flow, row_of},
    fault::Fault,
};
use crate::{
    ir::{SystemPart, SystemRef},
    position::XyzwprExt,
    status::Status,
    syspath::SysPath,
    types::{CONFIG_OFFSET, Type},
    value::{SysValue, Value},
};

impl Exec<'_> {
    /// Pushes a scalar, or stores a larger value at the address below the subscripts.
    pub(super) fn load_system(&mut self, row: u32) -> Result<Flow, Fault> {
        let program = self.program;
        let system = row_of(&program.code.systems, row);
        let path = self.take_path(system);
        let value = self.whole(&path)?;
        if system.ty.is_scalar() {
            let cell = match system.component {
                Some(component) => component_of(&value, component),
                None => scalar_of(&value, &system.ty),
            };
            self.push(cell.ok_or_else(|| wrong_type(&path))?);
        } else {
            let target = self.pop_address();
            if !self.memory().set_value(target, &system.ty, &value) {
                return Err(wrong_type(&path));
            }
        }
        Ok(Flow::Next)
    }

    pub(super) fn store_system(&mut self, row: u32) -> Result<Flow, Fault> {
        let program = self.program;
        let system = row_of(&program.code.systems, row);
        let path = self.take_path(system);
        let value = self.pop();
        if let Some(component) = system.component {
            self.store_component(&path, component, &value)?;
            return Ok(Flow::Next);
        }
        let value = match value {
            Cell::Address(at) => self
                .memory()
                .value(at, &system.ty)
                .ok_or_else(Fault::uninit)?,
            Cell::Integer(value) => Value::Integer(value),
            Cell::Real(value) => Value::Real(value),
            Cell::Boolean(value) => Value::Boolean(value),
            Cell::Text(mut value) => {
                if let Type::Text(crate::types::TextLength::AtMost(length)) = system.ty {
                    value.truncate(length as usize);
                }
                Value::String(value)
            }
            Cell::Config(value) => Value::Config(value),
            Cell::Uninit | Cell::File(_) | Cell::Path(_) => {
                unreachable!("the checker refuses this value")
            }
        };
        self.set_whole(&path, value.into())?;
        Ok(Flow::Next)
    }

    /// The variable's value, or none, into the temporary of an output argument.
    pub(super) fn fetch_system(&mut self, row: u32) -> Result<Flow, Fault> {
        let program = self.program;
        let system = row_of(&program.code.systems, row);
        let path = self.take_path(system);
        let target = self.pop_address();
        match self.host.system_variable(self.id, &path) {
            Ok(value) => {
                if let Some(component) = system.component {
                    let cell = component_of(&value, component);
                    self.memory()
                        .set(target, cell.ok_or_else(|| wrong_type(&path))?);
                } else if !self.memory().set_value(target, &system.ty, &value) {
                    return Err(wrong_type(&path));
                }
            }
            Err(Status::INTP_UNINIT) => self.memory().clear(target, &system.ty),
            Err(status) => return Err(unreadable(status, &path)),
        }
        Ok(Flow::Next)
    }

    /// The temporary of an output argument back into the variable.
    pub(super) fn return_system(&mut self, row: u32) -> Result<Flow, Fault> {
        let program = self.program;
        let system = row_of(&program.code.systems, row);
        let path = self.take_path(system);
        let source = self.pop_address();
        if let Some(component) = system.component {
            let value = self.memory().get(source).clone();
            self.store_component(&path, component, &value)?;
            return Ok(Flow::Next);
        }
        let value = self.memory().value(source, &system.ty);
        self.set_whole(&path, value.map_or(SysValue::Uninit, SysValue::Value))?;
        Ok(Flow::Next)
    }

    fn store_component(
        &mut self,
        path: &SysPath,
        component: u32,
        cell: &Cell,
    ) -> Result<(), Fault> {
        let whole = self.whole(path)?;
        let mut position = whole.as_xyzwprext().ok_or_else(|| wrong_type(path))?;
        if !set_component(&mut position, component, cell) {
            return Err(Fault::uninit());
        }
        // Every cartesian system variable that is known is a POSITION.
        self.set_whole(path, Value::Position(position.into()).into())
    }

    fn whole(&mut self, path: &SysPath) -> Result<Value, Fault> {
        self.host
            .system_variable(self.id, path)
            .map_err(|status| unreadable(status, path))
    }

    fn set_whole(&mut self, path: &SysPath, value: SysValue) -> Result<(), Fault> {
        let set = self.host.set_system_variable(self.id, path, value);
        set.map_err(|status| Fault::new(status, format!("Cannot set {path}")))
    }

    /// The path, with the subscripts that are on the stack.
    fn take_path(&mut self, system: &SystemRef) -> SysPath {
        if let Some(path) = &system.fixed {
            return path.clone();
        }
        let mut below = system.subscripts as usize;
        let mut path: Option<SysPath> = None;
        for part in &system.steps {
            path = Some(match (path, part) {
                (None, SystemPart::Name(name)) => SysPath::from_name(name),
                (Some(path), SystemPart::Name(name)) => path.field(name),
                (path, SystemPart::Index(count)) => {
                    let mut subscripts = Vec::new();
                    for _ in 0..*count {
                        below -= 1;
                        subscripts.push(self.operand(below).expect_integer());
                    }
                    path.unwrap_or_else(|| SysPath::from_name(""))
                        .index(&subscripts)
                }
            });
        }
        self.drop_operands(system.subscripts as usize);
        path.unwrap_or_else(|| SysPath::from_name(""))
    }
}

fn unreadable(status: Status, path: &SysPath) -> Fault {
    if status == Status::INTP_UNINIT {
        return Fault::uninit();
    }
    Fault::new(status, format!("Cannot read {path}"))
}

fn wrong_type(path: &SysPath) -> Fault {
    Fault::new(
        Status::INTP_TYPE,
        format!("{path} has another type on this controller"),
    )
}

fn scalar_of(value: &Value, ty: &Type) -> Option<Cell> {
    match (value, ty) {
        (Value::Integer(value), Type::Integer) => Some(Cell::Integer(*value)),
        (Value::Integer(value), Type::Real) => Some(Cell::Real(crate::value::real_of(*value))),
        (Value::Real(value), Type::Real) => Some(Cell::Real(*value)),
        (Value::Boolean(value), Type::Boolean) => Some(Cell::Boolean(*value)),
        (Value::String(value), Type::Text(_)) => Some(Cell::Text(value.clone())),
        (Value::Config(value), Type::Config) => Some(Cell::Config(*value)),
        _ => None,
    }
}

/// A component of a position by its cell.
pub(crate) fn component_of(value: &Value, component: u32) -> Option<Cell> {
    let XyzwprExt {
        x,
        y,
        z,
        w,
        p,
        r,
        config,
        ext,
    } = value.as_xyzwprext()?;
    if component == CONFIG_OFFSET {
        return Some(Cell::Config(config));
    }
    let [e1, e2, e3] = ext;
    let reals = [x, y, z, w, p, r, 0.0, e1, e2, e3];
    reals
        .get(component as usize)
        .map(|value| Cell::Real(*value))
}

/// `false` if the value is not one for this component, in particular if there is none.
pub(crate) fn set_component(position: &mut XyzwprExt, component: u32, cell: &Cell) -> bool {
    let XyzwprExt {
        x,
        y,
        z,
        w,
        p,
        r,
        config,
        ext: [e1, e2, e3],
    } = position;
    if let (Cell::Config(value), CONFIG_OFFSET) = (cell, component) {
        *config = *value;
        return true;
    }
    let Cell::Real(value) = cell else {
        return false;
    };
    let slot = match component {
        0 => x,
        1 => y,
        2 => z,
        3 => w,
        4 => p,
        5 => r,
        7 => e1,
        8 => e2,
        9 => e3,
        _ => return false,
    };
    *slot = *value;
    true
}

/// Where a value of a variable is; what `GET_VAR` and `SET_VAR` find by a path.
#[derive(Debug)]
pub(crate) struct Found {
    pub(crate) at: Address,
    pub(crate) ty: Type,
}
