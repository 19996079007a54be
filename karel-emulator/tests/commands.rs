//! Right and wrong commands, to a program that reads its fields with one READ each and to one that reads them with
//! a single READ. The clients keep their side open and wait, unless a test says otherwise.

mod common;

use std::net::SocketAddr;
use std::time::Duration;

use common::{
    ACCEPTED, INCORRECT, LINE, PORT, Stepped, UNREACHABLE, call, config_of, read_to_end,
    sock_server, wait_until, within,
};
use karel_emulator::ControllerConfig;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;

fn both() -> [ControllerConfig; 2] {
    let eight_reads = config_of(include_str!("programs/eight_reads.kl"), &[PORT]);
    [eight_reads, sock_server()]
}

/// Neither a byte nor an end has come.
#[allow(clippy::unwrap_used, reason = "a failure stops the test")]
async fn is_silent(cell: &Stepped, stream: &mut TcpStream) -> bool {
    cell.advance(60.0).await;
    let mut byte = [0];
    let answer = tokio::time::timeout(Duration::from_millis(20), stream.read(&mut byte));
    answer.await.is_err()
}

#[allow(clippy::unwrap_used, reason = "a failure stops the test")]
async fn connect(address: SocketAddr) -> TcpStream {
    let stream = within(TcpStream::connect(address)).await.unwrap();
    stream.set_nodelay(true).unwrap();
    stream
}

#[tokio::test]
async fn a_wrong_field_is_answered_at_once_while_the_client_waits() {
    for config in both() {
        let cell = Stepped::start(&config);
        let address = cell.address().await;
        for wrong in [
            &b"a b c d e f g h\n"[..],
            b"a b c d e f g h",
            b"a,b,c,d,e,f,g,h",
            b"1 2 x 4 5 6 7 1",
            b"1 2 3 4 5 6 7 x",
            b"1.5 2 3 4 5 6 7 1",
            b"99999999999 2 3 4 5 6 7 1",
        ] {
            assert_eq!(call(address, wrong).await, INCORRECT, "{wrong:?}");
        }
        assert_eq!(call(address, LINE).await, ACCEPTED);
        assert_eq!(cell.events().await.len(), 1, "only the right one moves");
    }
}

#[tokio::test]
async fn a_far_pose_and_a_wild_speed_are_unreachable() {
    for config in both() {
        let cell = Stepped::start(&config);
        let address = cell.address().await;
        for wrong in [
            &b"9000000 0 0 0 0 0 300 1"[..],
            b"600000 200000 600000 -180000 30000 0 0 1",
            b"600000 200000 600000 -180000 30000 0 2000 1",
            b"600000 200000 600000 -180000 30000 0 -300 1",
            b"2147483647 -2147483648 0 2147483647 0 0 300 1",
        ] {
            assert_eq!(call(address, wrong).await, UNREACHABLE, "{wrong:?}");
        }
        assert_eq!(cell.events().await, []);
    }
}

#[tokio::test]
async fn a_short_line_waits_and_is_incorrect_once_the_client_has_closed_its_side() {
    for config in both() {
        let cell = Stepped::start(&config);
        for short in [
            &b""[..],
            b"600000 200000",
            b"600000 200000\n",
            b"1 2 3 4 5 6 7 ",
        ] {
            let mut stream = connect(cell.address().await).await;
            stream.write_all(short).await.unwrap();
            assert!(is_silent(&cell, &mut stream).await, "{short:?}");
            stream.shutdown().await.unwrap();
            assert_eq!(read_to_end(&mut stream).await, INCORRECT, "{short:?}");
        }
    }
}

#[tokio::test]
async fn numbers_may_be_split_over_packets() {
    for config in both() {
        let cell = Stepped::start(&config);
        for size in [1, 2, 3, 7] {
            let mut stream = connect(cell.address().await).await;
            for piece in LINE.chunks(size) {
                stream.write_all(piece).await.unwrap();
                cell.advance(0.001).await;
            }
            let mut reply = vec![0; ACCEPTED.len()];
            let _count = within(stream.read_exact(&mut reply)).await.unwrap();
            assert_eq!(reply, ACCEPTED.as_bytes(), "pieces of {size}");
            cell.until_standstill().await;
        }
    }
}

#[tokio::test]
async fn a_client_that_goes_away_in_the_middle_of_a_line_makes_way_for_the_next() {
    for config in both() {
        let cell = Stepped::start(&config);
        let address = cell.address().await;
        for cut in [0, 1, 7, 20, LINE.len() - 1] {
            let mut stream = connect(address).await;
            stream.write_all(&LINE[..cut]).await.unwrap();
            drop(stream);
        }
        let mut reset = connect(address).await;
        reset.write_all(b"1 2 x").await.unwrap();
        reset.set_zero_linger().unwrap();
        drop(reset);
        assert_eq!(call(address, LINE).await, ACCEPTED);
        assert_eq!(cell.events().await.len(), 1, "a cut line moves nothing");
    }
}

#[tokio::test]
async fn a_hundred_clients_come_one_after_the_other() {
    for config in both() {
        let cell = Stepped::start(&config);
        let address = cell.address().await;
        for _ in 0..100 {
            assert_eq!(call(address, b"a b c d e f g h\n").await, INCORRECT);
        }
        wait_until(&cell.controller, |s| s.tags[0].state == "listening").await;
    }
}
