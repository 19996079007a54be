//! Types, and how values of a type lie in memory.
//!
//! Memory is a row of cells. A scalar is one cell; arrays, structures and positions are the cells
//! of their parts in order, so that every part can be uninitialized on its own and a reference to
//! any part is one number.

mod absent;
mod array;
mod display;
mod position;
mod standard;

use std::sync::Arc;

pub(crate) use absent::absent;
pub(crate) use array::{
    ArrayType, MAX_OPEN_DIMS, grid_lengths, split_grid, split_text_array, text_array_lengths,
};
pub(crate) use position::{CONFIG_OFFSET, JointKind, PositionKind};

/// Longest string of a program.
pub(crate) const MAX_STRING: usize = 254;

/// Most cells of one variable, and of all variables of a program.
pub(crate) const MAX_CELLS: u32 = 1 << 20;

/// Most PATHs of a program's variables, and of one routine's.
pub(crate) const MAX_PATHS: usize = 1_000;

/// Most cells of a node of a PATH.
pub(crate) const MAX_NODE: u32 = 1 << 12;

/// Most levels of arrays and structures in each other.
pub(crate) const MAX_TYPE_DEPTH: u32 = 32;

/// A type of a variable or an expression.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Type {
    Integer,
    Real,
    Boolean,
    Text(TextLength),
    File,
    Config,
    Position(PositionKind),
    Joints(JointKind),
    /// An INTEGER of an array or a structure that holds fewer.
    Small(Small),
    Array(Arc<ArrayType>),
    Structure(Arc<StructureType>),
    /// Nodes, and a header before them.
    Path(Arc<PathType>),
    /// A type that was reported already; fits everything.
    Error,
}

/// `SHORT` and `BYTE`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Small {
    Short,
    Byte,
}

impl Small {
    /// Least and largest value.
    ///
    /// ASSUMPTION: BYTE has no sign.
    pub(crate) fn range(self) -> (i32, i32) {
        match self {
            Small::Short => (i32::from(i16::MIN), i32::from(i16::MAX)),
            Small::Byte => (0, i32::from(u8::MAX)),
        }
    }
}

/// The declared length of a string.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TextLength {
    AtMost(u32),
    /// `STRING` without a length: of parameters, results and expressions.
    Any,
}

/// `PATH`: in memory one cell that names its nodes, and the header.
#[derive(Debug, PartialEq)]
pub(crate) struct PathType {
    pub(crate) header: Option<Type>,
    pub(crate) node: Type,
    /// Levels of arrays and structures, this one included.
    pub(crate) depth: u32,
}

#[derive(Debug)]
pub(crate) struct StructureType {
    pub(crate) name: String,
    pub(crate) fields: Vec<Field>,
    pub(crate) size: u32,
    /// Levels of arrays and structures, this one included.
    pub(crate) depth: u32,
}

/// Structures are the same if they have the same name and layout.
impl PartialEq for StructureType {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name && self.fields == other.fields
    }
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Field {
    pub(crate) name: String,
    pub(crate) ty: Type,
    pub(crate) offset: u32,
}

impl Type {
    pub(crate) const TEXT: Type = Type::Text(TextLength::Any);

    /// The type of the language with this name, in upper case.
    pub(crate) fn named(name: &str) -> Option<Type> {
        if let Some(axes) = name.strip_prefix("JOINTPOS") {
            return Some(Type::Joints(match axes.as_bytes() {
                [] => JointKind::OfGroup,
                [digit @ b'1'..=b'9'] => JointKind::Axes(digit - b'0'),
                _ => return None,
            }));
        }
        Some(match name {
            "INTEGER" => Type::Integer,
            "REAL" => Type::Real,
            "BOOLEAN" => Type::Boolean,
            "FILE" => Type::File,
            "CONFIG" => Type::Config,
            "SHORT" => Type::Small(Small::Short),
            "BYTE" => Type::Small(Small::Byte),
            "VECTOR" => Type::vector(),
            "STD_PTH_NODE" => Type::standard_node(),
            "GROUP_ASSOC" => Type::group_assoc(),
            "COMMON_ASSOC" => Type::common_assoc(),
            "QUEUE_TYPE" => Type::queue(),
            "POSITION" => Type::Position(PositionKind::Position),
            "XYZWPR" => Type::Position(PositionKind::Xyzwpr),
            "XYZWPREXT" => Type::Position(PositionKind::XyzwprExt),
            _ => return None,
        })
    }

    /// Cells of a value; an open array or a string without length counts as one reference.
    pub(crate) fn size(&self) -> u32 {
        match self {
            Type::Integer
            | Type::Real
            | Type::Boolean
            | Type::Text(_)
            | Type::File
            | Type::Config
            | Type::Small(_)
            | Type::Error => 1,
            Type::Position(kind) => kind.size(),
            Type::Joints(kind) => kind.size(),
            Type::Array(array) => array.dims.iter().fold(array.element.size(), |size, dim| {
                size.saturating_mul((*dim).max(1))
            }),
            Type::Structure(structure) => structure.size,
            Type::Path(path) => 1_u32.saturating_add(path.header.as_ref().map_or(0, Type::size)),
        }
    }

    /// Levels of arrays and structures; limited, because types are walked recursively.
    pub(crate) fn depth(&self) -> u32 {
        if let Type::Array(array) = self {
            array.depth
        } else if let Type::Structure(structure) = self {
            structure.depth
        } else if let Type::Path(path) = self {
            path.depth
        } else {
            0
        }
    }

    /// The cartesian kind, if it is one.
    pub(crate) fn position_kind(&self) -> Option<PositionKind> {
        if let Type::Position(kind) = self {
            Some(*kind)
        } else {
            None
        }
    }

    /// The declared length of a string, or of an array of one dimension.
    pub(crate) fn length(&self) -> Option<u32> {
        if let Type::Text(TextLength::AtMost(length)) = self {
            return Some(*length);
        }
        if let Type::Array(array) = self
            && let [length] = array.dims.as_slice()
            && *length > 0
        {
            return Some(*length);
        }
        None
    }

    /// Whether a value is one cell and travels on the operand stack.
    pub(crate) fn is_scalar(&self) -> bool {
        !matches!(
            self,
            Type::Position(_)
                | Type::Joints(_)
                | Type::Array(_)
                | Type::Structure(_)
                | Type::Path(_)
        )
    }

    /// The type of its values in expressions.
    pub(crate) fn of_value(&self) -> Type {
        if let Type::Small(_) = self {
            return Type::Integer;
        }
        self.clone()
    }

    pub(crate) fn is_number(&self) -> bool {
        matches!(self, Type::Integer | Type::Real | Type::Error)
    }

    pub(crate) fn is_text(&self) -> bool {
        matches!(self, Type::Text(_) | Type::Error)
    }

    /// Offset and type of a field.
    pub(crate) fn field(&self, name: &str) -> Option<(u32, Type)> {
        if let Type::Position(kind) = self {
            return kind.field(name);
        }
        if let Type::Structure(structure) = self {
            let field = structure.fields.iter().find(|field| field.name == name)?;
            return Some((field.offset, field.ty.clone()));
        }
        let Type::Path(path) = self else {
            return None;
        };
        let (offset, ty) = path.header.as_ref()?.field(name)?;
        Some((offset + 1, ty))
    }

    /// The types of its cells, in order.
    pub(crate) fn leaves(&self, leaves: &mut Vec<Type>) {
        match self {
            Type::Position(kind) => {
                let cells = 0..kind.size();
                leaves.extend(cells.map(|cell| match cell {
                    CONFIG_OFFSET => Type::Config,
                    _ => Type::Real,
                }));
            }
            Type::Joints(kind) => leaves.extend((0..kind.size()).map(|_| Type::Real)),
            Type::Array(array) => {
                let count: u32 = array.dims.iter().product();
                for _ in 0..count {
                    array.element.leaves(leaves);
                }
            }
            Type::Structure(structure) => {
                for field in &structure.fields {
                    field.ty.leaves(leaves);
                }
            }
            Type::Path(path) => {
                leaves.push(self.clone());
                if let Some(header) = &path.header {
                    header.leaves(leaves);
                }
            }
            Type::Integer
            | Type::Real
            | Type::Boolean
            | Type::Text(_)
            | Type::File
            | Type::Config
            | Type::Small(_)
            | Type::Error => leaves.push(self.clone()),
        }
    }

    /// Whether a FILE is in it, or it is one.
    pub(crate) fn holds_file(&self) -> bool {
        self.holds(&|ty| matches!(ty, Type::File))
    }

    /// Whether a PATH is in it, or it is one.
    pub(crate) fn holds_path(&self) -> bool {
        self.holds(&|ty| matches!(ty, Type::Path(_)))
    }

    /// Whether it can be copied: neither FILEs nor PATHs can.
    pub(crate) fn is_copied(&self) -> bool {
        !self.holds(&|ty| matches!(ty, Type::File | Type::Path(_)))
    }

    fn holds(&self, wanted: &dyn Fn(&Type) -> bool) -> bool {
        if let Type::Array(array) = self {
            return array.element.holds(wanted);
        }
        if let Type::Structure(structure) = self {
            let mut fields = structure.fields.iter();
            return fields.any(|field| field.ty.holds(wanted));
        }
        wanted(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_lie_as_components_then_configuration_then_extended_axes() {
        let extended = Type::Position(PositionKind::XyzwprExt);
        assert_eq!(extended.size(), 10);
        assert_eq!(extended.field("R"), Some((5, Type::Real)));
        assert_eq!(extended.field("EXT3"), Some((9, Type::Real)));
        assert_eq!(Type::Position(PositionKind::Xyzwpr).field("EXT1"), None);
    }

    #[test]
    fn the_size_of_an_array_is_the_product_of_its_dimensions() {
        let dims = vec![2, 3];
        let array = Type::Array(Arc::new(ArrayType {
            dims,
            element: Type::TEXT,
            depth: 1,
        }));
        assert_eq!(array.size(), 6);
        assert_eq!(array.to_string(), "ARRAY[2,3] OF STRING");
    }
}
