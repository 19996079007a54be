//! A journal with many records, opened again: the time until what the last process left behind is listed.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result};
use benches::processes;
use jiff::Timestamp;
use journal::{
    AppendError, Asked, Audit, AuditResult, Clocks, Filesystem, Intent, Journal as _, KeyRetention,
    MotionId, Opening, Position, Record, Repeatability, SqliteJournal, SqliteOptions, Target,
};
use uuid::Uuid;

use crate::client::{Client, get};
use crate::served::CELL;

/// Motions whose end nobody has seen.
const LEFT_OPEN: u64 = 8;
/// How long the doubts are waited for.
const PATIENCE: Duration = Duration::from_secs(20);
/// Seconds at most.
pub(crate) const TARGET_S: f64 = 2.0;
/// Seconds at most until it answers.
pub(crate) const READY_TARGET_S: f64 = 1.0;

/// What a restart took, from the start of the process.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Restart {
    /// Until it answered.
    pub(crate) answering: Duration,
    /// Until the doubts were listed.
    pub(crate) listed: Duration,
    pub(crate) doubts: usize,
}

/// Fills a journal at `path` and starts a server with it.
pub(crate) async fn measure(path: &Path, ports: &str, records: u64) -> Result<Restart> {
    fill(path, records, Instant::now()).await?;
    let begun = Instant::now();
    let arguments = [
        "served".to_owned(),
        ports.to_owned(),
        path.display().to_string(),
    ];
    let server = processes::start(&arguments).await?;
    let mut client = Client::new(server.port);
    let _status = client.status(&get("/livez"))?;
    let answering = begun.elapsed();
    let request = get(&format!("/api/v1/cells/{CELL}/interventions"));
    loop {
        let doubts = client
            .body(&request)?
            .get("interventions")
            .and_then(|list| list.as_array())
            .map_or(0, Vec::len);
        let listed = begun.elapsed();
        if u64::try_from(doubts)? >= LEFT_OPEN || listed > PATIENCE {
            return Ok(Restart {
                answering,
                listed,
                doubts,
            });
        }
    }
}

async fn fill(path: &Path, records: u64, start: Instant) -> Result<()> {
    let journal = Arc::new(open(path, start).await?);
    // Many at a time, so that they share their fsyncs.
    let writers: Vec<_> = (0..500)
        .map(|_| {
            let journal = Arc::clone(&journal);
            tokio::spawn(async move {
                while journal.head().position < Position(records) {
                    let _appended = journal.append(now(start), audit()).await?;
                }
                Ok::<_, AppendError>(())
            })
        })
        .collect();
    for writer in writers {
        writer.await??;
    }
    for seq in 1..=LEFT_OPEN {
        let intent = intent(&journal, seq);
        let _begun = journal.begin_motion(now(start), intent).await?;
    }
    let journal = Arc::into_inner(journal).context("a writer still has the journal")?;
    journal.close().await;
    Ok(())
}

async fn open(path: &Path, start: Instant) -> Result<SqliteJournal> {
    let opening = Opening {
        at: now(start),
        program: "service benchmark".into(),
        keys: KeyRetention::default(),
    };
    let options = SqliteOptions {
        filesystem: Filesystem::Trusted,
        ..SqliteOptions::default()
    };
    Ok(SqliteJournal::open(path, &opening, &options).await?)
}

fn now(start: Instant) -> Clocks {
    Clocks {
        wall: Timestamp::now(),
        monotonic: start.elapsed(),
    }
}

fn audit() -> Record {
    Record::Audit(Audit {
        principal: "anna".into(),
        action: "speed-override.put".into(),
        object: format!("{CELL}/r1"),
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

fn intent(journal: &SqliteJournal, seq: u64) -> Intent {
    Intent {
        motion: MotionId(Uuid::from_u128(seq.into())),
        cell: CELL.into(),
        robot: format!("r{}", seq % 8),
        epoch: journal.epoch(),
        seq,
        target: Target {
            x_um: 985_000,
            y_um: 0,
            z_um: 940_000,
            w_mdeg: -180_000,
            p_mdeg: 0,
            r_mdeg: 0,
        },
        speed_um_s: 200_000,
        class: Repeatability::AbsoluteFree,
        request_id: seq.to_string(),
        claim: None,
        job: None,
        reason: None,
        asked: Some(Box::new(Asked {
            output: None,
            motion_type: "JOINT".into(),
            principal: "anna".into(),
            joints_mdeg: [0, 0, 0, 0, -90_000, 0],
            speed_percent: None,
            not_after: None,
            wire_epoch: None,
            from: None,
            boot: None,
            to_joints: false,
        })),
    }
}
