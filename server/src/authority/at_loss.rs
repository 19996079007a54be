use std::fmt;
use std::sync::Arc;

use api::LossBehavior;
use tokio_util::task::TaskTracker;

use super::control::{ControlLoss, ControlObserver};
use crate::link::cell_server::CellServerLink;
use crate::motions::Motions;

/// Does to the robots of a cell what the holder of control asked for in case it is lost.
///
/// Nothing that waits is sent any more in any case: its claim ended with the lease. A controller that runs the seed
/// program cannot be told anything, so a motion it has taken runs to its end.
pub(crate) struct AtLoss {
    /// Each robot's motions, and the link of those that can be told.
    pub(crate) robots: Vec<(Arc<Motions>, Option<CellServerLink>)>,
    pub(crate) tracker: TaskTracker,
}

impl fmt::Debug for AtLoss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("AtLoss").finish_non_exhaustive()
    }
}

impl ControlObserver for AtLoss {
    fn control_lost(&self, loss: &ControlLoss) {
        for (motions, link) in &self.robots {
            let Some(link) = link.clone() else { continue };
            match loss.behavior {
                LossBehavior::CompleteStep => {}
                LossBehavior::Hold => {
                    let (cell, motions) = (loss.cell.clone(), Arc::clone(motions));
                    drop(self.tracker.spawn(async move {
                        // Where nothing can be held, standing still is what was meant.
                        let told = if motions.holds() {
                            link.hold().await.map(|_| ())
                        } else {
                            link.stop().await.map(|_| ())
                        };
                        if let Err(error) = told {
                            unheard(&cell, "hold", &error);
                        }
                    }));
                }
                LossBehavior::Stop1 => {
                    let _taken_back = motions.stop();
                    let cell = loss.cell.clone();
                    drop(self.tracker.spawn(async move {
                        if let Err(error) = link.stop().await {
                            unheard(&cell, "stop", &error);
                        }
                    }));
                }
            }
        }
    }
}

fn unheard(cell: &str, what: &str, error: &crate::link::cell_server::LinkError) {
    tracing::error!(
        cell.id = cell,
        error = error.chain(),
        "control was lost, and the controller has not confirmed the {what}"
    );
}
