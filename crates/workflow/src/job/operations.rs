//! The operations of a step, when one may start, and what its end means.

use crate::effect::{Action, GripAction, Interpolation, Speed, Target};
use crate::fact::Fact;
use crate::job::params::Workflow;
use crate::job::phase::Phase;
use crate::job::plan::slot_of;
use crate::job::{Job, StepState};
use crate::session::SessionState;
use crate::setup::PlaceRef;
use crate::signal::Message;
use crate::work::Work;

/// The operations of a step, in order.
pub(crate) fn operations(job: &Job, step: usize) -> Vec<Action> {
    let Some(step) = job.step(step) else {
        return Vec::new();
    };
    if step.plan.phase == Phase::Precheck {
        return vec![Action::Precheck {
            targets: all_targets(job),
        }];
    }
    let place = match (step.plan.phase, &step.plan.place) {
        (Phase::BackOut, _) => job.near.clone(),
        (_, place) => place.clone(),
    };
    let to = |target| Action::Move {
        interpolation: match target {
            Target::At { .. } | Target::LiftOf { .. } => Interpolation::Linear,
            Target::ApproachOf { .. } | Target::Safe => Interpolation::Joint,
        },
        speed: match target {
            Target::At { .. } | Target::LiftOf { .. } => Speed::Reduced,
            Target::ApproachOf { .. } | Target::Safe => Speed::Free,
        },
        target,
        docked: None,
    };
    // From where a hand left it no straight line is known to be free: each joint turns to the safe pose, slowly.
    if step.plan.phase == Phase::BackOut && job.is_displaced() {
        return vec![Action::Move {
            target: Target::Safe,
            interpolation: Interpolation::Joint,
            speed: Speed::Reduced,
            docked: None,
        }];
    }
    let Some(place) = place else {
        return vec![to(Target::Safe)];
    };
    let approach = to(Target::ApproachOf {
        place: place.clone(),
    });
    let at = to(Target::At {
        place: place.clone(),
    });
    let lift = to(Target::LiftOf { place });
    let (open, close) = (
        Action::Grip {
            action: GripAction::Open,
        },
        Action::Grip {
            action: GripAction::Close,
        },
    );
    let out = if job.near.is_some() || step.done_ops > 0 {
        vec![lift.clone(), to(Target::Safe)]
    } else {
        Vec::new()
    };
    match step.plan.phase {
        Phase::Approach | Phase::PlaceApproach => vec![approach, at],
        Phase::Grip if step.attempt <= 1 => vec![close],
        // F9: open, away, back, close; after the last attempt only open and leave.
        Phase::Grip if step.attempt <= job.spec.max_attempts => vec![open, lift, at, close],
        Phase::Grip => vec![open, lift, to(Target::Safe)],
        Phase::Release => vec![open],
        Phase::LiftClear | Phase::Retreat | Phase::BackOut => out,
        Phase::Reserve
        | Phase::Precheck
        | Phase::Call
        | Phase::Await
        | Phase::Dock
        | Phase::VerifyLoad
        | Phase::VerifyEmpty
        | Phase::Permit
        | Phase::ReleaseMr
        | Phase::VerifyOnMr
        | Phase::Exit
        | Phase::Transport
        | Phase::Close
        | Phase::Dismiss => Vec::new(),
    }
}

/// Every pose of the whole job, in the order of driving.
fn all_targets(job: &Job) -> Vec<Target> {
    let mut targets = Vec::new();
    for item in &job.items {
        let (slot, fixed) = (
            slot_of(&job.spec, item),
            PlaceRef::fixed(item.place.clone()),
        );
        let ways = match job.spec.workflow {
            Workflow::DeliveryAndPlacement => [slot, fixed],
            Workflow::PickupAndDelivery => [fixed, slot],
        };
        for place in ways {
            targets.push(Target::ApproachOf {
                place: place.clone(),
            });
            targets.push(Target::At {
                place: place.clone(),
            });
            targets.push(Target::LiftOf { place });
        }
    }
    targets.push(Target::Safe);
    targets
}

impl Work<'_> {
    /// Starts the next operation of a step, or ends the step.
    pub(crate) fn run_operations(&mut self, job: &Job, step: usize) {
        let Some(found) = job.step(step) else { return };
        if found.op.is_some() || job.waits_for_hand() {
            return;
        }
        let Some(arm) = job.arm.clone() else { return };
        let actions = operations(job, step);
        let Some(action) = actions.get(found.done_ops).cloned() else {
            self.arm_work_done(job, step, &arm);
            return;
        };
        let busy = self.cell.book.ops.values().any(|op| op.arm == arm);
        if busy || !self.cell.arm_ready(&arm) || !self.cell.arm_still(&arm) {
            return;
        }
        let mut action = action;
        if let Action::Move { target, docked, .. } = &mut action {
            if target.enters_zone() {
                if !self.may_enter(job) {
                    return;
                }
                *docked = self.cell.session_of(job).and_then(|s| s.docked);
            }
            if found.plan.phase == Phase::PlaceApproach
                && found.done_ops == 0
                && self.target_blocked(job, step)
            {
                return;
            }
        }
        let op = self.ids.next_id();
        self.emit(Fact::OpStarted {
            op,
            job: job.id,
            step,
            arm,
            action,
        });
    }

    /// Whether the arm may enter the zone now: its permit, and the second evidence (M5). After a fault the permit is
    /// granted again from DOCKED.
    fn may_enter(&mut self, job: &Job) -> bool {
        let Some(session) = self.cell.session_of(job).cloned() else {
            return false;
        };
        if self.cell.dock_evidence(&session).is_err() {
            return false;
        }
        if session.state == SessionState::Docked && session.ready && job.is_done(Phase::Permit) {
            self.move_session(&session, SessionState::TransferReady);
            let Some(session) = self.session(session.id) else {
                return false;
            };
            self.move_session(&session, SessionState::Transferring);
            self.tell(&session, Message::CellReady);
            return true;
        }
        session.state == SessionState::Transferring
    }

    /// All operations are done; now what is seen has to agree.
    fn arm_work_done(&mut self, job: &Job, step: usize, arm: &str) {
        let Some(found) = job.step(step) else { return };
        let phase = found.plan.phase;
        if phase == Phase::Grip && found.attempt > job.spec.max_attempts {
            self.grip_given_up(job, step);
            return;
        }
        if matches!(phase, Phase::LiftClear | Phase::Retreat | Phase::BackOut) {
            let Some(seen) = self.cell.arm_seen(arm) else {
                return;
            };
            let zone = self.cell.setup.point(&job.spec.point).map(|p| &p.zone);
            if zone.is_some_and(|z| seen.zones.contains(z)) {
                return;
            }
            let load = found
                .plan
                .item
                .and_then(|i| job.items.get(i))
                .and_then(|i| i.load.clone());
            if phase == Phase::Retreat
                && seen.part_present == Some(true)
                && let Some(load) = load
            {
                self.part_lost(
                    job,
                    &load,
                    "after the release a part is still in the gripper",
                );
                return;
            }
        }
        self.step_to(job, step, StepState::Succeeded, "");
        if phase == Phase::BackOut
            && let Some(job) = self.job(job.id)
        {
            self.after_back_out(&job);
        }
    }

    /// The arm left its place: what was begun there begins anew, and what the gripper had already done there is done.
    fn after_back_out(&mut self, job: &Job) {
        let begun = |phase: Phase| {
            job.steps.iter().position(|s| {
                s.plan.phase == phase
                    && matches!(s.state, StepState::Running | StepState::Retriable)
            })
        };
        for (late, early) in [
            (Phase::Grip, Phase::Approach),
            (Phase::Release, Phase::PlaceApproach),
        ] {
            // The gripper had already done it when the arm was told to leave: done again, the arm would drive into the
            // load it put down, or with a load in its gripper to where that came from.
            if let Some(late) = begun(late)
                && self.has_gripped_as_planned(job, late)
            {
                self.step_to(job, late, StepState::Succeeded, "done before the arm left");
                continue;
            }
            let again = match (begun(late), begun(early)) {
                (Some(late), _) => {
                    let item = job.step(late).and_then(|s| s.plan.item);
                    let undo = job.step(late).is_some_and(|s| s.plan.undo);
                    let early = job.steps.iter().rposition(|s| {
                        s.plan.phase == early
                            && s.plan.item == item
                            && s.plan.undo == undo
                            && s.state != StepState::Dropped
                    });
                    vec![Some(late), early]
                }
                (None, early) => vec![early],
            };
            for step in again.into_iter().flatten() {
                self.emit(Fact::StepMoved {
                    job: job.id,
                    step,
                    to: StepState::Pending,
                    attempt: 0,
                    text: "the arm left the place".into(),
                });
            }
        }
    }

    /// Custody says that the load of a grip or release is where the step was to bring it.
    fn has_gripped_as_planned(&self, job: &Job, step: usize) -> bool {
        let Some((found, load)) = job
            .step(step)
            .zip(job.item_of(step).and_then(|(_, item)| item.load.as_ref()))
        else {
            return false;
        };
        let custody = &self.cell.book.custody;
        if found.plan.phase == Phase::Grip {
            let arm = job.arm.as_deref();
            return arm.is_some_and(|arm| custody.in_gripper(arm) == Some(load.as_str()));
        }
        let target = found.plan.place.as_ref();
        let target = target.and_then(|place| self.location_of(job, place));
        target.is_some() && custody.of(load) == target.as_ref()
    }
}

/// In words, for questions.
pub(crate) fn describe(action: &Action) -> String {
    match action {
        Action::Move {
            target: Target::ApproachOf { place },
            ..
        } => format!("the move before {place}"),
        Action::Move {
            target: Target::At { place },
            ..
        } => format!("the move to {place}"),
        Action::Move {
            target: Target::LiftOf { place },
            ..
        } => format!("the lift from {place}"),
        Action::Move {
            target: Target::Safe,
            ..
        } => "the move to the safe pose".into(),
        Action::Grip {
            action: GripAction::Close,
        } => "closing the gripper".into(),
        Action::Grip {
            action: GripAction::Open,
        } => "opening the gripper".into(),
        Action::Precheck { .. } => "the precheck".into(),
    }
}
