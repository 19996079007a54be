//! F20: the loads of a transport that failed go on with another mobile robot.

use crate::claims::Resource;
use crate::custody::{Evidence, Location};
use crate::fact::Fact;
use crate::input::{Principal, Refusal};
use crate::job::Job;
use crate::job::phase::Phase;
use crate::work::Work;

impl Work<'_> {
    pub(super) fn check_swap(&self, job: &Job, to: &str) -> Result<(), Refusal> {
        let no = |text: String| {
            Err(Refusal::Conflict {
                command: "answer SwapMobileRobot".into(),
                text,
            })
        };
        let Some(setup) = self.cell.setup.mobile_robot(to) else {
            return Err(Refusal::Unknown {
                what: "mobile robot",
                id: to.to_owned(),
            });
        };
        if !self
            .cell
            .book
            .claims
            .is_free(&Resource::MobileRobot(to.to_owned()))
        {
            return no(format!("{to} has something else to do"));
        }
        for item in &job.items {
            let at = Location::MobileRobot {
                mobile_robot: to.to_owned(),
                slot: item.slot.clone(),
            };
            // Somebody may have said already that the load itself is there.
            let there = self.cell.book.custody.at(&at);
            let its_own = there.is_some() && there == item.load.as_deref();
            if !setup.slots.contains(&item.slot) || !(its_own || self.cell.is_free(&at)) {
                return no(format!("{} of {to} is not free", item.slot));
            }
        }
        Ok(())
    }

    /// F20: the loads are on another mobile robot now, which drives on.
    pub(super) fn swap(&mut self, job: &Job, to: &str, principal: &Principal, reason: &str) {
        let Some(from) = job.mobile_robot.clone() else {
            return;
        };
        let transport = self.transport_of(&from);
        for item in &job.items {
            let there = Location::MobileRobot {
                mobile_robot: from.clone(),
                slot: item.slot.clone(),
            };
            let now = Location::MobileRobot {
                mobile_robot: to.to_owned(),
                slot: item.slot.clone(),
            };
            // The first one has reported meanwhile that it is gone: this is the answer to where.
            let gone = item.load.clone().filter(|load| {
                let at = self.cell.book.custody.of(load);
                matches!(at, Some(Location::Unknown { arm: None }))
            });
            if let Some(load) = gone {
                let said = self.set_custody(&load, &now, &load, principal, reason);
                debug_assert!(said.is_ok(), "{said:?}");
            } else if let Some(load) = self.cell.book.custody.at(&there).map(str::to_owned) {
                self.emit(Fact::CustodyMoved {
                    load,
                    to: now,
                    by: Evidence::Human {
                        principal: principal.name.clone(),
                        reason: reason.to_owned(),
                    },
                });
            }
        }
        self.emit(Fact::TransportEnded { mobile_robot: from });
        self.emit(Fact::JobAssigned {
            job: job.id,
            arm: job.arm.clone().unwrap_or_default(),
            mobile_robot: to.to_owned(),
        });
        if let Some(transport) = transport {
            let order = self.ids.next_id();
            let destination = transport.destination.clone();
            let mobile_robot = to.to_owned();
            self.emit(Fact::TransportBegun {
                mobile_robot,
                job: job.id,
                order,
                destination,
                session: None,
                update: 1,
            });
            let transport = crate::book::Transport {
                order,
                session: None,
                update: 1,
                ..transport
            };
            self.resend_transport(to, &transport);
        }
        self.again(job, Phase::Transport);
    }
}
