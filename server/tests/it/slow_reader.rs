//! A listener to events that takes nothing, over a real socket.

use std::time::Duration;

use journal::MemoryDisk;
use serde_json::{Value, json};
use tokio::io::{AsyncBufReadExt as _, AsyncReadExt as _, AsyncWriteExt as _, BufReader};
use tokio::net::{TcpSocket, TcpStream};

use crate::mobile_signals::{send, serve, signal};
use crate::support::TestServer;

const LIMIT: Duration = Duration::from_mins(1);

async fn listen(server: &TestServer, room: Option<u32>) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    if let Some(room) = room {
        socket.set_recv_buffer_size(room).unwrap();
    }
    let mut stream = socket.connect(server.address).await.unwrap();
    let head = "GET /api/v1/cells/c1/events HTTP/1.0\r\nhost: localhost\r\n\r\n";
    stream.write_all(head.as_bytes()).await.unwrap();
    let mut first = [0; 12];
    let _read = stream.read_exact(&mut first).await.unwrap();
    assert_eq!(&first, b"HTTP/1.0 200");
    stream
}

/// A signal of some 27 KB: an event as large as they come.
fn large(seq: u64) -> Value {
    let mut signal = signal("MR_FAULT", (1, seq));
    let error = json!({"level": "WARNING", "type": "LONG", "description": "x".repeat(400)});
    signal["data"]["errors"] = vec![error; 60].into();
    signal
}

/// The numbers of the signals told of up to the last one or a gap, and the gaps.
async fn read_until(stream: TcpStream, last: u64) -> (Vec<u64>, usize) {
    let (mut seen, mut gaps) = (Vec::new(), 0);
    let mut lines = BufReader::new(stream).lines();
    let read = async {
        while let Ok(Some(line)) = lines.next_line().await {
            if line == "event: gap" {
                // It leads to the newest event, behind which nothing may follow.
                gaps += 1;
                return;
            }
            let Some(data) = line.strip_prefix("data: ") else {
                continue;
            };
            // One that was closed in the middle of an event.
            let Ok(data) = serde_json::from_str::<Value>(data) else {
                return;
            };
            if let Some(seq) = data["data"]["signal"]["seq"].as_u64() {
                seen.push(seq);
                if seq == last {
                    return;
                }
            }
        }
    };
    tokio::time::timeout(LIMIT, read).await.unwrap();
    (seen, gaps)
}

/// One listener takes nothing while more comes than any buffer on the way holds. The other one, and whoever sends, do
/// not notice; the slow one is closed or told what it has missed, and the server keeps no more for it than for anybody.
///
/// Covers: R5.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn r5_a_listener_that_takes_nothing_is_told_of_a_gap_or_closed_and_holds_up_nobody() {
    const COUNT: u64 = 900;
    let server = serve(&MemoryDisk::new()).await;
    let slow = listen(&server, Some(4_096)).await;
    let good = listen(&server, None).await;
    let reading = tokio::spawn(read_until(good, COUNT));
    for seq in 1..=COUNT {
        let signal = large(seq);
        let sent = tokio::time::timeout(Duration::from_secs(5), send(&server, &signal));
        assert_eq!(sent.await.expect("nobody waits for it").status, 200);
    }
    let (seen, gaps) = reading.await.unwrap();
    assert_eq!(gaps, 0);
    assert_eq!(seen, (1..=COUNT).collect::<Vec<_>>());
    // Some 24 MB, of which the buffers of the two sockets and the server's own 8 MiB hold a part.
    let (seen, gaps) = read_until(slow, COUNT).await;
    let missed = usize::try_from(COUNT).unwrap() - seen.len();
    assert!(missed > 0, "it was not slow enough");
    // Closed within its write timeout, or told.
    assert!(gaps > 0 || seen.last() != Some(&COUNT), "{gaps} {seen:?}");
    assert!(seen.is_sorted());
}
