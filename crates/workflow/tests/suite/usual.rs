//! What most tests say about a world: its first arm and mobile robot, a job of either workflow, how far that is.

use uuid::Uuid;
use workflow::{Command, JobState, Phase, Refusal, StepState, Workflow};

use super::world::{ArmTruth, MobileTruth, World, delivery, pickup};

pub(super) const A: Workflow = Workflow::DeliveryAndPlacement;
pub(super) const B: Workflow = Workflow::PickupAndDelivery;

pub(super) fn m1(w: &mut World) -> &mut MobileTruth {
    w.mobiles.get_mut("m1").unwrap()
}

pub(super) fn r1(w: &mut World) -> &mut ArmTruth {
    w.arms.get_mut("r1").unwrap()
}

/// A new job of this workflow.
pub(super) fn start(w: &mut World, which: Workflow) -> Uuid {
    w.create(if which == A { delivery() } else { pickup() })
}

/// Whether the job is at this phase.
pub(super) fn at(w: &World, job: Uuid, phase: Phase) -> bool {
    let steps = w.cell.job(w.now, job).unwrap().steps;
    steps
        .iter()
        .any(|step| step.phase == phase && step.state == StepState::Running)
}

pub(super) fn until_at(w: &mut World, job: Uuid, phase: Phase) {
    let ok = w.run(200_000, |w| at(w, job, phase));
    assert!(ok, "never at {phase:?}\n{}", w.story());
}

pub(super) fn until(w: &mut World, job: Uuid, state: JobState) {
    let ok = w.run(400_000, |w| w.state(job) == state);
    assert!(
        ok,
        "{:?} instead of {state:?}; {:?}\n{}",
        w.state(job),
        w.open_question(),
        w.story()
    );
}

/// There is no way around an open question: the job does not go on without its answer.
pub(super) fn assert_question_stands(w: &mut World, job: Uuid) {
    let went_on = w.command(job, Command::Unhold);
    assert!(matches!(went_on, Err(Refusal::Conflict { .. })));
}
