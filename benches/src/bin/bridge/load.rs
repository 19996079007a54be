//! Runs an exchange over and over on several connections, and counts.

use std::time::{Duration, Instant};

use anyhow::{Result, ensure};
use api::ControlToken;
use benches::cpu;
use benches::processes::Part;
use tokio::task::JoinSet;

use crate::{http, raw};

/// What one variant did in one slice of time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Exchanges finished a second.
    pub(crate) per_second: f64,
    /// Median duration of an exchange.
    pub(crate) p50: Duration,
    /// 99th percentile.
    pub(crate) p99: Duration,
    /// What an exchange costs the process in the middle, in microseconds of a core; not a number where there is none.
    pub(crate) cpu_us: f64,
}

/// Raw TCP: connection `i` talks to robot `i mod robots`.
pub(crate) async fn raw_tcp(
    first_port: u16,
    robots: usize,
    connections: usize,
    slice: Duration,
) -> Result<Sample> {
    let mut workers = JoinSet::new();
    let end = Instant::now() + slice;
    for worker in 0..connections {
        let port = first_port + u16::try_from(worker % robots)?;
        let _handle = workers.spawn(async move {
            let mut durations = Vec::with_capacity(1 << 14);
            while Instant::now() < end {
                let start = Instant::now();
                raw::exchange(port).await?;
                durations.push(start.elapsed());
            }
            anyhow::Ok(durations)
        });
    }
    collect(workers, slice).await
}

/// What a connection sends over HTTP again and again.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Request {
    pub(crate) body: Option<&'static str>,
    pub(crate) control: Option<ControlToken>,
    /// The status of the answer it is to have.
    pub(crate) status: u16,
}

/// HTTP to `server`: one connection for each path.
pub(crate) async fn over_http(
    server: &Part,
    paths: Vec<String>,
    request: Request,
    slice: Duration,
) -> Result<Sample> {
    let Request {
        body,
        control,
        status,
    } = request;
    let mut workers = JoinSet::new();
    let mut opened = Vec::new();
    for path in &paths {
        opened.push(http::Connection::open(server.port, path, body, control).await?);
    }
    let before = cpu::time(server.id()?)?;
    let end = Instant::now() + slice;
    for mut connection in opened {
        let _handle = workers.spawn(async move {
            let mut durations = Vec::with_capacity(1 << 14);
            while Instant::now() < end {
                let start = Instant::now();
                let answered = connection.exchange().await?;
                ensure!(
                    answered == status,
                    "expected status {status}, got {answered}"
                );
                durations.push(start.elapsed());
            }
            anyhow::Ok(durations)
        });
    }
    let sample = collect(workers, slice).await?;
    let cost = cpu::time(server.id()?)?.saturating_sub(before);
    let exchanges = sample.per_second * slice.as_secs_f64();
    Ok(Sample {
        cpu_us: cost.as_secs_f64() * 1e6 / exchanges,
        ..sample
    })
}

async fn collect(mut workers: JoinSet<Result<Vec<Duration>>>, slice: Duration) -> Result<Sample> {
    let mut durations = Vec::new();
    while let Some(worker) = workers.join_next().await {
        durations.extend(worker??);
    }
    durations.sort_unstable();
    let at = |share: f64| {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_precision_loss,
            clippy::cast_sign_loss,
            reason = "an index into a list that fits in memory"
        )]
        let index = (durations.len() as f64 * share) as usize;
        durations.get(index).copied().unwrap_or_default()
    };
    #[expect(clippy::cast_precision_loss, reason = "counts stay far below 2^52")]
    let per_second = durations.len() as f64 / slice.as_secs_f64();
    Ok(Sample {
        per_second,
        p50: at(0.5),
        p99: at(0.99),
        cpu_us: f64::NAN,
    })
}
