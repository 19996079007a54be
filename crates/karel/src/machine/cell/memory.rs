//! Variables and frames, by address.

use super::{super::fault::Fault, Address, Cell, FRAME_BIT, FileCell};
use crate::{
    position::{Config, JointPosition, XyzwprExt},
    types::{CONFIG_OFFSET, JointKind, PositionKind, TextLength, Type},
    value::Value,
};

/// All the memory that a task can reach.
pub(crate) struct Memory<'a> {
    pub(crate) globals: &'a mut Vec<Cell>,
    pub(crate) frames: &'a mut Vec<Cell>,
}

impl Memory<'_> {
    #[inline]
    pub(crate) fn get(&self, address: Address) -> &Cell {
        let index = (address.cell & !FRAME_BIT) as usize;
        let row = if address.cell & FRAME_BIT == 0 {
            &*self.globals
        } else {
            &*self.frames
        };
        row.get(index)
            .expect("the checker gave every place its cells")
    }

    #[inline]
    pub(crate) fn get_mut(&mut self, address: Address) -> &mut Cell {
        let index = (address.cell & !FRAME_BIT) as usize;
        let row = if address.cell & FRAME_BIT == 0 {
            &mut *self.globals
        } else {
            &mut *self.frames
        };
        row.get_mut(index)
            .expect("the checker gave every place its cells")
    }

    #[inline]
    pub(crate) fn set(&mut self, address: Address, cell: Cell) {
        *self.get_mut(address) = cell;
    }

    pub(crate) fn file(&self, address: Address) -> FileCell {
        let Cell::File(file) = self.get(address) else {
            unreachable!("a FILE variable holds {:?}", self.get(address))
        };
        *file
    }

    pub(crate) fn set_file(&mut self, address: Address, file: FileCell) {
        self.set(address, Cell::File(file));
    }

    /// Copies a whole array or structure.
    ///
    /// ASSUMPTION: elements that are uninitialized are copied as such and are no error.
    pub(crate) fn copy_cells(&mut self, from: Address, to: Address, cells: u32) {
        for offset in 0..cells {
            let cell = self.get(from.plus(offset)).clone();
            self.set(to.plus(offset), cell);
        }
    }

    /// Reads a position. Components that are uninitialized are an error; a configuration or an
    /// extended axis that was never set is the default one, because programs fill only x..r.
    pub(crate) fn position(&self, at: Address, kind: PositionKind) -> Result<XyzwprExt, Fault> {
        let mut components = [0.0; 6];
        for (component, offset) in components.iter_mut().zip(0..) {
            let Cell::Real(value) = self.get(at.plus(offset)) else {
                return Err(Fault::uninit());
            };
            *component = *value;
        }
        let config = if let Cell::Config(config) = self.get(at.plus(CONFIG_OFFSET)) {
            *config
        } else {
            Config::default()
        };
        let mut ext = [0.0; 3];
        if kind == PositionKind::XyzwprExt {
            for (axis, offset) in ext.iter_mut().zip(CONFIG_OFFSET + 1..) {
                if let Cell::Real(value) = self.get(at.plus(offset)) {
                    *axis = *value;
                }
            }
        }
        let [x, y, z, w, p, r] = components;
        Ok(XyzwprExt {
            x,
            y,
            z,
            w,
            p,
            r,
            config,
            ext,
        })
    }

    pub(crate) fn set_position(&mut self, at: Address, kind: PositionKind, value: &XyzwprExt) {
        let XyzwprExt {
            x,
            y,
            z,
            w,
            p,
            r,
            config,
            ext,
        } = *value;
        for (component, offset) in [x, y, z, w, p, r].into_iter().zip(0..) {
            self.set(at.plus(offset), Cell::Real(component));
        }
        self.set(at.plus(CONFIG_OFFSET), Cell::Config(config));
        if kind == PositionKind::XyzwprExt {
            for (axis, offset) in ext.into_iter().zip(CONFIG_OFFSET + 1..) {
                self.set(at.plus(offset), Cell::Real(axis));
            }
        }
    }

    /// Copies joints to a type with other axes; those that the source lacks are uninitialized.
    pub(crate) fn copy_joints(
        &mut self,
        from: Address,
        from_cells: u32,
        to: Address,
        to_cells: u32,
    ) -> Result<(), Fault> {
        for offset in to_cells..from_cells {
            if *self.get(from.plus(offset)) != Cell::Uninit {
                let axis = offset + 1;
                let message = format!("A JOINTPOS with axis {axis} for one with {to_cells} axes");
                return Err(Fault::argument(message));
            }
        }
        for offset in 0..to_cells {
            let cell = if offset < from_cells {
                self.get(from.plus(offset)).clone()
            } else {
                Cell::Uninit
            };
            self.set(to.plus(offset), cell);
        }
        Ok(())
    }

    /// The axes of a joint position: all of a type that says how many, else those that have a value.
    pub(crate) fn joints(&self, at: Address, kind: JointKind) -> Result<JointPosition, Fault> {
        let mut axes = Vec::new();
        let mut ended = false;
        for offset in 0..kind.size() {
            match (self.get(at.plus(offset)), kind) {
                (Cell::Real(value), _) if !ended => axes.push(*value),
                (Cell::Uninit, JointKind::OfGroup) => ended = true,
                _ => return Err(Fault::uninit()),
            }
        }
        if axes.is_empty() {
            return Err(Fault::uninit());
        }
        Ok(JointPosition { axes })
    }

    /// `false` if the variable has other axes; nothing is stored then.
    pub(crate) fn set_joints(
        &mut self,
        at: Address,
        kind: JointKind,
        value: &JointPosition,
    ) -> bool {
        let fits = match kind {
            JointKind::OfGroup => value.axes.len() <= kind.size() as usize,
            JointKind::Axes(axes) => value.axes.len() == usize::from(axes),
        };
        if fits {
            let mut values = value.axes.iter();
            for offset in 0..kind.size() {
                let cell = values
                    .next()
                    .map_or(Cell::Uninit, |value| Cell::Real(*value));
                self.set(at.plus(offset), cell);
            }
        }
        fits
    }

    /// The value of a variable for the world outside; `None` if it is uninitialized.
    pub(crate) fn value(&self, at: Address, ty: &Type) -> Option<Value> {
        if let Type::Position(kind) = ty {
            let position = self.position(at, *kind).ok()?;
            return Some(match kind {
                PositionKind::Position => Value::Position(position.into()),
                PositionKind::Xyzwpr => Value::Xyzwpr(position.into()),
                PositionKind::XyzwprExt => Value::XyzwprExt(position),
            });
        }
        if let Type::Joints(kind) = ty {
            return self.joints(at, *kind).ok().map(Value::Joints);
        }
        match self.get(at) {
            Cell::Integer(value) => Some(Value::Integer(*value)),
            Cell::Real(value) => Some(Value::Real(*value)),
            Cell::Boolean(value) => Some(Value::Boolean(*value)),
            Cell::Text(value) => Some(Value::String(value.clone())),
            Cell::Config(value) => Some(Value::Config(*value)),
            Cell::Uninit | Cell::File(_) | Cell::Path(_) | Cell::Address(_) => None,
        }
    }

    /// Makes a variable uninitialized.
    pub(crate) fn clear(&mut self, at: Address, ty: &Type) {
        for offset in 0..ty.size() {
            self.set(at.plus(offset), Cell::Uninit);
        }
    }

    /// Stores a value from outside, converted to the variable's type if KAREL would convert it.
    /// `false` if the types do not fit; nothing is stored then.
    pub(crate) fn set_value(&mut self, at: Address, ty: &Type, value: &Value) -> bool {
        let cell = match (ty, value) {
            (Type::Position(kind), _) => {
                let Some(position) = value.as_xyzwprext() else {
                    return false;
                };
                self.set_position(at, *kind, &position);
                return true;
            }
            (Type::Joints(kind), Value::Joints(value)) => {
                return self.set_joints(at, *kind, value);
            }
            (Type::Integer, Value::Integer(value)) => Cell::Integer(*value),
            (Type::Small(small), Value::Integer(value)) => {
                let (least, most) = small.range();
                if !(least..=most).contains(value) {
                    return false;
                }
                Cell::Integer(*value)
            }
            (Type::Real, Value::Real(value)) => Cell::Real(*value),
            (Type::Real, Value::Integer(value)) => Cell::Real(crate::value::real_of(*value)),
            (Type::Boolean, Value::Boolean(value)) => Cell::Boolean(*value),
            (Type::Config, Value::Config(value)) => Cell::Config(*value),
            (Type::Text(length), Value::String(text)) => {
                let mut text = text.clone();
                text.truncate(match length {
                    TextLength::AtMost(length) => *length as usize,
                    TextLength::Any => at.extra as usize,
                });
                Cell::Text(text)
            }
            _ => return false,
        };
        self.set(at, cell);
        true
    }

    /// Whether a variable counts as uninitialized: a scalar without a value, a position without
    /// one of its six components.
    pub(crate) fn is_uninit(&self, at: Address, ty: &Type) -> bool {
        match ty {
            Type::Position(_) => (0..6).any(|offset| *self.get(at.plus(offset)) == Cell::Uninit),
            Type::Joints(JointKind::Axes(axes)) => {
                (0..u32::from(*axes)).any(|offset| *self.get(at.plus(offset)) == Cell::Uninit)
            }
            // ASSUMPTION: arrays and structures count as uninitialized while all of them is.
            Type::Array(_) | Type::Structure(_) => {
                (0..ty.size()).all(|offset| *self.get(at.plus(offset)) == Cell::Uninit)
            }
            Type::Integer
            | Type::Real
            | Type::Boolean
            | Type::Text(_)
            | Type::File
            | Type::Config
            | Type::Path(_)
            | Type::Joints(JointKind::OfGroup)
            | Type::Small(_)
            | Type::Error => *self.get(at) == Cell::Uninit,
        }
    }
}
