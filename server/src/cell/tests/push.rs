//! Pushing, to robots that answer as they should not.

use std::time::Duration;

use journal::MemoryDisk;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use tokio_util::sync::CancellationToken;

use super::World;
use crate::cell::push;

/// Where a robot listens, and a push of its messages there.
async fn pushing(world: &World) -> (TcpListener, CancellationToken) {
    let robot = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let url = format!("http://{}/messages", robot.local_addr().unwrap());
    let stop = CancellationToken::new();
    drop(tokio::spawn(push(
        "mr1".to_owned(),
        url,
        world.outboxes.clone(),
        stop.clone(),
    )));
    (robot, stop)
}

/// The next request, read to the end of its body.
async fn asked(robot: &TcpListener) -> (TcpStream, String) {
    let (mut stream, _) = robot.accept().await.unwrap();
    let mut text = String::new();
    let mut buffer = [0; 4096];
    loop {
        let count = stream.read(&mut buffer).await.unwrap();
        text.push_str(str::from_utf8(&buffer[..count]).unwrap());
        if let Some((head, body)) = text.split_once("\r\n\r\n") {
            let length = head
                .lines()
                .find_map(|line| line.strip_prefix("content-length: "));
            if body.len() >= length.unwrap().parse().unwrap() {
                let body = body.to_owned();
                return (stream, body);
            }
        }
    }
}

async fn answer(stream: &mut TcpStream, head: &str, body: &str) {
    let length = body.len();
    let text =
        format!("HTTP/1.1 {head}\r\ncontent-length: {length}\r\nconnection: close\r\n\r\n{body}");
    stream.write_all(text.as_bytes()).await.unwrap();
}

/// Covers: M11. Messages go where the configuration says, in order, and are off the outbox once they are taken.
#[tokio::test]
async fn messages_are_pushed_to_the_configured_address_and_acknowledged() {
    let world = World::on(&MemoryDisk::new()).await;
    let (robot, _stop) = pushing(&world).await;
    let _job = world.pickup().await;
    let (mut stream, body) = asked(&robot).await;
    let message: api::OutboxMessage = serde_json::from_str(&body).unwrap();
    assert_eq!(message, world.message("TRANSPORT_ORDER").await);
    let taken = format!("{{\"n\": {}}}", message.n);
    answer(
        &mut stream,
        "200 OK\r\ncontent-type: application/json",
        &taken,
    )
    .await;
    let mut news = world.outboxes.watch();
    while !world.outboxes.after("mr1", 0).is_empty() {
        news.changed().await.unwrap();
    }
}

/// Covers: M12. Whatever is not a plain yes leaves the message where it is, and it is pushed again.
#[tokio::test]
async fn an_answer_that_is_no_yes_is_not_taken_for_one() {
    let world = World::on(&MemoryDisk::new()).await;
    let (robot, _stop) = pushing(&world).await;
    let elsewhere = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let away = format!(
        "307 Elsewhere\r\nlocation: http://{}/",
        elsewhere.local_addr().unwrap()
    );
    let _job = world.pickup().await;
    let huge = "x".repeat(256 * 1024 + 1);
    let answers = [
        ("200 OK\r\ncontent-type: text/html", "<html>ok</html>"),
        (&*away, ""),
        ("204 No Content", ""),
        ("200 OK", "{\"n\": 999}"),
        ("200 OK", &huge),
    ];
    let mut first = None;
    for (head, body) in answers {
        let (mut stream, message) = asked(&robot).await;
        let first = first.get_or_insert_with(|| message.clone());
        assert_eq!(*first, message);
        // It stops reading before the end of what is too long.
        let length = body.len();
        let text = format!(
            "HTTP/1.1 {head}\r\ncontent-length: {length}\r\nconnection: close\r\n\r\n{body}"
        );
        let _cut = stream.write_all(text.as_bytes()).await;
    }
    let (_stream, _message) = asked(&robot).await;
    // The order may have been sent again meanwhile; the first one is still there.
    let pushed: api::OutboxMessage = serde_json::from_str(&first.unwrap()).unwrap();
    assert_eq!(world.outboxes.after("mr1", 0).first(), Some(&pushed));
    let nobody = tokio::time::timeout(Duration::ZERO, elsewhere.accept()).await;
    assert!(nobody.is_err(), "a redirect was followed");
}

/// Covers: M12. A drip of bytes does not keep the push waiting.
#[tokio::test]
async fn a_slow_drip_has_three_seconds() {
    let world = World::on(&MemoryDisk::new()).await;
    let (robot, _stop) = pushing(&world).await;
    let _job = world.pickup().await;
    let (mut stream, _message) = asked(&robot).await;
    let begun = std::time::Instant::now();
    let head = "HTTP/1.1 200 OK\r\ncontent-length: 100000\r\n\r\n";
    stream.write_all(head.as_bytes()).await.unwrap();
    let mut ticks = tokio::time::interval(Duration::from_millis(100));
    let again = loop {
        tokio::select! {
            again = asked(&robot) => break again,
            _tick = ticks.tick() => { let _gone = stream.write_all(b" ").await; }
        }
    };
    let took = begun.elapsed().as_millis();
    assert!((2_900..10_000).contains(&took), "{took} ms");
    drop(again);
}
