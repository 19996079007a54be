//! A minimal HTTP/1.1 client on a connection kept open: the load must cost less than what it measures.

use std::net::{Ipv4Addr, SocketAddr};

use anyhow::{Context as _, Result, bail, ensure};
use api::ControlToken;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;

/// Stands in a request for the number that makes its key a new one.
const NUMBER: &str = "############";

/// A connection kept open, and the one request it sends again and again.
pub(crate) struct Connection {
    stream: TcpStream,
    request: Vec<u8>,
    /// Where in the request the number of its idempotency key stands.
    number_at: Option<usize>,
    sent: u64,
    buffer: Vec<u8>,
}

impl Connection {
    /// Connects to `port`; `body` makes the request a POST of JSON, and `control` is said with it.
    pub(crate) async fn open(
        port: u16,
        path: &str,
        body: Option<&str>,
        control: Option<ControlToken>,
    ) -> Result<Self> {
        let stream = TcpStream::connect(SocketAddr::from((Ipv4Addr::LOCALHOST, port))).await?;
        stream.set_nodelay(true)?;
        let control =
            control.map_or_else(String::new, |token| format!("Control-Token: {token}\r\n"));
        let request = match body {
            Some(body) => format!(
                "POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n{control}\
                 Idempotency-Key: {}-{NUMBER}\r\nContent-Length: {}\r\n\r\n{body}",
                stream.local_addr()?.port(),
                body.len()
            ),
            None => format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n"),
        };
        Ok(Self {
            stream,
            number_at: request.find(NUMBER),
            sent: 0,
            request: request.into_bytes(),
            buffer: Vec::with_capacity(4096),
        })
    }

    /// Sends the request and reads the whole answer; the answer's status.
    pub(crate) async fn exchange(&mut self) -> Result<u16> {
        self.sent += 1;
        if let Some(at) = self.number_at {
            // The same motion with the same key again would be answered and not be sent.
            let number = format!("{:012}", self.sent);
            if let Some(place) = self.request.get_mut(at..at + NUMBER.len()) {
                place.copy_from_slice(number.as_bytes());
            }
        }
        self.stream.write_all(&self.request).await?;
        self.buffer.clear();
        loop {
            let count = self.stream.read_buf(&mut self.buffer).await?;
            ensure!(count > 0, "the server closed the connection");
            if let Some(status) = parse(&self.buffer)? {
                return Ok(status);
            }
        }
    }
}

/// The status, once head and body are complete.
fn parse(bytes: &[u8]) -> Result<Option<u16>> {
    let Some(end) = bytes.windows(4).position(|window| window == b"\r\n\r\n") else {
        return Ok(None);
    };
    let (head, rest) = bytes.split_at(end + 4);
    let head = std::str::from_utf8(head)?;
    let mut lines = head.lines();
    let status = lines
        .next()
        .and_then(|line| line.split(' ').nth(1))
        .context("a status line")?;
    let mut length = 0;
    for line in lines {
        let Some((name, value)) = line.split_once(':') else {
            continue;
        };
        if name.eq_ignore_ascii_case("content-length") {
            length = value.trim().parse::<usize>()?;
        }
        if name.eq_ignore_ascii_case("transfer-encoding") {
            bail!("chunked answers are not expected here");
        }
    }
    Ok((rest.len() >= length).then_some(status.parse()?))
}
