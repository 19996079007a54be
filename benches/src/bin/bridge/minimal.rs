//! The least that can be called a bridge: an axum route that reads a pose, connects, sends, reads to the end, answers.
//!
//! No checks of the content, no limits, no deadlines, no records, no order between commands: what axum and the network
//! leave at best. The difference to it is what the real server's work costs.

use std::net::Ipv4Addr;

use anyhow::Result;
use axum::extract::{Path, State};
use axum::http::StatusCode;
use axum::routing::post;
use axum::{Json, Router};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};

use crate::processes;

/// Serves `POST /move/{robot}` until the parent goes away.
pub(crate) async fn run(first_port: u16) -> Result<()> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
    let port = listener.local_addr()?.port();
    let router = Router::new()
        .route("/move/{robot}", post(forward))
        .with_state(first_port);
    drop(tokio::spawn(
        async move { axum::serve(listener, router).await },
    ));
    processes::announce_and_wait(port).await
}

async fn forward(
    State(first_port): State<u16>,
    Path(robot): Path<u16>,
    Json([x, y, z, w, p, r]): Json<[f64; 6]>,
) -> Result<String, StatusCode> {
    let [x, y, z, w, p, r] = [x, y, z, w, p, r].map(|value| (value * 1000.0).round());
    let line = format!("{x} {y} {z} {w} {p} {r} 200 1");
    let exchange = async {
        let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, first_port + robot)).await?;
        stream.write_all(line.as_bytes()).await?;
        let mut reply = String::with_capacity(64);
        let _length = stream.read_to_string(&mut reply).await?;
        std::io::Result::Ok(reply)
    };
    exchange.await.map_err(|_| StatusCode::BAD_GATEWAY)
}
