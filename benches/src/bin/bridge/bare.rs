//! A bare axum route: what HTTP alone costs.

use std::net::Ipv4Addr;

use anyhow::Result;
use axum::Router;
use axum::routing::get;
use tokio::net::TcpListener;

use crate::processes;

/// Serves `GET /` until the parent goes away.
pub(crate) async fn run() -> Result<()> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
    let port = listener.local_addr()?.port();
    let router = Router::new().route("/", get(|| async { "hello" }));
    drop(tokio::spawn(
        async move { axum::serve(listener, router).await },
    ));
    processes::announce_and_wait(port).await
}
