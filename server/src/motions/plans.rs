//! What previews promised: kept for a short while, and good for as long as nothing changed.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use kinematics::PendantJoints;
use tokio::time::Instant;
use uuid::Uuid;

use super::Asked;
use crate::target::Prepared;

/// How long a plan is kept.
pub(crate) const KEPT: Duration = Duration::from_mins(1);
/// How many plans a robot keeps.
const CAPACITY: usize = 64;

/// What a preview came to.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) id: Uuid,
    pub(crate) planned: Planned,
    /// The revision of the book it was made from.
    pub(crate) revision: u64,
    /// Where the joints were, if the controller reports it.
    pub(crate) start: Option<PendantJoints>,
    pub(crate) expires: Instant,
}

/// A motion, ready for the link of its robot.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Planned {
    Seed(Prepared),
    Numbered(Asked),
}

/// The plans of one robot, oldest first.
#[derive(Debug, Default)]
pub(crate) struct Plans(Mutex<VecDeque<Plan>>);

impl Plans {
    pub(crate) fn keep(&self, plan: Plan) {
        let mut plans = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        plans.retain(|known| known.expires > now);
        if plans.len() >= CAPACITY {
            let _oldest = plans.pop_front();
        }
        plans.push_back(plan);
    }

    /// The plan, while it is kept.
    pub(crate) fn get(&self, id: Uuid) -> Option<Plan> {
        let plans = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        plans
            .iter()
            .find(|plan| plan.id == id && plan.expires > now)
            .cloned()
    }
}

impl Planned {
    pub(crate) fn asked(&self) -> Asked {
        match self {
            Self::Seed(prepared) => Asked::of(prepared),
            Self::Numbered(asked) => *asked,
        }
    }
}
