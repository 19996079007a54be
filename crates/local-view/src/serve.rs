//! The accept loop: everything a client can hold has a limit.

use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use axum::serve::Listener;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::TcpListener;
use tokio::sync::Semaphore;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Connections at a time; more wait in the kernel.
const CONNECTIONS: usize = 32;
/// The most headers of one request.
const HEADERS: usize = 64;
/// The largest head of one request, in bytes.
const HEAD_BYTES: usize = 16 * 1024;
/// How long a request may take to arrive, or a connection may be idle.
const HEAD_TIME: Duration = Duration::from_secs(10);
/// How long a connection may live. A browser opens another one; a client that never reads does not keep its place.
const LIFE: Duration = Duration::from_mins(1);
/// How long the last answer of a connection may take once its time is over.
const FAREWELL: Duration = Duration::from_secs(1);

/// Answers with `router` until `stop`.
pub async fn serve(
    mut listener: TcpListener,
    router: Router,
    stop: CancellationToken,
    tracker: TaskTracker,
) {
    let mut http = http1::Builder::new();
    let _builder = http
        .timer(TokioTimer::new())
        .header_read_timeout(HEAD_TIME)
        .max_headers(HEADERS)
        .max_header_size(HEAD_BYTES);
    let places = Arc::new(Semaphore::new(CONNECTIONS));
    // The place comes first, so that connections beyond the limit cost nothing here.
    while let Some(Ok(place)) = stop
        .run_until_cancelled(Arc::clone(&places).acquire_owned())
        .await
    {
        // Axum's listener logs what goes wrong and waits it out.
        let accepted = stop.run_until_cancelled(Listener::accept(&mut listener));
        let Some((stream, peer)) = accepted.await else {
            break;
        };
        let service = TowerToHyperService::new(router.clone());
        let connection = http.serve_connection(TokioIo::new(stream), service);
        let stop = stop.clone();
        let _task = tracker.spawn(async move {
            let mut connection = std::pin::pin!(connection);
            let whole = timeout(LIFE, stop.run_until_cancelled(connection.as_mut()));
            let ended = if let Ok(Some(ended)) = whole.await {
                Ok(ended)
            } else {
                // Its time is over, or the view's: the answer under way is the last one.
                connection.as_mut().graceful_shutdown();
                timeout(FAREWELL, connection).await
            };
            match ended {
                Ok(Ok(())) => {}
                Ok(Err(error)) => {
                    tracing::debug!(%peer, %error, "A client of the view broke off.");
                }
                Err(_) => tracing::debug!(%peer, "A client of the view took no answer."),
            }
            drop(place);
        });
    }
}
