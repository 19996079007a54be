//! What robots do when whoever moved them loses control.

use std::sync::Arc;

use api::LossBehavior;
use tokio_util::task::TaskTracker;

use super::{ControlLoss, ControlObserver};
use crate::state::{Robot, RobotLink};

/// Stops or holds the robots of a cell when control is lost, as the lost lease declared.
#[derive(Debug)]
pub(crate) struct OnLoss {
    pub(crate) robots: Vec<Arc<Robot>>,
    pub(crate) tracker: TaskTracker,
}

impl ControlObserver for OnLoss {
    fn control_lost(&self, loss: &ControlLoss) {
        let behavior = loss.behavior;
        for robot in &self.robots {
            // The seed program has no stop: what it accepted runs to its end, and the links send nothing more.
            let RobotLink::CellServer(link) = &robot.link else {
                continue;
            };
            let (robot, link) = (Arc::clone(robot), link.clone());
            drop(self.tracker.spawn(async move {
                let done = match behavior {
                    LossBehavior::Stop1 => link.stop().await.map(drop),
                    LossBehavior::Hold => link.hold().await.map(drop),
                    LossBehavior::CompleteStep => Ok(()),
                };
                if let Err(error) = done {
                    tracing::error!(
                        robot.id = robot.plan.id,
                        ?behavior,
                        error = error.chain(),
                        "control was lost, and the arm has not confirmed what it was to do then"
                    );
                }
            }));
        }
    }
}
