//! A caller with a connection it keeps, and opens again where the server has closed it while it was idle.

use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::time::Duration;

use anyhow::{Context as _, Result, bail, ensure};
use api::ControlToken;
use serde_json::Value;

/// The longest an answer is waited for.
const PATIENCE: Duration = Duration::from_secs(30);

/// One caller.
pub(crate) struct Client {
    address: SocketAddr,
    stream: Option<TcpStream>,
    buffer: Vec<u8>,
}

/// How an exchange went.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Answered {
    /// Whether the answer was the expected one.
    pub(crate) expected: bool,
    /// Whether the connection had to be opened again.
    pub(crate) reopened: bool,
}

impl Client {
    pub(crate) fn new(port: u16) -> Self {
        Self {
            address: (Ipv4Addr::LOCALHOST, port).into(),
            stream: None,
            buffer: Vec::with_capacity(4096),
        }
    }

    /// Sends a request and wants this status.
    pub(crate) fn http(&mut self, request: &[u8], status: u16) -> Result<Answered> {
        let (found, reopened) = self.exchange(request, parse)?;
        Ok(Answered {
            expected: found == status,
            reopened,
        })
    }

    /// The status of an answer.
    pub(crate) fn status(&mut self, request: &[u8]) -> Result<u16> {
        Ok(self.exchange(request, parse)?.0)
    }

    /// The JSON an answer has.
    pub(crate) fn body(&mut self, request: &[u8]) -> Result<Value> {
        let _status = self.status(request)?;
        let end = self.buffer.windows(4).position(|part| part == b"\r\n\r\n");
        let body = end.and_then(|end| self.buffer.get(end + 4..));
        Ok(serde_json::from_slice(body.context("a body")?)?)
    }

    /// Sends bytes and wants as many back.
    pub(crate) fn echo(&mut self, bytes: &[u8]) -> Result<Answered> {
        let length = bytes.len();
        let whole = move |received: &[u8]| Ok((received.len() == length).then_some(()));
        let ((), reopened) = self.exchange(bytes, whole)?;
        Ok(Answered {
            expected: true,
            reopened,
        })
    }

    fn exchange<T>(
        &mut self,
        request: &[u8],
        whole: impl Fn(&[u8]) -> Result<Option<T>>,
    ) -> Result<(T, bool)> {
        let was_open = self.stream.is_some();
        match self.try_exchange(request, &whole) {
            Ok(answer) => Ok((answer, false)),
            // An idle connection may be closed at any time; nothing of an answer came, and what is sent again has
            // the same key.
            Err(_) if was_open && self.buffer.is_empty() => {
                self.stream = None;
                Ok((self.try_exchange(request, &whole)?, true))
            }
            Err(error) => {
                self.stream = None;
                Err(error)
            }
        }
    }

    fn try_exchange<T>(
        &mut self,
        request: &[u8],
        whole: impl Fn(&[u8]) -> Result<Option<T>>,
    ) -> Result<T> {
        self.buffer.clear();
        if self.stream.is_none() {
            let stream = TcpStream::connect_timeout(&self.address, PATIENCE)?;
            stream.set_nodelay(true)?;
            stream.set_read_timeout(Some(PATIENCE))?;
            self.stream = Some(stream);
        }
        let stream = self.stream.as_mut().context("just opened")?;
        stream.write_all(request)?;
        let mut part = [0_u8; 4096];
        loop {
            let count = stream.read(&mut part)?;
            ensure!(count > 0, "the server closed the connection");
            self.buffer
                .extend_from_slice(part.get(..count).unwrap_or_default());
            if let Some(answer) = whole(&self.buffer)? {
                return Ok(answer);
            }
        }
    }
}

/// A `GET`.
pub(crate) fn get(path: &str) -> Vec<u8> {
    format!("GET {path} HTTP/1.1\r\nHost: localhost\r\n\r\n").into_bytes()
}

/// A `POST` of JSON with a key of its own.
pub(crate) fn post(path: &str, key: &str, body: &str) -> Vec<u8> {
    posted(path, key, "", body)
}

/// A `POST` of JSON by whoever has control.
pub(crate) fn post_controlled(path: &str, key: &str, control: ControlToken, body: &str) -> Vec<u8> {
    posted(path, key, &format!("Control-Token: {control}\r\n"), body)
}

fn posted(path: &str, key: &str, more: &str, body: &str) -> Vec<u8> {
    format!(
        "POST {path} HTTP/1.1\r\nHost: localhost\r\nContent-Type: application/json\r\n{more}\
         Idempotency-Key: {key}\r\nContent-Length: {}\r\n\r\n{body}",
        body.len()
    )
    .into_bytes()
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
