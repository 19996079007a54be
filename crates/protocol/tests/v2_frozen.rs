//! The bytes of version 2 of the wire, frozen. If a test here fails, do not change the file it read: the program on
//! the controllers is written to the same page.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests: a failure here fails the test"
)]

use protocol::v2::{
    Command, Elbow, ErrorCode, FinishStatus, Flip, Front, Greeting, LARGEST, LineDecoder,
    LinearSpeed, MotionNumber, Move, OperatingMode, Output, OutputNumber, Percent, Reply, Request,
    StatusLine, StatusReply, Verb, WireConfiguration, WireJoints, WirePose,
};
use units::{Degrees, Millimeters};

macro_rules! frozen {
    ($name:literal) => {
        include_str!(concat!("../testdata/v2/", $name, ".hex"))
    };
}

fn bytes(text: &str) -> Vec<u8> {
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .flat_map(str::split_whitespace)
        .map(|byte| u8::from_str_radix(byte, 16).unwrap())
        .collect()
}

/// The one line in the bytes.
fn line(bytes: &[u8]) -> Vec<u8> {
    let mut decoder = LineDecoder::default();
    let mut lines = Vec::new();
    for byte in bytes {
        lines.extend(decoder.push(*byte).unwrap().map(<[u8]>::to_vec));
    }
    assert_eq!((lines.len(), decoder.pending()), (1, 0));
    lines.remove(0)
}

fn number(epoch: u32, seq: u32) -> MotionNumber {
    MotionNumber { epoch, seq }
}

fn pose(values: [f64; 6]) -> WirePose {
    let [x, y, z, w, p, r] = values;
    WirePose::try_new([x, y, z].map(Millimeters), [w, p, r].map(Degrees)).unwrap()
}

fn joints(values: [f64; 6]) -> WireJoints {
    WireJoints::try_new(values.map(Degrees)).unwrap()
}

fn percent(value: u8) -> Percent {
    Percent::try_new(value).unwrap()
}

#[test]
fn the_commands_bytes_are_as_frozen() {
    let largest = f64::from(LARGEST) / 1000.0;
    let cases = [
        (
            frozen!("move_joint"),
            (number(7_000, 1), 4_711),
            Command::Move(Move::Joint {
                pose: pose([985.0, 0.0, 940.0, -180.0, 0.0, 0.0]),
                speed: percent(30),
                configuration: WireConfiguration::default(),
            }),
        ),
        (
            frozen!("move_linear"),
            (number(12_003, 42), LARGEST),
            Command::Move(Move::Linear {
                pose: pose([600.0, -200.0, 600.5, 179.999, -30.001, 90.0]),
                speed: LinearSpeed::try_new(1_999).unwrap(),
                configuration: WireConfiguration {
                    flip: Flip::Flip,
                    elbow: Elbow::Down,
                    front: Front::Back,
                    turns: [-1, 0, 1],
                },
            }),
        ),
        (
            frozen!("move_joints"),
            (number(7_000, 2), -5),
            Command::Move(Move::Joints {
                joints: joints([0.0, -10.0, 20.5, 0.0, -90.0, 180.0]),
                speed: percent(100),
            }),
        ),
        (
            frozen!("move_longest"),
            (
                number(LARGEST.unsigned_abs(), LARGEST.unsigned_abs()),
                -LARGEST,
            ),
            Command::Move(Move::Linear {
                pose: pose([-largest; 6]),
                speed: LinearSpeed::try_new(1_999).unwrap(),
                configuration: WireConfiguration {
                    turns: [-8; 3],
                    ..WireConfiguration::default()
                },
            }),
        ),
        (
            frozen!("output"),
            (number(7_000, 3), 99),
            Command::Output(Output {
                output: OutputNumber::try_new(1).unwrap(),
                on: true,
            }),
        ),
    ];
    for (hex, (number, nonce), command) in cases {
        let request = Request {
            number,
            nonce,
            command,
        };
        let bytes = bytes(hex);
        assert_eq!(request.encode(), bytes, "{request:?}");
        assert_eq!(Request::decode(&line(&bytes)), Ok(request));
    }
}

#[test]
fn the_greetings_bytes_are_as_frozen() {
    let cases = [
        (
            frozen!("greeting"),
            Greeting {
                boot: 17,
                epoch_max: 7_000,
                accepted: number(7_000, 2),
                finished: number(7_000, 1),
                finish: FinishStatus::Arrived,
                nonce: 4_711,
            },
        ),
        (
            frozen!("greeting_fresh"),
            Greeting {
                boot: 1,
                epoch_max: 0,
                accepted: number(0, 0),
                finished: number(0, 0),
                finish: FinishStatus::Arrived,
                nonce: -1,
            },
        ),
    ];
    for (hex, greeting) in cases {
        let bytes = bytes(hex);
        assert_eq!(greeting.encode(), bytes);
        assert_eq!(Greeting::decode(&line(&bytes)), Ok(greeting));
    }
}

#[test]
fn the_replies_bytes_are_as_frozen() {
    let number = number(7_000, 1);
    let pose = pose([985.0, 0.001, 940.0, -180.0, 0.0, -0.001]);
    let done = |finish| Reply::Done {
        number,
        finish,
        pose,
    };
    let cases = [
        (frozen!("ack"), Reply::Ack(number)),
        (frozen!("done"), done(FinishStatus::Arrived)),
        (frozen!("done_dead_man"), done(FinishStatus::DeadMan)),
        (
            frozen!("dup"),
            Reply::Dup {
                number,
                finished: true,
            },
        ),
        (frozen!("stale"), Reply::Stale { epoch_max: 8_000 }),
        (frozen!("busy"), Reply::Busy(number)),
        (frozen!("err_nonce"), Reply::Err(ErrorCode::Nonce)),
    ];
    for (hex, reply) in cases {
        let bytes = bytes(hex);
        assert_eq!(reply.encode(), bytes, "{reply:?}");
        assert_eq!(Reply::decode(&line(&bytes)), Ok(reply));
    }
}

#[test]
fn the_status_ports_bytes_are_as_frozen() {
    let standing = StatusLine {
        boot: 17,
        epoch_max: 7_000,
        accepted: number(7_000, 2),
        finished: number(7_000, 1),
        finish: FinishStatus::Arrived,
        moving: true,
        held: false,
        mode: OperatingMode::Auto,
        pendant: false,
        alarm: 0,
        speed_override: 100,
        user_frame: 1,
        tool: 2,
        dead_man: false,
        outputs: 1,
        inputs: 6,
        pose: pose([985.0, 0.0, 940.0, -180.0, 0.0, 0.0]),
        joints: joints([0.0, 0.0, 0.0, 0.0, -90.0, 0.0]),
    };
    assert!(standing.output(1) && !standing.output(2) && !standing.output(9));
    assert!(!standing.input(1) && standing.input(2) && standing.input(3));
    let alarmed = StatusLine {
        boot: 18,
        epoch_max: 7_001,
        accepted: number(7_000, 2),
        finished: number(7_000, 2),
        finish: FinishStatus::DeadMan,
        moving: false,
        held: true,
        mode: OperatingMode::T1,
        pendant: true,
        alarm: 11_050,
        speed_override: 0,
        user_frame: 0,
        tool: 0,
        dead_man: true,
        outputs: 255,
        inputs: 128,
        pose: pose([-985.0, 0.0, 940.0, -180.0, 0.0, 0.0]),
        joints: joints([170.0, -0.001, 0.001, 0.0, -90.0, 360.0]),
    };
    for (hex, status) in [
        (frozen!("status_line"), standing),
        (frozen!("status_line_alarm"), alarmed),
    ] {
        let bytes = bytes(hex);
        let reply = StatusReply::Status(status);
        assert_eq!(reply.encode(), bytes);
        assert_eq!(StatusReply::decode(&line(&bytes)), Ok(reply));
    }
    for (hex, verb) in [
        (frozen!("verb_status"), Verb::Status { epoch: 7_000 }),
        (frozen!("verb_fence"), Verb::Fence { epoch: 7_001 }),
        (frozen!("verb_stop"), Verb::Stop),
        (frozen!("verb_hold"), Verb::Hold),
        (frozen!("verb_continue"), Verb::Continue),
        (frozen!("verb_override"), Verb::Override(percent(35))),
    ] {
        let bytes = bytes(hex);
        assert_eq!(verb.encode(), bytes, "{verb:?}");
        assert_eq!(Verb::decode(&line(&bytes)), Ok(verb));
    }
}
