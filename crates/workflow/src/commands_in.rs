//! Inputs, one by one.

use uuid::Uuid;

use crate::custody::{Evidence, Location};
use crate::fact::Fact;
use crate::faults::Fault;
use crate::input::{ArmSeen, Command, Input, Principal, Refusal, Reply, Role};
use crate::job::params::NewJob;
use crate::job::validate::items_of;
use crate::job::{JobState, Why};
use crate::work::Work;

impl Work<'_> {
    pub(crate) fn take_input(&mut self, input: Input) -> Result<Reply, Refusal> {
        match input {
            Input::Recover => Ok(self.recover()),
            Input::CreateJob { job } => self.create(*job).map(Reply::Created),
            Input::JobCommand {
                job,
                command,
                principal,
                reason,
            } => self.command(job, command, &principal, &reason),
            Input::Signal(signal) => self.signal(*signal),
            Input::InstantAction {
                mobile_robot,
                action,
                principal,
                reason,
            } => self.instant(mobile_robot, action, &principal, reason),
            Input::OutboxTaken { mobile_robot, n } => {
                let waiting = self.cell.book.mobiles.get(&mobile_robot);
                if !waiting.is_some_and(|m| m.outbox.iter().any(|o| o.n <= n)) {
                    return Ok(Reply::Unchanged);
                }
                self.emit(Fact::OutboxTaken { mobile_robot, n });
                Ok(Reply::Done)
            }
            Input::OperationPlanned { op, expected_ms } => {
                if !self.cell.book.ops.contains_key(&op) {
                    return Ok(Reply::Unchanged);
                }
                self.emit(Fact::OpPlanned { op, expected_ms });
                Ok(Reply::Done)
            }
            Input::OperationEnded { op, result } => self.op_ended(op, result),
            Input::ArmObserved(seen) => self.observed(seen),
            Input::Respond {
                intervention,
                answer,
                detail,
                principal,
                reason,
            } => self.respond(intervention, answer, detail, &principal, &reason),
            Input::SetCustody {
                load,
                location,
                confirm,
                principal,
                reason,
            } => {
                self.set_custody(&load, &location, &confirm, &principal, &reason)?;
                Ok(Reply::Done)
            }
            Input::Control { jobs_may_act } => {
                if self.cell.live.jobs_may_act == jobs_may_act {
                    return Ok(Reply::Unchanged);
                }
                self.emit(Fact::ControlChanged { jobs_may_act });
                Ok(Reply::Done)
            }
            Input::Journal { writable } => Ok(self.journal(writable)),
            Input::SetupChanged(setup) => self.setup_changed(*setup),
            Input::Tick => Ok(Reply::Done),
        }
    }

    /// A new job in the queue.
    pub(crate) fn create(&mut self, spec: NewJob) -> Result<Uuid, Refusal> {
        self.create_for(spec, None)
    }

    /// The same, of a trigger and of the signal that fired it.
    pub(crate) fn create_for(
        &mut self,
        spec: NewJob,
        from: Option<(String, String)>,
    ) -> Result<Uuid, Refusal> {
        let items = items_of(&self.cell, &spec, self.now)?;
        let job = self.ids.next_id();
        let (trigger, origin) = from.unzip();
        self.emit(Fact::JobCreated {
            job,
            spec: Box::new(spec),
            trigger,
            origin,
            items,
        });
        Ok(job)
    }

    fn observed(&mut self, seen: ArmSeen) -> Result<Reply, Refusal> {
        if !self.cell.setup.arms.contains(&seen.arm) {
            return Err(Refusal::Unknown {
                what: "arm",
                id: seen.arm,
            });
        }
        self.emit(Fact::ArmSeen(seen));
        Ok(Reply::Done)
    }

    /// F24. While it cannot be written only looking is possible; when it can again, a human lets the jobs go on.
    fn journal(&mut self, writable: bool) -> Reply {
        if self.cell.live.unwritable != writable {
            return Reply::Unchanged;
        }
        self.emit(Fact::JournalChanged { writable });
        if writable {
            for id in self.jobs() {
                let Some(job) = self.job(id) else { continue };
                self.note(
                    id,
                    Fault::JournalUnwritable,
                    "the journal could not be written",
                );
                if crate::react::outranks(JobState::Holding, job.state) {
                    let why = Why::Fault {
                        fault: Fault::JournalUnwritable,
                    };
                    self.go(
                        id,
                        JobState::Holding,
                        why,
                        "the journal can be written again",
                    );
                }
            }
        }
        Reply::Done
    }

    /// A human says where a load is. Two fields have to agree, and the place has to be free.
    pub(crate) fn set_custody(
        &mut self,
        load: &str,
        location: &Location,
        confirm: &str,
        principal: &Principal,
        reason: &str,
    ) -> Result<(), Refusal> {
        let command = || "set-custody".to_owned();
        allowed(&command(), principal, reason)?;
        let Some(now) = self.cell.book.custody.of(load).cloned() else {
            return Err(Refusal::Unknown {
                what: "load",
                id: load.to_owned(),
            });
        };
        if load != confirm {
            return Err(Refusal::Invalid {
                item: "confirm".into(),
                problem: format!("{confirm}, but the load is {load}"),
            });
        }
        let known = match location {
            Location::Fixed { place } => self.cell.setup.place(place).is_some(),
            Location::Gripper { arm } => self.cell.setup.arms.contains(arm),
            Location::MobileRobot { mobile_robot, slot } => self
                .cell
                .setup
                .mobile_robot(mobile_robot)
                .is_some_and(|m| m.slots.contains(slot)),
            Location::Delivered { destination } => {
                self.cell.setup.destinations.contains(destination)
            }
            Location::Unknown { .. } => false,
        };
        if !known {
            return Err(Refusal::Invalid {
                item: "location".into(),
                problem: format!("{location} is no place of this cell"),
            });
        }
        if now != *location && !self.cell.is_free(location) {
            let other = self
                .cell
                .book
                .custody
                .at(location)
                .unwrap_or_default()
                .to_owned();
            return Err(Refusal::Conflict {
                command: command(),
                text: format!("load {other} is booked at {location}"),
            });
        }
        let gripping = self.cell.book.ops.values().any(|op| {
            crate::supervise::grip_of(&op.action).is_some()
                && self
                    .cell
                    .book
                    .jobs
                    .get(&op.job)
                    .is_some_and(|j| j.items.iter().any(|i| i.load.as_deref() == Some(load)))
        });
        let moving = self.cell.book.jobs.values().any(|j| {
            !(matches!(now, Location::Unknown { .. }) && crate::cell::Cell::is_in_transport(j))
                && j.items.iter().any(|i| i.load.as_deref() == Some(load))
                && (j.state.runs() && j.compensation != crate::Compensation::Blocked
                    || j.state.is_acting() && j.state != JobState::Stopping)
        });
        if gripping || moving {
            return Err(Refusal::Conflict {
                command: command(),
                text: format!("a job is working with load {load}; hold or stop it first"),
            });
        }
        if now != *location {
            self.emit(Fact::CustodyMoved {
                load: load.to_owned(),
                to: location.clone(),
                by: Evidence::Human {
                    principal: principal.name.clone(),
                    reason: reason.to_owned(),
                },
            });
        }
        let open = self.cell.book.interventions.values().find(|i| {
            i.is_open()
                && i.question.load.as_deref() == Some(load)
                && i.question.fault == Fault::PartLost
        });
        if let Some(intervention) = open.map(|i| i.question.id) {
            let text = format!("{} said where it is", principal.name);
            self.emit(Fact::Withdrawn { intervention, text });
        }
        Ok(())
    }

    fn setup_changed(&mut self, setup: crate::Setup) -> Result<Reply, Refusal> {
        if let Some(error) = setup.check().into_iter().next() {
            return Err(Refusal::Invalid {
                item: error.item,
                problem: error.problem,
            });
        }
        if setup == *self.cell.setup {
            return Ok(Reply::Unchanged);
        }
        for resource in self.cell.book.claims.0.keys() {
            let kept = match resource {
                crate::Resource::Point(id) => setup.point(id) == self.cell.setup.point(id),
                crate::Resource::Arm(id) => setup.arms.contains(id),
                crate::Resource::Place(id) => setup.place(id) == self.cell.setup.place(id),
                crate::Resource::MobileRobot(id) => {
                    setup.mobile_robot(id) == self.cell.setup.mobile_robot(id)
                }
                crate::Resource::Load(_) => true,
            };
            if !kept {
                return Err(Refusal::Conflict {
                    command: "set-up".into(),
                    text: format!("{resource:?} is in use and cannot change"),
                });
            }
        }
        for (load, found) in &self.cell.book.custody.0 {
            let kept = match &found.location {
                Location::Fixed { place } => setup.place(place).is_some(),
                Location::Gripper { arm } => setup.arms.contains(arm),
                Location::MobileRobot { mobile_robot, slot } => setup
                    .mobile_robot(mobile_robot)
                    .is_some_and(|m| m.slots.contains(slot)),
                Location::Delivered { .. } | Location::Unknown { .. } => true,
            };
            if !kept {
                return Err(Refusal::Conflict {
                    command: "set-up".into(),
                    text: format!("load {load} is at {}, which would vanish", found.location),
                });
            }
        }
        let taken = setup
            .loads
            .iter()
            .find(|l| self.cell.book.custody.of(&l.id).is_none() && !self.cell.is_free(&l.at));
        if let Some(load) = taken {
            return Err(Refusal::Conflict {
                command: "set-up".into(),
                text: format!("new load {}: {} is not free", load.id, load.at),
            });
        }
        self.emit(Fact::SetupChanged {
            setup: Box::new(setup),
        });
        Ok(Reply::Done)
    }
}

/// Every decision of a human has an author who may, and a reason.
pub(crate) fn allowed(command: &str, principal: &Principal, reason: &str) -> Result<(), Refusal> {
    if principal.role < Role::Operator {
        return Err(Refusal::Forbidden {
            command: command.to_owned(),
            needed: Role::Operator,
        });
    }
    if reason.trim().is_empty() {
        return Err(Refusal::Invalid {
            item: "reason".into(),
            problem: "it is empty".into(),
        });
    }
    if reason.len() > 1_000 {
        return Err(Refusal::Invalid {
            item: "reason".into(),
            problem: format!("{} bytes; the limit is 1000", reason.len()),
        });
    }
    Ok(())
}

/// The word of a command.
pub(crate) const fn word(command: Command) -> &'static str {
    match command {
        Command::Hold => "hold",
        Command::Unhold => "unhold",
        Command::Stop => "stop",
        Command::Abort => "abort",
        Command::RetryStep => "retry-step",
        Command::SkipStep => "skip-step",
        Command::CompleteManually => "complete-manually",
        Command::Compensate => "compensate",
        Command::Clear => "clear",
        Command::Reset => "reset",
    }
}
