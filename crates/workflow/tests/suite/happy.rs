//! Both workflows without a fault.

use super::usual::m1;
use super::world::{World, delivery, fixed, item, pickup};
use workflow::{CompleteOn, JobState, Location};

#[test]
fn a_delivery_is_placed_and_the_mobile_robot_leaves() {
    let mut w = World::new();
    let job = w.create(delivery());
    w.complete(job);
    assert_eq!(w.loads["L1"], fixed("rack/a"));
    assert!(w.cell.claims().is_empty(), "{:?}", w.cell.claims());
    assert!(w.cell.sessions(w.now).iter().all(|s| s.state.is_closed()));
}

#[test]
fn a_job_in_the_queue_says_what_it_waits_for() {
    let mut w = World::new();
    let first = w.create(delivery());
    let second = w.create(delivery());
    let text = |w: &World| w.cell.job(w.now, second).unwrap().text;
    assert!(w.run(5_000, |w| w.state(first) != JobState::Idle));
    assert_eq!(text(&w), "another job has station/1");
    w.complete(first);
    assert!(w.run(20_000, |w| w.cell.claims().is_empty()));
    // The load the second one names was brought already, and is where the second one is to put it.
    assert_eq!(text(&w), "m1 does not have L1 in s1");
}

#[test]
fn two_items_are_placed_one_after_the_other() {
    let mut w = World::new();
    let mut job = delivery();
    job.items.push(item(Some("L2"), "s2", "rack/b"));
    let job = w.create(job);
    w.complete(job);
    assert_eq!(w.loads["L2"], fixed("rack/b"));
}

#[test]
fn an_early_release_lets_the_mobile_robot_go_before_the_load_is_placed() {
    let mut w = World::new();
    let mut job = delivery();
    job.early_release = true;
    let job = w.create(job);
    // It drives out while the load is still in the gripper.
    assert!(w.run(60_000, |w| {
        w.mobiles["m1"].state.driving
            && w.mobiles["m1"]
                .got
                .contains(&workflow::Message::TransferDone)
            && w.arms["r1"].holds.is_some()
    }));
    w.complete(job);
    assert!(w.run(20_000, |w| w.cell.claims().is_empty()));
}

#[test]
fn a_pickup_ends_at_its_destination() {
    let mut w = World::new();
    let job = w.create(pickup());
    w.complete(job);
    assert_eq!(
        w.loads["P1"],
        Location::Delivered {
            destination: "warehouse".into()
        }
    );
    assert_eq!(
        w.cell
            .custody()
            .iter()
            .find(|l| l.id == "P1")
            .unwrap()
            .load
            .location,
        Location::Delivered {
            destination: "warehouse".into()
        }
    );
}

#[test]
fn a_prefetched_load_waits_in_the_gripper() {
    let mut w = World::new();
    let mut job = pickup();
    job.prefetch = true;
    job.items.push(item(Some("P2"), "s1", "rack/d"));
    job.mobile_robot = None;
    job.complete_on = CompleteOn::Departed;
    w.mobiles.get_mut("m2").unwrap().arrives = false;
    let id = w.create(job);
    assert!(w.run(20_000, |w| w.arms["r1"].holds.is_some()
        && w.arms["r1"].moving.is_none()));
    w.mobiles.get_mut("m2").unwrap().arrives = true;
    assert_eq!(
        w.cell.job(w.now, id).unwrap().mobile_robot.as_deref(),
        Some("m2")
    );
    let ok = w.run(700_000, |w| w.state(id) == JobState::Complete);
    assert!(ok, "{}", w.story());
}

#[test]
fn two_arms_and_two_mobile_robots_take_turns_at_one_point() {
    let mut w = World::new();
    let mut second = pickup();
    (second.arm, second.mobile_robot) = (Some("r2".into()), Some("m2".into()));
    second.priority = 5;
    let jobs = [
        w.create(delivery()),
        w.create(second),
        w.create({
            let mut third = delivery();
            third.items = vec![item(Some("L2"), "s2", "rack/b")];
            (third.arm, third.priority) = (None, 9);
            third
        }),
    ];
    assert_eq!(w.cell.queue(), [jobs[2], jobs[1]], "by priority");
    for job in jobs {
        let ok = w.run(300_000, |w| w.state(job) == JobState::Complete);
        assert!(ok, "{:?}\n{}", w.state(job), w.story());
    }
    w.judge_custody();
}

#[test]
fn a_job_that_could_not_start_in_time_is_stopped() {
    let mut w = World::new();
    let first = w.create(delivery());
    let mut late = delivery();
    late.items = vec![item(Some("L2"), "s2", "rack/b")];
    late.deadline = Some(w.now + 3_000);
    let late = w.create(late);
    assert!(w.run(10_000, |w| w.state(late) == JobState::Stopped));
    assert_eq!(
        w.cell.job(w.now, late).unwrap().why,
        workflow::Why::DeadlinePassed
    );
    w.complete(first);
}

#[test]
fn a_signal_at_a_configured_point_starts_a_job() {
    let mut setup = super::world::setup();
    setup.triggers.push(workflow::Trigger {
        id: "unload".into(),
        enabled: true,
        signal: workflow::SignalKind::MrReady,
        mobile_robot: None,
        points: vec![super::world::POINT.into()],
        deadline_ms: Some(600_000),
        job: delivery(),
    });
    let mut w = World::with(setup, 1, super::world::Odds::default());
    let m = m1(&mut w);
    m.state.at_point = Some(super::world::POINT.into());
    w.say("m1", workflow::SignalKind::MrReady);
    m1(&mut w).state.at_point = None;
    assert!(
        w.run(2_000, |w| !w.cell.jobs(w.now).is_empty()),
        "{:?}",
        w.answers
    );
    let job = w.cell.jobs(w.now)[0].clone();
    assert_eq!(job.trigger.as_deref(), Some("unload"));
    w.complete(job.id);
}

#[test]
fn parameters_are_refused_by_the_name_of_the_item() {
    let mut w = World::new();
    let cases: [(fn(&mut workflow::NewJob), &str); 7] = [
        (|j| j.point = "nowhere".into(), "point"),
        (|j| j.items.clear(), "items"),
        (|j| j.max_attempts = 0, "max_attempts"),
        (|j| j.items[0].place = "rack/z".into(), "items[0].place"),
        (|j| j.items[0].mr_slot = "s9".into(), "items[0].mr_slot"),
        (|j| j.prefetch = true, "prefetch"),
        (|j| j.deadline = Some(1), "deadline"),
    ];
    for (change, item) in cases {
        let mut job = delivery();
        change(&mut job);
        match w.input(workflow::Input::CreateJob { job: Box::new(job) }) {
            Err(workflow::Refusal::Invalid { item: named, .. }) => assert_eq!(named, item),
            other => panic!("{item}: {other:?}"),
        }
    }
}
