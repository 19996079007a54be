//! What a MOVE needs on the stack.

use super::{Lowering, add_row};
use crate::{
    ast::Waits,
    ir::{MoveKind, NodeShape, Op, Outward},
    typed::{Expr, MoveForm},
};

impl Lowering<'_> {
    /// Pushes the operands and returns the instruction.
    pub(super) fn move_form(
        &mut self,
        form: &MoveForm,
        via: Option<&Expr>,
        waits: Waits,
    ) -> Outward {
        if let Some(via) = via {
            self.value(via);
        }
        let kind = match form {
            MoveForm::To(target) => {
                self.value(target);
                if via.is_some() {
                    MoveKind::Via
                } else {
                    MoveKind::To
                }
            }
            MoveForm::Near { target, distance } => {
                self.value(target);
                self.scalar(distance);
                if via.is_some() {
                    MoveKind::NearVia
                } else {
                    MoveKind::Near
                }
            }
            MoveForm::Axis { axis, distance } => {
                self.scalar(axis);
                self.scalar(distance);
                MoveKind::Axis
            }
            MoveForm::Relative(vector) => {
                self.value(vector);
                MoveKind::Relative
            }
            MoveForm::About { vector, angle } => {
                self.value(vector);
                self.scalar(angle);
                MoveKind::About
            }
            MoveForm::Away(distance) => {
                self.scalar(distance);
                MoveKind::Away
            }
            MoveForm::Along {
                path,
                range,
                offset,
                kind,
            } => {
                self.address(path);
                if let Some((first, last)) = range {
                    self.scalar(first);
                    self.scalar(last);
                } else {
                    // All of them.
                    self.emit(Op::PushDiscard);
                    self.emit(Op::PushDiscard);
                }
                let shape = NodeShape {
                    offset: *offset,
                    kind: *kind,
                };
                let row = add_row(&mut self.code.nodes, shape);
                return Outward::MoveAlong(row, waits);
            }
        };
        Outward::Move(kind, waits)
    }
}
