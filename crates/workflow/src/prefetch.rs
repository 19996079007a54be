//! F2 of a pickup: a load that was fetched early does not wait in the gripper for ever.

use crate::fact::Fact;
use crate::faults::Fault;
use crate::job::phase::Phase;
use crate::job::{Job, StepState};
use crate::work::Work;

impl Work<'_> {
    /// F2 in B: the prefetched load does not wait in the gripper for ever.
    pub(super) fn put_prefetch_back(&mut self, job: &Job) {
        let Some(arm) = job.arm.clone() else { return };
        let held = job.items.iter().position(|item| {
            item.load.is_some() && item.load.as_deref() == self.cell.book.custody.in_gripper(&arm)
        });
        let Some((index, item)) = held.and_then(|i| job.items.get(i).map(|item| (i, item))) else {
            return;
        };
        self.note(
            job.id,
            Fault::ArrivalLate,
            "the prefetched load is put back",
        );
        let place = crate::PlaceRef::fixed(item.place.clone());
        let drop: Vec<_> = job
            .steps
            .iter()
            .enumerate()
            .filter(|(_, s)| {
                s.plan.item == Some(index)
                    && matches!(
                        s.plan.phase,
                        Phase::PlaceApproach | Phase::Release | Phase::Retreat
                    )
                    && s.state == StepState::Pending
            })
            .map(|(i, _)| i)
            .collect();
        // Back to its source now; after the permit it is picked again and put on the mobile robot.
        let mut b = crate::job::plan::Builder::after(job.steps.len(), false);
        let _back = b.put(index, &place);
        let back = job.steps.len() + 2;
        let _again = b.then(Phase::Approach, Some(index), Some(place.clone()));
        if let Some(permit) = job.find(Phase::Permit) {
            b.also(permit);
        }
        b.also(back);
        let _grip = b.then(Phase::Grip, Some(index), Some(place.clone()));
        let _lift = b.then(Phase::LiftClear, Some(index), Some(place));
        let last = b.put(index, &crate::job::plan::slot_of(&job.spec, item)) + 2;
        let steps = b.steps();
        self.emit(Fact::Planned {
            job: job.id,
            steps,
            drop,
            definition: None,
        });
        // What needed the old steps of this item needs the new ones.
        for phase in [Phase::Approach, Phase::VerifyOnMr] {
            let next = job.steps.iter().position(|s| {
                s.plan.phase == phase && s.state == StepState::Pending && s.plan.item != Some(index)
            });
            if let Some(step) = next {
                self.emit(Fact::StepNeeds {
                    job: job.id,
                    step,
                    need: last,
                });
            }
        }
    }
}
