//! Steps that wait for the mobile robot, and what happens when it does not do its part.

use crate::claims::{Holder, Resource};
use crate::custody::Location;
use crate::fact::{Fact, Rewind};
use crate::faults::Fault;
use crate::input::PoseFailure;
use crate::intervention::Answer;
use crate::job::params::Workflow;
use crate::job::phase::Phase;
use crate::job::plan::slot_of;
use crate::job::{Item, Job, JobState, StepState, Why};
use crate::react::Reaction;
use crate::session::{Session, SessionState};
use crate::setup::PlaceRef;
use crate::signal::{Message, SlotLoad};
use crate::words;
use crate::work::{Ask, Work};

impl Work<'_> {
    /// A3, B3: the order. Sending it again is sending the same one.
    pub(crate) fn send_order(&mut self, session: &Session) {
        let (order, update) = match session.order {
            Some(order) => (order, session.update),
            None => (self.ids.next_id(), 1),
        };
        self.emit(Fact::SessionOrdered {
            session: session.id,
            order,
            update,
        });
        let point = self.cell.setup.point(&session.point).cloned();
        let job = self.job(session.job);
        let then_to = job.as_ref().and_then(|j| j.spec.destination.clone());
        // What it brings is for the arm; it takes to the destination what the arm puts on it, and nothing else.
        let unload = job
            .filter(|_| then_to.is_some())
            .map(|j| j.items.iter().map(Item::in_slot).collect());
        self.tell(
            session,
            Message::TransportOrder {
                order,
                update,
                goal: session.point.clone(),
                dock: point.as_ref().map(|p| p.dock),
                route: point.map(|p| p.route).unwrap_or_default(),
                then_to,
                unload,
            },
        );
    }

    /// Whether the mobile robot says that an earlier order is not over.
    pub(crate) fn works_on_another(&self, session: &Session) -> bool {
        self.cell
            .mobile_seen(&session.mobile_robot)
            .is_some_and(|seen| seen.order.is_some() && seen.order != session.order)
    }

    /// A7, B8: everything the arm needs to enter.
    pub(crate) fn grant_entry(&mut self, session: &Session) {
        if session.state == SessionState::Docked
            && session.ready
            && self.cell.dock_evidence(session).is_ok()
        {
            self.move_session(session, SessionState::TransferReady);
            let Some(session) = self.session(session.id) else {
                return;
            };
            self.move_session(&session, SessionState::Transferring);
            self.tell(&session, Message::CellReady);
        }
    }

    /// A15, B13: the arm is out; the mobile robot may go, and in B it is told where to.
    pub(crate) fn begin_exit(&mut self, job: &Job, session: &Session, failed: Option<&str>) {
        self.move_session(session, SessionState::TransferDone);
        if let Some(reason) = failed {
            self.tell(
                session,
                Message::TransferFailed {
                    reason: reason.to_owned(),
                },
            );
            return;
        }
        self.tell(session, Message::TransferDone);
        if let (Workflow::PickupAndDelivery, Some(destination), Some(order)) =
            (job.spec.workflow, &job.spec.destination, session.order)
        {
            // The leaving edge was in the horizon until now; this update releases it.
            let update = session.update + 1;
            self.emit(Fact::SessionOrdered {
                session: session.id,
                order,
                update,
            });
            self.tell(
                session,
                Message::TransportOrder {
                    order,
                    update,
                    goal: destination.clone(),
                    dock: None,
                    route: Vec::new(),
                    then_to: None,
                    unload: Some(self.cell.to_unload(job, &session.mobile_robot)),
                },
            );
            self.emit(Fact::TransportBegun {
                mobile_robot: session.mobile_robot.clone(),
                job: job.id,
                order,
                destination: destination.clone(),
                session: Some(session.id),
                update,
            });
        }
    }

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
        let (Some(report), Some(mobile_robot), Some(arm)) =
            (self.report(job), job.mobile_robot.clone(), job.arm.clone())
        else {
            return false;
        };
        let Some(setup) = self.cell.setup.mobile_robot(&mobile_robot).cloned() else {
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
            let free = setup.slots.iter().find(|slot| {
                let place = PlaceRef::MobileRobot {
                    point: job.spec.point.clone(),
                    slot: (*slot).clone(),
                };
                let at = Location::MobileRobot {
                    mobile_robot: mobile_robot.clone(),
                    slot: (*slot).clone(),
                };
                !report.iter().any(|l| l.slot == **slot)
                    && !items.iter().any(|i| i.slot == **slot)
                    && self.cell.setup.is_taught(&arm, &place)
                    && self.cell.is_free(&at)
            });
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

    /// F3.
    pub(crate) fn dock_failed(&mut self, session: &Session, text: &str) {
        let Some(job) = self.job(session.job) else {
            return;
        };
        let tries = session.dock_tries;
        self.emit(Fact::SessionRewound {
            session: session.id,
            to: Rewind::Dock,
        });
        let retries = self.cell.setup.timers.dock_retries;
        let Some(step) = job.find(Phase::Dock) else {
            return;
        };
        let used = job
            .step(step)
            .map_or(0, |s| s.resends)
            .max(tries.saturating_sub(1));
        if used < retries {
            self.note(job.id, Fault::DockFailed, text);
            self.emit(Fact::StepResent { job: job.id, step });
            self.tell(session, Message::Retry);
            return;
        }
        // It stands before the dock and waits (VDA 5050: RETRIABLE): the answer says whether it tries again or gives up.
        let measured = session.docked;
        let mut answers = vec![Answer::Retry, Answer::Redispatch, Answer::Cancel];
        if measured.is_some() {
            answers.push(Answer::AcceptMeasured);
        }
        let mut known = self.known_of(&job);
        known.extend(measured.map(|at| format!("it docked at {}", words::pose(&at))));
        let ask = Ask {
            question: format!(
                "{} cannot dock at {}: {text}",
                session.mobile_robot, session.point
            ),
            known,
            unknown: vec!["why it cannot".into()],
            answers,
            ..Ask::default()
        };
        self.react(
            &job,
            Reaction {
                fault: Fault::DockFailed,
                text: text.into(),
                state: Some(JobState::Suspending),
                ask: Some(ask),
                ..Reaction::default()
            },
        );
    }

    /// F3, given up: it drives out, and comes again with a new order when it is clear. False if it is not at the dock.
    pub(crate) fn back_out(&mut self, job: &Job) -> bool {
        let Some(session) = self.cell.session_of(job).cloned() else {
            return false;
        };
        if session.state != SessionState::Positioned {
            return false;
        }
        self.emit(Fact::SessionBacksOut {
            session: session.id,
        });
        self.tell(&session, Message::SkipRetry);
        true
    }

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
    fn use_another_slot(&mut self, job: &Job, step: usize, index: usize) -> bool {
        let (Some(mobile_robot), Some(arm), Some(item)) =
            (&job.mobile_robot, &job.arm, job.items.get(index))
        else {
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
        let free = next.filter(|slot| {
            let place = PlaceRef::MobileRobot {
                point: job.spec.point.clone(),
                slot: (*slot).clone(),
            };
            let at = Location::MobileRobot {
                mobile_robot: mobile_robot.clone(),
                slot: (*slot).clone(),
            };
            !job.items.iter().any(|item| item.slot == **slot)
                && self.cell.setup.is_taught(arm, &place)
                && self.cell.is_free(&at)
        });
        let Some(slot) = free.clone().next().cloned() else {
            return false;
        };
        let to = Item {
            slot,
            ..item.clone()
        };
        self.redirect_slot(job, index, to);
        true
    }

    /// An item goes into another slot of the mobile robot.
    fn redirect_slot(&mut self, job: &Job, index: usize, to: Item) {
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
