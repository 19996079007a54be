//! What holds for every line of version 2 and for any bytes at all.

#![expect(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "helpers of tests: a failure here fails the test"
)]

use proptest::prelude::*;
use protocol::v2::{
    Command, DecodeError, Elbow, ErrorCode, FinishStatus, Flip, Front, Greeting, LARGEST,
    LineDecoder, LinearSpeed, MotionNumber, Move, OperatingMode, Output, OutputNumber, Percent,
    Reply, Request, StatusLine, StatusReply, ValueError, Verb, WireConfiguration, WireJoints,
    WirePose,
};
use units::{Degrees, Millimeters};

/// Any line of the wire.
#[derive(Clone, Debug, PartialEq)]
enum Message {
    Greeting(Greeting),
    Request(Request),
    Reply(Reply),
    Verb(Verb),
    Status(StatusReply),
}

impl Message {
    fn encode(&self) -> Vec<u8> {
        match self {
            Self::Greeting(message) => message.encode(),
            Self::Request(message) => message.encode(),
            Self::Reply(message) => message.encode(),
            Self::Verb(message) => message.encode(),
            Self::Status(message) => message.encode(),
        }
    }

    /// Reads lines where this message is expected: only its own kind is looked for, as a link does.
    fn decode_same(&self, line: &[u8]) -> Result<Self, DecodeError> {
        match self {
            Self::Greeting(_) => Greeting::decode(line).map(Self::Greeting),
            Self::Request(_) => Request::decode(line).map(Self::Request),
            Self::Reply(_) => Reply::decode(line).map(Self::Reply),
            Self::Verb(_) => Verb::decode(line).map(Self::Verb),
            Self::Status(_) => StatusReply::decode(line).map(Self::Status),
        }
    }

    /// The messages in a stream of bytes.
    fn all_in(&self, bytes: &[u8]) -> Vec<Result<Self, DecodeError>> {
        let mut decoder = LineDecoder::default();
        let mut messages = Vec::new();
        for byte in bytes {
            if let Some(line) = decoder.push(*byte).unwrap() {
                messages.push(self.decode_same(line));
            }
        }
        messages
    }
}

fn counts() -> impl Strategy<Value = u32> {
    prop_oneof![0..10_u32, 0..=LARGEST.unsigned_abs()]
}

fn numbers() -> impl Strategy<Value = MotionNumber> {
    (counts(), counts()).prop_map(|(epoch, seq)| MotionNumber { epoch, seq })
}

fn six() -> impl Strategy<Value = [f64; 6]> {
    let largest = f64::from(LARGEST) / 1000.0;
    proptest::array::uniform6(prop_oneof![-largest..=largest, -2000.0..2000.0_f64])
}

fn poses() -> impl Strategy<Value = WirePose> {
    six().prop_map(|[x, y, z, w, p, r]| {
        WirePose::try_new([x, y, z].map(Millimeters), [w, p, r].map(Degrees)).unwrap()
    })
}

fn joints() -> impl Strategy<Value = WireJoints> {
    six().prop_map(|values| WireJoints::try_new(values.map(Degrees)).unwrap())
}

fn percents() -> impl Strategy<Value = Percent> {
    (1..=100_u8).prop_map(|value| Percent::try_new(value).unwrap())
}

fn configurations() -> impl Strategy<Value = WireConfiguration> {
    let turns = proptest::array::uniform3(any::<i8>());
    (any::<[bool; 3]>(), turns).prop_map(|([flip, elbow, front], turns)| WireConfiguration {
        flip: if flip { Flip::Flip } else { Flip::NoFlip },
        elbow: if elbow { Elbow::Down } else { Elbow::Up },
        front: if front { Front::Back } else { Front::Toward },
        turns,
    })
}

fn commands() -> impl Strategy<Value = Command> {
    prop_oneof![
        (poses(), percents(), configurations()).prop_map(|(pose, speed, configuration)| {
            Command::Move(Move::Joint {
                pose,
                speed,
                configuration,
            })
        }),
        (poses(), 1..=1999_u16, configurations()).prop_map(|(pose, speed, configuration)| {
            Command::Move(Move::Linear {
                pose,
                speed: LinearSpeed::try_new(speed).unwrap(),
                configuration,
            })
        }),
        (joints(), percents())
            .prop_map(|(joints, speed)| Command::Move(Move::Joints { joints, speed })),
        (1..=8_u8, any::<bool>()).prop_map(|(output, on)| {
            Command::Output(Output {
                output: OutputNumber::try_new(output).unwrap(),
                on,
            })
        }),
    ]
}

fn finishes() -> impl Strategy<Value = FinishStatus> {
    proptest::sample::select(FinishStatus::ALL.to_vec())
}

fn statuses() -> impl Strategy<Value = StatusLine> {
    let registers = (
        counts(),
        counts(),
        numbers(),
        numbers(),
        finishes(),
        counts(),
    );
    let small = (0..=100_u8, any::<[u8; 4]>(), 0..3_u8);
    (registers, any::<[bool; 4]>(), small, poses(), joints()).prop_map(
        |(
            (boot, epoch_max, accepted, finished, finish, alarm),
            [moving, held, pendant, dead_man],
            (speed_override, [user_frame, tool, outputs, inputs], mode),
            pose,
            joints,
        )| StatusLine {
            boot,
            epoch_max,
            accepted,
            finished,
            finish,
            moving,
            held,
            mode: [OperatingMode::T1, OperatingMode::T2, OperatingMode::Auto][usize::from(mode)],
            pendant,
            alarm,
            speed_override,
            user_frame,
            tool,
            dead_man,
            outputs,
            inputs,
            pose,
            joints,
        },
    )
}

fn messages() -> impl Strategy<Value = Message> {
    let greetings = (
        counts(),
        counts(),
        numbers(),
        numbers(),
        finishes(),
        -LARGEST..=LARGEST,
    );
    prop_oneof![
        greetings.prop_map(|(boot, epoch_max, accepted, finished, finish, nonce)| {
            Message::Greeting(Greeting {
                boot,
                epoch_max,
                accepted,
                finished,
                finish,
                nonce,
            })
        }),
        (numbers(), -LARGEST..=LARGEST, commands()).prop_map(|(number, nonce, command)| {
            Message::Request(Request {
                number,
                nonce,
                command,
            })
        }),
        prop_oneof![
            numbers().prop_map(Reply::Ack),
            numbers().prop_map(Reply::Busy),
            (numbers(), finishes(), poses()).prop_map(|(number, finish, pose)| Reply::Done {
                number,
                finish,
                pose,
            }),
            (numbers(), any::<bool>())
                .prop_map(|(number, finished)| Reply::Dup { number, finished }),
            counts().prop_map(|epoch_max| Reply::Stale { epoch_max }),
            proptest::sample::select(ErrorCode::ALL.to_vec()).prop_map(Reply::Err),
        ]
        .prop_map(Message::Reply),
        prop_oneof![
            counts().prop_map(|epoch| Verb::Status { epoch }),
            counts().prop_map(|epoch| Verb::Fence { epoch }),
            proptest::sample::select(vec![Verb::Stop, Verb::Hold, Verb::Continue]),
            percents().prop_map(Verb::Override),
        ]
        .prop_map(Message::Verb),
        statuses().prop_map(|status| Message::Status(StatusReply::Status(status))),
        Just(Message::Status(StatusReply::Malformed)),
    ]
}

proptest! {
    #[test]
    fn a_message_survives_the_wire_whatever_ends_its_line(message in messages()) {
        let bytes = message.encode();
        prop_assert_eq!(message.all_in(&bytes), vec![Ok(message.clone())]);
        let line = bytes.trim_ascii_end();
        for end in ["\r", "\n", "\n\r", "\r\n\r\n"] {
            let bytes = [line, end.as_bytes()].concat();
            prop_assert_eq!(message.all_in(&bytes), vec![Ok(message.clone())]);
        }
    }

    #[test]
    fn every_prefix_of_a_line_is_not_yet_a_message(message in messages()) {
        let bytes = message.encode();
        let line = bytes.trim_ascii_end();
        for cut in 0..=line.len() {
            prop_assert_eq!(message.all_in(&line[..cut]), vec![]);
        }
    }

    #[test]
    fn a_changed_byte_is_noticed_or_changes_nothing(message in messages(), at in any::<prop::sample::Index>(), to in any::<u8>()) {
        let mut bytes = message.encode();
        let at = at.index(bytes.len());
        bytes[at] = to;
        for read in message.all_in(&bytes).into_iter().flatten() {
            prop_assert_eq!(&read, &message, "byte {} became {:#04x}", at, to);
        }
    }

    /// Covers: W3.
    #[test]
    fn a_line_cut_short_and_ended_is_never_a_message(message in messages()) {
        let bytes = message.encode();
        let line = bytes.trim_ascii_end();
        for cut in 0..line.len() {
            prop_assert!(message.decode_same(&line[..cut]).is_err());
        }
    }

    #[test]
    fn any_line_is_refused_or_is_the_canonical_form(line in "(V2|M|O|ACK|DONE|DUP|STALE|BUSY|ERR|S|F|X|P|C|G|ST)( -?[0-9]{1,3}){0,6}") {
        let sum = protocol::v2::checksum(line.as_bytes());
        let line = format!("{line} {sum}");
        let whole = format!("{line}\r\n");
        let line = line.as_bytes();
        let read = [
            Greeting::decode(line).map(Message::Greeting),
            Request::decode(line).map(Message::Request),
            Reply::decode(line).map(Message::Reply),
            Verb::decode(line).map(Message::Verb),
            StatusReply::decode(line).map(Message::Status),
        ];
        for message in read.into_iter().flatten() {
            prop_assert_eq!(message.encode(), whole.as_bytes());
        }
    }

    #[test]
    fn any_bytes_are_read_without_a_panic(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        let _refused = Greeting::decode(&bytes);
        let _refused = Request::decode(&bytes);
        let _refused = Reply::decode(&bytes);
        let _refused = Verb::decode(&bytes);
        let _refused = StatusReply::decode(&bytes);
        let mut decoder = LineDecoder::default();
        for byte in bytes {
            let _line = decoder.push(byte);
        }
    }

    #[test]
    fn rounding_moves_a_value_by_half_a_thousandth_at_most(values in six()) {
        let [x, y, z, w, p, r] = values;
        let pose = WirePose::try_new([x, y, z].map(Millimeters), [w, p, r].map(Degrees)).unwrap();
        for (sent, asked) in pose.thousandths().into_iter().zip(values) {
            prop_assert!((f64::from(sent) - asked * 1000.0).abs() <= 0.5);
        }
    }
}

#[test]
fn values_the_wire_cannot_carry_are_refused_by_name() {
    let pose = |x, r| {
        WirePose::try_new(
            [Millimeters(x), Millimeters(0.0), Millimeters(0.0)],
            [Degrees(0.0), Degrees(0.0), Degrees(r)],
        )
    };
    assert!(matches!(
        pose(f64::NAN, 0.0),
        Err(ValueError::NotFinite { item: "X", .. })
    ));
    assert!(matches!(
        pose(0.0, f64::INFINITY),
        Err(ValueError::NotFinite { item: "R", .. })
    ));
    let error = pose(-2_147_483.648, 0.0).unwrap_err();
    assert!(error.to_string().contains("2147483.647"), "{error}");
    assert!(pose(2_147_483.647, 0.0).is_ok());
    assert_eq!(
        pose(0.0005, -0.0005).unwrap().thousandths(),
        [1, 0, 0, 0, 0, -1]
    );
    for (low, high) in [(0, 101), (0, 255)] {
        assert!(Percent::try_new(low).is_err() && Percent::try_new(high).is_err());
    }
    assert!(LinearSpeed::try_new(0).is_err() && LinearSpeed::try_new(2_000).is_err());
    assert!(OutputNumber::try_new(0).is_err() && OutputNumber::try_new(9).is_err());
    let joints = [0.0, 0.0, 1e9, 0.0, 0.0, 0.0].map(Degrees);
    assert!(matches!(
        WireJoints::try_new(joints),
        Err(ValueError::TooLarge { item: "J3", .. })
    ));
}

/// A line with the right checksum.
fn summed(body: &str) -> Vec<u8> {
    format!("{body} {}", protocol::v2::checksum(body.as_bytes())).into_bytes()
}

#[test]
fn a_line_in_another_form_is_refused_with_the_item_named() {
    let cases = [
        ("S", DecodeError::Missing { item: "the epoch" }),
        ("S  1", DecodeError::Missing { item: "the epoch" }),
        ("S +1", DecodeError::NotANumber { item: "the epoch" }),
        ("S 01", DecodeError::NotANumber { item: "the epoch" }),
        (
            "S 2147483648",
            DecodeError::NotANumber { item: "the epoch" },
        ),
        (
            "S -1",
            DecodeError::OutOfRange {
                item: "the epoch",
                value: -1,
                min: 0,
                max: LARGEST,
            },
        ),
        ("S 1 2", DecodeError::Trailing),
        ("S 1 ", DecodeError::Trailing),
        (
            "s 1",
            DecodeError::Kind {
                expected: "S, F, X, P, C, G",
            },
        ),
        (
            "G 0",
            DecodeError::OutOfRange {
                item: "the percentage",
                value: 0,
                min: 1,
                max: 100,
            },
        ),
    ];
    for (body, error) in cases {
        assert_eq!(Verb::decode(&summed(body)), Err(error), "{body}");
    }
    assert_eq!(Verb::decode(b""), Err(DecodeError::NoChecksum));
    assert_eq!(Verb::decode(b"X"), Err(DecodeError::NoChecksum));
    assert_eq!(Verb::decode(b"X 088"), Err(DecodeError::NoChecksum));
    assert_eq!(
        Verb::decode(b"X 89"),
        Err(DecodeError::Checksum {
            received: 89,
            computed: 88
        })
    );
    assert_eq!(
        Verb::decode(b"X\t88"),
        Err(DecodeError::Byte { at: 1, byte: 9 })
    );
    assert_eq!(
        Request::decode(&summed("M 1 1 1 1 0 0 0 0 0 0 30 X U T 0 0 0")),
        Err(DecodeError::Letter {
            item: "the flip",
            expected: "N or F"
        })
    );
    assert_eq!(
        Reply::decode(&summed("ERR 8")),
        Err(DecodeError::OutOfRange {
            item: "the error code",
            value: 8,
            min: 1,
            max: 7
        })
    );
}

#[test]
fn numbers_are_compared_epoch_first() {
    let number = |epoch, seq| MotionNumber { epoch, seq };
    assert!(number(2, 1) > number(1, 9) && number(1, 2) > number(1, 1));
    assert_eq!(number(7_000, 3).to_string(), "7000/3");
}
