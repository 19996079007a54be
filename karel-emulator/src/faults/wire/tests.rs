//! Each fault on one connection.

use super::*;

const ONE: ConnectionId = ConnectionId(1);
const MS: Duration = Duration::from_millis(1);

fn wire() -> Wire {
    let mut wire = Wire::new(1);
    wire.connected(ONE, Tag::try_new(3).unwrap(), Some(59_002));
    wire
}

fn bytes_in(wire: &mut Wire, now: Duration, bytes: &[u8]) -> Vec<Vec<u8>> {
    let mut passed = Passed::default();
    let event = Event::Bytes {
        connection: ONE,
        bytes: bytes.to_vec(),
        request_id: None,
    };
    wire.incoming(now, event, &mut passed);
    texts(passed)
}

fn released(wire: &mut Wire, now: Duration) -> Vec<Vec<u8>> {
    let mut passed = Passed::default();
    wire.release(now, &mut passed);
    texts(passed)
}

fn texts(passed: Passed) -> Vec<Vec<u8>> {
    let events = passed.events.into_iter();
    let bytes = |event| {
        if let Event::Bytes { bytes, .. } = event {
            Some(bytes)
        } else {
            None
        }
    };
    events.filter_map(bytes).collect()
}

#[test]
fn a_delay_keeps_the_order_and_says_when_it_is_over() {
    let mut wire = wire();
    let kind = FaultKind::Delay {
        ms: 5,
        jitter_ms: 0,
    };
    let _none = wire.add(1, kind, Scope::default(), Some(1));
    assert!(bytes_in(&mut wire, Duration::ZERO, b"late").is_empty());
    assert!(
        bytes_in(&mut wire, MS, b"behind").is_empty(),
        "waits behind it"
    );
    assert_eq!((wire.next_due(), wire.held(ONE)), (Some(5 * MS), 10));
    assert!(released(&mut wire, 4 * MS).is_empty());
    assert_eq!(
        released(&mut wire, 5 * MS),
        [b"late".to_vec(), b"behind".to_vec()]
    );
    assert_eq!(bytes_in(&mut wire, 6 * MS, b"now"), [b"now".to_vec()]);
}

#[test]
fn split_truncate_drop_and_corrupt_do_what_they_say() {
    let mut wire = wire();
    let _none = wire.add(
        1,
        FaultKind::Split {
            bytes: 2,
            gap_ms: 3,
        },
        Scope::default(),
        Some(1),
    );
    assert_eq!(
        bytes_in(&mut wire, Duration::ZERO, b"abcde"),
        [b"ab".to_vec()]
    );
    assert_eq!(released(&mut wire, 3 * MS), [b"cd".to_vec()]);
    assert_eq!(released(&mut wire, 6 * MS), [b"e".to_vec()]);
    let _none = wire.add(
        2,
        FaultKind::Truncate { keep: 1 },
        Scope::default(),
        Some(1),
    );
    assert_eq!(bytes_in(&mut wire, 7 * MS, b"abc"), [b"a".to_vec()]);
    let _none = wire.add(3, FaultKind::Drop, Scope::default(), Some(1));
    assert!(bytes_in(&mut wire, 7 * MS, b"abc").is_empty());
    let _none = wire.add(
        4,
        FaultKind::Corrupt { bytes: 2 },
        Scope::default(),
        Some(1),
    );
    let changed = bytes_in(&mut wire, 7 * MS, b"abcdef").remove(0);
    let differ = changed.iter().zip(b"abcdef").filter(|(a, b)| a != b);
    assert_eq!(differ.count(), 2);
    assert_eq!(
        bytes_in(&mut wire, 7 * MS, b"abc"),
        [b"abc".to_vec()],
        "all are spent"
    );
}

#[test]
fn a_fault_strikes_in_its_scope_only() {
    let mut wire = wire();
    let scope = |port, direction| Scope {
        port,
        direction,
        ..Scope::default()
    };
    let _none = wire.add(1, FaultKind::Drop, scope(Some(1), Direction::Both), None);
    let _none = wire.add(2, FaultKind::Drop, scope(None, Direction::Out), None);
    assert_eq!(bytes_in(&mut wire, MS, b"x"), [b"x".to_vec()]);
    let mut passed = Passed::default();
    let bytes = b"reply".to_vec();
    wire.outgoing(
        MS,
        Effect::Send {
            connection: ONE,
            bytes,
        },
        &mut passed,
    );
    assert!(passed.effects.is_empty());
    let sent = Event::Sent {
        connection: ONE,
        count: 5,
    };
    assert_eq!(passed.events, [sent], "the program's buffer is free again");
    assert_eq!(wire.rule(2), Some((1, None)));
}

#[test]
fn a_half_open_peer_neither_speaks_nor_hears_until_the_fault_ends() {
    let mut wire = wire();
    let _none = wire.add(9, FaultKind::HalfOpen, Scope::default(), Some(1));
    assert!(bytes_in(&mut wire, MS, b"x").is_empty());
    let mut passed = Passed::default();
    wire.incoming(MS, Event::PeerClosed { connection: ONE }, &mut passed);
    let bytes = b"reply".to_vec();
    wire.outgoing(
        MS,
        Effect::Send {
            connection: ONE,
            bytes,
        },
        &mut passed,
    );
    assert!(passed.effects.is_empty() && passed.events.is_empty());
    wire.remove(9);
    assert_eq!(bytes_in(&mut wire, MS, b"y"), [b"y".to_vec()]);
}

#[test]
fn a_stall_holds_everything_and_lets_it_go() {
    let mut wire = wire();
    let _none = wire.add(1, FaultKind::Stall, Scope::default(), None);
    assert!(bytes_in(&mut wire, MS, b"x").is_empty());
    assert!(released(&mut wire, 100 * MS).is_empty());
    assert_eq!(wire.next_due(), None, "nothing passes by itself");
    wire.remove(1);
    assert_eq!(released(&mut wire, 101 * MS), [b"x".to_vec()]);
    assert!(wire.is_plain());
}
