//! How fast a journal is on this disk.
//!
//! ```text
//! cargo run --release -p journal --example journal_bench [DIRECTORY]
//! ```
//! Prints the time of a durable intent at 50 a second, appends a second and their times with 64 writers, and the time
//! from start to ready with 100,000 records.
#![expect(
    clippy::disallowed_methods,
    clippy::print_stdout,
    reason = "a benchmark reads the clock and prints"
)]

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use jiff::Timestamp;
use journal::{
    AppendError, Audit, AuditResult, Claim, Clocks, Digest, End, Filesystem, IdempotencyKey,
    Intent, Journal, KeyError, KeyRetention, MotionId, MotionPhase, OpenError, Opening, Outcome,
    Position, Record, Repeatability, SqliteJournal, SqliteOptions, Target, verify,
};
use uuid::Uuid;

type Outcomes = Result<(), Box<dyn Error + Send + Sync>>;

const WRITERS: u64 = 64;
const EACH: u64 = 400;

#[tokio::main]
async fn main() -> Outcomes {
    let directory = std::env::args_os().nth(1).map(PathBuf::from);
    let directory = directory.unwrap_or_else(std::env::temp_dir);
    let directory = tempfile::tempdir_in(directory)?;
    let path = directory.path().join("bench.journal");
    let start = Instant::now();
    paced(&path, start).await?;
    saturated(&path, start).await?;
    ready(&path, start).await
}

/// Fifty motions a second, each with a key, as a busy cell has them; a second append ends each motion.
async fn paced(path: &Path, start: Instant) -> Outcomes {
    let journal = open(path, start).await?;
    let mut ticks = tokio::time::interval(Duration::from_millis(20));
    let mut times = Vec::new();
    for n in 0..500 {
        let _tick = ticks.tick().await;
        let before = Instant::now();
        let _begun = journal
            .begin_motion(now(start), intent(&journal, n, Some(claim(n)?)))
            .await?;
        times.push(before.elapsed());
        let _ended = journal.append(now(start), rejected(n)).await?;
    }
    println!("durable intent at 50/s:            {}", summary(times));
    journal.close().await;
    Ok(())
}

/// As many as the disk takes: 64 tasks, each with one append at a time.
async fn saturated(path: &Path, start: Instant) -> Outcomes {
    let journal = Arc::new(open(path, start).await?);
    let begun = Instant::now();
    let writers: Vec<_> = (1..=WRITERS)
        .map(|writer| tokio::spawn(write(Arc::clone(&journal), writer, start)))
        .collect();
    let mut times = Vec::new();
    for writer in writers {
        times.extend(writer.await??);
    }
    let seconds = begun.elapsed().as_secs_f64();
    let count = u32::try_from(times.len())?;
    println!(
        "durable intent, {WRITERS} writers:        {}",
        summary(times)
    );
    println!(
        "appends a second, {WRITERS} writers:      {:.0}",
        f64::from(count) / seconds
    );
    close(journal).await
}

async fn write(
    journal: Arc<SqliteJournal>,
    writer: u64,
    start: Instant,
) -> Result<Vec<Duration>, Box<dyn Error + Send + Sync>> {
    let mut times = Vec::new();
    for n in 0..EACH {
        let intent = intent(&journal, writer * 1_000_000 + n, None);
        let before = Instant::now();
        let _begun = journal.begin_motion(now(start), intent).await?;
        times.push(before.elapsed());
    }
    Ok(times)
}

/// From nothing to ready, with what the last process left behind listed.
async fn ready(path: &Path, start: Instant) -> Outcomes {
    fill(open(path, start).await?, start).await?;
    let before = Instant::now();
    let journal = open(path, start).await?;
    let opened = before.elapsed();
    let left = [MotionPhase::Open, MotionPhase::Accepted];
    let left = journal.motions(&left, Position::START, 1_000).await?;
    println!(
        "start to ready, {} records:   {:.1} ms, and {} motions left behind listed after {:.1} ms",
        journal.head().position,
        opened.as_secs_f64() * 1e3,
        left.len(),
        before.elapsed().as_secs_f64() * 1e3
    );
    journal.close().await;
    let before = Instant::now();
    let report = verify(path, None).await?;
    println!(
        "verify, {} records:           {:.1} ms; the file has {} KiB",
        report.head.position,
        before.elapsed().as_secs_f64() * 1e3,
        std::fs::metadata(path)?.len() / 1_024
    );
    Ok(())
}

/// Audit records, many at a time, until the journal has 100,000.
async fn fill(journal: SqliteJournal, start: Instant) -> Outcomes {
    let journal = Arc::new(journal);
    let writers: Vec<_> = (0..500)
        .map(|_| {
            let journal = Arc::clone(&journal);
            tokio::spawn(async move {
                while journal.head().position < Position(100_000) {
                    let _appended = journal.append(now(start), audit()).await?;
                }
                Ok::<_, AppendError>(())
            })
        })
        .collect();
    for writer in writers {
        writer.await??;
    }
    close(journal).await
}

async fn close(journal: Arc<SqliteJournal>) -> Outcomes {
    let journal = Arc::into_inner(journal).ok_or("a writer still has the journal")?;
    journal.close().await;
    Ok(())
}

async fn open(path: &Path, start: Instant) -> Result<SqliteJournal, OpenError> {
    let opening = Opening {
        at: now(start),
        program: "journal_bench".into(),
        keys: KeyRetention::default(),
    };
    let options = SqliteOptions {
        filesystem: Filesystem::Trusted,
        ..SqliteOptions::default()
    };
    SqliteJournal::open(path, &opening, &options).await
}

fn now(start: Instant) -> Clocks {
    Clocks {
        wall: Timestamp::now(),
        monotonic: start.elapsed(),
    }
}

fn motion(n: u64) -> MotionId {
    MotionId(Uuid::from_u128(n.into()))
}

fn intent(journal: &SqliteJournal, n: u64, claim: Option<Claim>) -> Intent {
    Intent {
        motion: motion(n),
        cell: "c1".into(),
        robot: "r1".into(),
        epoch: journal.epoch(),
        seq: n,
        target: Target {
            x_um: 600_000,
            y_um: -200_000,
            z_um: 600_000,
            w_mdeg: 180_000,
            p_mdeg: 0,
            r_mdeg: 0,
        },
        speed_um_s: 200_000,
        class: Repeatability::AbsoluteFree,
        request_id: Uuid::from_u128(n.into()).to_string(),
        claim,
        job: None,
        reason: None,
        asked: None,
    }
}

fn claim(n: u64) -> Result<Claim, KeyError> {
    Ok(Claim {
        key: IdempotencyKey::try_new(Uuid::from_u128(n.into()).to_string())?,
        body: Digest::of(&n.to_le_bytes()),
    })
}

fn rejected(n: u64) -> Record {
    Record::Outcome(Outcome {
        motion: motion(n),
        end: End::Rejected {
            text: "ERROR: POINT UNREACHABLE".into(),
        },
    })
}

fn audit() -> Record {
    Record::Audit(Audit {
        principal: "anna".into(),
        action: "speed-override.put".into(),
        object: "c1/r1".into(),
        result: AuditResult::Done,
        request_id: None,
        cell: None,
        role: None,
        source: None,
        lease: None,
        before: Some("100".into()),
        after: Some("50".into()),
    })
}

/// Percentiles of `times`, for people.
fn summary(mut times: Vec<Duration>) -> String {
    times.sort_unstable();
    let at = |percent: usize| {
        let place = (times.len() * percent / 100).min(times.len().saturating_sub(1));
        times
            .get(place)
            .map_or(0.0, |time| time.as_secs_f64() * 1e3)
    };
    format!(
        "p50 {:.2} ms, p99 {:.2} ms, max {:.2} ms",
        at(50),
        at(99),
        at(100)
    )
}
