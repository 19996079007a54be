//! Instructions that are too seldom for the hot loop.

use super::{
    arithmetic,
    cell::Cell,
    exec::{Exec, subscript_offset},
    fault::Fault,
};
use crate::{
    ir::Rare,
    position::Config,
    status::Status,
    types::{MAX_STRING, Type, split_grid, split_text_array},
};

impl Exec<'_> {
    /// Instructions that are too seldom to make the hot loop larger.
    #[inline(never)]
    #[expect(clippy::too_many_lines, reason = "one arm for each instruction")]
    pub(super) fn rare(&mut self, op: Rare) -> Result<(), Fault> {
        match op {
            Rare::AddressShared(cell) => {
                let at = self.global(cell);
                let Cell::Address(address) = *self.memory().get(at) else {
                    return Err(self.unresolved_variable(cell));
                };
                self.push(Cell::Address(address));
            }
            Rare::NegateInteger => {
                let value = self.pop_integer();
                self.push(Cell::Integer(
                    value.checked_neg().ok_or_else(Fault::overflow)?,
                ));
            }
            Rare::NegateReal => {
                let value = self.pop_real();
                self.push(Cell::Real(-value));
            }
            Rare::NotBoolean => {
                let value = self.pop_boolean();
                self.push(Cell::Boolean(!value));
            }
            Rare::NotInteger => {
                let value = self.pop_integer();
                self.push(Cell::Integer(!value));
            }
            Rare::Concatenate => {
                let (b, mut a) = (self.pop_text(), self.pop_text());
                a.append(b.as_bytes(), MAX_STRING);
                self.push(Cell::Text(a));
            }
            Rare::CompareText(relation) => {
                let (b, a) = (self.pop_text(), self.pop_text());
                let order = a.as_bytes().cmp(b.as_bytes());
                self.push(Cell::Boolean(arithmetic::holds(relation, order)));
            }
            Rare::CompareBoolean(relation) => {
                let (b, a) = (self.pop_boolean(), self.pop_boolean());
                self.push(Cell::Boolean(arithmetic::holds(relation, a.cmp(&b))));
            }
            Rare::CopyCells(cells) => {
                let (from, to) = (self.pop_address(), self.pop_address());
                self.memory().copy_cells(from, to, cells);
            }
            Rare::CopyPosition {
                from: from_kind,
                to: to_kind,
                may_lack,
            } => {
                let (from, to) = (self.pop_address(), self.pop_address());
                let ty = Type::Position(from_kind);
                if may_lack && self.memory().is_uninit(from, &ty) {
                    self.memory().clear(to, &Type::Position(to_kind));
                    return Ok(());
                }
                let position = self.memory().position(from, from_kind)?;
                self.memory().set_position(to, to_kind, &position);
            }
            Rare::OpenTextIndex => {
                let subscript = self.pop_integer();
                let address = self.pop_address();
                let (length, text) = split_text_array(address.extra);
                let offset = subscript_offset(subscript, length)?;
                self.push(Cell::Address(address.plus(offset).with_extra(text)));
            }
            Rare::StoreTextIndirect => {
                let mut text = self.pop_text();
                let address = self.pop_address();
                text.truncate(address.extra as usize);
                self.memory().set(address, Cell::Text(text));
            }
            Rare::CheckRange { least, most } => {
                let value = self.operand(0).expect_integer();
                if !(least..=most).contains(&value) {
                    let message = format!("{value} is not in {least} to {most}");
                    return Err(Fault::new(Status::INTP_OVERFLOW, message));
                }
            }
            Rare::OpenGrid {
                dims,
                element_cells,
            } => {
                let count = usize::from(dims);
                let at = self.operand_address(count);
                let mut offset = 0;
                for (below, dim) in (0..count).rev().zip(split_grid(at.extra, count)) {
                    let subscript = self.operand(below).expect_integer();
                    offset = offset * dim + subscript_offset(subscript, dim)?;
                }
                self.drop_operands(count);
                self.change_address(|address| address.plus(offset * element_cells));
            }
            Rare::LoadAny => {
                let at = self.pop_address();
                let cell = self.memory().get(at).clone();
                self.push(cell);
            }
            Rare::LoadConfig => {
                let at = self.pop_address();
                let mut cell = self.memory().get(at).clone();
                if cell == Cell::Uninit {
                    cell = Cell::Config(Config::default());
                }
                self.push(cell);
            }
            Rare::Node => {
                let subscript = self.pop_integer();
                let at = self.pop_address();
                let path = self.memory().get(at).expect_path();
                let node = self.paths.expect_node(path, subscript)?;
                self.push(Cell::Address(node));
            }
            Rare::CopyJoints {
                from: from_cells,
                to: to_cells,
            } => {
                let (from, to) = (self.pop_address(), self.pop_address());
                self.memory().copy_joints(from, from_cells, to, to_cells)?;
            }
        }
        Ok(())
    }
}
