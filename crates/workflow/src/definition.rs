//! Which version of a workflow a job was planned by (P15).
//!
//! The steps of a job are facts and survive an upgrade. What a step does is this program's: a job that another program
//! planned, and whose steps may mean something else here, is held until a person has said how to go on.

use std::fmt::{self, Write as _};

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::effect::Action;
use crate::job::operations::operations;
use crate::job::params::{CompleteOn, NewJob, OnCancel, Workflow};
use crate::job::plan::plan;
use crate::job::{Item, Job, JobState, Step};

/// Raised whenever the meaning of a step changes; a test compares it with the digests.
const VERSION: u32 = 1;

/// A version of a workflow: its number, and a digest of its plan and of what its steps do.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Definition {
    /// The number.
    pub version: u32,
    /// 16 hexadecimal digits.
    pub digest: String,
}

impl fmt::Display for Definition {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "version {} ({})", self.version, self.digest)
    }
}

impl Definition {
    /// What this program does.
    #[must_use]
    pub fn of(workflow: Workflow) -> Self {
        let mut text = String::new();
        // With and without what a job may choose, two loads, and a second attempt at everything.
        for choice in [false, true] {
            let items = ["one", "two"].map(|name| Item {
                load: None,
                kind: "kind".into(),
                slot: name.into(),
                place: format!("place/{name}"),
                alternates: Vec::new(),
            });
            let job = example(workflow, choice, items.to_vec());
            for (index, step) in job.steps.iter().enumerate() {
                let row = step.plan.phase.row();
                // Writing to a string cannot fail.
                let _ = write!(text, "{:?}{row:?}", step.plan);
                for attempt in [1, 2] {
                    let mut again = job.clone();
                    if let Some(step) = again.steps.get_mut(index) {
                        step.attempt = attempt;
                    }
                    again.near.clone_from(&step.plan.place);
                    let actions: Vec<Action> = operations(&again, index);
                    let _ = write!(text, "{actions:?}");
                }
            }
        }
        Self {
            version: VERSION,
            digest: format!("{:016x}", fnv1a(text.as_bytes())),
        }
    }
}

fn example(workflow: Workflow, choice: bool, items: Vec<Item>) -> Job {
    let spec = NewJob {
        workflow,
        mobile_robot: None,
        arm: None,
        point: "station/point".into(),
        items: Vec::new(),
        early_release: choice,
        prefetch: choice,
        on_cancel_with_load: OnCancel::Hold,
        reject_slot: None,
        max_attempts: 2,
        destination: Some("destination".into()),
        complete_on: CompleteOn::Delivered,
        priority: 0,
        deadline: None,
        expected_arrival_ms: None,
        expected_transport_ms: None,
    };
    let steps = plan(&spec, &items);
    Job {
        state: JobState::Execute,
        steps: steps.into_iter().map(Step::new).collect(),
        ..Job::new(Uuid::nil(), 0, spec, items)
    }
}

/// FNV-1a, 64 bits: it tells versions of this program apart, and protects against nobody.
fn fnv1a(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If this fails, a step means something else than in the version that jobs in the field were planned by: raise
    /// `VERSION`, then write the new digests here.
    #[test]
    fn p15_a_version_has_the_digests_it_always_had() {
        let digest = |workflow| Definition::of(workflow).to_string();
        assert_eq!(
            [
                digest(Workflow::DeliveryAndPlacement),
                digest(Workflow::PickupAndDelivery)
            ],
            [
                "version 1 (10965ca7b9a05709)",
                "version 1 (ecc43fde8994fdbc)"
            ]
        );
    }
}
