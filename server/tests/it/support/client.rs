use std::fmt::Write as _;
use std::net::SocketAddr;
use std::sync::LazyLock;

use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

/// An answer, taken apart.
#[derive(Debug)]
pub(crate) struct HttpReply {
    pub(crate) status: u16,
    head: String,
    pub(crate) body: String,
}

impl HttpReply {
    fn parse(bytes: &[u8]) -> Self {
        let text = String::from_utf8_lossy(bytes);
        let (head, body) = text
            .split_once("\r\n\r\n")
            .unwrap_or_else(|| panic!("no whole answer: {text:?}"));
        Self {
            status: head[9..12].parse().unwrap(),
            head: head.to_owned(),
            body: body.to_owned(),
        }
    }

    pub(crate) fn header(&self, name: &str) -> Option<&str> {
        self.head.lines().skip(1).find_map(|line| {
            let (key, value) = line.split_once(": ")?;
            key.eq_ignore_ascii_case(name).then_some(value)
        })
    }

    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.body)
            .unwrap_or_else(|error| panic!("{error} in {:?}", self.body))
    }

    /// Checks that the answer is a problem with this status, code and outcome, complete; returns it.
    pub(crate) fn problem(&self, status: u16, code: &str, outcome: &str) -> Value {
        assert_eq!(self.status, status, "{self:?}");
        assert_eq!(
            self.header("content-type"),
            Some("application/problem+json")
        );
        let problem = self.json();
        assert_eq!(problem["status"], status);
        assert_eq!(problem["code"], code, "{problem}");
        assert_eq!(problem["outcome"], outcome, "{problem}");
        assert_eq!(problem["request_id"], self.header("x-request-id").unwrap());
        assert_eq!(problem["type"], format!("/problems/{code}"));
        assert!(problem["instance"].as_str().unwrap().starts_with('/'));
        problem
    }
}

/// Sends one request on a connection of its own and reads its answer.
pub(crate) async fn request(
    address: SocketAddr,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
    body: &str,
) -> HttpReply {
    let mut stream = TcpStream::connect(address).await.unwrap();
    let mut text = format!("{method} {path} HTTP/1.1\r\nhost: localhost\r\nconnection: close\r\n");
    for (name, value) in headers {
        write!(text, "{name}: {value}\r\n").unwrap();
    }
    if !headers.iter().any(|(name, _)| *name == "transfer-encoding") {
        write!(text, "content-length: {}\r\n", body.len()).unwrap();
    }
    write!(text, "\r\n{body}").unwrap();
    // A server that does not want the body may close before all of it is written, or reset after its answer.
    let _written = stream.write_all(text.as_bytes()).await;
    let mut answer = Vec::new();
    let _end = stream.read_to_end(&mut answer).await;
    let reply = HttpReply::parse(&answer);
    assert_documented(method, path, &reply);
    reply
}

/// Checks an answer against the OpenAPI document: the status is one the operation may have, of that media type.
fn assert_documented(method: &str, path: &str, reply: &HttpReply) {
    static DOCUMENT: LazyLock<Value> =
        LazyLock::new(|| serde_json::to_value(server::openapi()).unwrap());
    let document = &*DOCUMENT;
    let path = path.split('?').next().unwrap();
    let Some((_, item)) = document["paths"]
        .as_object()
        .unwrap()
        .iter()
        .find(|(template, _)| matches(template, path))
    else {
        return;
    };
    // An answer to HEAD is that to GET without its body.
    let method = method.replace("HEAD", "GET");
    let Some(operation) = item.get(method.to_ascii_lowercase()) else {
        assert_eq!(reply.status, 405, "{method} {path} is not documented");
        return;
    };
    let Some(response) = operation["responses"].get(reply.status.to_string()) else {
        panic!("{method} {path} answered {}, undocumented", reply.status);
    };
    let media_type = reply.header("content-type").unwrap_or("none");
    let documented = response["content"]
        .as_object()
        .is_some_and(|content| content.keys().any(|known| media_type.starts_with(known)));
    assert!(
        documented,
        "{method} {path} answered {} as {media_type}, undocumented",
        reply.status
    );
}

fn matches(template: &str, path: &str) -> bool {
    let (templates, parts) = (template.split('/'), path.split('/'));
    templates.clone().count() == parts.clone().count()
        && templates
            .zip(parts)
            .all(|(template, part)| template == part || template.starts_with('{'))
}
