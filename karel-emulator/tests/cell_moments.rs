//! A stop, a fence, a hold or a power failure at every moment of a command, on a processor so slow that each moment is
//! a few statements long.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a helper that fails stops its test"
)]

mod common;

use std::time::Duration;

use common::wire::{joints, sealed};
use common::world::{COMMANDS, STATUS, World};
use karel_emulator::LedgerEvent;

const THERE: [f64; 6] = [20.0, 10.0, -10.0, 5.0, -60.0, 15.0];

/// A command takes about a tenth of a second then, far less than its nonce lives.
const INSTRUCTIONS_PER_MS: u32 = 60;
const MOMENTS: u64 = 160;

fn ms(count: u64) -> Duration {
    Duration::from_millis(count)
}

/// A command under way for `moment` ms, and a status client that is connected.
fn at_moment(moment: u64) -> World {
    let mut world = World::new(INSTRUCTIONS_PER_MS);
    world.pass(ms(100));
    world.connect(STATUS);
    world.connect(COMMANDS);
    while world.nonces.is_empty() {
        world.pass(ms(1));
    }
    let text = joints((1, 1), &world.nonces[0].clone(), THERE, 60);
    world.command((1, 1), &text);
    world.pass(ms(moment));
    world
}

fn starts(world: &World) -> usize {
    let ledger = world.core.ledger(0);
    ledger
        .iter()
        .filter(|entry| entry.event == LedgerEvent::Started)
        .count()
}

/// What became of the command, of those things that may.
fn outcomes(order: &str) -> Vec<(usize, Option<i32>)> {
    let mut seen = Vec::new();
    for moment in 0..MOMENTS {
        let mut world = at_moment(moment);
        world.status(order);
        let started_before = starts(&world);
        world.pass(ms(4_000));
        assert_eq!(
            starts(&world),
            started_before,
            "{order} at {moment} ms: a ghost"
        );
        let done = world.done.get(&(1, 1)).copied();
        assert_eq!(
            world.acknowledged.len(),
            usize::from(done.is_some()),
            "{order} at {moment} ms: acknowledged and never done"
        );
        seen.push((started_before, done));
    }
    seen.sort_unstable();
    seen.dedup();
    seen
}

#[test]
fn a_stop_at_any_moment_ends_the_command_or_lets_it_never_begin() {
    let seen = outcomes("X");
    // Its nonce died; it was accepted and never began; it began and was stopped.
    let all = [(0, None), (0, Some(2)), (1, Some(2))];
    assert_eq!(seen, all);
}

/// The time at which the arm came to the target, in s.
fn arrival_s(world: &World) -> Option<f64> {
    let ledger = world.core.ledger(0);
    let end = ledger
        .iter()
        .find(|entry| entry.event == LedgerEvent::Finished);
    end.map(|entry| entry.time_s)
}

#[test]
fn a_stop_around_the_arrival_is_reported_as_a_stop_unless_the_arm_has_arrived() {
    let mut undisturbed = at_moment(0);
    undisturbed.pass(ms(4_000));
    let begun = at_moment(0).core.now();
    let arrival = Duration::from_secs_f64(arrival_s(&undisturbed).unwrap());
    let arrival = arrival.checked_sub(begun).unwrap().as_millis();
    let arrival = u64::try_from(arrival).unwrap();
    let mut seen = Vec::new();
    for moment in arrival - 100..arrival + 100 {
        let mut world = at_moment(moment);
        world.status("X");
        world.pass(ms(4_000));
        let done = world.done[&(1, 1)];
        seen.push((done, arrival_s(&world).is_some()));
    }
    // On its way; in its last moments, when braking ends at the target, or before the program has noted the arrival;
    // too late.
    seen.dedup();
    assert_eq!(seen, [(2, false), (2, true), (0, true)]);
}

#[test]
fn a_fence_at_any_moment_lets_it_never_begin_or_run_to_its_end() {
    let seen = outcomes("F 2");
    let all = [(0, None), (0, Some(2)), (1, Some(0))];
    assert_eq!(seen, all);
}

#[test]
fn a_hold_at_any_moment_holds_what_was_accepted() {
    for moment in 0..MOMENTS {
        let mut world = at_moment(moment);
        let accepted = world.acknowledged.len();
        world.status("P");
        for _ in 0..8 {
            world.pass(ms(300));
            world.status("S 1");
        }
        if accepted == 1 {
            assert!(
                world.done.is_empty(),
                "{moment} ms: it arrived while it was held"
            );
            world.status("C");
            for _ in 0..8 {
                world.pass(ms(300));
                world.status("S 1");
            }
            assert_eq!(world.done.get(&(1, 1)), Some(&0), "{moment} ms");
        }
    }
}

#[test]
fn the_power_may_fail_at_any_moment_and_no_number_is_used_twice() {
    let mut kept = 0;
    for moment in 0..MOMENTS {
        let mut world = at_moment(moment);
        let acknowledged = world.acknowledged.len();
        world.power_cycle();
        world.pass(ms(1_500));
        // The same command again, as somebody would who has lost the answer.
        world.connect(COMMANDS);
        while world.nonces.len() < 2 {
            world.pass(ms(4));
        }
        let nonce = world.nonces.last().unwrap().clone();
        world.send(COMMANDS, &sealed(&joints((1, 1), &nonce, THERE, 60)));
        world.sent.entry((1, 1)).or_default().push(0);
        world.pass(ms(4_000));
        let started = starts(&world);
        assert!(started <= 1, "{moment} ms: {started} starts");
        if acknowledged == 1 {
            assert!(
                world.acknowledged.len() == 1,
                "{moment} ms: acknowledged twice"
            );
            kept += 1;
        }
    }
    assert!(kept > 10, "the moments do not reach far enough: {kept}");
}

#[test]
fn a_client_may_leave_at_any_moment_and_the_motion_goes_on_if_it_was_accepted() {
    for moment in 0..MOMENTS {
        let mut world = at_moment(moment);
        let acknowledged = world.acknowledged.len();
        world.leave(COMMANDS);
        for _ in 0..6 {
            world.status("S 1");
            world.pass(ms(400));
        }
        let finished = world
            .core
            .ledger(0)
            .iter()
            .any(|entry| entry.event == LedgerEvent::Finished);
        assert!(finished || acknowledged == 0, "{moment} ms");
        assert_eq!(finished, starts(&world) == 1, "{moment} ms");
    }
}
