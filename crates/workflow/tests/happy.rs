//! Both workflows without a fault.

mod world;

use workflow::{CompleteOn, JobState, Location};
use world::{World, delivery, item, pickup};

#[test]
fn a_delivery_is_placed_and_the_mobile_robot_leaves() {
    let mut w = World::new();
    let job = w.create(delivery());
    w.complete(job);
    assert_eq!(w.loads["L1"], Location::Fixed { place: "rack/a".into() });
    assert!(w.cell.claims().is_empty(), "{:?}", w.cell.claims());
    assert!(w.cell.sessions(w.now).iter().all(|s| s.state.is_closed()));
}

#[test]
fn two_items_are_placed_one_after_the_other() {
    let mut w = World::new();
    let mut job = delivery();
    job.items.push(item(Some("L2"), "s2", "rack/b"));
    let job = w.create(job);
    w.complete(job);
    assert_eq!(w.loads["L2"], Location::Fixed { place: "rack/b".into() });
}

#[test]
fn an_early_release_lets_the_mobile_robot_go_before_the_load_is_placed() {
    let mut w = World::new();
    let mut job = delivery();
    job.early_release = true;
    let job = w.create(job);
    // It drives out while the load is still in the gripper.
    assert!(w.run(60_000, |w| w.mobiles["m1"].state.driving
        && w.mobiles["m1"].got.contains(&workflow::Message::TransferDone)
        && w.arms["r1"].holds.is_some()));
    w.complete(job);
    assert!(w.run(20_000, |w| w.cell.claims().is_empty()));
}

#[test]
fn a_pickup_ends_at_its_destination() {
    let mut w = World::new();
    let job = w.create(pickup());
    w.complete(job);
    assert_eq!(w.loads["P1"], Location::Delivered { destination: "warehouse".into() });
    assert_eq!(
        w.cell.custody().iter().find(|l| l.id == "P1").unwrap().load.location,
        Location::Delivered { destination: "warehouse".into() }
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
    assert!(w.run(20_000, |w| w.arms["r1"].holds.is_some() && w.arms["r1"].moving.is_none()));
    w.mobiles.get_mut("m2").unwrap().arrives = true;
    assert_eq!(w.cell.job(w.now, id).unwrap().mobile_robot.as_deref(), Some("m2"));
    let ok = w.run(700_000, |w| w.state(id) == JobState::Complete);
    assert!(ok, "{}", w.story());
}
