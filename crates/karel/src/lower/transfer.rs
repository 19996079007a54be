//! READ and WRITE: positions and arrays become their parts.

use super::{Lowering, add_row, count};
use crate::{
    ir::{Op, Outward, Rare, ReadPart, ReadShape, ScalarType, WritePart, WriteShape},
    typed::{Expr, ExprKind, Place, ReadItem, Root, Step, WriteItem},
    types::{CONFIG_OFFSET, JointKind, PositionKind, Small, Type},
};

impl Lowering<'_> {
    pub(super) fn read(&mut self, file: &Place, items: &[ReadItem]) {
        self.address(file);
        let mut operands = 1;
        let mut parts = Vec::new();
        for item in items {
            match item {
                ReadItem::LineEnd => parts.push(ReadPart::LineEnd),
                ReadItem::Value { place, formats } if place.ty.is_scalar() => {
                    self.reference(place);
                    for format in formats {
                        self.scalar(format);
                    }
                    let formats = count(formats.len());
                    operands += 1 + formats;
                    parts.push(ReadPart::Value {
                        ty: scalar_type(&place.ty),
                        formats,
                    });
                }
                ReadItem::Value { place, formats } => {
                    self.address(place);
                    let at = self.kept();
                    let kept = self.kept_formats(formats);
                    for (offset, ty) in parts_of(&place.ty) {
                        self.reference(&part(at, offset, ty.clone()));
                        operands += 1 + self.formats(&kept);
                        parts.push(ReadPart::Value {
                            ty: scalar_type(&ty),
                            formats: count(kept.len()),
                        });
                    }
                }
            }
        }
        let shape = ReadShape {
            items: parts,
            operands,
        };
        let row = add_row(&mut self.code.reads, shape);
        self.emit(Op::Outward(Outward::Read(row)));
    }

    pub(super) fn write(&mut self, file: Option<&Place>, items: &[WriteItem]) {
        let mut operands = 0;
        if let Some(file) = file {
            self.address(file);
            operands += 1;
        }
        let mut parts = Vec::new();
        for item in items {
            match item {
                WriteItem::LineEnd => parts.push(WritePart::LineEnd),
                WriteItem::Value { value, formats } if value.ty.is_scalar() => {
                    self.scalar(value);
                    for format in formats {
                        self.scalar(format);
                    }
                    let formats = count(formats.len());
                    operands += 1 + formats;
                    parts.push(WritePart::Value {
                        ty: written_type(value),
                        formats,
                        follows: false,
                    });
                }
                WriteItem::Value { value, formats } => {
                    self.value(value);
                    let at = self.kept();
                    let kept = self.kept_formats(formats);
                    for (offset, ty) in parts_of(&value.ty) {
                        let cell = part(at, offset, ty.clone());
                        if ty == Type::Config {
                            // Programs fill only x..r of a position.
                            self.address(&cell);
                            self.emit(Op::Rare(Rare::LoadConfig));
                        } else if value.ty == Type::Joints(JointKind::OfGroup) && offset > 0 {
                            // As many axes as there are; none is an error.
                            self.address(&cell);
                            self.emit(Op::Rare(Rare::LoadAny));
                        } else {
                            self.load(&cell);
                        }
                        operands += 1 + self.formats(&kept);
                        parts.push(WritePart::Value {
                            ty: scalar_type(&ty),
                            formats: count(kept.len()),
                            follows: offset > 0 && !matches!(ty, Type::Text(_) | Type::Config),
                        });
                    }
                }
            }
        }
        let shape = WriteShape {
            to_file: file.is_some(),
            items: parts,
            operands,
        };
        let row = add_row(&mut self.code.writes, shape);
        self.emit(Op::Outward(Outward::Write(row)));
    }

    /// Keeps what is on the stack in a frame cell: it is needed for each part.
    fn kept(&mut self) -> u32 {
        let cell = self.temporary(1);
        self.emit(Op::StoreLocal(cell));
        cell
    }

    fn kept_formats(&mut self, formats: &[Expr]) -> Vec<u32> {
        let kept = formats.iter().map(|format| {
            self.scalar(format);
            self.kept()
        });
        kept.collect()
    }

    /// Pushes them, and says how many they are.
    fn formats(&mut self, kept: &[u32]) -> u32 {
        for cell in kept {
            self.emit(Op::LoadLocal(*cell));
        }
        count(kept.len())
    }
}

/// A part of what the address in a frame cell means.
fn part(at: u32, offset: u32, ty: Type) -> Place {
    Place {
        root: Root::Param(at),
        steps: vec![Step::Offset(offset)],
        ty,
    }
}

/// Offset and type of the parts in the order of READ and WRITE.
///
/// ASSUMPTION: a position is its components, extended axes, and the configuration as text at the
/// end; an array its elements, the last subscript running fastest.
fn parts_of(ty: &Type) -> Vec<(u32, Type)> {
    let mut leaves = Vec::new();
    ty.leaves(&mut leaves);
    let mut parts: Vec<(u32, Type)> = (0..).zip(leaves).collect();
    let kind = if let Type::Array(array) = ty {
        array.element.position_kind()
    } else {
        ty.position_kind()
    };
    if let Some(kind @ PositionKind::XyzwprExt) = kind {
        for position in parts.chunks_mut(kind.size() as usize) {
            if let Some(end) = position.get_mut(CONFIG_OFFSET as usize..) {
                end.rotate_left(1);
            }
        }
    }
    parts
}

fn written_type(value: &Expr) -> ScalarType {
    if let ExprKind::Place(place) = &value.kind {
        return scalar_type(&place.ty);
    }
    scalar_type(&value.ty)
}

fn scalar_type(ty: &Type) -> ScalarType {
    match ty {
        Type::Real => ScalarType::Real,
        Type::Boolean => ScalarType::Boolean,
        Type::Text(_) => ScalarType::Text,
        Type::Config => ScalarType::Config,
        Type::Small(Small::Short) => ScalarType::Short,
        Type::Small(Small::Byte) => ScalarType::Byte,
        Type::Integer
        | Type::File
        | Type::Position(_)
        | Type::Joints(_)
        | Type::Array(_)
        | Type::Structure(_)
        | Type::Path(_)
        | Type::Error => ScalarType::Integer,
    }
}
