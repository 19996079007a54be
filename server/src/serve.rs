//! The accept loop: connections, their limits, and the orderly end.

use std::net::IpAddr;
use std::sync::Arc;

use axum::Router;
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper_util::rt::TokioIo;
use hyper_util::server::graceful::GracefulShutdown;
use thiserror::Error;
use tokio::time::{Duration, MissedTickBehavior, interval, sleep, timeout};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::config::{Plan, ServerPlan};
use crate::connections::{AcceptFailures, Listener, Table, Watched, answer};
use crate::link::Connector;
use crate::openapi;
use crate::router;
use crate::setup::StoreError;
use crate::state::{App, Seams};

/// The most headers of one request.
const MAX_HEADERS: usize = 64;
/// The largest head of one request, in bytes.
const MAX_HEAD_BYTES: usize = 16 * 1024;
/// How often the recorded durations are moved into their buckets.
const UPKEEP: Duration = Duration::from_secs(5);

/// Why a server did not start.
#[derive(Debug, Error)]
pub enum ServeError {
    /// The recorder of the metrics could not be made.
    #[error("starting the metrics")]
    Metrics(#[source] metrics_exporter_prometheus::BuildError),
    /// The plan says neither who callers are nor that it is a demo.
    #[error("nobody would be asked who they are: the plan needs an identity, or demo mode")]
    NoIdentity,
    /// The set-up of a cell cannot be read, or does not fit.
    #[error(transparent)]
    Setup(StoreError),
    /// What the journal knows of a cell's jobs could not be taken up.
    #[error("taking up the work of a cell")]
    Cell(#[source] crate::cell::StartError),
    /// What the journal knows of earlier motions could not be read.
    #[error("reading the journal")]
    Journal(#[source] ::journal::ReadError),
}

/// Serves until `stop` is cancelled, then ends: no new connections, each link stops between two commands, requests
/// that are being answered are finished within the configured time, and everything this started has ended.
///
/// # Errors
/// The server could not start.
pub async fn run<L: Listener, C: Connector>(
    listener: L,
    plan: Plan,
    seams: Seams<C>,
    stop: CancellationToken,
) -> Result<(), ServeError> {
    let limits = plan.server.clone();
    let robots = plan.cells.iter().map(|cell| cell.robots.len()).sum();
    let table = Arc::new(Table::new(&limits, robots));
    let tracker = TaskTracker::new();
    let started = start(plan, seams, &tracker, &stop).await;
    let _closed = tracker.close();
    match started {
        Ok(router) => serve(listener, router, table, &limits, &stop).await,
        Err(error) => {
            // What had begun lets go of the journal first: the next start needs it.
            tracker.wait().await;
            return Err(error);
        }
    }
    tracker.wait().await;
    tracing::info!("the server has stopped");
    Ok(())
}

/// Starts the links and makes the router on top of them, for a caller with an accept loop of its own.
///
/// The links run on `tracker` and end once `stop` is cancelled.
///
/// # Errors
/// The metrics could not be started, a cell's set-up does not fit, or the journal could not be read.
pub async fn start<C: Connector>(
    plan: Plan,
    seams: Seams<C>,
    tracker: &TaskTracker,
    stop: &CancellationToken,
) -> Result<Router, ServeError> {
    let (routes, document) = router::documented();
    let paths = document.paths.paths.keys().cloned();
    let begun = stop.child_token();
    let app = App::start(plan, seams, paths, tracker, &begun).await;
    let app = Arc::new(app.inspect_err(|_| begun.cancel())?);
    drop(tracker.spawn(keep_up(Arc::clone(&app), stop.clone())));
    drop(tracker.spawn(Arc::clone(&app).end_revoked_leases(stop.clone())));
    Ok(router::finish(routes, openapi::complete(document), app))
}

async fn keep_up(app: Arc<App>, stop: CancellationToken) {
    let mut ticks = interval(UPKEEP);
    ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
    while stop.run_until_cancelled(ticks.tick()).await.is_some() {
        app.metrics.upkeep();
    }
}

async fn serve<L: Listener>(
    mut listener: L,
    router: Router,
    table: Arc<Table>,
    limits: &ServerPlan,
    stop: &CancellationToken,
) {
    let mut http = http1::Builder::new();
    // No timers: the table sweeps.
    let _builder = http
        .max_headers(MAX_HEADERS)
        .max_header_size(MAX_HEAD_BYTES);
    let graceful = GracefulShutdown::new();
    let cut_off = CancellationToken::new();
    let connections = TaskTracker::new();
    let sweeping = {
        let (table, cut_off) = (Arc::clone(&table), cut_off.clone());
        tokio::spawn(async move { cut_off.run_until_cancelled(table.sweep()).await })
    };
    if let Err(error) = listener.prepare() {
        tracing::warn!(%error, "the backlog of the listener stays as it is");
    }
    let mut failures = AcceptFailures::none();
    while let Some(accepted) = stop.run_until_cancelled(listener.accept()).await {
        let (stream, peer) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                if let Some(pause) = failures.note(&error) {
                    let _made = table.make_room();
                    let _stopped = stop.run_until_cancelled(sleep(pause)).await;
                }
                continue;
            }
        };
        failures = AcceptFailures::none();
        // Who finds neither a place nor anybody to make room waits, and the others behind it in the kernel.
        let Some(seat) = stop.run_until_cancelled(table.seat(peer.ip())).await else {
            break;
        };
        let stream = TokioIo::new(Watched::new(stream, Arc::clone(&seat.standing)));
        let (router, standing) = (router.clone(), Arc::clone(&seat.standing));
        let address = peer.ip();
        let service = service_fn(move |mut request: hyper::Request<_>| {
            let _none = request.extensions_mut().insert(Peer(address));
            answer(router.clone(), Arc::clone(&standing), request)
        });
        let connection = graceful.watch(http.serve_connection(stream, service));
        let cut_off = cut_off.clone();
        drop(connections.spawn(async move {
            tokio::select! {
                biased;
                ended = connection => if let Err(error) = ended {
                    tracing::debug!(%error, "a connection broke off");
                },
                () = seat.standing.closed() => {
                    tracing::debug!(%peer, "a connection was closed: it was late, or made room");
                }
                () = cut_off.cancelled() => {}
            }
            drop(seat);
        }));
    }
    drop(listener);
    tracing::info!("stopping: requests that are being answered are finished");
    if timeout(limits.shutdown_timeout, graceful.shutdown())
        .await
        .is_err()
    {
        tracing::warn!("requests were cut off: they did not end in time");
    }
    cut_off.cancel();
    let _closed = connections.close();
    connections.wait().await;
    let _swept = sweeping.await;
}

/// The machine at the other end of a request's connection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peer(pub(crate) IpAddr);
