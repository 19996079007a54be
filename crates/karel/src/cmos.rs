//! What a machine remembers without power, as plain data that can be written to a file.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{
    machine::cell::Cell,
    position::Config,
    registers::Registers,
    types::{TextLength, Type},
    value::Text,
};

/// Registers, and the variables in CMOS of all programs by program and variable.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Cmos {
    /// The scalars of each variable in order; `None` for one that is uninitialized.
    pub programs: BTreeMap<String, BTreeMap<String, Vec<Option<Scalar>>>>,
    /// The nodes of each PATH, a list of scalars for each.
    #[serde(default)]
    pub paths: BTreeMap<String, BTreeMap<String, PathNodes>>,
    /// The registers.
    pub registers: Registers,
}

/// The scalars of each node in order; `None` for one that is uninitialized.
pub type PathNodes = Vec<Vec<Option<Scalar>>>;

/// One scalar value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scalar {
    /// `INTEGER`.
    Integer(i32),
    /// `REAL`, and components of positions.
    Real(f32),
    /// `BOOLEAN`.
    Boolean(bool),
    /// `STRING`, one character for each byte (Latin-1).
    String(String),
    /// `CONFIG`.
    Config(Config),
}

impl Scalar {
    /// `None` for a cell without a value, and for a FILE, which is never kept.
    pub(crate) fn of(cell: &Cell) -> Option<Scalar> {
        match cell {
            Cell::Integer(value) => Some(Scalar::Integer(*value)),
            Cell::Real(value) => Some(Scalar::Real(*value)),
            Cell::Boolean(value) => Some(Scalar::Boolean(*value)),
            Cell::Text(value) => Some(Scalar::String(value.to_string_lossless())),
            Cell::Config(value) => Some(Scalar::Config(*value)),
            Cell::Uninit | Cell::File(_) | Cell::Path(_) | Cell::Address(_) => None,
        }
    }

    /// The cell for a scalar of this type, `None` if the value is of another.
    fn cell(&self, ty: &Type) -> Option<Cell> {
        match (self, ty) {
            (Scalar::Integer(value), Type::Integer) => Some(Cell::Integer(*value)),
            (Scalar::Real(value), Type::Real) if value.is_finite() => Some(Cell::Real(*value)),
            (Scalar::Boolean(value), Type::Boolean) => Some(Cell::Boolean(*value)),
            (Scalar::Config(value), Type::Config) => Some(Cell::Config(*value)),
            (Scalar::String(value), Type::Text(TextLength::AtMost(length))) => {
                let fits = value.chars().count() <= *length as usize;
                fits.then(|| Cell::Text(Text::from(value.as_str())))
            }
            _ => None,
        }
    }
}

/// The cells of a variable, `None` if the values do not fit its type as it is now.
pub(crate) fn cells(values: &[Option<Scalar>], ty: &Type) -> Option<Vec<Cell>> {
    let mut leaves = Vec::new();
    ty.leaves(&mut leaves);
    if leaves.len() != values.len() {
        return None;
    }
    let cells = values.iter().zip(leaves).map(|(value, leaf)| match value {
        None if leaf == Type::File => Some(Cell::File(crate::machine::cell::FileCell::default())),
        None => Some(Cell::Uninit),
        Some(value) => value.cell(&leaf),
    });
    cells.collect()
}
