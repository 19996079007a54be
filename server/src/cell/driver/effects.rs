//! Carries out what was decided, and hears how it ends.

use tokio::sync::{mpsc, watch};
use tokio_util::sync::CancellationToken;
use uuid::Uuid;
use workflow::{Effect, Input};

use super::super::arm::{Later, Operation};
use super::super::handle::Ask;
use super::Task;

impl Task {
    pub(super) fn carry_out(&mut self, effect: Effect) {
        match effect {
            Effect::Operate {
                op,
                arm,
                action,
                job,
                step: _,
            } => self.operate(&arm, Operation { op, job, action }),
            Effect::Reconcile { op, arm, action } => {
                let job = Uuid::nil();
                self.reconcile(&arm, Operation { op, job, action });
            }
            Effect::StopArm { arm } => {
                if let Some(port) = self.driver.arms.get(&arm) {
                    drop(self.driver.tracker.spawn(port.stop()));
                }
            }
            // The message is in the outbox, which the view shows; whoever waits for it watches the view.
            Effect::Tell {
                mobile_robot,
                message,
            } => {
                self.told.note(&mobile_robot, message.n, self.decided_at);
                tracing::info!(
                    cell.id = self.driver.id,
                    mobile_robot.id = mobile_robot,
                    n = message.n,
                    "a message for a mobile robot"
                );
            }
            Effect::Ask { intervention } => tracing::warn!(
                cell.id = self.driver.id,
                %intervention,
                "a person is needed"
            ),
            Effect::Remind { intervention } => tracing::warn!(
                cell.id = self.driver.id,
                %intervention,
                "a person is still needed"
            ),
        }
    }

    pub(super) fn operate(&mut self, arm: &str, operation: Operation) {
        let Some(port) = self.driver.arms.get(arm).cloned() else {
            return;
        };
        let op = operation.op;
        if let Some(expected_ms) = port.expected(&operation) {
            self.report(Input::OperationPlanned { op, expected_ms });
        }
        let ends = port.operate(operation);
        self.report_end(op, ends);
    }

    pub(super) fn reconcile(&mut self, arm: &str, operation: Operation) {
        let Some(port) = self.driver.arms.get(arm).cloned() else {
            return;
        };
        let op = operation.op;
        let ends = port.reconcile(operation);
        self.report_end(op, ends);
    }

    pub(super) fn report_end(&self, op: Uuid, ends: Later<workflow::OpResult>) {
        let asks = self.asks.clone();
        drop(self.driver.tracker.spawn(async move {
            let result = ends.await;
            if let Some(asks) = asks.upgrade() {
                let input = Input::OperationEnded { op, result };
                let ask = Ask {
                    input,
                    claim: None,
                    answer: None,
                };
                let _stopping = asks.send(ask).await;
            }
        }));
    }

    pub(super) fn report(&self, input: Input) {
        if let Some(asks) = self.asks.upgrade() {
            // Only an estimate: where there is no room for it, the cell's own default holds.
            let _full = asks.try_send(Ask {
                input,
                claim: None,
                answer: None,
            });
        }
    }
}

/// Tells the driver what is seen of an arm, the latest only.
pub(super) async fn follow(
    mut seen: watch::Receiver<workflow::ArmSeen>,
    asks: mpsc::Sender<Ask>,
    stop: CancellationToken,
) {
    loop {
        let now = seen.borrow_and_update().clone();
        let ask = Ask {
            input: Input::ArmObserved(now),
            claim: None,
            answer: None,
        };
        if asks.send(ask).await.is_err() {
            return;
        }
        let changed = stop.run_until_cancelled(seen.changed()).await;
        if !matches!(changed, Some(Ok(()))) {
            return;
        }
    }
}
