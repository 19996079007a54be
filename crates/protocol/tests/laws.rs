//! What holds for every command and for any bytes at all.

use proptest::prelude::*;
use protocol::{
    CommandError, DecodeError, Item, MoveCommand, ReplyDecode, Stream, decode_command, decode_reply,
};
use units::{Degrees, Millimeters, MmPerSec};

const LARGEST: f64 = 2_147_483.647;

fn commands() -> impl Strategy<Value = MoveCommand> {
    let value = prop_oneof![-LARGEST..=LARGEST, -2000.0..2000.0_f64, -0.001..0.001_f64];
    (proptest::array::uniform6(value), 1..=1999_u16).prop_map(|([x, y, z, w, p, r], speed)| {
        MoveCommand {
            x: Millimeters(x),
            y: Millimeters(y),
            z: Millimeters(z),
            w: Degrees(w),
            p: Degrees(p),
            r: Degrees(r),
            speed: MmPerSec(f64::from(speed)),
        }
    })
}

fn numbers(command: &MoveCommand) -> [f64; 6] {
    [
        command.x.0,
        command.y.0,
        command.z.0,
        command.w.0,
        command.p.0,
        command.r.0,
    ]
}

proptest! {
    #[test]
    fn a_command_survives_the_wire(command in commands()) {
        let wire = command.to_wire().unwrap();
        prop_assert_eq!(decode_command(&wire.encode()), Ok(wire));
        prop_assert_eq!(wire.command().to_wire(), Ok(wire));
    }

    #[test]
    fn rounding_moves_a_value_by_half_a_thousandth_at_most(command in commands()) {
        let wire = command.to_wire().unwrap();
        for (sent, asked) in wire.thousandths().into_iter().zip(numbers(&command)) {
            // The product with 1000 is itself rounded, by 2^-22 at the ends of the range.
            prop_assert!((f64::from(sent) - asked * 1000.0).abs() <= 0.5);
        }
    }

    #[test]
    fn a_command_cut_short_is_never_a_command(command in commands()) {
        let bytes = command.encode().unwrap();
        for cut in 0..bytes.len() {
            prop_assert!(decode_command(&bytes[..cut]).is_err());
        }
    }

    #[test]
    fn any_bytes_are_refused_or_are_the_canonical_form(bytes in proptest::collection::vec(any::<u8>(), 0..100)) {
        if let Ok(wire) = decode_command(&bytes) {
            prop_assert_eq!(&*wire.encode(), &*bytes);
        }
        let _decoded: ReplyDecode = decode_reply(&bytes, Stream::Open);
    }

    #[test]
    fn command_like_text_is_refused_or_is_the_canonical_form(text in "(-?[0-9]{1,11} ?){6,8}1?") {
        if let Ok(wire) = decode_command(text.as_bytes()) {
            prop_assert_eq!(&*wire.encode(), text.as_bytes());
        }
    }
}

fn typical() -> MoveCommand {
    MoveCommand {
        x: Millimeters(600.0),
        y: Millimeters(200.0),
        z: Millimeters(600.0),
        w: Degrees(-180.0),
        p: Degrees(30.0),
        r: Degrees(0.0),
        speed: MmPerSec(300.0),
    }
}

#[test]
fn ties_go_away_from_zero() {
    let command = MoveCommand {
        x: Millimeters(0.0005),
        y: Millimeters(-0.0005),
        z: Millimeters(0.000_499),
        w: Degrees(-0.0),
        ..typical()
    };
    let [x, y, z, w, ..] = command.to_wire().unwrap().thousandths();
    assert_eq!([x, y, z, w], [1, -1, 0, 0]);
}

#[test]
fn a_value_whose_thousandths_overflow_32_bits_is_refused() {
    for value in [2_147_483.648, -2_147_483.649, 1e300, f64::MAX] {
        let command = MoveCommand {
            y: Millimeters(value),
            ..typical()
        };
        let error = command.to_wire().unwrap_err();
        assert_eq!(
            error,
            CommandError::OutOfRange {
                item: Item::Y,
                value
            }
        );
        assert!(error.to_string().contains("2147483.647"));
    }
}

#[test]
fn a_value_that_is_not_finite_is_refused() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let command = MoveCommand {
            r: Degrees(value),
            ..typical()
        };
        let error = command.to_wire().unwrap_err();
        assert_eq!(error.item(), Item::R);
        assert!(!error.value().is_finite());
    }
}

#[test]
fn a_speed_is_a_whole_number_of_1_to_1999() {
    for value in [0.0, -1.0, 2000.0, 0.5, 200.5, f64::NAN, f64::INFINITY, 1e9] {
        let command = MoveCommand {
            speed: MmPerSec(value),
            ..typical()
        };
        assert_eq!(command.to_wire().unwrap_err().item(), Item::Speed);
    }
    for value in [1.0, 1999.0] {
        let command = MoveCommand {
            speed: MmPerSec(value),
            ..typical()
        };
        assert!(command.to_wire().is_ok());
    }
}

#[test]
fn a_command_in_another_form_is_refused_with_the_field_named() {
    let cases: [(&[u8], DecodeError); 12] = [
        (b"", DecodeError::Missing { item: Item::X }),
        (b" 1 2 3 4 5 6 7 1", DecodeError::Missing { item: Item::X }),
        (b"1  2 3 4 5 6 7 1", DecodeError::Missing { item: Item::Y }),
        (
            b"1 +2 3 4 5 6 7 1",
            DecodeError::NotANumber { item: Item::Y },
        ),
        (
            b"1 2 03 4 5 6 7 1",
            DecodeError::NotANumber { item: Item::Z },
        ),
        (
            b"1 2 3 -0 5 6 7 1",
            DecodeError::NotANumber { item: Item::W },
        ),
        (
            b"1 2 3 4 2147483648 6 7 1",
            DecodeError::Overflow { item: Item::P },
        ),
        (b"1 2 3 4 5 6 0 1", DecodeError::Speed { value: 0 }),
        (b"1 2 3 4 5 6 2000 1", DecodeError::Speed { value: 2000 }),
        (b"1 2 3 4 5 6 7", DecodeError::Missing { item: Item::Last }),
        (
            b"1 2 3 4 5 6 7 2",
            DecodeError::NotANumber { item: Item::Last },
        ),
        (b"1 2 3 4 5 6 7 1 ", DecodeError::Trailing),
    ];
    for (bytes, error) in cases {
        assert_eq!(
            decode_command(bytes),
            Err(error),
            "{}",
            bytes.escape_ascii()
        );
    }
    let long = [b'1'; 200];
    assert_eq!(
        decode_command(&long),
        Err(DecodeError::TooLong { len: 200 })
    );
}
