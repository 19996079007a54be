//! The bytes of the wire, frozen. If a test here fails, do not change the file it read: controllers in the field
//! run the program these bytes are for.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests: a failure here fails the test"
)]

use protocol::{MoveCommand, Reply, ReplyDecode, Stream, decode_command, decode_reply};
use units::{Degrees, Millimeters, MmPerSec};

fn frozen(text: &str) -> Vec<u8> {
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .flat_map(str::split_whitespace)
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect()
}

fn command([x, y, z, w, p, r]: [f64; 6], speed: f64) -> MoveCommand {
    MoveCommand {
        x: Millimeters(x),
        y: Millimeters(y),
        z: Millimeters(z),
        w: Degrees(w),
        p: Degrees(p),
        r: Degrees(r),
        speed: MmPerSec(speed),
    }
}

fn assert_frozen(hex: &str, command: &MoveCommand, text: &str) {
    let bytes = frozen(hex);
    assert_eq!(String::from_utf8_lossy(&bytes), text);
    assert_eq!(&*command.encode().unwrap(), bytes);
    assert_eq!(decode_command(&bytes).unwrap().command(), *command);
}

#[test]
fn the_commands_bytes_are_as_frozen() {
    assert_frozen(
        include_str!("../testdata/v1/move_typical.hex"),
        &command([600.0, 200.0, 600.0, -180.0, 30.0, 0.0], 300.0),
        "600000 200000 600000 -180000 30000 0 300 1",
    );
    assert_frozen(
        include_str!("../testdata/v1/move_small.hex"),
        &command([0.1; 6], 200.0),
        "100 100 100 100 100 100 200 1",
    );
    assert_frozen(
        include_str!("../testdata/v1/move_longest.hex"),
        &command([-2_147_483.648; 6], 1999.0),
        "-2147483648 -2147483648 -2147483648 -2147483648 -2147483648 -2147483648 1999 1",
    );
}

#[test]
fn the_fences_bytes_are_as_frozen_and_are_no_command() {
    let bytes = frozen(include_str!("../testdata/v1/fence.hex"));
    assert_eq!(&*protocol::seed_fence(), bytes);
    assert_eq!(
        decode_command(&bytes),
        Err(protocol::DecodeError::Speed { value: 0 })
    );
}

#[test]
fn the_replies_bytes_are_as_frozen() {
    let files = [
        (
            Reply::Accepted,
            include_str!("../testdata/v1/reply_accepted.hex"),
        ),
        (
            Reply::Unreachable,
            include_str!("../testdata/v1/reply_unreachable.hex"),
        ),
        (
            Reply::IncorrectInput,
            include_str!("../testdata/v1/reply_incorrect_input.hex"),
        ),
    ];
    for (reply, hex) in files {
        let bytes = frozen(hex);
        assert_eq!(reply.encode(), bytes);
        assert_eq!(
            decode_reply(&bytes, Stream::Open),
            ReplyDecode::Reply(reply)
        );
    }
}
