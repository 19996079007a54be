//! Open-loop load: every request has its time, whether the ones before it were answered or not.
//!
//! A worker is a thread that waits for its turn to the microsecond, which the runtime's timer of a millisecond cannot.
//! If a worker is late because an answer was, its next request goes at once, and its latency counts from the time it
//! was due: a stall of the server shows in every request that fell into it (no coordinated omission).

use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Result, anyhow};

use crate::client::Answered;
use crate::latencies::Latencies;

/// Does the exchange of the given number.
pub(crate) type Exchange = Box<dyn FnMut(u64) -> Result<Answered> + Send>;

/// Requests at a rate.
pub(crate) struct Load {
    pub(crate) name: &'static str,
    rate: f64,
    workers: usize,
    exchange: Box<dyn Fn(usize) -> Exchange>,
}

/// What became of a load.
#[derive(Clone, Debug, Default)]
pub(crate) struct Measured {
    pub(crate) name: &'static str,
    pub(crate) latencies: Latencies,
    /// Answers other than the expected one, and exchanges without an answer.
    pub(crate) failed: u64,
    /// Connections the server had closed, and that were opened again.
    pub(crate) reopened: u64,
}

impl Load {
    /// `rate` a second, by turns on as many connections as there are `workers`.
    pub(crate) fn new(
        name: &'static str,
        rate: f64,
        workers: usize,
        exchange: impl Fn(usize) -> Exchange + 'static,
    ) -> Self {
        Self {
            name,
            rate,
            workers,
            exchange: Box::new(exchange),
        }
    }
}

/// Runs all loads at the same time.
pub(crate) fn run(loads: &[Load], slice: Duration) -> Result<Vec<Measured>> {
    // Time for all threads to be there.
    let begin = Instant::now() + Duration::from_millis(200);
    let mut running = Vec::new();
    for load in loads {
        let mut threads = Vec::new();
        for worker in 0..load.workers {
            let exchange = (load.exchange)(worker);
            let turn = Turn {
                first: begin + Duration::from_secs_f64(at(worker) / load.rate),
                every: Duration::from_secs_f64(at(load.workers) / load.rate),
                end: begin + slice,
            };
            threads.push(thread::spawn(move || work(exchange, turn)));
        }
        running.push((load.name, threads));
    }
    let mut all = Vec::new();
    for (name, threads) in running {
        let mut measured = Measured {
            name,
            ..Measured::default()
        };
        for thread in threads {
            let part = thread.join().map_err(|_| anyhow!("a worker panicked"))?;
            measured.add(part);
        }
        all.push(measured);
    }
    Ok(all)
}

impl Measured {
    /// Adds another part of the same load.
    pub(crate) fn add(&mut self, other: Self) {
        self.latencies.add(other.latencies);
        self.failed += other.failed;
        self.reopened += other.reopened;
    }
}

#[derive(Clone, Copy)]
struct Turn {
    first: Instant,
    every: Duration,
    end: Instant,
}

fn work(mut exchange: Exchange, turn: Turn) -> Measured {
    let mut measured = Measured::default();
    let mut due = turn.first;
    let mut number = 0;
    while due < turn.end {
        wait_until(due);
        match exchange(number) {
            Ok(answered) => {
                measured.latencies.push(due.elapsed());
                measured.reopened += u64::from(answered.reopened);
                measured.failed += u64::from(!answered.expected);
            }
            Err(_) => measured.failed += 1,
        }
        number += 1;
        due += turn.every;
    }
    measured
}

fn wait_until(due: Instant) {
    loop {
        let left = due.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return;
        }
        thread::park_timeout(left);
    }
}

#[expect(clippy::cast_precision_loss, reason = "a few workers")]
fn at(count: usize) -> f64 {
    count as f64
}
