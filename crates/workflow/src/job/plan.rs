//! The plan of a job: its phases as steps that need one another.

use crate::job::params::{CompleteOn, NewJob, Workflow};
use crate::job::phase::Phase;
use crate::job::{Item, PlannedStep};
use crate::setup::PlaceRef;

/// Steps in the making.
#[derive(Debug, Default)]
pub(crate) struct Builder {
    steps: Vec<PlannedStep>,
    /// Number of the first step.
    offset: usize,
    /// The step that the next one needs.
    last: Option<usize>,
    undo: bool,
}

impl Builder {
    /// Steps that are appended to a plan of `offset` steps.
    pub(crate) fn after(offset: usize, undo: bool) -> Self {
        Self {
            offset,
            undo,
            ..Self::default()
        }
    }

    /// One more step, after the last one.
    pub(crate) fn then(
        &mut self,
        phase: Phase,
        item: Option<usize>,
        place: Option<PlaceRef>,
    ) -> usize {
        let index = self.offset + self.steps.len();
        let needs = self.last.into_iter().collect();
        self.steps.push(PlannedStep {
            phase,
            item,
            place,
            needs,
            undo: self.undo,
        });
        self.last = Some(index);
        index
    }

    /// The next step needs this one instead.
    pub(crate) const fn fork(&mut self, from: usize) {
        self.last = Some(from);
    }

    /// The step just added needs this one too.
    pub(crate) fn also(&mut self, need: usize) {
        if let Some(step) = self.steps.last_mut()
            && !step.needs.contains(&need)
        {
            step.needs.push(need);
        }
    }

    /// To the place, grip, lift and out.
    pub(crate) fn pick(&mut self, item: usize, place: &PlaceRef) -> usize {
        let (item, place) = (Some(item), Some(place.clone()));
        let _approach = self.then(Phase::Approach, item, place.clone());
        let _grip = self.then(Phase::Grip, item, place.clone());
        self.then(Phase::LiftClear, item, place)
    }

    /// To the place, release, retreat and out.
    pub(crate) fn put(&mut self, item: usize, place: &PlaceRef) -> usize {
        let (item, place) = (Some(item), Some(place.clone()));
        let first = self.then(Phase::PlaceApproach, item, place.clone());
        let _release = self.then(Phase::Release, item, place.clone());
        let _retreat = self.then(Phase::Retreat, item, place);
        first
    }

    pub(crate) fn steps(self) -> Vec<PlannedStep> {
        self.steps
    }
}

/// The slot of an item at the job's point.
pub(crate) fn slot_of(spec: &NewJob, item: &Item) -> PlaceRef {
    PlaceRef::MobileRobot {
        point: spec.point.clone(),
        slot: item.slot.clone(),
    }
}

/// The plan of a new job: A1 to A16, or B1 to B16.
pub(crate) fn plan(spec: &NewJob, items: &[Item]) -> Vec<PlannedStep> {
    let mut b = Builder::default();
    let _reserve = b.then(Phase::Reserve, None, None);
    let precheck = b.then(Phase::Precheck, None, None);
    match spec.workflow {
        Workflow::DeliveryAndPlacement => {
            for phase in [
                Phase::Call,
                Phase::Await,
                Phase::Dock,
                Phase::VerifyLoad,
                Phase::Permit,
            ] {
                let _next = b.then(phase, None, None);
            }
            for (index, item) in items.iter().enumerate() {
                let _clear = b.pick(index, &slot_of(spec, item));
                if spec.early_release && index + 1 == items.len() {
                    let _released = b.then(Phase::ReleaseMr, None, None);
                }
                let _put = b.put(index, &PlaceRef::fixed(item.place.clone()));
            }
            if !spec.early_release {
                let _exit = b.then(Phase::Exit, None, None);
            }
        }
        Workflow::PickupAndDelivery => {
            let prefetched = (spec.prefetch && !items.is_empty()).then(|| {
                let place = items.first().map(|i| PlaceRef::fixed(i.place.clone()));
                place.map(|place| b.pick(0, &place))
            });
            b.fork(precheck);
            for phase in [
                Phase::Call,
                Phase::Await,
                Phase::Dock,
                Phase::VerifyEmpty,
                Phase::Permit,
            ] {
                let _next = b.then(phase, None, None);
            }
            for (index, item) in items.iter().enumerate() {
                let picked = prefetched.flatten().filter(|_| index == 0);
                if picked.is_none() {
                    let _clear = b.pick(index, &PlaceRef::fixed(item.place.clone()));
                }
                let (item, place) = (Some(index), Some(slot_of(spec, item)));
                let _approach = b.then(Phase::PlaceApproach, item, place.clone());
                if let Some(picked) = picked {
                    b.also(picked);
                }
                let _release = b.then(Phase::Release, item, place.clone());
                let _retreat = b.then(Phase::Retreat, item, place);
            }
            let _verify = b.then(Phase::VerifyOnMr, None, None);
            let _exit = b.then(Phase::Exit, None, None);
            if spec.complete_on == CompleteOn::Delivered {
                let _transport = b.then(Phase::Transport, None, None);
            }
        }
    }
    let _close = b.then(Phase::Close, None, None);
    b.steps()
}
