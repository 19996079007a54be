//! A hundred random schedules of faults, each judged by the fake's ledger.

use std::time::Duration;

use protocol::v2::OperatingMode;
use tokio::time::sleep;

use super::harness::{Harness, arrived, output, to, to_joints};
use super::serve::{Fault, Status};
use crate::link::cell_server::MotionEnd;

/// `SplitMix64`: a seed is a schedule.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, limit: u64) -> u64 {
        self.next() % limit
    }

    fn millis(&mut self, limit: u64) -> Duration {
        Duration::from_millis(self.below(limit))
    }
}

fn command_fault(random: &mut Random) -> Fault {
    match random.below(22) {
        0 => Fault::Refused,
        1 => Fault::DropBeforeGreeting,
        2 => Fault::NoGreeting,
        3 => Fault::LateGreeting(random.millis(1_500)),
        4 => Fault::CorruptGreeting,
        5 => Fault::DropAfterGreeting,
        6 => Fault::DropAfterRead,
        7 => Fault::LateRead(random.millis(3_000)),
        8 => Fault::DropAfterAccept,
        9 => Fault::CorruptAck,
        10 => Fault::SilentAfterAccept,
        11 => Fault::DropAfterAck,
        12 => Fault::CorruptDone,
        13 => Fault::SilentAfterAck,
        _ => Fault::None,
    }
}

/// Breaks something, waits, and mends it.
async fn disturb(cell: &Harness, random: &mut Random) {
    match random.below(14) {
        0 => cell.fake.set_status(Status::Refused),
        1 => cell.fake.set_status(Status::BlackHole),
        2 => cell.fake.set_status(Status::Silent),
        3 => cell.fake.set_status(Status::Deaf),
        4 => {
            let late = random.millis(900);
            cell.fake.set_status(Status::Late(late));
        }
        5 => cell.fake.set_status(Status::Corrupt),
        6 => cell.fake.set_status(Status::Malformed),
        7 => cell.fake.set_status(Status::Drop),
        8 => cell.fake.lose_power(),
        9 => {
            let _report = cell.link.stop().await;
        }
        10 => {
            let _status = cell.link.hold().await;
            sleep(random.millis(4_000)).await;
            let _status = cell.link.resume().await;
        }
        11 => {
            let _fenced = cell.link.fence().await;
        }
        12 => cell.fake.brain().status.mode = OperatingMode::T1,
        _ => {}
    }
    if random.below(3) == 0 {
        cell.fake.cut();
    }
    sleep(random.millis(4_000)).await;
    cell.fake.set_status(Status::Well);
    cell.fake.brain().status.mode = OperatingMode::Auto;
    // A hold whose release was lost would be waited for, for ever.
    if cell.fake.brain().status.held {
        cell.fake.brain().release();
    }
}

#[tokio::test(start_paused = true)]
async fn whatever_goes_wrong_nothing_moves_twice_or_behind_a_fence_and_arrived_is_true() {
    let (mut arrivals, mut doubts, mut refused, mut interrupted) = (0, 0, 0, 0);
    for seed in 0..100 {
        let cell = Harness::start().await;
        let mut random = Random(seed);
        let mut motions = Vec::new();
        for _ in 0..8 {
            cell.fake.brain().duration = random.millis(4_000) + Duration::from_millis(50);
            cell.fake.then(command_fault(&mut random));
            let target = f64::from(u32::try_from(random.below(400)).unwrap());
            let command = match random.below(4) {
                0 => to_joints(target / 4.0),
                1 => output(1, random.below(2) == 0),
                _ => to(target),
            };
            if let Ok((motion, _)) = cell.try_submit(command, Duration::from_secs(5)) {
                motions.push(motion);
            }
            sleep(random.millis(3_000)).await;
            if random.below(2) == 0 {
                disturb(&cell, &mut random).await;
            }
        }
        for motion in motions {
            match &*cell.end(motion).await {
                MotionEnd::Arrived { .. } => arrivals += 1,
                MotionEnd::InDoubt { .. } => doubts += 1,
                MotionEnd::Interrupted { .. } => interrupted += 1,
                MotionEnd::Rejected { .. } | MotionEnd::NotSent { .. } => refused += 1,
            }
        }
        cell.judge();
        // In the end all is well again, and the robot works.
        cell.until_state(api::LinkState::Control).await;
        cell.fake.clear_faults();
        let end = cell.carry_out(to(1.0)).await;
        assert!(arrived(&end), "seed {seed}: {end:?}");
    }
    println!(
        "{arrivals} arrived, {interrupted} interrupted, {refused} not executed, {doubts} in doubt"
    );
    // The schedules reach every kind of end, and doubt is the exception.
    assert!(arrivals > 200 && interrupted > 10 && refused > 50);
    assert!((1..60).contains(&doubts), "{doubts} in doubt");
}
