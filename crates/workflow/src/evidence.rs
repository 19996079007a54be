//! What is seen right now, and what may be concluded from it. Not seen means no.

use uuid::Uuid;

use crate::book::OpState;
use crate::cell::Cell;
use crate::custody::Location;
use crate::effect::Action;
use crate::input::{ArmSeen, Safety};
use crate::job::params::Workflow;
use crate::job::{Job, JobState};
use crate::permits::Permit;
use crate::session::Session;
use crate::setup::Point;
use crate::signal::MobileState;
use crate::words;

impl Cell {
    /// The permit of a session right now.
    pub(crate) fn permit_of(&self, session: &Session) -> Permit {
        if self.live.recovered {
            Permit::of(session.state)
        } else {
            Permit::None
        }
    }

    /// The last look at an arm whose controller answers.
    pub(crate) fn arm_seen(&self, arm: &str) -> Option<&ArmSeen> {
        self.live.arms.get(arm).map(|a| &a.seen).filter(|s| s.link)
    }

    /// It is seen to stand still.
    pub(crate) fn arm_still(&self, arm: &str) -> bool {
        self.arm_seen(arm).is_some_and(|s| s.still)
            && !self.live.arms.get(arm).is_some_and(|a| a.stopping)
    }

    /// It takes operations, and jobs may give them.
    pub(crate) fn arm_ready(&self, arm: &str) -> bool {
        self.live.jobs_may_act
            && self
                .arm_seen(arm)
                .is_some_and(|s| s.ready && matches!(s.safety, Safety::Normal | Safety::Reduced))
    }

    /// An arm of the point that is known and not heard now: nobody is permitted at the point meanwhile.
    pub(crate) fn unheard_at(&self, point: &str) -> Option<&str> {
        let point = self.setup.point(point)?;
        let unheard = |arm: &&String| self.live.arms.get(*arm).is_some_and(|a| !a.seen.link);
        point.arms.iter().find(unheard).map(String::as_str)
    }

    pub(crate) fn arm_in_zone(&self, arm: &str, zone: &str) -> bool {
        self.live
            .arms
            .get(arm)
            .is_some_and(|a| a.seen.zones.iter().any(|z| z == zone))
    }

    /// `ARM_CLEAR`: every arm of the point is seen outside its zone, and none is on its way in.
    pub(crate) fn arm_clear(&self, point: &Point) -> bool {
        point.arms.iter().all(|arm| {
            self.arm_seen(arm)
                .is_some_and(|s| !s.zones.contains(&point.zone))
                && !self.book.ops.values().any(|op| {
                    op.arm == *arm
                        && matches!(&op.action, Action::Move { target, .. } if target.enters_zone())
                })
        })
    }

    /// Where an arm may be in the zone of the point, by sight or by intention.
    pub(crate) fn arm_may_be_in(&self, point: &Point) -> bool {
        point
            .arms
            .iter()
            .any(|arm| self.arm_in_zone(arm, &point.zone))
            || !point.arms.iter().all(|arm| self.arm_seen(arm).is_some())
            || self.book.ops.values().any(|op| {
                point.arms.contains(&op.arm)
                    && matches!(&op.action, Action::Move { target, .. } if target.enters_zone())
            })
    }

    /// The last state of a mobile robot that is not lost.
    pub(crate) fn mobile_seen(&self, mobile_robot: &str) -> Option<&MobileState> {
        self.live
            .mobiles
            .get(mobile_robot)
            .filter(|m| !m.lost)
            .and_then(|m| m.state.as_ref())
    }

    /// The second evidence (M5): it stands where it said it docked, and trusts its pose.
    pub(crate) fn dock_evidence(&self, session: &Session) -> Result<(), String> {
        let point = self
            .setup
            .point(&session.point)
            .ok_or("the point is not configured")?;
        let seen = self
            .mobile_seen(&session.mobile_robot)
            .ok_or("it is not heard")?;
        let docked = session.docked.ok_or("it has not docked")?;
        if seen.driving {
            return Err("it drives".into());
        }
        if !seen.localized {
            return Err("it is not localized".into());
        }
        if !seen.mode.is_automatic() {
            return Err(format!("its mode is {}", words::word(&seen.mode)));
        }
        if !seen.pose.within(&docked, point.tolerance) {
            return Err("its pose is not the one it docked at".into());
        }
        let near = docked.within(&point.dock, point.tolerance)
            && seen.pose.within(&point.dock, point.tolerance);
        if !near && !session.measured_accepted {
            return Err(format!(
                "it docked at {}, outside {} mm and {} deg",
                words::pose(&docked),
                point.tolerance.mm,
                point.tolerance.deg
            ));
        }
        Ok(())
    }

    /// Its own account of its way to the dock is one that can have been driven (M5).
    pub(crate) fn way_evidence(&self, session: &Session) -> Result<(), String> {
        let live = self.live.mobiles.get(&session.mobile_robot);
        match live.and_then(|live| live.jump) {
            Some(jump) if !session.measured_accepted => Err(jump.to_string()),
            Some(_) | None => Ok(()),
        }
    }

    /// Nothing is booked where a load is to be put down, and the mobile robot reports nothing there either. What it says
    /// of a slot that is being emptied again comes too late to be asked.
    pub(crate) fn is_target_free(&self, job: &Job, at: &Location) -> bool {
        let reported = |mobile_robot: &str, slot: &str| {
            let loads = self.mobile_seen(mobile_robot)?.loads.as_ref()?;
            loads.iter().find(|load| load.slot == *slot).map(drop)
        };
        let taken = match at {
            Location::MobileRobot { mobile_robot, slot } => {
                reported(mobile_robot, slot).is_some()
                    && job.spec.workflow == Workflow::PickupAndDelivery
                    && job.state != JobState::Stopping
                    && !job.loads_accepted
            }
            Location::Fixed { .. }
            | Location::Gripper { .. }
            | Location::Delivered { .. }
            | Location::Unknown { .. } => false,
        };
        !taken && self.is_free(at)
    }

    /// Operations of a job that have not ended.
    pub(crate) fn ops_of(&self, job: Uuid) -> impl Iterator<Item = (Uuid, OpState)> {
        self.book
            .ops
            .iter()
            .filter(move |(_, op)| op.job == job)
            .map(|(id, op)| (*id, op.state))
    }

    /// The arm of the job stands still and has nothing to do, or there is none.
    pub(crate) fn is_quiet(&self, job: &Job) -> bool {
        let running = self
            .ops_of(job.id)
            .any(|(_, state)| state == OpState::Running);
        !running && job.arm.as_ref().is_none_or(|arm| self.arm_still(arm))
    }

    /// The session of a job, while it is open.
    pub(crate) fn session_of(&self, job: &Job) -> Option<&std::sync::Arc<Session>> {
        self.book
            .sessions
            .get(&job.session?)
            .filter(|s| !s.state.is_closed())
    }
}
