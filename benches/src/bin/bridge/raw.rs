//! The limit: connect, send a command, read the answer to its end, close. No HTTP, no validation.

use std::net::{Ipv4Addr, SocketAddr};

use anyhow::{Result, ensure};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;

use crate::robot::REPLY;

/// One exchange with the robot on `port`.
pub(crate) async fn exchange(port: u16) -> Result<()> {
    let address = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
    let mut stream = TcpStream::connect(address).await?;
    stream
        .write_all(b"985000 0 940000 -180000 0 0 200 1")
        .await?;
    let mut reply = Vec::with_capacity(64);
    let _length = stream.read_to_end(&mut reply).await?;
    ensure!(reply == REPLY, "the robot answered {reply:?}");
    Ok(())
}
