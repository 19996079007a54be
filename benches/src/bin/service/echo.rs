//! A bare TCP echo: what the machine and the runtime leave of a latency at best.

use std::net::Ipv4Addr;

use anyhow::Result;
use benches::processes;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};

use crate::client::Client;
use crate::schedule::Load;

/// Asks at this rate for as many bytes as a state has.
pub(crate) fn load(port: u16, rate: f64) -> Load {
    Load::new("bare TCP echo", rate, 32, move |_worker| {
        let mut client = Client::new(port);
        Box::new(move |_number| client.echo(&[b'x'; 512]))
    })
}

/// Echoes until the parent goes away.
pub(crate) async fn run() -> Result<()> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
    let port = listener.local_addr()?.port();
    drop(tokio::spawn(async move {
        while let Ok((stream, _)) = listener.accept().await {
            drop(tokio::spawn(echo(stream)));
        }
    }));
    processes::announce_and_wait(port).await
}

async fn echo(mut stream: TcpStream) -> std::io::Result<()> {
    stream.set_nodelay(true)?;
    let mut bytes = [0_u8; 4096];
    loop {
        let count = stream.read(&mut bytes).await?;
        match bytes.get(..count) {
            None | Some([]) => return Ok(()),
            Some(some) => stream.write_all(some).await?,
        }
    }
}
