//! A trivial robot: what is left of a controller when nothing but the exchange of bytes costs time.

use std::net::{Ipv4Addr, SocketAddr};

use anyhow::{Context as _, Result};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};

use crate::processes;

/// The answer of the seed program to a command it takes.
pub(crate) const REPLY: &[u8] = b"SUCESS: MOVEMENT COMPLETE";

/// Listens on `ports` consecutive ports until the parent goes away.
pub(crate) async fn run(ports: usize) -> Result<()> {
    let listeners = bind_consecutive(ports).await?;
    let first = listeners
        .first()
        .context("at least one port")?
        .local_addr()?
        .port();
    for listener in listeners {
        drop(tokio::spawn(accept(listener)));
    }
    processes::announce_and_wait(first).await
}

async fn bind_consecutive(ports: usize) -> Result<Vec<TcpListener>> {
    for _ in 0..100 {
        let first = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
        let start = first.local_addr()?.port();
        let mut listeners = vec![first];
        for offset in 1..u16::try_from(ports)? {
            let Some(port) = start.checked_add(offset) else {
                break;
            };
            let Ok(listener) = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).await else {
                break;
            };
            listeners.push(listener);
        }
        if listeners.len() == ports {
            return Ok(listeners);
        }
    }
    anyhow::bail!("no {ports} consecutive free ports found in 100 tries")
}

async fn accept(listener: TcpListener) {
    loop {
        let Ok((stream, _peer)): Result<(TcpStream, SocketAddr), _> = listener.accept().await
        else {
            continue;
        };
        drop(tokio::spawn(serve(stream)));
    }
}

async fn serve(mut stream: TcpStream) {
    let mut line = [0_u8; 256];
    if matches!(stream.read(&mut line).await, Ok(count) if count > 0) {
        // A peer that has gone is the load's business; its own count shows it.
        let _ = stream.write_all(REPLY).await;
    }
}
