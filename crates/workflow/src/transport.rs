//! B15: the transport of what a pickup has loaded, to its end.

use crate::custody::{Evidence, Location};
use crate::fact::Fact;
use crate::job::phase::Phase;
use crate::signal::Signal;
use crate::work::Work;

impl Work<'_> {
    /// B15: custody goes to the destination.
    pub(crate) fn delivered(&mut self, mobile_robot: &str) {
        let Some(transport) = self.transport_of(mobile_robot) else {
            return;
        };
        let on_it: Vec<_> = self
            .cell
            .book
            .custody
            .0
            .iter()
            .filter(|(_, l)| {
                matches!(&l.location, Location::MobileRobot { mobile_robot: m, .. } if m == mobile_robot)
            })
            .map(|(id, _)| id.clone())
            .filter(|id| {
                // Only what this transport took along; loads of others stay where they are.
                self.cell.book.jobs.get(&transport.job).is_some_and(|j| {
                    j.items.iter().any(|i| i.load.as_ref() == Some(id))
                })
            })
            .collect();
        for load in on_it {
            self.emit(Fact::CustodyMoved {
                load,
                to: Location::Delivered {
                    destination: transport.destination.clone(),
                },
                by: Evidence::MobileRobot {
                    mobile_robot: mobile_robot.to_owned(),
                },
            });
        }
        self.emit(Fact::TransportEnded {
            mobile_robot: mobile_robot.to_owned(),
        });
        if let Some(job) = self.job(transport.job)
            && job.state == crate::JobState::Suspended
        {
            self.withdraw(job.id, "the loads were delivered");
            if job.why != crate::Why::Awaiting {
                self.go(
                    job.id,
                    crate::JobState::Unsuspending,
                    crate::Why::Awaiting,
                    "delivered",
                );
            }
        }
    }

    /// F20, as it says itself.
    pub(super) fn transport_stuck(&mut self, mobile_robot: &str, text: &str) {
        let job = self
            .transport_of(mobile_robot)
            .and_then(|t| self.job(t.job));
        if let Some(job) = job
            && let Some(step) = job.find(Phase::Transport)
            && job
                .step(step)
                .is_some_and(|s| s.state == crate::StepState::Running)
        {
            self.transport_failed(&job, step, text);
        }
    }

    pub(crate) fn transport_of(&self, mobile_robot: &str) -> Option<crate::book::Transport> {
        let mobile = self.cell.book.mobiles.get(mobile_robot)?;
        mobile.transport.clone()
    }

    pub(super) fn is_of_transport(&self, signal: &Signal) -> bool {
        self.transport_of(&signal.mobile_robot)
            .is_some_and(|t| signal.state.order == Some(t.order))
    }
}
