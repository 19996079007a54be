//! What is counted, forgotten, taken elsewhere and kept closed: one row of a table each.

use super::usual::{m1, r1};
use super::world::{World, delivery, item, pickup, setup};
use uuid::Uuid;
use workflow::{
    Answer, Cell, Command, CountingIds, Definition, Detail, Evidence, Fact, Fault, Input, JobState,
    Location, Message, Permit, SignalKind, Workflow,
};

fn permit(w: &World) -> Permit {
    let permits = w.cell.permits();
    permits
        .iter()
        .map(|(_, permit)| *permit)
        .find(|permit| *permit != Permit::None)
        .unwrap_or(Permit::None)
}

/// Jobs count on by one, whatever hand-overs and questions there were meanwhile.
#[test]
fn jobs_have_numbers_without_gaps() {
    let mut w = World::new();
    m1(&mut w).acks = false;
    let first = w.create(delivery());
    assert!(w.run(400_000, |w| w.open_question().is_some()));
    m1(&mut w).acks = true;
    let _reply = w.answer(Answer::Retry, Detail::None).unwrap();
    w.complete(first);
    let mut second = delivery();
    second.items = vec![item(Some("L2"), "s2", "rack/b")];
    let second = w.create(second);
    w.complete(second);
    w.crash();
    let numbers: Vec<_> = w.cell.jobs(w.now).iter().map(|job| job.number).collect();
    assert_eq!(numbers, [1, 2]);
}

fn at(cell: &Cell, load: &str) -> Option<Location> {
    let custody = cell.custody();
    let found = custody.into_iter().find(|known| known.id == load);
    found.map(|known| known.load.location)
}

fn delivered(load: &str) -> Fact {
    Fact::CustodyMoved {
        load: load.into(),
        to: Location::Delivered {
            destination: "warehouse".into(),
        },
        by: Evidence::MobileRobot {
            mobile_robot: "m1".into(),
        },
    }
}

/// A cell that delivers for years does not keep every load it ever saw; what the set-up names stays, so that its next
/// change does not bring it back to where it was at first.
#[test]
fn delivered_loads_are_forgotten_after_a_while_and_those_of_the_set_up_with_it() {
    let mut cell = Cell::new(setup());
    cell.replay(&delivered("P1"));
    for n in 0..1_000 {
        let load = format!("box-{n}");
        cell.replay(&Fact::LoadRegistered {
            load: load.clone(),
            kind: "box".into(),
            location: Location::MobileRobot {
                mobile_robot: "m1".into(),
                slot: "s3".into(),
            },
        });
        cell.replay(&delivered(&load));
    }
    let known = cell.custody();
    let boxes = known.iter().filter(|load| load.id.starts_with("box-"));
    assert_eq!(boxes.count(), 256);
    assert!(at(&cell, "box-999").is_some() && at(&cell, "box-0").is_none());
    assert!(at(&cell, "P1").is_some(), "the set-up names it");
    let named = setup();
    cell.replay(&Fact::SetupChanged {
        setup: Box::new(named.clone()),
    });
    let gone = Location::Delivered {
        destination: "warehouse".into(),
    };
    assert_eq!(at(&cell, "P1"), Some(gone));
    let mut without = named;
    without.loads.retain(|load| load.id != "P1");
    cell.replay(&Fact::SetupChanged {
        setup: Box::new(without),
    });
    assert_eq!(at(&cell, "P1"), None);
}

/// F6 in the pickup: the arm cannot reach the slot, so the load goes into another one of the same mobile robot.
#[test]
fn f06_another_slot_is_taken_where_the_first_cannot_be_reached_b() {
    let mut w = World::new();
    // L1 and L2 are in the first two slots: nothing else is free.
    let _new = r1(&mut w).blocked.insert("s3 at station/1".into());
    let job = w.create(pickup());
    assert!(w.run(400_000, |w| w.state(job) == JobState::Stopped));
    assert!(w.mobiles["m1"].got.is_empty(), "nobody was called");

    let mut setup = setup();
    setup.loads.retain(|load| load.id != "L2");
    let mut w = World::with(setup, 1, super::world::Odds::default());
    let _new = r1(&mut w).blocked.insert("s3 at station/1".into());
    let job = w.create(pickup());
    assert!(
        w.run(60_000, |w| w.state(job) != JobState::Idle
            && w.cell.job(w.now, job).unwrap().items[0].slot == "s2"),
        "{}",
        w.story()
    );
    w.complete(job);
    w.judge_custody();
    // Where none can be reached each is tried once, and the job stops.
    let mut w = World::with(
        {
            let mut setup = super::world::setup();
            setup.loads.retain(|load| !load.id.starts_with('L'));
            setup
        },
        1,
        super::world::Odds::default(),
    );
    for slot in ["s1", "s2", "s3"] {
        let blocked = &mut r1(&mut w).blocked;
        let _new = blocked.insert(format!("{slot} at station/1"));
    }
    let job = w.create(pickup());
    assert!(w.run(400_000, |w| w.state(job) == JobState::Stopped));
    let faults = w.cell.job(w.now, job).unwrap().faults;
    let said = faults.iter().filter(|f| f.fault == Fault::Unreachable);
    assert_eq!(said.count(), 3, "{faults:?}");
}

/// F8, and the mobile robot drops its order meanwhile: going on is of no use, only a new order is.
#[test]
fn f08_an_order_that_was_dropped_while_the_arm_was_away_is_given_anew() {
    let mut w = World::new();
    let job = w.create(delivery());
    assert!(w.run(60_000, |w| permit(w) == Permit::ArmEntry));
    r1(&mut w).link = false;
    assert!(w.run(60_000, |w| matches!(
        w.state(job),
        JobState::Suspending | JobState::Suspended
    )));
    let m = m1(&mut w);
    m.state.order = None;
    m.plan.clear();
    w.say("m1", SignalKind::MrHeartbeat);
    r1(&mut w).link = true;
    let orders = |w: &World| {
        let got = w.mobiles["m1"].got.iter();
        got.filter(|m| matches!(m, Message::TransportOrder { .. }))
            .count()
    };
    let before = orders(&w);
    // Nobody is needed: the arm leaves the zone, and the mobile robot is called anew.
    assert!(w.run(400_000, |w| orders(w) > before), "{}", w.story());
    w.complete(job);
    let faults = w.cell.job(w.now, job).unwrap().faults;
    for fault in [Fault::NoAnswer, Fault::ModeChanged] {
        assert!(faults.iter().any(|f| f.fault == fault), "{faults:?}");
    }
}

/// M6: an aborted job is cleared, its arm still stands in the zone and its mobile robot at the point. Nobody is let in
/// before both are out, whoever asks.
#[test]
fn m6_after_an_abort_the_zone_stays_closed_until_both_are_out() {
    let mut w = World::new();
    let job = w.create(delivery());
    assert!(w.run(60_000, |w| w.arm_inside(&w.arms["r1"])
        && w.arms["r1"].moving.is_none()));
    m1(&mut w).leaves = false;
    let _reply = w.command(job, Command::Abort).unwrap();
    assert!(w.run(60_000, |w| w.state(job) == JobState::Aborted));
    let mut second = pickup();
    second.mobile_robot = Some("m2".into());
    second.arm = Some("r2".into());
    let second = w.create(second);
    let closed = |w: &mut World, why: &str| {
        let opened = w.run(120_000, |w| permit(w) != Permit::None);
        let inside = w.arm_inside(&w.arms["r1"]);
        assert!(!opened, "{why}; the arm is inside: {inside}\n{}", w.story());
        assert_eq!(w.state(second), JobState::Idle, "{why}");
    };
    closed(&mut w, "the job is aborted");
    let _reply = w.command(job, Command::Clear).unwrap();
    assert!(w.run(60_000, |w| w.state(job) == JobState::Stopped));
    assert!(w.arm_inside(&w.arms["r1"]), "nothing moves by itself");
    // The arm is inside: the mobile robot at the point may not drive under it, and no other is called.
    closed(&mut w, "the arm is in the zone");
    // A person says that the mobile robot is away. The arm is still there.
    assert!(w.run(900_000, |w| w.open_question().is_some()));
    assert!(w.arm_inside(&w.arms["r1"]));
    let _reply = w.answer(Answer::OperatorMoved, Detail::None).unwrap();
    let entered = w.run(200_000, |w| permit(w) != Permit::None);
    assert!(!entered, "an arm is in the zone\n{}", w.story());
    // And drives it out by hand.
    r1(&mut w).at = Some(workflow::Target::Safe);
    assert!(
        w.run(900_000, |w| permit(w) == Permit::MrMove),
        "{}",
        w.story()
    );
}

/// The facts of a job in the middle of its course, as a program of another version would have left them.
fn planned_by(version: u32) -> (World, Uuid) {
    let mut w = World::new();
    let job = w.create(delivery());
    assert!(w.run(60_000, |w| w.arm_inside(&w.arms["r1"])));
    for fact in &mut w.journal {
        if let Fact::Planned {
            definition: Some(definition),
            ..
        } = fact
        {
            definition.version = version;
        }
    }
    (w, job)
}

/// P15: the program was replaced in the middle of a job by one in which a step may mean something else.
#[test]
fn p15_a_job_of_another_version_is_held_and_both_are_named() {
    let now = Definition::of(Workflow::DeliveryAndPlacement);
    for (answer, end) in [
        (Answer::Resume, JobState::Complete),
        (Answer::Cancel, JobState::Stopped),
    ] {
        let (mut w, job) = planned_by(now.version + 1);
        let mut cell = Cell::new(setup());
        for fact in &w.journal {
            cell.replay(fact);
        }
        w.cell = cell;
        w.crash();
        let question = w.open_question().unwrap().question;
        let then = Definition {
            version: now.version + 1,
            ..now.clone()
        };
        for named in [then.to_string(), now.to_string()] {
            assert!(question.question.contains(&named), "{}", question.question);
        }
        let moved = w.run(60_000, |w| {
            w.arms["r1"].moving.is_some() && w.state(job) == JobState::Held
        });
        assert!(!moved, "{}", w.story());
        assert_eq!(w.state(job), JobState::Held);
        let _reply = w.answer(answer, Detail::None).unwrap();
        assert!(
            w.run(900_000, |w| w.state(job) == end),
            "{:?} {:?}\n{}",
            w.state(job),
            w.open_question(),
            w.story()
        );
        // It is asked once: what was accepted is kept.
        let before = w.asked.len();
        w.crash();
        assert_eq!(w.asked.len(), before);
    }
    let (mut w, job) = planned_by(now.version);
    w.crash();
    w.complete(job);
    assert!(w.asked.is_empty(), "the same version asks nothing");
}

/// A plan of a program that did not say what it was made by goes on as before.
#[test]
fn p15_an_old_plan_without_a_version_is_read() {
    let text =
        r#"{"fact":"planned","job":"00000000-0000-0000-0000-000000000001","steps":[],"drop":[]}"#;
    let fact: Fact = serde_json::from_str(text).unwrap();
    assert_eq!(serde_json::to_string(&fact).unwrap(), text);
    let mut cell = Cell::new(setup());
    cell.replay(&fact);
    let decision = cell.decide(0, Input::Recover, &mut CountingIds::default());
    assert!(decision.is_ok());
}
