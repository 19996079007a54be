//! Tests of the test kit itself: each way of breaking the network does what its name says, and nothing else.

mod fake_robot;
mod proxy;

use std::net::SocketAddr;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// Long enough for a slow machine, and never waited for in full when all is well.
const LONG: Duration = Duration::from_secs(20);

const COMMAND: &[u8] = b"600000 200000 600000 -180000 30000 0 200 1";

/// Sends a command and reads the reply to its end.
async fn ask(address: SocketAddr) -> std::io::Result<Vec<u8>> {
    let mut socket = TcpStream::connect(address).await?;
    socket.write_all(COMMAND).await?;
    let mut reply = Vec::new();
    let _ = socket.read_to_end(&mut reply).await?;
    Ok(reply)
}
