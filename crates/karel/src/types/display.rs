//! Types as programs write them.

use std::fmt;

use super::{JointKind, PositionKind, Small, TextLength, Type};

impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Type::Integer => f.write_str("INTEGER"),
            Type::Real => f.write_str("REAL"),
            Type::Boolean => f.write_str("BOOLEAN"),
            Type::Text(TextLength::AtMost(length)) => write!(f, "STRING[{length}]"),
            Type::Text(TextLength::Any) => f.write_str("STRING"),
            Type::File => f.write_str("FILE"),
            Type::Config => f.write_str("CONFIG"),
            Type::Position(PositionKind::Position) => f.write_str("POSITION"),
            Type::Position(PositionKind::Xyzwpr) => f.write_str("XYZWPR"),
            Type::Position(PositionKind::XyzwprExt) => f.write_str("XYZWPREXT"),
            Type::Small(Small::Short) => f.write_str("SHORT"),
            Type::Small(Small::Byte) => f.write_str("BYTE"),
            Type::Joints(JointKind::OfGroup) => f.write_str("JOINTPOS"),
            Type::Joints(JointKind::Axes(axes)) => write!(f, "JOINTPOS{axes}"),
            Type::Array(array) if array.dims.is_empty() => write!(f, "ARRAY OF {}", array.element),
            Type::Array(array) => {
                let length = |dim: &u32| match dim {
                    0 => "*".to_owned(),
                    dim => dim.to_string(),
                };
                let dims: Vec<String> = array.dims.iter().map(length).collect();
                write!(f, "ARRAY[{}] OF {}", dims.join(","), array.element)
            }
            Type::Structure(structure) => f.write_str(&structure.name),
            Type::Path(path) => match &path.header {
                None if path.node.is_standard_node() => f.write_str("PATH"),
                None => write!(f, "PATH NODEDATA = {}", path.node),
                Some(header) => write!(f, "PATH PATHHEADER = {header}, NODEDATA = {}", path.node),
            },
            Type::Error => f.write_str("unknown"),
        }
    }
}
