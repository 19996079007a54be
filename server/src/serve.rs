//! The accept loop: connections, their limits, and the orderly end.

use std::convert::Infallible;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;

use axum::Router;
use axum::response::Response;
use axum::serve::Listener;
use hyper::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::Service;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::server::graceful::GracefulShutdown;
use hyper_util::service::{TowerToHyperService, TowerToHyperServiceFuture};
use thiserror::Error;
use tokio::sync::Semaphore;
use tokio::time::{Duration, MissedTickBehavior, interval, timeout};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::config::{Plan, ServerPlan};
use crate::link::Connector;
use crate::openapi;
use crate::router;
use crate::setup::StoreError;
use crate::stall::StallGuard;
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
pub async fn run<L: Listener<Addr = SocketAddr>, C: Connector>(
    listener: L,
    plan: Plan,
    seams: Seams<C>,
    stop: CancellationToken,
) -> Result<(), ServeError> {
    let limits = plan.server.clone();
    let tracker = TaskTracker::new();
    let router = start(plan, seams, &tracker, &stop).await?;
    serve(listener, router, &limits, &stop).await;
    let _closed = tracker.close();
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
    let app = App::start(plan, seams, paths, tracker, stop).await?;
    let app = Arc::new(app);
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

async fn serve<L: Listener<Addr = SocketAddr>>(
    mut listener: L,
    router: Router,
    limits: &ServerPlan,
    stop: &CancellationToken,
) {
    let mut http = http1::Builder::new();
    let _builder = http
        .timer(TokioTimer::new())
        .header_read_timeout(limits.header_timeout)
        .max_headers(MAX_HEADERS)
        .max_header_size(MAX_HEAD_BYTES);
    let graceful = GracefulShutdown::new();
    let cut_off = CancellationToken::new();
    let connections = TaskTracker::new();
    let places = Arc::new(Semaphore::new(limits.max_connections));
    // The place comes first, so that connections beyond the limit wait in the kernel and cost nothing here.
    while let Some(Ok(place)) = stop
        .run_until_cancelled(Arc::clone(&places).acquire_owned())
        .await
    {
        // Errors of accepting are logged and waited out by the listener.
        let Some((stream, peer)) = stop.run_until_cancelled(listener.accept()).await else {
            break;
        };
        let stream = StallGuard::new(stream, limits.write_timeout);
        let service = FromPeer {
            router: TowerToHyperService::new(router.clone()),
            peer: Peer(peer.ip()),
        };
        let connection = http.serve_connection(TokioIo::new(stream), service);
        let connection = graceful.watch(connection);
        let cut_off = cut_off.clone();
        drop(connections.spawn(async move {
            if let Some(Err(error)) = cut_off.run_until_cancelled(connection).await {
                tracing::debug!(%error, "a connection broke off");
            }
            drop(place);
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
}

/// The machine at the other end of a request's connection.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Peer(pub(crate) IpAddr);

/// The router, telling each request which machine it comes from.
#[derive(Debug)]
struct FromPeer {
    router: TowerToHyperService<Router>,
    peer: Peer,
}

impl Service<Request<Incoming>> for FromPeer {
    type Response = Response;
    type Error = Infallible;
    type Future = TowerToHyperServiceFuture<Router, Request<Incoming>>;

    fn call(&self, mut request: Request<Incoming>) -> Self::Future {
        let _none = request.extensions_mut().insert(self.peer);
        self.router.call(request)
    }
}
