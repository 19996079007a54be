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

/// Below the ports that the system gives to connections: the load has used thousands of those.
async fn bind_consecutive(ports: usize) -> Result<Vec<TcpListener>> {
    const LOWEST: u32 = 10_000;
    const RANGE: u32 = 20_000;
    let count = u16::try_from(ports)?;
    for attempt in 0..100 {
        let steps = std::process::id().wrapping_add(attempt);
        let start = LOWEST + steps.wrapping_mul(u32::from(count)) % (RANGE - u32::from(count));
        let start = u16::try_from(start)?;
        let mut listeners = Vec::new();
        for port in start..start + count {
            match TcpListener::bind((Ipv4Addr::LOCALHOST, port)).await {
                Ok(listener) => listeners.push(listener),
                Err(_) => break,
            }
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
