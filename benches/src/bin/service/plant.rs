//! Eight controllers: six answer at once, one takes connections and never says a word, one has a full backlog, so that
//! the handshake with it never ends.

use std::io::Write as _;
use std::net::{Ipv4Addr, SocketAddr};

use anyhow::{Context as _, Result};
use benches::processes;
use socket2::{Domain, Socket, Type};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};

/// How many answer; their places in the list come first.
const GOOD: usize = 6;
/// How many of those are never told to stop, which would take back the motions that wait for them.
pub(crate) const NOT_STOPPED: usize = 4;
/// The one that is mute.
pub(crate) const MUTE: usize = 6;
/// The one that cannot be reached.
pub(crate) const UNREACHABLE: usize = 7;

/// Starts the eight; the ports of all of them in order.
pub(crate) async fn start() -> Result<(processes::Part, Vec<u16>)> {
    let part = processes::start(&["robots".to_owned()]).await?;
    // The first line was the port of a listener that gives the ports.
    let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, part.port)).await?;
    let mut text = String::new();
    let _length = stream.read_to_string(&mut text).await?;
    let ports = text
        .split(',')
        .map(|port| port.trim().parse().context("a port"))
        .collect::<Result<_>>()?;
    Ok((part, ports))
}

/// Runs the eight until the parent goes away.
pub(crate) async fn run() -> Result<()> {
    let mut ports = Vec::new();
    for _ in 0..GOOD {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
        ports.push(listener.local_addr()?.port());
        drop(tokio::spawn(answer_all(listener)));
    }
    let mute = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
    ports.push(mute.local_addr()?.port());
    drop(tokio::spawn(hold_all(mute)));
    let (unreachable, _fillers) = full_backlog()?;
    let address = unreachable
        .local_addr()?
        .as_socket()
        .context("an address")?;
    ports.push(address.port());

    let asked = std::net::TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    let port = asked.local_addr()?.port();
    let text = ports
        .iter()
        .map(ToString::to_string)
        .collect::<Vec<_>>()
        .join(",");
    let told = tokio::task::spawn_blocking(move || asked.accept()?.0.write_all(text.as_bytes()));
    processes::announce_and_wait(port).await?;
    told.await??;
    Ok(())
}

async fn answer_all(listener: TcpListener) {
    while let Ok((stream, _)) = listener.accept().await {
        drop(tokio::spawn(answer(stream)));
    }
}

/// As the seed program: one command a connection.
async fn answer(mut stream: TcpStream) {
    let mut line = [0_u8; 256];
    if matches!(stream.read(&mut line).await, Ok(count) if count > 0) {
        // Who has gone needs no answer.
        let _ = stream.write_all(b"SUCESS: MOVEMENT COMPLETE").await;
    }
}

async fn hold_all(listener: TcpListener) {
    let mut held = Vec::new();
    while let Ok((stream, _)) = listener.accept().await {
        held.push(stream);
    }
}

/// A listener nobody accepts from, and connections that fill its backlog: the kernel drops further ones.
fn full_backlog() -> Result<(Socket, Vec<Socket>)> {
    let listener = Socket::new(Domain::IPV4, Type::STREAM, None)?;
    listener.bind(&SocketAddr::from((Ipv4Addr::LOCALHOST, 0)).into())?;
    listener.listen(1)?;
    let address = listener.local_addr()?;
    let mut fillers = Vec::new();
    for _ in 0..8 {
        let filler = Socket::new(Domain::IPV4, Type::STREAM, None)?;
        filler.set_nonblocking(true)?;
        // In progress is an error here.
        let _ = filler.connect(&address);
        fillers.push(filler);
    }
    Ok((listener, fillers))
}
