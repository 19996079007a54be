//! Positions and joint positions: their cells.

use super::Type;

/// The three cartesian types. VECTOR has three cells of the same kind and is not one of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum PositionKind {
    Position,
    Xyzwpr,
    XyzwprExt,
}

/// `JOINTPOS` and `JOINTPOS1` to `JOINTPOS9`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum JointKind {
    /// As many axes as the group has; the cells behind them are uninitialized.
    OfGroup,
    /// This many.
    Axes(u8),
}

impl JointKind {
    pub(crate) fn size(self) -> u32 {
        match self {
            JointKind::OfGroup => MAX_AXES,
            JointKind::Axes(axes) => u32::from(axes),
        }
    }
}

/// Axes of a motion group.
const MAX_AXES: u32 = 9;

/// Offset of CONFIG in a position; x, y, z, w, p, r come before it.
pub(crate) const CONFIG_OFFSET: u32 = 6;

const COMPONENTS: [&str; 6] = ["X", "Y", "Z", "W", "P", "R"];
const EXTENDED: [&str; 3] = ["EXT1", "EXT2", "EXT3"];

impl PositionKind {
    /// Cells of a value: six components, the configuration, and extended axes if any.
    pub(crate) fn size(self) -> u32 {
        match self {
            PositionKind::Position | PositionKind::Xyzwpr => CONFIG_OFFSET + 1,
            PositionKind::XyzwprExt => CONFIG_OFFSET + 4,
        }
    }

    pub(super) fn field(self, name: &str) -> Option<(u32, Type)> {
        let index = |names: &[&str]| names.iter().position(|known| *known == name);
        if let Some(index) = index(&COMPONENTS) {
            return Some((u32::try_from(index).ok()?, Type::Real));
        }
        if name == "CONFIG_DATA" {
            return Some((CONFIG_OFFSET, Type::Config));
        }
        if self != PositionKind::XyzwprExt {
            return None;
        }
        let extended = u32::try_from(index(&EXTENDED)?).ok()?;
        Some((CONFIG_OFFSET + 1 + extended, Type::Real))
    }
}
