//! Callers who hold 256 connections without need, and others who keep the queues of the dead robots full.
//!
//! A third sends a head line by line without end, a third a body byte by byte, a third asks for a large answer and
//! reads a few bytes of it now and then. Half of each come from the honest callers' own address, the others from an
//! address each. Whoever is closed is back at once.

use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use anyhow::Result;
use api::ControlToken;
use benches::processes;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpSocket, TcpStream};
use tokio::time::sleep;

use crate::client::post_controlled;
use crate::motions::{self, BODY};
use crate::plant::{MUTE, UNREACHABLE};

const CONNECTIONS: u8 = 255;
/// More than a queue holds.
const CALLERS_OF_A_DEAD_ROBOT: usize = 20;
/// Between two drops.
const DRIP: Duration = Duration::from_millis(500);
/// Before whoever was closed is back.
const PAUSE: Duration = Duration::from_millis(20);

/// Attacks until the parent wants no more; then says how many connections it made.
#[expect(clippy::print_stdout, reason = "the count goes to the parent")]
pub(crate) async fn run(port: u16, control: ControlToken) -> Result<()> {
    let server = SocketAddr::from((Ipv4Addr::LOCALHOST, port));
    let made = Arc::new(AtomicU64::new(0));
    for number in 0..=CONNECTIONS {
        let made = Arc::clone(&made);
        drop(tokio::spawn(async move {
            loop {
                let _before = made.fetch_add(1, Ordering::Relaxed);
                // However it ends, it begins again.
                let _ = hold(number, server).await;
                sleep(PAUSE).await;
            }
        }));
    }
    for robot in [MUTE, UNREACHABLE] {
        for caller in 0..CALLERS_OF_A_DEAD_ROBOT {
            drop(tokio::spawn(async move {
                loop {
                    let _ = call_dead_robot(robot, caller, server, control).await;
                    sleep(10 * PAUSE).await;
                }
            }));
        }
    }
    processes::announce_and_wait(port).await?;
    println!("{}", made.load(Ordering::Relaxed));
    Ok(())
}

async fn hold(number: u8, server: SocketAddr) -> Result<()> {
    let socket = TcpSocket::new_v4()?;
    let own = if number.is_multiple_of(2) {
        Ipv4Addr::LOCALHOST
    } else {
        Ipv4Addr::new(127, 0, 1, number)
    };
    socket.bind((own, 0).into())?;
    let kind = number / 2 % 3;
    if kind == 2 {
        socket.set_recv_buffer_size(4096)?;
    }
    let mut stream = socket.connect(server).await?;
    match kind {
        0 => drip_head(&mut stream).await,
        1 => drip_body(&mut stream).await,
        _ => drip_answer(&mut stream).await,
    }
}

async fn drip_head(stream: &mut TcpStream) -> Result<()> {
    stream
        .write_all(b"GET /livez HTTP/1.1\r\nHost: localhost\r\n")
        .await?;
    loop {
        wait(stream).await?;
        stream.write_all(b"X: y\r\n").await?;
    }
}

async fn drip_body(stream: &mut TcpStream) -> Result<()> {
    let head = format!(
        "POST {} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n\
         Idempotency-Key: slow\r\nContent-Length: 60000\r\n\r\n{{",
        motions::path(0)
    );
    stream.write_all(head.as_bytes()).await?;
    loop {
        wait(stream).await?;
        stream.write_all(b" ").await?;
    }
}

/// A drop later, or an error once the server has closed.
async fn wait(stream: &mut TcpStream) -> Result<()> {
    let mut byte = [0_u8; 1];
    tokio::select! {
        read = stream.read(&mut byte) => anyhow::ensure!(read? > 0, "closed"),
        () = sleep(DRIP) => {}
    }
    Ok(())
}

async fn drip_answer(stream: &mut TcpStream) -> Result<()> {
    let request = b"GET /docs/swagger-ui-bundle.js HTTP/1.1\r\nHost: localhost\r\n\r\n";
    stream.write_all(&request.repeat(20)).await?;
    let mut few = [0_u8; 64];
    loop {
        anyhow::ensure!(stream.read(&mut few).await? > 0, "closed");
        sleep(DRIP).await;
    }
}

/// Asks for a motion, and stays until it is answered.
async fn call_dead_robot(
    robot: usize,
    caller: usize,
    server: SocketAddr,
    control: ControlToken,
) -> Result<()> {
    let key = format!("dead-{}-{caller}", motions::run_id());
    let request = post_controlled(&motions::path(robot), &key, control, BODY);
    let mut stream = TcpStream::connect(server).await?;
    stream.write_all(&request).await?;
    let mut answer = [0_u8; 4096];
    let _length = stream.read(&mut answer).await?;
    Ok(())
}
