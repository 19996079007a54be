//! The authority in running time: timers, the sleep of the machine, and who is told.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use api::{ControlEnd, ControlLease, LossBehavior, ProblemCode, Station};
use jiff::Timestamp;
use tokio_util::sync::CancellationToken;

use super::control::{CellControl, ControlLoss, ControlObserver};
use super::said::AcquireError;
use super::{Claim, EpochStore, Force, LeaseClock, MemoryEpochs, NextEpoch, Terms};
use crate::clock::WallClock;
use crate::identity::{AuditSink, NotRecorded, Recorded};

/// A clock of the machine that goes on while the runtime sleeps.
#[derive(Debug, Default)]
struct Clock {
    slept: Mutex<Duration>,
}

impl WallClock for Clock {
    fn now(&self) -> Timestamp {
        Timestamp::UNIX_EPOCH
    }

    fn since_boot(&self) -> Option<Duration> {
        Some(*self.slept.lock().unwrap())
    }
}

/// What was recorded, and what was lost.
#[derive(Debug, Default)]
struct Witness {
    actions: Mutex<Vec<String>>,
    losses: Mutex<Vec<ControlLoss>>,
}

impl AuditSink for Witness {
    fn record(&self, entry: journal::Audit) -> Recorded<'_> {
        self.note(entry);
        Box::pin(std::future::ready(Ok(())))
    }

    fn note(&self, entry: journal::Audit) {
        self.actions.lock().unwrap().push(entry.action);
    }
}

impl ControlObserver for Witness {
    fn control_lost(&self, loss: &ControlLoss) {
        self.losses.lock().unwrap().push(loss.clone());
    }
}

#[derive(Debug)]
struct FullDisk;

impl EpochStore for FullDisk {
    fn next(&self, _: &str) -> NextEpoch<'_> {
        let reason = "no space left".to_owned();
        Box::pin(std::future::ready(Err(NotRecorded { reason })))
    }
}

struct Bench {
    clock: Arc<Clock>,
    witness: Arc<Witness>,
    control: Arc<CellControl>,
    stop: CancellationToken,
}

fn bench() -> Bench {
    let (clock, witness) = (Arc::new(Clock::default()), Arc::new(Witness::default()));
    let time = LeaseClock::new(Arc::clone(&clock) as Arc<dyn WallClock>);
    let audit = Arc::clone(&witness) as Arc<dyn AuditSink>;
    let epochs = Arc::new(MemoryEpochs::default());
    let control = Arc::new(CellControl::new("c1", time, epochs, audit));
    control.observe(Arc::clone(&witness) as Arc<dyn ControlObserver>);
    let stop = CancellationToken::new();
    drop(tokio::spawn(Arc::clone(&control).keep_time(stop.clone())));
    Bench {
        clock,
        witness,
        control,
        stop,
    }
}

fn terms(holder: &str, ttl_s: u64, loss: LossBehavior) -> Terms {
    Terms {
        holder: holder.to_owned(),
        station: Station::Remote,
        ttl: Duration::from_secs(ttl_s),
        loss,
        reason: "a test".to_owned(),
    }
}

impl Bench {
    async fn acquire(&self, ttl_s: u64, loss: LossBehavior) -> ControlLease {
        let terms = terms("anna", ttl_s, loss);
        self.control.acquire(terms, Force::ByStation).await.unwrap()
    }

    async fn until_lost(&self) -> ControlLoss {
        let mut news = self.control.watch();
        let lost = news.wait_for(|news| news.losses > 0).await.unwrap();
        lost.last_loss.clone().unwrap()
    }
}

/// O4, F22: the dead-man of a jog.
#[tokio::test(start_paused = true)]
async fn o4_without_a_heartbeat_control_is_lost_and_whoever_must_stop_is_told() {
    let bench = bench();
    assert!(bench.control.jobs_may_act());
    let lease = bench.acquire(2, LossBehavior::Hold).await;
    assert!(!bench.control.jobs_may_act());
    let began = tokio::time::Instant::now();
    for _ in 0..5 {
        tokio::time::advance(Duration::from_millis(1_900)).await;
        assert!(bench.control.heartbeat(lease.lease, "anna").is_ok());
    }
    let loss = bench.until_lost().await;
    let took = began.elapsed();
    assert!((11_500..=11_800).contains(&took.as_millis()), "{took:?}");
    assert_eq!(
        (loss.end, loss.behavior, loss.epoch),
        (ControlEnd::Expired, LossBehavior::Hold, 1)
    );
    assert_eq!(*bench.witness.losses.lock().unwrap(), [loss]);
    assert!(bench.control.jobs_may_act());
    let late = bench.control.heartbeat(lease.lease, "anna").unwrap_err();
    assert_eq!(late.code, ProblemCode::ControlLost);
    let next = bench.acquire(2, LossBehavior::Hold).await;
    assert_eq!(next.epoch, 2);
    assert_eq!(*bench.witness.actions.lock().unwrap(), ["control.expired"]);
    bench.stop.cancel();
}

/// T3.
#[tokio::test(start_paused = true)]
async fn t3_a_machine_that_was_suspended_is_not_in_control_when_it_wakes() {
    let bench = bench();
    let lease = bench.acquire(10, LossBehavior::Stop1).await;
    *bench.clock.slept.lock().unwrap() = Duration::from_mins(1);
    // Before anything else: no timer has fired yet.
    let refused = bench.control.check(lease.token, "anna").unwrap_err();
    assert_eq!(refused.code, ProblemCode::ControlLost);
    assert!(bench.control.heartbeat(lease.lease, "anna").is_err());
    assert_eq!(bench.until_lost().await.end, ControlEnd::Expired);
}

#[tokio::test(start_paused = true)]
async fn giving_control_back_stops_nothing() {
    let bench = bench();
    let lease = bench.acquire(10, LossBehavior::Stop1).await;
    bench.control.release(lease.lease, "anna").unwrap();
    assert!(bench.witness.losses.lock().unwrap().is_empty());
    let news = bench.control.watch().borrow().clone();
    assert_eq!((news.held, news.epoch, news.losses), (false, 1, 0));
}

#[tokio::test(start_paused = true)]
async fn jobs_act_while_nobody_has_control() {
    let bench = bench();
    let jobs = Claim::of_jobs(Arc::clone(&bench.control));
    assert_eq!(jobs.check(), Ok(()));
    let lease = bench.acquire(10, LossBehavior::Stop1).await;
    assert_eq!(jobs.check().unwrap_err().code, ProblemCode::ControlHeld);
    bench.control.release(lease.lease, "anna").unwrap();
    assert_eq!((jobs.check(), jobs.actor()), (Ok(()), "jobs"));
}

#[tokio::test]
async fn an_epoch_that_cannot_be_kept_grants_nothing() {
    let witness = Arc::new(Witness::default());
    let time = LeaseClock::new(Arc::new(Clock::default()));
    let control = CellControl::new("c1", time, Arc::new(FullDisk), witness);
    let asked = control.acquire(terms("anna", 10, LossBehavior::Hold), Force::ByStation);
    assert!(matches!(asked.await, Err(AcquireError::NotRecorded(_))));
    assert!(control.jobs_may_act());
}
