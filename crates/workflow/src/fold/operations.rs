//! The arms' operations, from their start to their end.

use uuid::Uuid;

use crate::book::{Op, OpState};
use crate::cell::Cell;
use crate::effect::{Action, Target};
use crate::input::OpResult;

impl Cell {
    pub(super) fn fold_op_started(
        &mut self,
        op: Uuid,
        job: Uuid,
        step: usize,
        arm: &str,
        action: &Action,
    ) {
        let new = Op {
            job,
            step,
            arm: arm.to_owned(),
            action: action.clone(),
            state: OpState::Running,
        };
        drop(self.book.ops.insert(op, new));
        self.moves_on(arm);
        self.job_mut(&job, |j| {
            if let Action::Move { target, .. } = action
                && let Some(place) = target.place()
            {
                j.near = Some(place.clone());
            }
            if let Some(s) = j.steps.get_mut(step) {
                s.op = Some(op);
            }
        });
    }

    pub(super) fn fold_op_ended(&mut self, op: &Uuid, result: &OpResult) {
        let Some(ended) = self.book.ops.remove(op) else {
            return;
        };
        let _planned = self.live.planned.remove(op);
        self.moves_on(&ended.arm);
        let succeeded = match (&ended.action, result) {
            (Action::Move { .. }, OpResult::Arrived) => true,
            (Action::Precheck { .. }, OpResult::Prechecked { failures }) => failures.is_empty(),
            (
                Action::Grip { action, .. },
                OpResult::Gripped {
                    closed,
                    open,
                    part_present,
                },
            ) => match action {
                crate::GripAction::Close => *closed && *part_present,
                crate::GripAction::Open => *open && !*part_present,
            },
            (Action::Move { .. } | Action::Precheck { .. } | Action::Grip { .. }, _) => false,
        };
        let safe = matches!(
            &ended.action,
            Action::Move {
                target: Target::Safe,
                ..
            }
        );
        if safe {
            let _one = self.live.safe.remove(&ended.arm);
        }
        self.job_mut(&ended.job, |j| {
            if let Some(step) = j.steps.get_mut(ended.step)
                && step.op == Some(*op)
            {
                step.op = None;
                step.done_ops += usize::from(succeeded);
            }
            if safe && succeeded {
                (j.near, j.by_hand) = (None, None);
            }
        });
    }

    /// Where an arm was seen to stand is overtaken by its next operation.
    pub(super) fn moves_on(&mut self, arm: &str) {
        if let Some(live) = self.live.arms.get_mut(arm) {
            live.seen.displaced = false;
        }
    }

    pub(super) fn op_state(&mut self, op: &Uuid, state: OpState) {
        if let Some(found) = self.book.ops.get_mut(op) {
            found.state = state;
        }
    }
}
