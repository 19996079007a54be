//! The queue: by priority, then deadline, then age; a job starts when everything it needs is free at once.

use std::cmp::Reverse;

use crate::cell::Cell;
use crate::claims::{Holder, Resource};
use crate::custody::Location;
use crate::definition::Definition;
use crate::fact::Fact;
use crate::job::params::Workflow;
use crate::job::plan::plan;
use crate::job::{Job, JobState, StepState, Why};
use crate::setup::PlaceRef;
use crate::work::Work;

/// What a job would get.
struct Match {
    arm: String,
    mobile_robot: String,
    resources: Vec<Resource>,
}

impl Work<'_> {
    pub(crate) fn run_queue(&mut self) {
        if !self.cell.live.jobs_may_act {
            return;
        }
        let mut queue: Vec<_> = self
            .cell
            .book
            .jobs
            .values()
            .filter(|j| j.state == JobState::Idle)
            .map(|j| {
                let deadline = j.spec.deadline.unwrap_or(u64::MAX);
                ((Reverse(j.spec.priority), deadline, j.number), j.clone())
            })
            .collect();
        queue.sort_by_key(|(key, _)| *key);
        for (_, job) in queue {
            if let Some(found) = self.cell.match_job(&job) {
                self.start(&job, found);
                return;
            }
        }
    }

    /// A1, B1: the claims, the session and the plan, in one decision.
    fn start(&mut self, job: &Job, found: Match) {
        let Match {
            arm,
            mobile_robot,
            resources,
        } = found;
        let session = self.ids.next_id();
        let (held, shared): (Vec<_>, Vec<_>) = resources
            .into_iter()
            .partition(|r| matches!(r, Resource::Point(_) | Resource::MobileRobot(_)));
        self.emit(Fact::Claimed {
            by: Holder::Session(session),
            resources: held,
        });
        self.emit(Fact::Claimed {
            by: Holder::Job(job.id),
            resources: shared,
        });
        self.emit(Fact::JobAssigned {
            job: job.id,
            arm: arm.clone(),
            mobile_robot: mobile_robot.clone(),
        });
        self.emit(Fact::SessionOpened {
            session,
            point: job.spec.point.clone(),
            job: job.id,
            mobile_robot,
        });
        self.emit(Fact::Planned {
            job: job.id,
            steps: plan(&job.spec, &job.items),
            drop: Vec::new(),
            definition: Some(Definition::of(job.spec.workflow)),
        });
        self.go(job.id, JobState::Starting, Why::Course, "");
        if let Some(job) = self.job(job.id) {
            self.step_to(&job, 0, StepState::Running, "");
        }
        if let Some(job) = self.job(job.id) {
            self.step_to(&job, 0, StepState::Succeeded, "claimed");
        }
    }
}

impl Cell {
    /// Arm, mobile robot and resources for a job, if all are free right now.
    fn match_job(&self, job: &Job) -> Option<Match> {
        let point = self.setup.point(&job.spec.point)?;
        let free = |r: &Resource| self.book.claims.is_free(r);
        if !free(&Resource::Point(point.id.clone())) {
            return None;
        }
        let arm = point
            .arms
            .iter()
            .filter(|a| job.spec.arm.as_ref().is_none_or(|named| named == *a))
            .find(|a| {
                free(&Resource::Arm((*a).clone()))
                    && self.arm_may_serve(a)
                    && self.arm_was_taught(a, job)
                    && self.arm_ready(a)
            })?;
        let mobile_robot = self.choose_mobile_robot(job, None)?;
        let mut resources = vec![
            Resource::Point(point.id.clone()),
            Resource::Arm(arm.clone()),
            Resource::MobileRobot(mobile_robot.clone()),
        ];
        for item in &job.items {
            let at = Location::Fixed {
                place: item.place.clone(),
            };
            let ready = match job.spec.workflow {
                Workflow::DeliveryAndPlacement => self.is_free(&at),
                Workflow::PickupAndDelivery => self
                    .book
                    .custody
                    .at(&at)
                    .is_some_and(|l| item.load.as_ref().is_none_or(|named| named == l)),
            };
            if !ready {
                return None;
            }
            if self.setup.is_single(&at) {
                resources.push(Resource::Place(item.place.clone()));
            }
            if let Some(load) = &item.load {
                resources.push(Resource::Load(load.clone()));
            }
        }
        resources.sort();
        resources.dedup();
        resources.iter().all(free).then(|| Match {
            arm: arm.clone(),
            mobile_robot,
            resources,
        })
    }

    /// Its gripper is empty, and nothing it had is lost.
    fn arm_may_serve(&self, arm: &str) -> bool {
        self.book.custody.in_gripper(arm).is_none() && self.book.custody.doubt_of(arm).is_none()
    }

    fn arm_was_taught(&self, arm: &str, job: &Job) -> bool {
        job.items.iter().all(|item| {
            let slot = PlaceRef::MobileRobot {
                point: job.spec.point.clone(),
                slot: item.slot.clone(),
            };
            self.setup.is_taught(arm, &slot)
                && self
                    .setup
                    .is_taught(arm, &PlaceRef::fixed(item.place.clone()))
        })
    }

    /// The named mobile robot, or any that has the slots, the loads and nothing to do.
    pub(crate) fn choose_mobile_robot(&self, job: &Job, besides: Option<&str>) -> Option<String> {
        self.setup
            .mobile_robots
            .iter()
            .filter(|m| {
                job.spec
                    .mobile_robot
                    .as_ref()
                    .is_none_or(|named| *named == m.id)
            })
            .filter(|m| besides != Some(m.id.as_str()))
            .find(|m| {
                job.items.iter().all(|item| {
                    let at = Location::MobileRobot {
                        mobile_robot: m.id.clone(),
                        slot: item.slot.clone(),
                    };
                    let load = self.book.custody.at(&at);
                    let fits = match job.spec.workflow {
                        Workflow::PickupAndDelivery => load.is_none(),
                        Workflow::DeliveryAndPlacement => match &item.load {
                            Some(named) => load == Some(named.as_str()),
                            None => true,
                        },
                    };
                    m.slots.contains(&item.slot) && fits
                }) && self
                    .book
                    .claims
                    .is_free(&Resource::MobileRobot(m.id.clone()))
                    && self.book.open_session_of(&m.id).is_none()
                    && self
                        .book
                        .mobiles
                        .get(&m.id)
                        .is_none_or(|b| b.transport.is_none())
                    && self
                        .mobile_seen(&m.id)
                        .is_none_or(|s| s.mode.is_automatic())
            })
            .map(|m| m.id.clone())
    }
}
