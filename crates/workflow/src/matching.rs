//! What a waiting job would get, or what it waits for.

use std::fmt;

use crate::cell::Cell;
use crate::claims::Resource;
use crate::custody::Location;
use crate::job::Job;
use crate::job::params::Workflow;
use crate::setup::{MobileRobotSetup, PlaceRef};

/// What a job would get.
pub(crate) struct Match {
    pub(crate) arm: String,
    pub(crate) mobile_robot: String,
    pub(crate) resources: Vec<Resource>,
}

/// The first thing a job waits for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Unmet {
    /// Jobs may not act: somebody has control of the cell, or nothing can be recorded.
    JobsMayNotAct,
    /// The point is not in the set-up any more.
    NoPoint(String),
    /// Another job or session has it.
    Taken(Resource),
    /// What the arm is not: empty, taught, ready.
    Arm(String, &'static str),
    /// None of several arms of the point is free, taught and ready.
    NoArm(String),
    /// What keeps the only mobile robot there is for it.
    MobileRobot(String, String),
    /// None of several mobile robots is free and fits.
    NoMobileRobot,
    /// The place a load is to be put down at has one.
    PlaceFull(String, String),
    /// The place a load is to be taken from has none, or another one.
    PlaceLacks(String, Option<String>),
}

impl fmt::Display for Unmet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::JobsMayNotAct => f.write_str("jobs may not act now"),
            Self::NoPoint(point) => write!(f, "{point} is not in the set-up"),
            Self::Taken(
                Resource::Point(id)
                | Resource::Arm(id)
                | Resource::Place(id)
                | Resource::MobileRobot(id)
                | Resource::Load(id),
            ) => write!(f, "another job has {id}"),
            Self::Arm(arm, lack) => write!(f, "{arm} {lack}"),
            Self::NoArm(point) => write!(f, "no arm of {point} is free, taught and ready"),
            Self::MobileRobot(robot, lack) => write!(f, "{robot} {lack}"),
            Self::NoMobileRobot => f.write_str("no mobile robot is free and fits"),
            Self::PlaceFull(place, load) => write!(f, "{place} has {load}"),
            Self::PlaceLacks(place, Some(load)) => write!(f, "{place} does not have {load}"),
            Self::PlaceLacks(place, None) => write!(f, "{place} has no load"),
        }
    }
}

impl Cell {
    /// What a job in the queue waits for, in words; `None` where it could start now.
    pub(crate) fn waits_for(&self, job: &Job) -> Option<String> {
        if !self.live.jobs_may_act {
            return Some(Unmet::JobsMayNotAct.to_string());
        }
        self.match_job(job).err().map(|unmet| unmet.to_string())
    }

    /// Arm, mobile robot and resources for a job, if all are free right now.
    pub(crate) fn match_job(&self, job: &Job) -> Result<Match, Unmet> {
        let name = &job.spec.point;
        let point = self.setup.point(name);
        let point = point.ok_or_else(|| Unmet::NoPoint(name.clone()))?;
        self.unclaimed(Resource::Point(point.id.clone()))?;
        let arm = self.choose_arm(job, &point.arms)?;
        let mobile_robot = self.match_mobile_robot(job, None)?;
        let mut resources = vec![
            Resource::Point(point.id.clone()),
            Resource::Arm(arm.clone()),
            Resource::MobileRobot(mobile_robot.clone()),
        ];
        for item in &job.items {
            let at = Location::Fixed {
                place: item.place.clone(),
            };
            let there = self.book.custody.at(&at);
            match job.spec.workflow {
                Workflow::DeliveryAndPlacement if !self.is_free(&at) => {
                    let place = item.place.clone();
                    return Err(match there {
                        Some(load) => Unmet::PlaceFull(place, load.to_owned()),
                        None => Unmet::Taken(Resource::Place(place)),
                    });
                }
                Workflow::PickupAndDelivery
                    if there.is_none_or(|load| item.load.as_ref().is_some_and(|l| l != load)) =>
                {
                    return Err(Unmet::PlaceLacks(item.place.clone(), item.load.clone()));
                }
                Workflow::DeliveryAndPlacement | Workflow::PickupAndDelivery => {}
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
        for resource in &resources {
            self.unclaimed(resource.clone())?;
        }
        Ok(Match {
            arm,
            mobile_robot,
            resources,
        })
    }

    fn unclaimed(&self, resource: Resource) -> Result<(), Unmet> {
        if self.book.claims.is_free(&resource) {
            Ok(())
        } else {
            Err(Unmet::Taken(resource))
        }
    }

    /// The named arm, or the first of the point that can do it.
    fn choose_arm(&self, job: &Job, arms: &[String]) -> Result<String, Unmet> {
        let named = |arm: &&String| job.spec.arm.as_ref().is_none_or(|named| named == *arm);
        let candidates = arms.iter().filter(named);
        only(
            candidates.map(|arm| self.arm_for(job, arm).map(|()| arm.clone())),
            Unmet::NoArm(job.spec.point.clone()),
        )
    }

    fn arm_for(&self, job: &Job, arm: &str) -> Result<(), Unmet> {
        self.unclaimed(Resource::Arm(arm.to_owned()))?;
        let lacks = |lack| Err(Unmet::Arm(arm.to_owned(), lack));
        if self.book.custody.in_gripper(arm).is_some() {
            return lacks("has a load in its gripper");
        }
        if self.book.custody.doubt_of(arm).is_some() {
            return lacks("had a load, and nobody knows where that is");
        }
        if !self.arm_was_taught(arm, job) {
            return lacks("was not taught the places of this job");
        }
        if !self.arm_ready(arm) {
            return lacks("is not ready");
        }
        Ok(())
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
        self.match_mobile_robot(job, besides).ok()
    }

    fn match_mobile_robot(&self, job: &Job, besides: Option<&str>) -> Result<String, Unmet> {
        let named = job.spec.mobile_robot.as_ref();
        let candidates = self
            .setup
            .mobile_robots
            .iter()
            .filter(|robot| named.is_none_or(|named| *named == robot.id))
            .filter(|robot| besides != Some(robot.id.as_str()));
        only(
            candidates.map(|robot| self.mobile_robot_for(job, robot).map(|()| robot.id.clone())),
            Unmet::NoMobileRobot,
        )
    }

    fn mobile_robot_for(&self, job: &Job, robot: &MobileRobotSetup) -> Result<(), Unmet> {
        let lacks = |lack: String| Err(Unmet::MobileRobot(robot.id.clone(), lack));
        for item in &job.items {
            let slot = &item.slot;
            if !robot.slots.contains(slot) {
                return lacks(format!("has no slot {slot}"));
            }
            let at = Location::MobileRobot {
                mobile_robot: robot.id.clone(),
                slot: slot.clone(),
            };
            match (job.spec.workflow, self.book.custody.at(&at), &item.load) {
                (Workflow::PickupAndDelivery, Some(load), _) => {
                    return lacks(format!("has {load} in {slot}"));
                }
                (Workflow::DeliveryAndPlacement, load, Some(named))
                    if load != Some(named.as_str()) =>
                {
                    return lacks(format!("does not have {named} in {slot}"));
                }
                (Workflow::PickupAndDelivery | Workflow::DeliveryAndPlacement, _, _) => {}
            }
        }
        self.unclaimed(Resource::MobileRobot(robot.id.clone()))?;
        let transports = self.book.mobiles.get(&robot.id);
        if self.book.open_session_of(&robot.id).is_some() {
            return lacks("is still at a hand-over".to_owned());
        }
        if transports.is_some_and(|known| known.transport.is_some()) {
            return lacks("has a transport order".to_owned());
        }
        if self
            .mobile_seen(&robot.id)
            .is_some_and(|seen| !seen.mode.is_automatic())
        {
            return lacks("is not in an automatic mode".to_owned());
        }
        Ok(())
    }
}

/// The first that fits. Else why the only one does not, or, of none or several, `otherwise`.
fn only(
    candidates: impl Iterator<Item = Result<String, Unmet>>,
    otherwise: Unmet,
) -> Result<String, Unmet> {
    let mut reasons = Vec::new();
    for candidate in candidates {
        match candidate {
            Ok(found) => return Ok(found),
            Err(unmet) => reasons.push(unmet),
        }
    }
    let first = reasons.pop();
    Err(first.filter(|_| reasons.is_empty()).unwrap_or(otherwise))
}
