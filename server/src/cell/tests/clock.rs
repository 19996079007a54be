//! Jobs while the wall clock is set.

use std::sync::Arc;
use std::sync::atomic::{AtomicI64, Ordering};
use std::time::Duration;

use jiff::{SignedDuration, Timestamp};
use journal::MemoryDisk;
use tokio::time::{Instant, sleep};

use super::{World, opened};
use crate::clock::{SystemClock, WallClock};

/// A wall clock that somebody sets, in seconds.
#[derive(Debug, Default)]
struct Set(AtomicI64);

impl WallClock for Set {
    fn now(&self) -> Timestamp {
        let seconds = self.0.load(Ordering::SeqCst);
        SystemClock.now() + SignedDuration::from_secs(seconds)
    }
}

impl World {
    fn orders(&self) -> usize {
        let told = self.outboxes.after("mr1", 0);
        let orders = told.iter().map(|one| one.message.kind());
        orders.filter(|kind| *kind == "TRANSPORT_ORDER").count()
    }

    /// How long it takes, on the clock of the runtime, until an order is sent once more.
    async fn until_sent_again(&self) -> Duration {
        let (began, before) = (Instant::now(), self.orders());
        while self.orders() == before {
            let waiting = self.outboxes.after("mr1", 0);
            assert!(began.elapsed() < Duration::from_mins(1), "{waiting:?}");
            sleep(Duration::from_millis(10)).await;
        }
        began.elapsed()
    }
}

/// An order that nobody acknowledges is sent again every 5 s. Neither an hour forward nor an hour back makes it sooner or
/// later, and the job's deadline stays as far away as it was.
///
/// Covers: T1.
#[tokio::test(start_paused = true)]
async fn t1_a_wall_clock_that_is_set_moves_no_timer_of_a_job() {
    let wall = Arc::new(Set::default());
    let clock: Arc<dyn WallClock> = Arc::clone(&wall) as Arc<dyn WallClock>;
    let world = World::at(&opened(&MemoryDisk::new()), clock).await;
    // An arm that nothing is seen of for long is another matter.
    let arm = world.arm.clone();
    let _looks = tokio::spawn(async move {
        loop {
            arm.send_modify(|_| {});
            sleep(Duration::from_millis(500)).await;
        }
    });
    let job = world.pickup().await;
    let _order = world.message("TRANSPORT_ORDER").await;
    for hour in [1, -1, 0] {
        wall.0.store(hour * 3_600, Ordering::SeqCst);
        let took = world.until_sent_again().await.as_millis();
        assert!((4_900..=5_200).contains(&took), "{took} ms after {hour} h");
    }
    // Then it is a person's turn, at its time as well.
    wall.0.store(24 * 3_600, Ordering::SeqCst);
    let began = Instant::now();
    let asked = |world: &World| {
        let asked = world.work.view().interventions();
        asked.iter().any(|one| one.question.job == Some(job))
    };
    while !asked(&world) {
        assert!(began.elapsed() < Duration::from_mins(1), "never");
        sleep(Duration::from_millis(10)).await;
    }
    let took = began.elapsed().as_millis();
    assert!((4_900..=5_200).contains(&took), "{took} ms");
}
