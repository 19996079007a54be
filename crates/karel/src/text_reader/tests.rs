//! What READ makes of bytes, item by item.

use super::*;

const OPEN: InputEnd = InputEnd::Open;
const GONE: InputEnd = InputEnd::Closed(Status::HOST_PEER_CLOSED);
const INTEGER: ItemFormat = ItemFormat {
    kind: ItemKind::Integer { base: 10 },
    width: None,
    line_end: None,
};
const REAL: ItemFormat = ItemFormat {
    kind: ItemKind::Real,
    width: None,
    line_end: None,
};
const BOOLEAN: ItemFormat = ItemFormat {
    kind: ItemKind::Boolean,
    width: None,
    line_end: None,
};
const TEXT: ItemFormat = ItemFormat {
    kind: ItemKind::Text { length: 8 },
    width: None,
    line_end: None,
};
const LINE_END: ItemFormat = ItemFormat {
    kind: ItemKind::LineEnd,
    width: None,
    line_end: None,
};

fn wide(format: ItemFormat, width: usize) -> ItemFormat {
    ItemFormat {
        width: Some(width),
        ..format
    }
}

fn read(bytes: &[u8], end: InputEnd, format: ItemFormat) -> Reading {
    read_item(Input { bytes, end }, LineState::Inside, format)
}

/// Reads items one after the other from bytes that are all there.
fn read_all(mut bytes: &[u8], end: InputEnd, formats: &[ItemFormat]) -> Vec<ReadResult> {
    let mut line_state = LineState::Inside;
    let mut results = Vec::new();
    for format in formats {
        let reading = read_item(Input { bytes, end }, line_state, *format);
        bytes = &bytes[reading.consumed..];
        line_state = reading.line_state;
        results.push(reading.result);
    }
    results
}

fn integer(value: i32) -> ReadResult {
    ReadResult::Value(ReadValue::Integer(value))
}

fn real(value: f32) -> ReadResult {
    ReadResult::Value(ReadValue::Real(value))
}

fn text(value: &str) -> ReadResult {
    ReadResult::Value(ReadValue::Text(value.into()))
}

const ILLEGAL: ReadResult = ReadResult::Failed(Status::INTP_ILLEGAL_DATA);

/// Bytes, the end, the item, what comes out, bytes used. `[D]` decided here, `[K]` known from
/// descriptions, `[S]` a program in the field needs it.
#[test]
fn items_read_as_the_table_says() {
    let closed = ReadResult::Failed(Status::HOST_PEER_CLOSED);
    let short = ReadResult::Failed(Status::INTP_SHORT_DATA);
    let table: &[(&[u8], InputEnd, ItemFormat, ReadResult, usize)] = &[
        (b"12 ", OPEN, INTEGER, integer(12), 3), // [S] one delimiter is used up
        (b"12  7", OPEN, INTEGER, integer(12), 3), // [S] exactly one
        (b" \r\n -12,", OPEN, INTEGER, integer(-12), 8), // [K] line ends are blanks before a number
        (b"+12\n", OPEN, INTEGER, integer(12), 4), // [K]
        (b"12", OPEN, INTEGER, ReadResult::Incomplete, 0), // [S] no delimiter, no value
        (b"   ", OPEN, INTEGER, ReadResult::Incomplete, 3), // [D] blanks need not be kept
        (b"12", GONE, INTEGER, integer(12), 2),  // [D] the end is a delimiter
        (b"", GONE, INTEGER, closed.clone(), 0), // [S]
        (b"  ", GONE, INTEGER, closed.clone(), 2), // [D]
        (b"abc 5\n6", OPEN, INTEGER, ILLEGAL, 4), // [D] the token is dropped, with one delimiter
        (b"abc  5", OPEN, INTEGER, ILLEGAL, 4),  // [D] exactly one
        (b"abc\r\n5", OPEN, INTEGER, ILLEGAL, 4), // [D]
        (b", 5", OPEN, INTEGER, ILLEGAL, 1),     // [D] nothing before a comma is no number
        (b"abc", GONE, INTEGER, ILLEGAL, 3),     // [D]
        (b"12abc\n6", OPEN, INTEGER, ILLEGAL, 6), // [D] the whole token must be a number
        (b"1.5\n", OPEN, INTEGER, ILLEGAL, 4),   // [D]
        (b"x", OPEN, INTEGER, ILLEGAL, 1),       // [D] hopeless at once
        (b"-", OPEN, INTEGER, ReadResult::Incomplete, 0), // [D] may become a number
        (b"- ", OPEN, INTEGER, ILLEGAL, 2),      // [D]
        (b"2147483647 ", OPEN, INTEGER, integer(i32::MAX), 11),
        (b"2147483648 ", OPEN, INTEGER, ILLEGAL, 11), // [D] refused, not clamped
        (b"1", OPEN, wide(INTEGER, 1), integer(1), 1), // [S] a width needs no delimiter
        (b" 12 9", OPEN, wide(INTEGER, 4), integer(12), 4), // [D] blanks inside the width
        (b" ", OPEN, wide(INTEGER, 1), ILLEGAL, 1),   // [D]
        (b"h 5\n", OPEN, wide(INTEGER, 1), ILLEGAL, 1), // [D] a width takes its bytes, legal or not
        (b"1x34", OPEN, wide(INTEGER, 3), ILLEGAL, 3), // [D]
        (b"12", OPEN, wide(INTEGER, 3), ReadResult::Incomplete, 0),
        (b"12", GONE, wide(INTEGER, 3), short, 2), // [D]
        (b"1.5 ", OPEN, REAL, real(1.5), 4),
        (b"-.5E-1,", OPEN, REAL, real(-0.05), 7),
        (b"7 ", OPEN, REAL, real(7.0), 2),
        (b"1e", OPEN, REAL, ReadResult::Incomplete, 0),
        (b"inf ", OPEN, REAL, ILLEGAL, 4), // [D] words are no numbers
        (b"1e99 ", OPEN, REAL, ILLEGAL, 5), // [D]
        (
            b"true ",
            OPEN,
            BOOLEAN,
            ReadResult::Value(ReadValue::Boolean(true)),
            5,
        ), // [K]
        (b"FA", OPEN, BOOLEAN, ReadResult::Incomplete, 0),
        (b"tree", OPEN, BOOLEAN, ILLEGAL, 4),
        (b"hello\nx", OPEN, TEXT, text("hello"), 6), // [S] LF alone ends a line
        (b"hello\r\n", OPEN, TEXT, text("hello"), 6), // [D] CR ends it too
        (b"\n", OPEN, TEXT, text(""), 1),
        (b"a long line\nx", OPEN, TEXT, text("a long l"), 12), // [K] the rest is dropped
        (b"hello", OPEN, TEXT, ReadResult::Incomplete, 0),
        (b"hello", GONE, TEXT, text("hello"), 5), // [D]
        (b"", GONE, TEXT, closed.clone(), 0),     // [S]
        (b"hello", OPEN, wide(TEXT, 3), text("hel"), 3), // [K]
        (b"12345678901", OPEN, wide(TEXT, 10), text("12345678"), 10), // [D]
        (
            b"abc\ndef",
            OPEN,
            LINE_END,
            ReadResult::Value(ReadValue::Nothing),
            4,
        ), // [K]
        (b"abc", OPEN, LINE_END, ReadResult::Incomplete, 3), // [D]
        (b"abc", OPEN, wide(TEXT, 0), text(""), 0), // [D] `::0` takes nothing
        (b"", OPEN, wide(TEXT, 0), text(""), 0),  // [D] and never waits
        (b"", GONE, wide(TEXT, 0), closed, 0),    // [D]
    ];
    for (bytes, end, format, result, consumed) in table {
        let reading = read(bytes, *end, *format);
        let shown = Text::from(*bytes);
        assert_eq!(&reading.result, result, "{shown:?} {end:?} {format:?}");
        assert_eq!(reading.consumed, *consumed, "{shown:?} {end:?} {format:?}");
    }
}

#[test]
fn assumed_delimiter_rule_lets_a_width_of_one_follow_a_number() {
    let items = read_all(b"300 1", OPEN, &[INTEGER, wide(INTEGER, 1)]);
    assert_eq!(items, [integer(300), integer(1)]);
}

#[test]
fn assumed_illegal_data_costs_its_token_even_if_that_arrives_later() {
    let first = read(b"x1", OPEN, INTEGER);
    assert_eq!(
        (first.consumed, first.line_state),
        (2, LineState::SkippingToken)
    );
    let later = Input {
        bytes: b"23 4 5",
        end: OPEN,
    };
    let second = read_item(later, first.line_state, INTEGER);
    assert_eq!((second.result, second.consumed), (integer(4), 5));
}

#[test]
fn assumed_eight_reads_of_eight_illegal_fields_wait_for_nothing() {
    let mut formats = [INTEGER; 8];
    formats[7] = wide(INTEGER, 1);
    for message in [
        &b"a b c d e f g h\n"[..],
        b"a b c d e f g h",
        b"a,b,c,d,e,f,g,h",
    ] {
        assert_eq!(read_all(message, OPEN, &formats), vec![ILLEGAL; 8]);
    }
    let items = read_all(b"1 2 x 4 5 6 7 1", OPEN, &formats);
    let mut expected = [1, 2, 3, 4, 5, 6, 7, 1].map(integer);
    expected[2] = ILLEGAL;
    assert_eq!(items, expected);
}

#[test]
fn a_line_end_of_two_bytes_is_one_line_end() {
    let items = read_all(
        b"one\r\ntwo\r\n3\r\nfour\rfive\n",
        OPEN,
        &[TEXT, TEXT, INTEGER, TEXT, TEXT],
    );
    assert_eq!(
        items,
        [
            text("one"),
            text("two"),
            integer(3),
            text("four"),
            text("five")
        ]
    );
}

#[test]
fn a_token_that_never_ends_is_given_up() {
    let digits = vec![b'0'; MAX_TOKEN + 1];
    assert_eq!(read(&digits, OPEN, INTEGER).result, ILLEGAL);
    assert_eq!(
        read(&digits[1..], OPEN, INTEGER).result,
        ReadResult::Incomplete
    );
    let line = vec![b'a'; MAX_TOKEN];
    let reading = read(&line, OPEN, TEXT);
    assert_eq!(
        (reading.result, reading.line_state),
        (text("aaaaaaaa"), LineState::SkippingLine)
    );
    assert_eq!(reading.consumed, MAX_TOKEN);
}

mod laws {
    use proptest::prelude::*;

    use super::*;

    /// Feeds a message byte by byte and collects what comes out.
    fn drip(message: &[u8], formats: &[ItemFormat]) -> Vec<ReadResult> {
        let mut buffer = Vec::new();
        let mut incoming = message.iter();
        let mut line_state = LineState::Inside;
        let mut results = Vec::new();
        for format in formats {
            loop {
                let reading = read_item(
                    Input {
                        bytes: &buffer,
                        end: OPEN,
                    },
                    line_state,
                    *format,
                );
                drop(buffer.drain(..reading.consumed));
                line_state = reading.line_state;
                if reading.result != ReadResult::Incomplete {
                    results.push(reading.result);
                    break;
                }
                match incoming.next() {
                    Some(byte) => buffer.push(*byte),
                    None => return results,
                }
            }
        }
        results
    }

    fn formats() -> impl Strategy<Value = Vec<ItemFormat>> {
        let one = prop_oneof![
            Just(INTEGER),
            Just(REAL),
            Just(BOOLEAN),
            Just(TEXT),
            Just(LINE_END),
            (1_usize..5).prop_map(|width| wide(INTEGER, width)),
            (1_usize..5).prop_map(|width| wide(TEXT, width)),
        ];
        proptest::collection::vec(one, 1..6)
    }

    proptest! {
        #[test]
        fn a_written_number_reads_back(value: i32, other in -1.0e30_f32..1.0e30) {
            let mut bytes = Vec::new();
            crate::text_writer::integer(&mut bytes, value, None);
            bytes.push(b' ');
            prop_assert_eq!(read(&bytes, OPEN, INTEGER).result, integer(value));
            let bytes = format!("{other:e} ");
            prop_assert_eq!(read(bytes.as_bytes(), OPEN, REAL).result, real(other));
        }

        #[test]
        fn every_prefix_of_a_message_is_not_yet(value: i32) {
            let message = format!("{value} ");
            for length in 0..message.len() {
                let reading = read(&message.as_bytes()[..length], OPEN, INTEGER);
                prop_assert_eq!(reading.result, ReadResult::Incomplete);
            }
        }

        #[test]
        fn each_token_is_one_item_whatever_stands_before_it(
            tokens in proptest::collection::vec(("[0-9a-z.-]{1,4}", prop_oneof![Just(' '), Just(','), Just('\n'), Just('\t')]), 1..8),
        ) {
            let mut message = String::new();
            for (token, end) in &tokens {
                message.push_str(token);
                message.push(*end);
            }
            let alone = |(token, _): &(String, char)| {
                parse(token.as_bytes(), INTEGER.kind).map_or(ILLEGAL, ReadResult::Value)
            };
            let expected: Vec<ReadResult> = tokens.iter().map(alone).collect();
            let formats = vec![INTEGER; tokens.len()];
            prop_assert_eq!(read_all(message.as_bytes(), OPEN, &formats), expected);
        }

        #[test]
        fn how_the_network_splits_a_message_changes_nothing(
            message in "[0-9a-fTRUE,+. \r\n-]{0,40}",
            formats in formats(),
        ) {
            let whole = read_all(message.as_bytes(), OPEN, &formats);
            let complete = whole.iter().take_while(|result| **result != ReadResult::Incomplete);
            let complete: Vec<ReadResult> = complete.cloned().collect();
            prop_assert_eq!(drip(message.as_bytes(), &formats), complete);
        }

        #[test]
        fn no_bytes_panic_and_no_more_is_used_than_there_is(
            bytes in proptest::collection::vec(any::<u8>(), 0..300),
            formats in formats(),
            closed: bool,
        ) {
            let end = if closed { GONE } else { OPEN };
            for format in formats {
                let reading = read(&bytes, end, format);
                prop_assert!(reading.consumed <= bytes.len());
                prop_assert!(!closed || reading.result != ReadResult::Incomplete);
            }
        }
    }
}
