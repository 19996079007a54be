//! Whether the loads on a mobile robot are those of the job: as it reports them, as the books have them, or as a human
//! accepts them.

use crate::claims::{Holder, Resource};
use crate::custody::Location;
use crate::fact::Fact;
use crate::faults::Fault;
use crate::intervention::Answer;
use crate::job::phase::Phase;
use crate::job::{Item, Job, JobState, StepState};
use crate::react::Reaction;
use crate::signal::SlotLoad;
use crate::words;
use crate::work::{Ask, Work};

impl Work<'_> {
    /// The report of loads: `None` while there is none.
    fn report(&self, job: &Job) -> Option<Vec<SlotLoad>> {
        self.cell
            .mobile_seen(job.mobile_robot.as_ref()?)?
            .loads
            .clone()
    }

    /// ASSUMPTION: "extra" loads are those in the slots of this job; what stands in other slots of the mobile robot is
    /// somebody else's. A rescan is waiting for the next report: the outbox has no word that asks for one.
    ///
    /// A6. Unknown loads get a name; whatever does not fit waits for the timer.
    pub(crate) fn verify_load(&mut self, job: &Job, step: usize) {
        let Some(mobile_robot) = job.mobile_robot.clone() else {
            return;
        };
        let report = self.report(job);
        if report.is_none() && !job.loads_accepted {
            return;
        }
        let report = report.unwrap_or_default();
        let mut named: Vec<(usize, String, bool)> = Vec::new();
        for (index, item) in job.items.iter().enumerate() {
            let at = Location::MobileRobot {
                mobile_robot: mobile_robot.clone(),
                slot: item.slot.clone(),
            };
            let there = report.iter().find(|l| l.slot == item.slot);
            let booked = self.cell.book.custody.at(&at).map(str::to_owned);
            let said = there.and_then(|l| l.load.clone());
            let fits = match (&item.load, there, &said) {
                (Some(load), Some(_), Some(said)) => load == said,
                (None, Some(_), _) => true,
                (_, None, _) | (Some(_), Some(_), None) => false,
            };
            let load = match (&item.load, said, &booked) {
                (Some(load), _, _) => load.clone(),
                (None, Some(said), _) => said,
                (None, None, Some(booked)) => booked.clone(),
                (None, None, None) => format!("{}-{index}", job.id),
            };
            // A load cannot be in two places: what the books say has to agree, whoever accepts the report.
            let location = self.cell.book.custody.of(&load);
            let agrees = match location {
                None => booked.is_none(),
                Some(location) => *location == at,
            };
            let claimed =
                item.load.is_some() || self.cell.book.claims.is_free(&Resource::Load(load.clone()));
            let twice = named.iter().any(|(_, other, _)| *other == load);
            if !(fits || job.loads_accepted) || !agrees || !claimed || twice {
                return;
            }
            named.push((index, load, location.is_none()));
        }
        for (index, load, new) in named {
            let Some(item) = job.items.get(index) else {
                continue;
            };
            if new {
                self.emit(Fact::LoadRegistered {
                    load: load.clone(),
                    kind: item.kind.clone(),
                    location: Location::MobileRobot {
                        mobile_robot: mobile_robot.clone(),
                        slot: item.slot.clone(),
                    },
                });
            }
            if item.load.is_none() {
                let resources = vec![Resource::Load(load.clone())];
                self.emit(Fact::Claimed {
                    by: Holder::Job(job.id),
                    resources,
                });
                let to = Item {
                    load: Some(load),
                    ..item.clone()
                };
                self.emit(Fact::ItemChanged {
                    job: job.id,
                    item: index,
                    to,
                });
            }
        }
        self.step_to(job, step, StepState::Succeeded, "the loads are right");
    }

    /// B7.
    pub(crate) fn verify_empty(&mut self, job: &Job, step: usize) {
        let report = self.report(job);
        let empty = |item: &Item| match &report {
            Some(report) => !report.iter().any(|l| l.slot == item.slot),
            None => false,
        };
        if job.loads_accepted || job.items.iter().all(empty) {
            self.step_to(job, step, StepState::Succeeded, "the slots are free");
        }
    }

    /// F5: another slot that is free, taught and not used by this job.
    pub(crate) fn other_slots(&mut self, job: &Job) -> bool {
        let (Some(report), Some(mobile_robot)) = (self.report(job), &job.mobile_robot) else {
            return false;
        };
        let Some(setup) = self.cell.setup.mobile_robot(mobile_robot).cloned() else {
            return false;
        };
        let mut changed = false;
        let mut items = job.items.clone();
        for index in 0..items.len() {
            let Some(item) = items.get(index).cloned() else {
                continue;
            };
            if !report.iter().any(|l| l.slot == item.slot) {
                continue;
            }
            let reported = |slot: &str| report.iter().any(|l| l.slot == slot);
            let mut slots = setup.slots.iter();
            let free = slots.find(|slot| !reported(slot) && self.is_free_slot(job, &items, slot));
            let Some(slot) = free.cloned() else {
                return false;
            };
            let to = Item { slot, ..item };
            if let Some(place) = items.get_mut(index) {
                *place = to.clone();
            }
            self.redirect_slot(job, index, to);
            changed = true;
        }
        changed
    }

    /// B12: what was put on it is on it.
    pub(crate) fn verify_on_mr(&mut self, job: &Job, step: usize) {
        let report = self.report(job);
        let there = |item: &Item| {
            report.as_ref().is_some_and(|r| {
                r.iter()
                    .any(|l| l.slot == item.slot && (l.load.is_none() || l.load == item.load))
            })
        };
        if job.loads_accepted || job.items.iter().all(there) {
            self.step_to(
                job,
                step,
                StepState::Succeeded,
                "the loads are on the mobile robot",
            );
        }
    }

    /// F4, F4', F5: a human looks at the loads. The arm does not move.
    pub(crate) fn load_question(&mut self, job: &Job, fault: Fault, text: &str) {
        let on_mr = job
            .current()
            .and_then(|s| job.step(s))
            .map(|s| s.plan.phase)
            == Some(Phase::VerifyOnMr);
        let answers = if on_mr {
            vec![Answer::Rescan, Answer::Repick, Answer::Accept, Answer::Hold]
        } else {
            vec![
                Answer::Rescan,
                Answer::Accept,
                Answer::SendBack,
                Answer::Cancel,
            ]
        };
        let mut known = self.known_of(job);
        known.push(match self.report(job) {
            Some(report) if report.is_empty() => "it reports no loads".into(),
            Some(report) => format!("it reports {}", words::loads(&report)),
            None => "it does not report its loads".into(),
        });
        let ask = Ask {
            question: format!("{text}. What should be done?"),
            known,
            unknown: vec!["what is really there".into()],
            answers,
            ..Ask::default()
        };
        let state = Some(JobState::Holding);
        self.react(
            job,
            Reaction {
                fault,
                text: text.into(),
                state,
                ask: Some(ask),
                ..Reaction::default()
            },
        );
    }
}
