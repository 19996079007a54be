//! Whole jobs in the workflows' own little world, told and added up.

#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::wildcard_enum_match_arm,
    clippy::panic,
    clippy::too_many_lines,
    clippy::struct_excessive_bools,
    clippy::type_complexity,
    clippy::enum_glob_use,
    clippy::manual_is_multiple_of,
    clippy::match_same_arms,
    clippy::pedantic,
    unused_results,
    unreachable_pub,
    reason = "a test stops where it is wrong, and the world is the workflows' own"
)]

#[path = "../../../crates/workflow/tests/suite/world/mod.rs"]
mod world;

use std::cell::RefCell;
use std::time::Duration;

use api::{JobReport, PhaseKind};
use jiff::Timestamp;
use journal::{Clocks, Epoch, Position};
use uuid::Uuid;
use workflow::{Answer, Command, Detail, JobState};
use world::{World, delivery, item, pickup};

use super::story::{Chapter, History, Picker};
use super::{events, remembered, report};

/// The journal of a world: what was kept at each moment, as one record.
#[derive(Default)]
struct Kept {
    seen: usize,
    chapters: Vec<Chapter>,
}

impl Kept {
    fn look(&mut self, world: &World) {
        let new = &world.journal[self.seen..];
        if new.is_empty() {
            return;
        }
        self.seen = world.journal.len();
        self.chapters.push(Chapter {
            position: Position(self.chapters.len() as u64 + 1),
            epoch: Epoch(u64::from(world.crashes) + 1),
            at: Clocks {
                wall: Timestamp::from_millisecond(world.now as i64).unwrap(),
                monotonic: Duration::from_millis(world.now),
            },
            facts: new.iter().cloned().enumerate().collect(),
        });
    }

    fn of(&self, job: Uuid) -> History {
        let mut picker = Picker::new(job);
        History {
            job,
            chapters: self
                .chapters
                .iter()
                .filter_map(|chapter| picker.pick(chapter.clone()))
                .collect(),
        }
    }
}

/// Runs a world until a job is in a state, and keeps what happens.
fn run(world: &mut World, kept: &mut Kept, what: &str, done: impl Fn(&World) -> bool) {
    kept.look(world);
    let kept = RefCell::new(kept);
    let ok = world.run(900_000, |world| {
        kept.borrow_mut().look(world);
        done(world)
    });
    assert!(ok, "never {what}\n{}", world.story());
    kept.borrow_mut().look(world);
}

fn report_of(world: &World, history: &History) -> JobReport {
    let now = Timestamp::from_millisecond(world.now as i64).unwrap();
    let report = report("c1", history, (now, Epoch(u64::from(world.crashes) + 1)));
    assert_eq!(report.queued_ms + report.cycle_ms, report.total_ms);
    let states: u64 = report.states.iter().map(|state| state.duration_ms).sum();
    assert_eq!(states, report.total_ms, "{:?}", report.states);
    for phase in &report.phases {
        assert!(!phase.code.is_empty() && !phase.attempts.is_empty());
        assert!(
            phase.begin_ms + phase.duration_ms <= report.total_ms,
            "{phase:?}"
        );
        for pair in phase.attempts.windows(2) {
            assert!(pair[0].begin_ms + pair[0].duration_ms <= pair[1].begin_ms);
        }
    }
    report
}

/// A delivery from its creation to its end.
#[test]
fn a_delivery_is_told_in_order_and_its_phases_are_added_up() {
    let mut world = World::new();
    let mut kept = Kept::default();
    let job = world.create(delivery());
    run(&mut world, &mut kept, "complete", |w| {
        w.state(job) == JobState::Complete
    });
    let history = kept.of(job);
    let events = events(&history);
    assert_eq!(events[0].kind, "job_created");
    assert!(
        events
            .iter()
            .all(|event| !event.text.is_empty() && !event.kind.is_empty())
    );
    assert!(
        events
            .windows(2)
            .all(|pair| pair[0].since_ms <= pair[1].since_ms)
    );
    let text = |part: &str| events.iter().position(|event| event.text.contains(part));
    let order = [
        "claimed: ",
        "A2 precheck: RUNNING",
        "every pose can be reached",
        "to m1: TRANSPORT_ORDER",
        "m1 says MR_ARRIVED",
        "session TRANSFERRING",
        "close the gripper",
        "in the gripper of r1",
        "A13 release (rack/a): SUCCEEDED",
        "COMPLETE",
    ];
    let places: Vec<_> = order.iter().map(|part| text(part)).collect();
    assert!(
        places.iter().all(Option::is_some),
        "{places:?}\n{events:#?}"
    );
    assert!(
        places.windows(2).all(|pair| pair[0] <= pair[1]),
        "{places:?}"
    );

    let report = report_of(&world, &history);
    assert_eq!(report.state, api::JobState::Complete);
    assert!(report.ended_at.is_some());
    let codes: Vec<_> = report.phases.iter().map(|phase| &*phase.code).collect();
    let first: Vec<_> = ["A1", "A2", "A3", "A4", "A5"].into();
    assert_eq!(codes[..5], first[..], "{codes:?}");
    for code in ["A8", "A9", "A10", "A12", "A13", "A14", "A15", "A16"] {
        let phase = report.phases.iter().find(|phase| phase.code == code);
        let phase = phase.unwrap_or_else(|| panic!("{code} is missing of {codes:?}"));
        assert_eq!(phase.end.as_deref(), Some("SUCCEEDED"), "{phase:?}");
        assert_eq!(phase.attempts.len(), 1, "{phase:?}");
    }
    let arm: u64 = report
        .phases
        .iter()
        .filter(|phase| phase.kind == PhaseKind::Arm)
        .map(|phase| phase.duration_ms)
        .sum();
    assert!(arm > 0 && arm < report.cycle_ms);
    assert_eq!(report.restarts, 0);
}

/// A job the cell has forgotten is shown as its story leaves it.
#[test]
fn a_job_is_shown_from_its_story_as_the_cell_shows_it() {
    let mut world = World::new();
    let mut kept = Kept::default();
    let job = world.create(pickup());
    run(&mut world, &mut kept, "complete", |w| {
        w.state(job) == JobState::Complete
    });
    let told = remembered(&kept.of(job)).unwrap();
    let known = world.cell.job(0, job).unwrap();
    assert_eq!(told.state, known.state);
    assert_eq!(told.spec, known.spec);
    assert_eq!(told.items, known.items);
    let ends = |view: &workflow::view::JobView| -> Vec<_> {
        view.steps
            .iter()
            .map(|step| (step.phase, step.state))
            .collect()
    };
    assert_eq!(ends(&told), ends(&known));
    assert_eq!((told.arm, told.session), (known.arm, known.session));
}

/// A grip that fails is an attempt of its phase, and a fault.
#[test]
fn a_grip_that_was_repeated_is_two_attempts_and_a_fault() {
    let mut world = World::new();
    world.arms.get_mut("r1").unwrap().grip_fails = 1;
    let mut kept = Kept::default();
    let job = world.create(delivery());
    run(&mut world, &mut kept, "complete", |w| {
        w.state(job) == JobState::Complete
    });
    let report = report_of(&world, &kept.of(job));
    assert!(
        report.faults.iter().any(|fault| fault.fault.code == "F9"),
        "{:?}",
        report.faults
    );
    let repeated = report
        .phases
        .iter()
        .filter(|phase| matches!(&*phase.code, "A8" | "A9") && phase.attempts.len() > 1);
    assert!(repeated.count() > 0, "{:#?}", report.phases);
}

/// Two jobs at once: each story has its own facts only.
#[test]
fn the_stories_of_two_jobs_are_not_mixed() {
    let mut world = World::new();
    let mut kept = Kept::default();
    let first = world.create(delivery());
    let mut other = delivery();
    other.items = vec![item(Some("L2"), "s2", "rack/b")];
    let second = world.create(other);
    run(&mut world, &mut kept, "both complete", |w| {
        [first, second]
            .iter()
            .all(|job| w.state(*job) == JobState::Complete)
    });
    for (job, load, no) in [(first, "L1", "L2"), (second, "L2", "L1")] {
        let events = events(&kept.of(job));
        let about = |load: &str| {
            let moved = format!("load {load} is");
            events
                .iter()
                .filter(|event| event.text.contains(&moved))
                .count()
        };
        assert_eq!((about(load), about(no)), (2, 0), "{events:#?}");
        let report = report_of(&world, &kept.of(job));
        assert_eq!(
            report
                .phases
                .iter()
                .filter(|phase| phase.code == "A9")
                .count(),
            1
        );
    }
}

/// What people command and answer is in the report, with how long the question was open.
#[test]
fn decisions_and_restarts_are_reported() {
    let mut world = World::new();
    let mut kept = Kept::default();
    let job = world.create(delivery());
    run(&mut world, &mut kept, "in the gripper", |w| {
        w.arms["r1"].holds.is_some()
    });
    world.command(job, Command::Hold).unwrap();
    run(&mut world, &mut kept, "held", |w| {
        w.state(job) == JobState::Held
    });
    world.crash();
    run(&mut world, &mut kept, "recovered", |w| {
        w.state(job) != JobState::Unholding
    });
    let mut asked = None;
    for _ in 0..20 {
        if let Some(question) = world.open_question() {
            asked = Some(question.question.id);
            let answers: Vec<_> = question.allowed.iter().map(|one| one.answer).collect();
            let answer = [Answer::Resume, Answer::Retry, Answer::Replan]
                .into_iter()
                .find(|answer| answers.contains(answer));
            let _tried = world.answer(answer.unwrap_or(answers[0]), Detail::None);
        } else if world.state(job) == JobState::Held {
            let _tried = world.command(job, Command::Unhold);
        }
        kept.look(&world);
        let until = world.now + 30_000;
        run(&mut world, &mut kept, "later", |w| {
            w.now >= until || w.state(job) == JobState::Complete
        });
        if world.state(job) == JobState::Complete {
            break;
        }
    }
    assert_eq!(world.state(job), JobState::Complete, "{}", world.story());
    let report = report_of(&world, &kept.of(job));
    assert_eq!(report.restarts, 1);
    let who = &report.decisions[0];
    assert_eq!(who.decision, "HOLDING", "{:?}", report.decisions);
    assert!(!who.principal.is_empty() && !who.reason.is_empty());
    if let Some(asked) = asked {
        let answered = report
            .decisions
            .iter()
            .find(|one| one.intervention == Some(asked));
        assert!(
            answered.is_some_and(|one| one.open_ms.is_some()),
            "{:?}",
            report.decisions
        );
    }
}
