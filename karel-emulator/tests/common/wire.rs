//! The cell server's lines as a test writes and reads them; nothing of the product's own encoder is used.

use std::net::SocketAddr;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

use super::{Stepped, arm, within};
use karel_emulator::cell_server::{COMMAND_PORT, STATUS_PORT};
use karel_emulator::{ControllerConfig, LedgerEvent};

pub(crate) fn cell() -> Stepped {
    Stepped::start(&ControllerConfig::cell_server("test", arm()))
}

pub(crate) fn sum(text: &str) -> u32 {
    text.bytes()
        .fold(0, |c, byte| (c * 31 + u32::from(byte)) % 65_521)
}

pub(crate) fn sealed(text: &str) -> String {
    format!("{text} {}\r\n", sum(text))
}

/// One connection, read line by line; controller time passes while it waits.
pub(crate) struct Line<'a> {
    pub(crate) stream: TcpStream,
    cell: &'a Stepped,
    received: Vec<u8>,
}

/// What an answer says, its checksum taken off.
pub(crate) type Tokens = Vec<String>;

impl<'a> Line<'a> {
    pub(crate) async fn to(cell: &'a Stepped, address: SocketAddr) -> Self {
        let stream = within(TcpStream::connect(address)).await.unwrap();
        Self {
            stream,
            cell,
            received: Vec::new(),
        }
    }

    /// The command port; the greeting is for the caller to read.
    pub(crate) async fn command(cell: &'a Stepped) -> Self {
        let address = within(cell.controller.address_of_port(COMMAND_PORT)).await;
        Self::to(cell, address.unwrap()).await
    }

    pub(crate) async fn status(cell: &'a Stepped) -> Self {
        let address = within(cell.controller.address_of_port(STATUS_PORT)).await;
        Self::to(cell, address.unwrap()).await
    }

    pub(crate) async fn send(&mut self, text: &str) {
        self.raw(sealed(text).as_bytes()).await;
    }

    pub(crate) async fn raw(&mut self, bytes: &[u8]) {
        self.stream.write_all(bytes).await.unwrap();
    }

    /// The next line, or `None` at the end of the connection. Steps the controller, 4 ms at a time, for at most
    /// `seconds` of its time.
    pub(crate) async fn next_within(&mut self, seconds: f64) -> Option<Tokens> {
        let mut left = seconds;
        loop {
            if let Some(end) = self.received.iter().position(|byte| *byte == b'\n') {
                let line: Vec<u8> = self.received.drain(..=end).collect();
                let line = String::from_utf8(line).unwrap();
                return Some(opened(line.trim_end()));
            }
            let mut bytes = [0; 1024];
            match self.stream.try_read(&mut bytes) {
                Ok(0) => return None,
                Ok(count) => self.received.extend_from_slice(&bytes[..count]),
                Err(error) if error.kind() == std::io::ErrorKind::WouldBlock => {
                    assert!(
                        left > 0.0,
                        "no line in {seconds} s of controller time: {:#?}",
                        self.cell.controller.state().await
                    );
                    self.cell.advance(0.004).await;
                    left -= 0.004;
                    tokio::task::yield_now().await;
                }
                Err(_) => return None,
            }
        }
    }

    pub(crate) async fn next(&mut self) -> Tokens {
        self.next_within(60.0).await.expect("the connection ended")
    }

    /// Sends a line to the status port and reads the answer.
    pub(crate) async fn ask(&mut self, text: &str) -> Tokens {
        self.send(text).await;
        self.next().await
    }

    /// Reads to the end of the connection.
    pub(crate) async fn closed(&mut self) {
        assert_eq!(self.next_within(5.0).await, None);
    }

    pub(crate) async fn drain(&mut self) {
        let mut rest = Vec::new();
        let _count = within(self.stream.read_to_end(&mut rest)).await;
    }
}

/// Takes the checksum off, which must be right.
pub(crate) fn opened(line: &str) -> Tokens {
    let (text, given) = line.rsplit_once(' ').expect("a line has two tokens");
    assert_eq!(given, sum(text).to_string(), "the checksum of {line:?}");
    text.split(' ').map(str::to_owned).collect()
}

/// `V2 <boot> ..`: the nonce.
pub(crate) fn nonce(greeting: &[String]) -> String {
    assert_eq!(greeting[0], "V2");
    assert_eq!(greeting.len(), 9);
    greeting[8].clone()
}

/// A joint motion to joint values in degrees.
pub(crate) fn joints(id: (u32, u32), nonce: &str, deg: [f64; 6], percent: u32) -> String {
    let [a, b, c, d, e, f] = deg.map(milli);
    let (epoch, seq) = id;
    format!("M {epoch} {seq} {nonce} 3 {a} {b} {c} {d} {e} {f} {percent} N U T 0 0 0")
}

/// A motion to a pose: kind 1 or 2.
pub(crate) fn pose(
    id: (u32, u32),
    nonce: &str,
    kind: u32,
    pose: [f64; 6],
    speed: u32,
    config: &str,
) -> String {
    let [x, y, z, w, p, r] = pose.map(milli);
    let (epoch, seq) = id;
    format!("M {epoch} {seq} {nonce} {kind} {x} {y} {z} {w} {p} {r} {speed} {config}")
}

#[expect(clippy::cast_possible_truncation, reason = "test values are small")]
pub(crate) fn milli(value: f64) -> i64 {
    (value * 1000.0).round() as i64
}

/// Fields of a status line by name.
pub(crate) fn field(status: &[String], name: &str) -> i64 {
    const NAMES: &[&str] = &[
        "boot",
        "epoch_max",
        "acc_epoch",
        "acc_seq",
        "fin_epoch",
        "fin_seq",
        "fin_status",
        "moving",
        "held",
        "mode",
        "pendant",
        "alarm",
        "override",
        "uframe",
        "utool",
        "deadman",
        "outputs",
        "inputs",
        "x",
        "y",
        "z",
        "w",
        "p",
        "r",
        "j1",
        "j2",
        "j3",
        "j4",
        "j5",
        "j6",
    ];
    assert_eq!(status[0], "ST");
    assert_eq!(status.len(), NAMES.len() + 1, "{status:?}");
    let index = NAMES.iter().position(|known| *known == name).unwrap();
    status[index + 1].parse().unwrap()
}

/// Sends one command on a connection of its own and returns the first answer and the open connection.
pub(crate) async fn command<'a>(
    cell: &'a Stepped,
    text: impl FnOnce(&str) -> String,
) -> (Tokens, Line<'a>) {
    let mut line = Line::command(cell).await;
    let greeting = line.next().await;
    let text = text(&nonce(&greeting));
    line.send(&text).await;
    (line.next().await, line)
}

/// How often the arm started a motion for each command.
pub(crate) async fn starts(cell: &Stepped) -> Vec<(u32, u32)> {
    let ledger = cell.controller.ledger().await.unwrap();
    let started = ledger
        .iter()
        .filter(|entry| entry.event == LedgerEvent::Started);
    started
        .map(|entry| entry.command.map(|c| (c.epoch, c.seq)).unwrap_or_default())
        .collect()
}
