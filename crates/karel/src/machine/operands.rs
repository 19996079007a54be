//! The operand stack.

use super::{
    cell::{Address, Cell},
    exec::Exec,
    fault::Fault,
};
use crate::value::Text;

impl Exec<'_> {
    #[inline]
    pub(super) fn push(&mut self, cell: Cell) {
        self.task.operands.push(cell);
    }

    #[inline]
    pub(super) fn pop(&mut self) -> Cell {
        self.task
            .operands
            .pop()
            .expect("lowering balances the stack")
    }

    #[inline]
    pub(super) fn pop_integer(&mut self) -> i32 {
        let Cell::Integer(value) = self.pop() else {
            mistyped()
        };
        value
    }

    #[inline]
    pub(super) fn pop_real(&mut self) -> f32 {
        let Cell::Real(value) = self.pop() else {
            mistyped()
        };
        value
    }

    #[inline]
    pub(super) fn pop_boolean(&mut self) -> bool {
        let Cell::Boolean(value) = self.pop() else {
            mistyped()
        };
        value
    }

    pub(super) fn pop_text(&mut self) -> Text {
        let Cell::Text(value) = self.pop() else {
            mistyped()
        };
        value
    }

    #[inline]
    pub(super) fn pop_address(&mut self) -> Address {
        let Cell::Address(value) = self.pop() else {
            mistyped()
        };
        value
    }

    /// The operand this far below the top, the top being 0.
    pub(super) fn operand(&self, below: usize) -> &Cell {
        let index = self.task.operands.len().wrapping_sub(below + 1);
        self.task
            .operands
            .get(index)
            .expect("lowering balances the stack")
    }

    pub(super) fn operand_address(&self, below: usize) -> Address {
        self.operand(below).expect_address()
    }

    pub(super) fn drop_operands(&mut self, count: usize) {
        let left = self.task.operands.len().saturating_sub(count);
        self.task.operands.truncate(left);
    }

    #[inline]
    pub(super) fn change_address(&mut self, change: impl FnOnce(Address) -> Address) {
        let address = self.pop_address();
        self.push(Cell::Address(change(address)));
    }

    #[inline]
    pub(super) fn integers(
        &mut self,
        compute: impl FnOnce(i32, i32) -> Result<i32, Fault>,
    ) -> Result<(), Fault> {
        let (b, a) = (self.pop_integer(), self.pop_integer());
        self.push(Cell::Integer(compute(a, b)?));
        Ok(())
    }

    #[inline]
    pub(super) fn reals(
        &mut self,
        compute: impl FnOnce(f32, f32) -> Result<f32, Fault>,
    ) -> Result<(), Fault> {
        let (b, a) = (self.pop_real(), self.pop_real());
        self.push(Cell::Real(compute(a, b)?));
        Ok(())
    }

    #[inline]
    pub(super) fn booleans(&mut self, compute: impl FnOnce(bool, bool) -> bool) {
        let (b, a) = (self.pop_boolean(), self.pop_boolean());
        self.push(Cell::Boolean(compute(a, b)));
    }
}

/// The checker typed every operand, so this is a bug of the lowering.
#[cold]
fn mistyped() -> ! {
    unreachable!("an operand has another type than its instruction")
}
