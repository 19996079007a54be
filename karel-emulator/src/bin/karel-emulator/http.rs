//! One question to a running controller over loopback HTTP.
//!
//! The peer is this crate's own panel: one request a connection, the answer's length is given, and everything has a
//! limit.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::ExitCode;
use std::time::Duration;

use serde::Serialize;
use serde_json::Value;

/// How long a connection may take.
const CONNECT: Duration = Duration::from_secs(3);
/// How long an answer may take: more than the longest wait that can be asked for.
const ANSWER: Duration = Duration::from_secs(40);
/// The longest answer.
const ANSWER_BYTES: u64 = 64 << 20;

/// Where the controller is.
#[derive(Clone, Copy, Debug, clap::Args)]
pub(crate) struct Panel {
    /// Address of the controller's panel.
    #[arg(
        long,
        default_value = "127.0.0.1:8081",
        global = true,
        env = "KAREL_EMULATOR_PANEL",
        value_name = "ADDRESS"
    )]
    panel: SocketAddr,
}

/// Why there is no answer.
#[derive(Debug, thiserror::Error)]
pub(crate) enum LinkError {
    /// Nobody there, or it broke off.
    #[error("asking the controller at {address}: {step}")]
    Io {
        address: SocketAddr,
        step: &'static str,
        #[source]
        source: std::io::Error,
    },
    /// No panel of a controller.
    #[error("what answers at {address} is no panel of a virtual controller: {reason}")]
    Protocol { address: SocketAddr, reason: String },
    /// The controller says no.
    #[error("{0}")]
    Refused(String),
}

/// 3 for a link that failed, 1 for a refusal, 2 for everything else.
pub(crate) fn exit_of(error: &anyhow::Error) -> ExitCode {
    match error.downcast_ref::<LinkError>() {
        Some(LinkError::Io { .. } | LinkError::Protocol { .. }) => ExitCode::from(3),
        Some(LinkError::Refused(_)) => ExitCode::from(1),
        None => ExitCode::from(2),
    }
}

impl Panel {
    pub(crate) fn get(self, path: &str) -> Result<Value, LinkError> {
        self.ask("GET", path, None)
    }

    pub(crate) fn post<T: Serialize>(self, path: &str, body: &T) -> Result<Value, LinkError> {
        self.send("POST", path, body)
    }

    pub(crate) fn put<T: Serialize>(self, path: &str, body: &T) -> Result<Value, LinkError> {
        self.send("PUT", path, body)
    }

    pub(crate) fn patch<T: Serialize>(self, path: &str, body: &T) -> Result<Value, LinkError> {
        self.send("PATCH", path, body)
    }

    pub(crate) fn delete(self, path: &str) -> Result<Value, LinkError> {
        self.ask("DELETE", path, None)
    }

    fn send<T: Serialize>(self, method: &str, path: &str, body: &T) -> Result<Value, LinkError> {
        let body = serde_json::to_string(body).map_err(|error| LinkError::Protocol {
            address: self.panel,
            reason: error.to_string(),
        })?;
        self.ask(method, path, Some(&body))
    }

    fn ask(self, method: &str, path: &str, body: Option<&str>) -> Result<Value, LinkError> {
        let address = self.panel;
        let io = |step| {
            move |source| LinkError::Io {
                address,
                step,
                source,
            }
        };
        let mut stream = TcpStream::connect_timeout(&address, CONNECT).map_err(io("connecting"))?;
        stream
            .set_read_timeout(Some(ANSWER))
            .and_then(|()| stream.set_write_timeout(Some(ANSWER)))
            .map_err(io("setting a time limit"))?;
        let content = body.map_or(String::new(), |body| {
            let length = body.len();
            format!("Content-Type: application/json\r\nContent-Length: {length}\r\n")
        });
        let body = body.unwrap_or_default();
        let request = format!(
            "{method} {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{content}\r\n{body}"
        );
        stream
            .write_all(request.as_bytes())
            .map_err(io("sending the request"))?;
        let mut answer = Vec::new();
        let _count = stream
            .take(ANSWER_BYTES)
            .read_to_end(&mut answer)
            .map_err(io("reading the answer"))?;
        let answer = String::from_utf8_lossy(&answer);
        read_answer(&answer).map_err(|problem| match problem {
            Trouble::NotHttp(reason) => LinkError::Protocol {
                address,
                reason: reason.to_owned(),
            },
            Trouble::Refused(detail) => LinkError::Refused(detail),
        })
    }
}

#[derive(Debug, PartialEq)]
enum Trouble {
    NotHttp(&'static str),
    Refused(String),
}

fn read_answer(answer: &str) -> Result<Value, Trouble> {
    let (head, body) = answer
        .split_once("\r\n\r\n")
        .ok_or(Trouble::NotHttp("the answer has no head"))?;
    let status = head
        .strip_prefix("HTTP/1.1 ")
        .and_then(|rest| rest.get(..3)?.parse::<u16>().ok())
        .ok_or(Trouble::NotHttp("the answer has no status"))?;
    if body.is_empty() && (200..300).contains(&status) {
        return Ok(Value::Null);
    }
    let body: Value =
        serde_json::from_str(body).map_err(|_| Trouble::NotHttp("the answer is not JSON"))?;
    if (200..300).contains(&status) {
        return Ok(body);
    }
    match body.get("detail").and_then(Value::as_str) {
        Some(detail) => Err(Trouble::Refused(detail.to_owned())),
        None => Err(Trouble::NotHttp("the refusal has no words")),
    }
}

/// A part of a path or a query, escaped.
pub(crate) fn escape(text: &str) -> String {
    use std::fmt::Write as _;
    text.bytes().fold(String::new(), |mut escaped, byte| {
        if byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_' | b'.' | b'~') {
            escaped.push(char::from(byte));
        } else {
            // Writing to a String does not fail.
            let _ = write!(escaped, "%{byte:02X}");
        }
        escaped
    })
}

/// Prints an answer for machines.
pub(crate) fn print_json(value: &Value) {
    put(&format!("{value:#}\n"));
}

/// Prints text; a reader who has gone is nobody's failure. What programs and peers wrote moves no cursor.
pub(crate) fn put(text: &str) {
    let mut out = std::io::stdout().lock();
    let _gone = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// Text of others without control characters.
pub(crate) fn clean(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { ' ' } else { c })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn answers_are_values_refusals_or_no_http() {
        let ok = "HTTP/1.1 200 OK\r\nx: y\r\n\r\n{\"a\": 1}";
        assert_eq!(read_answer(ok), Ok(serde_json::json!({"a": 1})));
        assert_eq!(
            read_answer("HTTP/1.1 204 No Content\r\n\r\n"),
            Ok(Value::Null)
        );
        let no = "HTTP/1.1 422 X\r\n\r\n{\"detail\": \"too much\"}";
        assert_eq!(
            read_answer(no),
            Err(Trouble::Refused("too much".to_owned()))
        );
        for wrong in [
            "",
            "SSH-2.0\r\n",
            "HTTP/1.1 200 OK\r\n\r\nhello",
            "HTTP/1.1 x\r\n\r\n{}",
        ] {
            assert!(
                matches!(read_answer(wrong), Err(Trouble::NotHttp(_))),
                "{wrong:?}"
            );
        }
    }

    #[test]
    fn paths_are_escaped() {
        assert_eq!(escape("DIN[3]"), "DIN%5B3%5D");
        assert_eq!(escape("$MCR.$X"), "%24MCR.%24X");
    }
}
