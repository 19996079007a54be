//! `programs/sock_server.kl` through its whole command set.

use karel::{Machine, TaskId};

use crate::host::{Event, ScriptedHost, machine_with, run};

const SOURCE: &[u8] = include_bytes!("../../../../programs/sock_server.kl");
const ACCEPTED: &str = "SUCESS: MOVEMENT COMPLETE";
const UNREACHABLE: &str = "ERROR: POINT UNREACHABLE";
const INCORRECT: &str = "ERROR: INCORRECT INPUT";
const COMMAND: &[u8] = b"600000 200000 600000 -180000 30000 0 300 1";

fn server() -> (Machine, TaskId) {
    machine_with(SOURCE, "sock_server.kl")
}

/// Runs the server until it waits for another client.
fn serve(script: Vec<Event>) -> ScriptedHost {
    let (mut machine, task) = server();
    let mut host = ScriptedHost::new(script);
    run(&mut machine, task, &mut host);
    assert!(
        host.trace.ends_with("waits for Connect(\"S3\")\n"),
        "{}",
        host.trace
    );
    host
}

fn reply_to(command: &[u8]) -> String {
    let host = serve(vec![
        Event::Connect,
        Event::Send(command.to_vec()),
        Event::Close,
    ]);
    String::from_utf8(host.replies.concat()).unwrap()
}

#[test]
fn a_reachable_pose_is_accepted_before_the_motion_ends() {
    let host = serve(vec![Event::Connect, Event::Send(COMMAND.to_vec())]);
    assert_eq!(host.replies, [ACCEPTED.as_bytes()]);
    assert_eq!(host.segments, 1, "one WRITE is one segment");
    let [motion] = host.moves.as_slice() else {
        panic!("{:?}", host.moves)
    };
    assert_eq!(
        (motion.target.x, motion.target.y, motion.target.z),
        (600.0, 200.0, 600.0)
    );
    assert_eq!(
        (motion.target.w, motion.target.p, motion.target.r),
        (-180.0, 30.0, 0.0)
    );
    let answered = host.trace.find(ACCEPTED).unwrap();
    assert!(
        answered < host.trace.find("move (").unwrap(),
        "{}",
        host.trace
    );
    assert!(!host.trace.contains("motion ended"), "{}", host.trace);
    assert!(host.trace.contains("set $SPEED = 300.0"), "{}", host.trace);
}

#[test]
fn the_start_sets_tool_override_and_motion_type() {
    let host = serve(Vec::new());
    for line in [
        "set $UTOOL = (0 0 0 0 0 0 'N U T, 0, 0, 0')",
        "set $MCR.$GENOVERRIDE = 25",
        "set $MOTYPE = 6",
        "set $TERMTYPE = 4",
        "set $HOSTS_CFG[3].$SERVER_PORT = 59002",
    ] {
        assert!(
            host.trace.contains(line),
            "{line} is missing in\n{}",
            host.trace
        );
    }
}

#[test]
fn an_unreachable_pose_and_a_speed_out_of_range_get_the_same_answer() {
    for command in [
        "9000000 0 0 0 0 0 300 1",
        "600000 0 0 0 0 0 0 1",
        "600000 0 0 0 0 0 2000 1",
        "600000 0 0 0 0 0 -1 1",
    ] {
        let host = serve(vec![
            Event::Connect,
            Event::Send(command.as_bytes().to_vec()),
        ]);
        assert_eq!(host.replies, [UNREACHABLE.as_bytes()], "{command}");
        assert_eq!(host.moves, [], "{command}");
    }
    assert_eq!(reply_to(b"600000 0 0 0 0 0 1 1"), ACCEPTED);
    assert_eq!(reply_to(b"600000 0 0 0 0 0 1999 1"), ACCEPTED);
}

#[test]
fn garbage_is_answered_at_once_and_the_next_client_is_served() {
    for garbage in [
        &b"a b c d e f g h\n"[..],
        b"hello",
        b"1 2 x",
        b"1.5 2",
        b"99999999999 1",
        b"1 2 3 4 5 6 7 x",
        b"\xff\xfe",
    ] {
        let host = serve(vec![
            Event::Connect,
            Event::Send(garbage.to_vec()),
            Event::Connect,
            Event::Send(COMMAND.to_vec()),
        ]);
        assert_eq!(
            host.replies,
            [INCORRECT.as_bytes(), ACCEPTED.as_bytes()],
            "{garbage:?}"
        );
    }
}

#[test]
fn a_short_command_waits_and_is_incorrect_when_the_peer_closes() {
    for short in [
        &b""[..],
        b"600000 200000",
        b"600000 200000 600000 -180000 30000 0 300 ",
    ] {
        let (mut machine, task) = server();
        let mut host = ScriptedHost::new(vec![Event::Connect, Event::Send(short.to_vec())]);
        run(&mut machine, task, &mut host);
        assert!(
            host.trace.ends_with("waits for Readable(FileId(1))\n"),
            "{}",
            host.trace
        );
        assert_eq!(reply_to(short), INCORRECT);
    }
}

/// Covers: K4.
#[test]
fn a_field_of_an_earlier_command_is_never_used_again() {
    let host = serve(vec![
        Event::Connect,
        Event::Send(COMMAND.to_vec()),
        Event::Connect,
        Event::Send(b"1 2".to_vec()),
        Event::Close,
    ]);
    assert_eq!(host.replies, [ACCEPTED.as_bytes(), INCORRECT.as_bytes()]);
    assert_eq!(host.moves.len(), 1);
}

#[test]
fn a_command_that_is_split_anywhere_is_the_same_command() {
    for split in 1..COMMAND.len() {
        let (head, tail) = COMMAND.split_at(split);
        let host = serve(vec![
            Event::Connect,
            Event::Send(head.to_vec()),
            Event::Send(tail.to_vec()),
        ]);
        assert_eq!(host.replies, [ACCEPTED.as_bytes()], "split at {split}");
        assert_eq!(host.moves.len(), 1);
    }
    let bytes = COMMAND.iter().map(|byte| Event::Send(vec![*byte]));
    let host = serve(std::iter::once(Event::Connect).chain(bytes).collect());
    assert_eq!(host.replies, [ACCEPTED.as_bytes()]);
}

#[test]
fn a_hundred_clients_are_served_one_after_the_other() {
    let clients = (0..100).flat_map(|_| [Event::Connect, Event::Send(COMMAND.to_vec())]);
    let host = serve(clients.collect());
    assert_eq!(host.replies.len(), 100);
    assert!(
        host.replies
            .iter()
            .all(|reply| reply == ACCEPTED.as_bytes())
    );
}

/// Covers: K2.
#[test]
fn a_connect_that_fails_is_repeated_after_a_rest() {
    let host = serve(vec![
        Event::FailConnect(67_144),
        Event::Connect,
        Event::Send(COMMAND.to_vec()),
    ]);
    assert!(
        host.trace.contains("connect S3 failed HOST-144"),
        "{}",
        host.trace
    );
    assert_eq!(host.replies, [ACCEPTED.as_bytes()]);
}
