//! Structures that no program declares: `VECTOR`, `QUEUE_TYPE`, and what a node of a PATH has.

use std::sync::Arc;

use super::{Field, PositionKind, StructureType, Type};

const VECTOR: &str = "VECTOR";
const QUEUE: &str = "QUEUE_TYPE";
const STANDARD_NODE: &str = "STD_PTH_NODE";

/// A structure that no program declares.
pub(crate) fn structure(name: &str, members: &[(&str, Type)]) -> Type {
    let mut fields = Vec::new();
    let mut size = 0;
    let mut depth = 0;
    for (name, ty) in members {
        fields.push(Field {
            name: (*name).to_owned(),
            ty: ty.clone(),
            offset: size,
        });
        size += ty.size();
        depth = depth.max(ty.depth());
    }
    Type::Structure(Arc::new(StructureType {
        name: name.to_owned(),
        fields,
        size,
        depth: depth + 1,
    }))
}

impl Type {
    /// `VECTOR`: three REALs by the names of their axes, like a structure that nobody declares.
    pub(crate) fn vector() -> Type {
        structure(VECTOR, &["X", "Y", "Z"].map(|axis| (axis, Type::Real)))
    }

    /// The standard node of a PATH.
    ///
    /// ASSUMPTION: the names and types of the fields beside `NODE_POS` are from memory; motion does
    /// not look at them.
    pub(crate) fn standard_node() -> Type {
        let position = Type::Position(PositionKind::Position);
        structure(
            STANDARD_NODE,
            &[
                ("NODE_POS", position),
                ("GROUP_DATA", Type::group_assoc()),
                ("COMMON_DATA", Type::common_assoc()),
            ],
        )
    }

    /// What a node says of a motion group.
    pub(crate) fn group_assoc() -> Type {
        structure(
            "GROUP_ASSOC",
            &[
                ("SEGRELSPEED", Type::Integer),
                ("SEGMOTYPE", Type::Integer),
                ("SEGORIENTYPE", Type::Integer),
                ("SEGBREAK", Type::Boolean),
            ],
        )
    }

    /// What a node says of all groups.
    pub(crate) fn common_assoc() -> Type {
        structure(
            "COMMON_ASSOC",
            &[
                ("SEGTERMTYPE", Type::Integer),
                ("SEGDECELTOL", Type::Integer),
                ("SEGRELACCEL", Type::Integer),
                ("SEGTIMESHFT", Type::Integer),
            ],
        )
    }

    /// What the queue built-ins keep beside the data of a queue.
    ///
    /// ASSUMPTION: programs do not look at the fields, whose names are ours.
    pub(crate) fn queue() -> Type {
        structure(
            QUEUE,
            &[
                ("FIRST", Type::Integer),
                ("COUNT", Type::Integer),
                ("SEQUENCE", Type::Integer),
            ],
        )
    }

    pub(crate) fn is_queue(&self) -> bool {
        matches!(self, Type::Structure(structure) if structure.name == QUEUE)
            && *self == Type::queue()
    }

    pub(crate) fn is_standard_node(&self) -> bool {
        matches!(self, Type::Structure(structure) if structure.name == STANDARD_NODE)
            && *self == Type::standard_node()
    }

    pub(crate) fn is_vector(&self) -> bool {
        // A program may declare a structure of this name with other fields.
        matches!(self, Type::Structure(structure) if structure.name == VECTOR && structure.size == 3)
            && *self == Type::vector()
    }
}
