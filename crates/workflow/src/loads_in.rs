//! What a mobile robot says about its loads when nobody asked: a load that is gone is somewhere else now.

use crate::cell::Cell;
use crate::custody::{Evidence, Location};
use crate::fact::Fact;
use crate::faults::Fault;
use crate::intervention::Answer;
use crate::job::phase::Phase;
use crate::job::{Item, Job, StepState};
use crate::signal::{Signal, SlotLoad};
use crate::work::{Ask, Work};

impl Item {
    /// What is in its slot of the mobile robot, once it is there.
    pub(crate) fn in_slot(&self) -> SlotLoad {
        SlotLoad {
            slot: self.slot.clone(),
            load: self.load.clone(),
        }
    }
}

impl Cell {
    /// The loads of a job that a mobile robot has: what is taken off where the job's order ends (VDA 5050: `drop`).
    pub(crate) fn to_unload(&self, job: &Job, mobile_robot: &str) -> Vec<SlotLoad> {
        let on_it = |item: &&Item| {
            let at = Location::MobileRobot {
                mobile_robot: mobile_robot.to_owned(),
                slot: item.slot.clone(),
            };
            item.load
                .as_ref()
                .is_some_and(|load| self.book.custody.of(load) == Some(&at))
        };
        job.items.iter().filter(on_it).map(Item::in_slot).collect()
    }

    /// The job's loads are on their way to a destination: no arm of the cell has anything to do with them.
    pub(crate) fn is_in_transport(job: &Job) -> bool {
        job.find(Phase::Transport)
            .and_then(|step| job.step(step))
            .is_some_and(|step| step.state == StepState::Running)
    }
}

impl Work<'_> {
    /// `LOAD_CHANGED`: a load that is booked on the mobile robot and that it does not have any more. Where its order
    /// explains that, the load is at the destination; otherwise nobody knows, and a human is asked.
    ///
    /// The loads of a hand-over under way are left to its own checks: the arm takes them, or F4 asks about them.
    pub(crate) fn loads_gone(&mut self, signal: &Signal) {
        // Without sensors it cannot know.
        let Some(report) = &signal.state.loads else {
            return;
        };
        let id = &signal.mobile_robot;
        let busy = self.cell.book.open_session_of(id).map(|s| s.job);
        let of = |job: Option<uuid::Uuid>, load: &str| {
            job.and_then(|job| self.cell.book.jobs.get(&job))
                .is_some_and(|j| j.items.iter().any(|i| i.load.as_deref() == Some(load)))
        };
        let transport = self.transport_of(id);
        let mut gone = Vec::new();
        for (load, found) in &self.cell.book.custody.0 {
            let Location::MobileRobot { mobile_robot, slot } = &found.location else {
                continue;
            };
            // In another slot it is still there; without a name it may be this one.
            let there = report.iter().any(|l| match &l.load {
                Some(said) => said == load,
                None => l.slot == *slot,
            });
            if mobile_robot != id || there || of(busy, load) {
                continue;
            }
            let ordered = transport.as_ref().filter(|t| {
                of(Some(t.job), load) && signal.state.at_point.as_ref() == Some(&t.destination)
            });
            gone.push((
                load.clone(),
                slot.clone(),
                ordered.map(|t| t.destination.clone()),
            ));
        }
        for (load, slot, destination) in gone {
            match destination {
                Some(destination) => self.emit(Fact::CustodyMoved {
                    load,
                    to: Location::Delivered { destination },
                    by: Evidence::MobileRobot {
                        mobile_robot: id.clone(),
                    },
                }),
                None => self.load_gone(signal, &load, &slot),
            }
        }
    }

    /// F10 without an arm: it was on the mobile robot, and is not any more.
    fn load_gone(&mut self, signal: &Signal, load: &str, slot: &str) {
        let id = &signal.mobile_robot;
        let text = format!("{id} reports that load {load} is not in its slot {slot} any more");
        if let Some(job) = self.transport_of(id).map(|t| t.job) {
            self.note(job, Fault::PartLost, text.clone());
        }
        self.emit(Fact::CustodyMoved {
            load: load.to_owned(),
            to: Location::Unknown { arm: None },
            by: Evidence::Doubt { text: text.clone() },
        });
        let known = match (&signal.state.at_point, &signal.state.order) {
            (Some(point), _) => format!("{id} stands at {point}"),
            (None, Some(order)) => format!("{id} is on its way with order {order}"),
            (None, None) => format!("{id} has no order and is at no point"),
        };
        self.ask(Ask {
            load: Some(load.to_owned()),
            fault: Fault::PartLost,
            question: format!("{text}, and no order says so. Where is load {load}?"),
            known: vec![known],
            unknown: vec![format!("where load {load} is")],
            answers: vec![Answer::SetCustody],
            ..Ask::default()
        });
    }
}
