//! Places in memory and system variables.

use super::{Lowering, add_row};
use crate::{
    ir::{Op, Rare, Shape, SystemPart, SystemRef},
    syspath::SysPath,
    typed::{Constant, Expr, ExprKind, Place, Root, Step, SystemPlace, SystemStep},
    types::{TextLength, Type},
};

/// A place whose cell is known before the program runs.
#[derive(Clone, Copy)]
enum Fixed {
    Global(u32),
    Local(u32),
}

impl Lowering<'_> {
    /// Pushes the value of a scalar place.
    pub(super) fn load(&mut self, place: &Place) {
        match (fixed(place), place.root) {
            (Some(Fixed::Global(cell)), _) => self.emit(Op::LoadGlobal(cell)),
            (Some(Fixed::Local(cell)), _) => self.emit(Op::LoadLocal(cell)),
            (None, Root::Param(cell)) if place.steps.is_empty() => self.emit(Op::LoadParam(cell)),
            (None, _) => {
                self.address(place);
                self.emit(Op::LoadIndirect);
            }
        }
    }

    /// Stores a scalar; `value` emits what pushes it.
    pub(super) fn store(&mut self, place: &Place, value: impl FnOnce(&mut Self)) {
        let target = fixed(place);
        let direct = matches!(place.root, Root::Param(_)) && place.steps.is_empty();
        if target.is_none() && !direct {
            self.address(place);
        }
        value(self);
        if let Type::Text(TextLength::AtMost(length)) = place.ty {
            self.emit(Op::Truncate(length));
        }
        if let Type::Small(small) = place.ty {
            let (least, most) = small.range();
            self.emit(Op::Rare(Rare::CheckRange { least, most }));
        }
        self.emit(match (target, place.root) {
            (Some(Fixed::Global(cell)), _) => Op::StoreGlobal(cell),
            (Some(Fixed::Local(cell)), _) => Op::StoreLocal(cell),
            (None, Root::Param(cell)) if direct && place.ty == Type::TEXT => {
                Op::StoreTextParam(cell)
            }
            (None, Root::Param(cell)) if direct => Op::StoreParam(cell),
            (None, _) if place.ty == Type::TEXT => Op::Rare(Rare::StoreTextIndirect),
            (None, _) => Op::StoreIndirect,
        });
    }

    /// Pushes the address of a place.
    pub(super) fn address(&mut self, place: &Place) {
        match fixed(place) {
            Some(Fixed::Global(cell)) => return self.emit(Op::AddressGlobal(cell)),
            Some(Fixed::Local(cell)) => return self.emit(Op::AddressLocal(cell)),
            None => {}
        }
        self.emit(match place.root {
            Root::Global(cell) => Op::AddressGlobal(cell),
            Root::Local(cell) => Op::AddressLocal(cell),
            Root::Param(cell) => Op::AddressParam(cell),
            Root::Shared(cell) => Op::Rare(Rare::AddressShared(cell)),
        });
        for step in &place.steps {
            match step {
                Step::Offset(0) => {}
                Step::Offset(offset) => self.emit(Op::Offset(*offset)),
                Step::Index {
                    subscripts,
                    dims,
                    element_cells,
                } => {
                    for subscript in subscripts {
                        self.scalar(subscript);
                    }
                    let shape = Shape {
                        dims: dims.clone(),
                        element_cells: *element_cells,
                    };
                    let known = self.code.shapes.iter().position(|known| *known == shape);
                    let row = match known {
                        Some(row) => super::count(row),
                        None => add_row(&mut self.code.shapes, shape),
                    };
                    self.emit(Op::Index(row));
                }
                Step::OpenGrid {
                    subscripts,
                    element_cells,
                } => {
                    for subscript in subscripts {
                        self.scalar(subscript);
                    }
                    self.emit(Op::Rare(Rare::OpenGrid {
                        dims: u8::try_from(subscripts.len()).unwrap_or(u8::MAX),
                        element_cells: *element_cells,
                    }));
                }
                Step::Node(subscript) => {
                    self.scalar(subscript);
                    self.emit(Op::Rare(Rare::Node));
                }
                Step::OpenIndex {
                    subscript,
                    element_cells,
                } => {
                    self.scalar(subscript);
                    self.emit(if *element_cells == 0 {
                        Op::Rare(Rare::OpenTextIndex)
                    } else {
                        Op::OpenIndex(*element_cells)
                    });
                }
            }
        }
    }

    /// Pushes the address of a place, with the length of its string or array beside it.
    pub(super) fn reference(&mut self, place: &Place) {
        self.address(place);
        if let Some(length) = place.ty.length() {
            self.emit(Op::Extra(length));
        }
    }

    /// Pushes the computed subscripts of a system variable and returns its table row.
    pub(super) fn system(&mut self, place: &SystemPlace) -> u32 {
        let Some(path) = fixed_path(place) else {
            return self.computed_system(place);
        };
        let row = SystemRef {
            steps: Vec::new(),
            fixed: Some(path),
            subscripts: 0,
            component: place.component,
            ty: place.ty.clone(),
        };
        add_row(&mut self.code.systems, row)
    }

    fn computed_system(&mut self, place: &SystemPlace) -> u32 {
        let mut steps = Vec::new();
        let mut subscripts = 0;
        for step in &place.steps {
            steps.push(match step {
                SystemStep::Name(name) => SystemPart::Name(name.clone()),
                SystemStep::Index(list) => {
                    for subscript in list {
                        self.scalar(subscript);
                    }
                    subscripts += super::count(list.len());
                    SystemPart::Index(super::count(list.len()))
                }
            });
        }
        let row = SystemRef {
            steps,
            fixed: None,
            subscripts,
            component: place.component,
            ty: place.ty.clone(),
        };
        add_row(&mut self.code.systems, row)
    }
}

/// The path of a system variable whose subscripts are constants.
fn fixed_path(place: &SystemPlace) -> Option<SysPath> {
    let mut path: Option<SysPath> = None;
    for step in &place.steps {
        path = Some(match (path, step) {
            (None, SystemStep::Name(name)) => SysPath::from_name(name),
            (Some(path), SystemStep::Name(name)) => path.field(name),
            (path, SystemStep::Index(list)) => {
                let constants: Option<Vec<i32>> = list.iter().map(constant_integer).collect();
                path?.index(&constants?)
            }
        });
    }
    path
}

fn constant_integer(expr: &Expr) -> Option<i32> {
    if let ExprKind::Constant(Constant::Integer(value)) = expr.kind {
        Some(value)
    } else {
        None
    }
}

/// The cell of a place without parameters and computed subscripts.
fn fixed(place: &Place) -> Option<Fixed> {
    let mut offset = 0;
    for step in &place.steps {
        match step {
            Step::Offset(more) => offset += more,
            Step::Index {
                subscripts,
                dims,
                element_cells,
            } => {
                offset += constant_offset(subscripts, dims)? * element_cells;
            }
            Step::OpenIndex { .. } | Step::OpenGrid { .. } | Step::Node(_) => return None,
        }
    }
    match place.root {
        Root::Global(cell) => Some(Fixed::Global(cell + offset)),
        Root::Local(cell) => Some(Fixed::Local(cell + offset)),
        Root::Param(_) | Root::Shared(_) => None,
    }
}

/// Elements before this one; `None` if a subscript is computed or out of range.
fn constant_offset(subscripts: &[Expr], dims: &[u32]) -> Option<u32> {
    let mut offset = 0;
    for (subscript, dim) in subscripts.iter().zip(dims) {
        let index = u32::try_from(constant_integer(subscript)?)
            .ok()?
            .checked_sub(1)?;
        if index >= *dim {
            return None;
        }
        offset = offset * dim + index;
    }
    Some(offset)
}
