//! C10: a human has the arm between two steps of a job. Nothing goes on by itself, nor along a line from there.

use super::usual::{A, B, assert_question_stands, r1, start, until_at};
use super::world::World;
use uuid::Uuid;
use workflow::{Answer, Command, Detail, Fault, JobState, Phase, Refusal, Workflow};

/// Holds the job while it is at `phase`, so that the arm stands between two of its motions.
fn between(which: Workflow, phase: Phase) -> (World, Uuid) {
    let mut w = World::new();
    let job = start(&mut w, which);
    until_at(&mut w, job, phase);
    let _reply = w.command(job, Command::Hold).unwrap();
    assert!(w.run(60_000, |w| w.state(job) == JobState::Held));
    assert!(w.open_question().is_none(), "{}", w.story());
    (w, job)
}

/// The pendant is enabled, the arm is moved, and it is AUTO again.
fn jog(w: &mut World) {
    pendant(w, true);
    r1(w).displaced = true;
    let _never = w.run(1_000, |_| false);
    pendant(w, false);
}

fn pendant(w: &mut World, on: bool) {
    let arm = r1(w);
    (arm.manual, arm.ready) = (on, !on);
    let _never = w.run(1_000, |_| false);
}

fn asked_of(w: &World) -> usize {
    w.arms["r1"].asked.len()
}

/// Asked, held, and nothing moves however long it takes.
fn assert_waits(w: &mut World, job: Uuid) {
    let question = w.open_question().unwrap_or_else(|| panic!("{}", w.story()));
    assert_eq!(question.question.fault, Fault::ControlLost, "{}", w.story());
    assert_eq!(w.state(job), JobState::Held, "{}", w.story());
    let before = asked_of(w);
    let _never = w.run(60_000, |_| false);
    assert_eq!(asked_of(w), before, "it moved by itself\n{}", w.story());
}

fn phases(which: Workflow) -> Vec<Phase> {
    let mut all = vec![
        Phase::Grip,
        Phase::LiftClear,
        Phase::PlaceApproach,
        Phase::Release,
        Phase::Retreat,
    ];
    if which == A {
        // A pickup is at its first step before it has moved the arm at all.
        all.push(Phase::Approach);
    }
    all
}

fn jogged(which: Workflow) {
    for phase in phases(which) {
        let (mut w, job) = between(which, phase);
        jog(&mut w);
        if w.open_question().is_none() {
            // It had not moved the arm yet: where the arm stands is where the job begins.
            assert_eq!(phase, Phase::Approach, "{}", w.story());
            continue;
        }
        assert_waits(&mut w, job);
        assert_question_stands(&mut w, job);
        // The world itself judges the first motion: joint by joint to the safe pose.
        let _reply = w.answer(Answer::Replan, Detail::None).unwrap();
        w.complete(job);
    }
}

#[test]
fn c10_a_jogged_arm_begins_its_step_anew_from_the_safe_pose_a() {
    jogged(A);
}

#[test]
fn c10_a_jogged_arm_begins_its_step_anew_from_the_safe_pose_b() {
    jogged(B);
}

fn pendant_only(which: Workflow) {
    for phase in phases(which) {
        let mut w = World::new();
        let job = start(&mut w, which);
        until_at(&mut w, job, phase);
        pendant(&mut w, true);
        let _motion_ends = w.run(2_000, |_| false);
        pendant(&mut w, false);
        if w.open_question().is_none() && phase == Phase::Approach {
            continue;
        }
        assert_waits(&mut w, job);
        let _reply = w.answer(Answer::Replan, Detail::None).unwrap();
        w.complete(job);
    }
}

#[test]
fn c10_back_in_auto_nothing_goes_on_by_itself_a() {
    pendant_only(A);
}

#[test]
fn c10_back_in_auto_nothing_goes_on_by_itself_b() {
    pendant_only(B);
}

#[test]
fn c10_an_answer_given_at_the_pendant_is_refused() {
    let (mut w, job) = between(A, Phase::PlaceApproach);
    pendant(&mut w, true);
    let refused = w.answer(Answer::Replan, Detail::None);
    assert!(
        matches!(refused, Err(Refusal::Conflict { .. })),
        "{refused:?}"
    );
    pendant(&mut w, false);
    let _reply = w.answer(Answer::Replan, Detail::None).unwrap();
    w.complete(job);
}

#[test]
fn c10_the_pendant_again_asks_again() {
    let (mut w, job) = between(B, Phase::Release);
    jog(&mut w);
    let first = w.open_question().unwrap();
    let _reply = w.answer(Answer::Replan, Detail::None).unwrap();
    // The way out has begun: the pendant stops nothing that the world does not stop, but what comes next waits.
    pendant(&mut w, true);
    let _motion_ends = w.run(5_000, |_| false);
    pendant(&mut w, false);
    let second = w.open_question().unwrap_or_else(|| panic!("{}", w.story()));
    assert_ne!(first.number, second.number);
    assert_waits(&mut w, job);
    let _reply = w.answer(Answer::Replan, Detail::None).unwrap();
    w.complete(job);
}

fn canceled(which: Workflow) {
    for phase in [Phase::LiftClear, Phase::PlaceApproach, Phase::Release] {
        let (mut w, job) = between(which, phase);
        jog(&mut w);
        let _reply = w.answer(Answer::Cancel, Detail::None).unwrap();
        let ended = |w: &World| {
            w.state(job) == JobState::Stopped
                || w.open_question()
                    .is_some_and(|q| q.question.fault != Fault::ControlLost)
        };
        assert!(w.run(400_000, ended), "{phase:?}\n{}", w.story());
    }
}

#[test]
fn c10_a_canceled_job_leaves_by_the_safe_pose_a() {
    canceled(A);
}

#[test]
fn c10_a_canceled_job_leaves_by_the_safe_pose_b() {
    canceled(B);
}

#[test]
fn c10_a_stopped_job_asks_before_it_undoes_anything() {
    let (mut w, job) = between(A, Phase::LiftClear);
    jog(&mut w);
    let before = asked_of(&w);
    let _reply = w.command(job, Command::Stop).unwrap();
    let _never = w.run(20_000, |_| false);
    assert_eq!(asked_of(&w), before, "{}", w.story());
    let asked = w.open_question().unwrap();
    if asked.question.fault == Fault::ControlLost {
        assert!(!asked.question.answers.contains(&Answer::Cancel));
        let _reply = w.answer(Answer::Replan, Detail::None).unwrap();
        let on = w.run(60_000, |w| asked_of(w) > before);
        assert!(on, "{}", w.story());
    }
}

#[test]
fn c10_what_a_hand_did_outlives_a_restart() {
    let (mut w, job) = between(A, Phase::LiftClear);
    jog(&mut w);
    w.crash();
    let _never = w.run(5_000, |_| false);
    assert_waits(&mut w, job);
    let _reply = w.answer(Answer::Replan, Detail::None).unwrap();
    w.complete(job);
}

#[test]
fn c10_an_arm_that_was_jogged_before_the_job_moved_it_is_no_question() {
    let mut w = World::new();
    let job = start(&mut w, A);
    r1(&mut w).manual = true;
    let _never = w.run(2_000, |_| false);
    assert!(w.open_question().is_none(), "{}", w.story());
    r1(&mut w).manual = false;
    w.complete(job);
}
