//! F6, F18: another place or slot for an item than the one that was meant.

use crate::claims::{Holder, Resource};
use crate::custody::Location;
use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::PoseFailure;
use crate::intervention::Answer;
use crate::job::params::Workflow;
use crate::job::plan::slot_of;
use crate::job::{Item, Job, JobState, StepState, Why};
use crate::react::Reaction;
use crate::setup::PlaceRef;
use crate::work::{Ask, Work};

impl Work<'_> {
    /// F6: an alternate place, or the job stops before anything moved.
    pub(crate) fn unreachable(&mut self, job: &Job, step: usize, failure: &PoseFailure) {
        let item = failure.target / 6;
        let of_place =
            (failure.target % 6 >= 3) == (job.spec.workflow == Workflow::DeliveryAndPlacement);
        let text = match job.items.get(item) {
            Some(i) => {
                let place = if of_place { &i.place } else { &i.slot };
                format!("item {item}, {place}: {}", failure.reason)
            }
            None => format!("safe pose: {}", failure.reason),
        };
        self.note(job.id, Fault::Unreachable, text.clone());
        let another = match (job.spec.workflow, of_place) {
            (Workflow::DeliveryAndPlacement, true) => self.use_alternate(job, item),
            (Workflow::PickupAndDelivery, false) => self.use_another_slot(job, step, item),
            (Workflow::DeliveryAndPlacement, false) | (Workflow::PickupAndDelivery, true) => false,
        };
        if another {
            if let Some(job) = self.job(job.id) {
                self.emit(Fact::StepResent { job: job.id, step });
            }
            return;
        }
        self.go(
            job.id,
            JobState::Stopping,
            Why::Fault {
                fault: Fault::Unreachable,
            },
            text,
        );
    }

    /// F6 in B: the next slot of the mobile robot that is free and was taught, each of them once.
    pub(super) fn use_another_slot(&mut self, job: &Job, step: usize, index: usize) -> bool {
        let (Some(mobile_robot), Some(item)) = (&job.mobile_robot, job.items.get(index)) else {
            return false;
        };
        let Some(setup) = self.cell.setup.mobile_robot(mobile_robot) else {
            return false;
        };
        let tried = job.step(step).map_or(0, |s| usize::from(s.resends));
        let here = setup.slots.iter().position(|slot| *slot == item.slot);
        if tried + 1 >= setup.slots.len() {
            return false;
        }
        let next = setup
            .slots
            .iter()
            .cycle()
            .skip(here.map_or(0, |here| here + 1))
            .take(setup.slots.len());
        let mut free = next.filter(|slot| self.is_free_slot(job, &job.items, slot));
        let Some(slot) = free.next().cloned() else {
            return false;
        };
        let to = Item {
            slot,
            ..item.clone()
        };
        self.redirect_slot(job, index, to);
        true
    }

    /// Whether a slot of the job's mobile robot is free, was taught to the job's arm, and is meant for none of `items`.
    pub(super) fn is_free_slot(&self, job: &Job, items: &[Item], slot: &str) -> bool {
        let (Some(mobile_robot), Some(arm)) = (&job.mobile_robot, &job.arm) else {
            return false;
        };
        let place = PlaceRef::MobileRobot {
            point: job.spec.point.clone(),
            slot: slot.to_owned(),
        };
        let at = Location::MobileRobot {
            mobile_robot: mobile_robot.clone(),
            slot: slot.to_owned(),
        };
        !items.iter().any(|item| item.slot == slot)
            && self.cell.setup.is_taught(arm, &place)
            && self.cell.is_free(&at)
    }

    /// An item goes into another slot of the mobile robot.
    pub(super) fn redirect_slot(&mut self, job: &Job, index: usize, to: Item) {
        let place = slot_of(&job.spec, &to);
        self.emit(Fact::ItemChanged {
            job: job.id,
            item: index,
            to,
        });
        for (number, step) in job.steps.iter().enumerate() {
            let there = step.plan.place.as_ref().is_some_and(PlaceRef::in_zone);
            if there && step.plan.item == Some(index) && step.state == StepState::Pending {
                self.emit(Fact::StepRedirected {
                    job: job.id,
                    step: number,
                    place: place.clone(),
                });
            }
        }
    }

    /// Takes the next alternate that is free, reachable by teaching and not claimed. The old place is given back.
    pub(crate) fn use_alternate(&mut self, job: &Job, item: usize) -> bool {
        let (Some(old), Some(arm)) = (job.items.get(item).cloned(), job.arm.clone()) else {
            return false;
        };
        let mut rest = old.alternates.clone();
        while !rest.is_empty() {
            let place = rest.remove(0);
            if self.place_usable(&arm, &place) {
                self.redirect(
                    job,
                    item,
                    Item {
                        place,
                        alternates: rest,
                        ..old
                    },
                );
                return true;
            }
        }
        false
    }

    pub(crate) fn place_usable(&self, arm: &str, place: &str) -> bool {
        let at = Location::Fixed {
            place: place.to_owned(),
        };
        self.cell.setup.place(place).is_some()
            && self.cell.setup.is_taught(arm, &PlaceRef::fixed(place))
            && self.cell.is_free(&at)
            && self
                .cell
                .book
                .claims
                .is_free(&Resource::Place(place.to_owned()))
    }

    /// An item goes to another fixed place.
    pub(crate) fn redirect(&mut self, job: &Job, index: usize, to: Item) {
        let Some(old) = job.items.get(index) else {
            return;
        };
        let by = Holder::Job(job.id);
        let back = vec![Resource::Place(old.place.clone())];
        self.emit(Fact::Released {
            by,
            resources: Some(back),
        });
        if self.cell.setup.is_single(&Location::Fixed {
            place: to.place.clone(),
        }) {
            self.emit(Fact::Claimed {
                by,
                resources: vec![Resource::Place(to.place.clone())],
            });
        }
        let place = PlaceRef::fixed(to.place.clone());
        self.emit(Fact::ItemChanged {
            job: job.id,
            item: index,
            to,
        });
        for (number, step) in job.steps.iter().enumerate() {
            let there = step.plan.place.as_ref().is_some_and(|p| !p.in_zone());
            if there && step.plan.item == Some(index) && !step.state.is_done() {
                self.emit(Fact::StepRedirected {
                    job: job.id,
                    step: number,
                    place: place.clone(),
                });
            }
        }
    }

    /// F18: is the target still free? If not: alternates, then back while it is docked, then a human.
    pub(crate) fn target_blocked(&mut self, job: &Job, step: usize) -> bool {
        let Some(found) = job.step(step) else {
            return false;
        };
        let Some(at) = found
            .plan
            .place
            .as_ref()
            .and_then(|p| self.location_of(job, p))
        else {
            return false;
        };
        if self.cell.is_target_free(job, &at) {
            return false;
        }
        let asked = self.cell.book.question_of(job.id);
        if asked.is_some_and(|q| q.question.fault == Fault::TargetBlocked) {
            return true;
        }
        let text = format!("{at} is not free");
        let fixed = matches!(at, Location::Fixed { .. });
        if let (true, false, Some(item)) = (fixed, found.plan.undo, found.plan.item)
            && job.spec.workflow == Workflow::DeliveryAndPlacement
            && self.use_alternate(job, item)
        {
            self.note(job.id, Fault::TargetBlocked, text);
            return true;
        }
        let docked = self
            .cell
            .session_of(job)
            .is_some_and(|s| s.state.is_docked());
        let mut answers = vec![Answer::Wait];
        if fixed {
            answers.push(Answer::ChooseSlot);
        }
        if job.spec.reject_slot.is_some() {
            answers.push(Answer::RejectBin);
        }
        if docked || job.spec.workflow == Workflow::PickupAndDelivery {
            answers.push(Answer::PutBack);
        }
        let ask = Ask {
            question: format!("{text}. Where should the load go?"),
            known: self.known_of(job),
            unknown: vec![format!("when {at} will be free")],
            answers,
            ..Ask::default()
        };
        self.react(
            job,
            Reaction {
                fault: Fault::TargetBlocked,
                text,
                state: Some(JobState::Suspending),
                ask: Some(ask),
                ..Reaction::default()
            },
        );
        true
    }
}
