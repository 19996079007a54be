//! Streams of events over HTTP.

use journal::MemoryDisk;
use serde_json::Value;
use tokio::io::{AsyncBufReadExt as _, AsyncWriteExt as _, BufReader, Lines};
use tokio::net::TcpStream;
use tokio::net::tcp::OwnedReadHalf;

use crate::mobile_signals::{send, serve, signal};
use crate::support::TestServer;

const EVENTS: &str = "/api/v1/cells/c1/events";

/// A connection on which events come.
struct Listener {
    lines: Lines<BufReader<OwnedReadHalf>>,
    _write: tokio::net::tcp::OwnedWriteHalf,
}

#[derive(Debug, Default)]
struct Block {
    event: String,
    id: Option<String>,
    data: Value,
}

impl Listener {
    async fn open(server: &TestServer, query: &str, last: Option<&str>) -> Self {
        let (read, mut write) = TcpStream::connect(server.address)
            .await
            .unwrap()
            .into_split();
        let last = last.map(|id| format!("last-event-id: {id}\r\n"));
        // Without chunks: what comes is what was written.
        let head = format!(
            "GET {EVENTS}{query} HTTP/1.0\r\nhost: localhost\r\n{}\r\n",
            last.unwrap_or_default()
        );
        write.write_all(head.as_bytes()).await.unwrap();
        let mut lines = BufReader::new(read).lines();
        let status = lines.next_line().await.unwrap().unwrap();
        assert!(status.contains(" 200 "), "{status}");
        while !lines.next_line().await.unwrap().unwrap().is_empty() {}
        Self {
            lines,
            _write: write,
        }
    }

    async fn block(&mut self) -> Block {
        let (mut block, mut any) = (Block::default(), false);
        loop {
            let line = self
                .lines
                .next_line()
                .await
                .unwrap()
                .expect("the stream goes on");
            match line.split_once(": ") {
                Some(("event", event)) => event.clone_into(&mut block.event),
                Some(("id", id)) => block.id = Some(id.to_owned()),
                Some(("data", data)) => block.data = serde_json::from_str(data).unwrap(),
                _ if line.is_empty() && any => return block,
                _ => continue,
            }
            any = true;
        }
    }

    /// The first event whose sentence has this in it, and the last id that came with it or before.
    async fn until(&mut self, text: &str) -> (Value, String) {
        let mut last = String::new();
        loop {
            let block = self.block().await;
            last = block.id.unwrap_or(last);
            let said = block.data["data"]["text"].as_str().unwrap_or_default();
            if said.contains(text) {
                return (block.data, last);
            }
        }
    }
}

#[tokio::test]
async fn what_happens_is_told_at_once_in_the_form_of_cloudevents() {
    let server = serve(&MemoryDisk::new()).await;
    let mut listener = Listener::open(&server, "", None).await;
    let begin = listener.block().await;
    assert!(begin.id.is_some() && begin.data.is_null(), "{begin:?}");
    assert_eq!(send(&server, &signal("MR_FAULT", (1, 1))).await.status, 200);
    let (event, id) = listener.until("mr1 says MR_FAULT").await;
    assert_eq!(event["specversion"], "1.0");
    assert_eq!(event["source"], "/api/v1/cells/c1");
    assert_eq!(event["type"], "robocell.mobile-robot.signal");
    assert_eq!(event["subject"], "mobile-robots/mr1");
    assert_eq!(event["id"], format!("{id}-0"));
    assert_eq!(event["data"]["signal"]["seq"], 1);
}

#[tokio::test]
async fn a_listener_goes_on_where_it_was_after_a_restart_of_the_server() {
    let disk = MemoryDisk::new();
    let server = serve(&disk).await;
    let mut listener = Listener::open(&server, "?from=0-0", None).await;
    assert_eq!(send(&server, &signal("MR_FAULT", (1, 1))).await.status, 200);
    let (_first, last) = listener.until("mr1 says MR_FAULT").await;
    drop(listener);
    assert_eq!(
        send(&server, &signal("LOAD_CHANGED", (1, 2))).await.status,
        200
    );
    server.stopped().await;

    let server = serve(&disk).await;
    let mut listener = Listener::open(&server, "", Some(&last)).await;
    let missed = listener.block().await;
    assert_eq!(missed.data["data"]["text"], "mr1 says LOAD_CHANGED");
    let (restarted, _id) = listener.until("was started").await;
    assert_eq!(restarted["type"], "robocell.server.started");
    assert_eq!(send(&server, &signal("MR_MODE", (1, 3))).await.status, 200);
    let (_live, id) = listener.until("mr1 says MR_MODE").await;
    assert!(
        id.starts_with("2-"),
        "the second opening of the journal: {id}"
    );
}

#[tokio::test]
async fn an_id_of_another_journal_is_a_gap() {
    let server = serve(&MemoryDisk::new()).await;
    let mut listener = Listener::open(&server, "", Some("7-1000000")).await;
    let gap = listener.block().await;
    assert_eq!(gap.event, "gap");
    assert_eq!(gap.data["reason"], "OTHER_JOURNAL");
    assert_eq!(gap.data["to"], gap.id.unwrap());
    assert_eq!(send(&server, &signal("MR_FAULT", (1, 1))).await.status, 200);
    let _event = listener.until("mr1 says MR_FAULT").await;
}

#[tokio::test]
async fn the_state_of_the_cell_comes_with_it_where_it_is_asked_for() {
    let server = serve(&MemoryDisk::new()).await;
    let mut listener = Listener::open(&server, "?status=true&types=robocell.motion", None).await;
    let status = loop {
        let block = listener.block().await;
        if block.event == "status" {
            break block.data;
        }
    };
    assert_eq!(status["points"][0]["point"], "handover/front");
    assert_eq!(status["points"][0]["arm_entry_permit"], false);
    let loads = status["loads"].as_array().unwrap();
    assert!(loads.iter().any(|load| load["at"] == "rack/a"), "{status}");
}

#[tokio::test]
async fn a_stream_is_asked_for_properly() {
    let server = serve(&MemoryDisk::new()).await;
    for query in [
        "from=3",
        "from=x-1",
        "types=",
        "types=ROBOCELL",
        "job=1",
        "limit=3",
    ] {
        let reply = server.get(&format!("{EVENTS}?{query}")).await;
        let _problem = reply.problem(422, "validation", "NONE");
    }
    let headers = [("last-event-id", "nonsense")];
    let reply = server.bare("GET", EVENTS, &headers, "").await;
    let _problem = reply.problem(422, "validation", "NONE");
}
