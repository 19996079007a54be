//! A fault that ends by itself, at any moment of both workflows: the job completes, and every load is where it belongs.

use super::usual::{m1, r1};
use super::world::{World, delivery, pickup};
use uuid::Uuid;
use workflow::{Answer, Command, Detail, Fault, JobState, MobileMode, NewJob, SignalKind};

/// Moments are this far apart: the tick of the world. While the mobile robot drives, little happens.
const APART_MS: u64 = 50;
const APART_DRIVING_MS: u64 = 1_000;

/// Runs the job once for each moment, with the fault there, until the job is over before the moment comes.
fn at_any_moment(name: &str, fault: impl Fn(&mut World, Uuid)) {
    for job_of in [delivery as fn() -> NewJob, pickup] {
        let mut moments = 0;
        let mut after = 0;
        loop {
            let mut w = World::new();
            let job = w.create(job_of());
            if w.run(after, |w| w.state(job) == JobState::Complete) {
                break;
            }
            moments += 1;
            let driving = w.mobiles["m1"].state.driving;
            fault(&mut w, job);
            let ok = w.run(400_000, |w| w.state(job) == JobState::Complete);
            assert!(
                ok,
                "{name} after {after} ms: {:?} {:?}\n{}",
                w.state(job),
                w.open_question(),
                w.story()
            );
            w.judge_custody();
            after += if driving { APART_DRIVING_MS } else { APART_MS };
        }
        assert!(moments > 50, "{moments} moments");
    }
}

/// Five seconds without a heartbeat: F12 while it is docked.
#[test]
fn f12_a_silence_at_any_moment_needs_nobody() {
    at_any_moment("a silence", |w, _job| {
        m1(w).beats = false;
        let _over = w.run(5_000, |_| false);
        m1(w).beats = true;
    });
}

/// Somebody turns its key to manual, and back.
#[test]
fn f13_manual_mode_at_any_moment_needs_nobody() {
    at_any_moment("manual mode", |w, _job| {
        m1(w).state.mode = MobileMode::Manual;
        w.say("m1", SignalKind::MrMode);
        let _over = w.run(5_000, |_| false);
        m1(w).state.mode = MobileMode::Automatic;
        w.say("m1", SignalKind::MrMode);
    });
}

/// A person presses hold and lets it go on.
#[test]
fn a_hold_at_any_moment_is_undone_by_unhold() {
    at_any_moment("hold", |w, job| {
        if w.command(job, Command::Hold).is_err() {
            return;
        }
        let _held = w.run(20_000, |w| w.state(job) == JobState::Held);
        let went_on = w.run(20_000, |w| w.state(job) != JobState::Held);
        if !went_on {
            let _reply = w.command(job, Command::Unhold).unwrap();
        }
    });
}

/// The link to the arm is away for three seconds: F8 if it moves.
#[test]
fn f8_a_lost_link_at_any_moment_needs_nobody() {
    at_any_moment("a lost link", |w, _job| {
        r1(w).link = false;
        let _over = w.run(3_000, |_| false);
        r1(w).link = true;
        let _found = w.run(10_000, |_| false);
        let open = w.open_question();
        if open.is_some_and(|q| q.question.fault == Fault::NoAnswer) {
            let _reply = w.answer(Answer::Replan, Detail::None);
        }
    });
}

/// Another arm of the same point is not heard for a while: nobody is permitted there, and then all goes on.
#[test]
fn f8_another_arm_of_the_point_that_is_not_heard_needs_nobody() {
    at_any_moment("another arm unheard", |w, _job| {
        w.arms.get_mut("r2").unwrap().link = false;
        let _over = w.run(3_000, |_| false);
        w.arms.get_mut("r2").unwrap().link = true;
    });
}
