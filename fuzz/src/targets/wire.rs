//! Any bytes as what a controller or a server sends over the wire.

use protocol::v2::{Greeting, LineDecoder, MAX_LINE_BYTES, Reply, Request, StatusReply, Verb};
use protocol::{ReplyDecode, Stream, decode_command, decode_reply};

use crate::choices::Choices;

/// Lines that are taken are written again as they were; how bytes are cut into pieces changes nothing.
///
/// # Panics
/// If that finds something.
pub fn run(data: &[u8]) {
    seed(data);
    line(data);
    with_a_right_sum(data);
    let mut decoder = LineDecoder::default();
    let mut lines = 0_usize;
    for byte in data {
        if let Ok(Some(text)) = decoder.push(*byte) {
            lines += 1;
            assert!(!text.is_empty() && text.len() <= MAX_LINE_BYTES);
            assert!(!text.contains(&b'\r') && !text.contains(&b'\n'));
            line(text);
        }
        assert!(decoder.pending() <= MAX_LINE_BYTES);
    }
    let ends = data.iter().filter(|b| matches!(b, b'\r' | b'\n')).count();
    assert!(lines <= ends, "{lines} lines with {ends} ends");
}

fn seed(data: &[u8]) {
    if let Ok(command) = decode_command(data) {
        assert_eq!(&*command.encode(), data, "the canonical form");
        assert_eq!(command.command().to_wire(), Ok(command));
    }
    // A reply that is known does not become another one by what follows.
    let mut known = None;
    for length in 0..=data.len().min(64) {
        let prefix = data.get(..length).unwrap_or_default();
        if let ReplyDecode::Reply(reply) = decode_reply(prefix, Stream::Open) {
            assert!(known.is_none_or(|before| before == reply), "{prefix:?}");
            known = Some(reply);
        }
    }
    let _at_the_end = decode_reply(data, Stream::Ended);
}

/// A checksum is seldom guessed: the same text with the right one.
fn with_a_right_sum(data: &[u8]) {
    let mut choices = Choices::new(data);
    let text = choices.bytes(400);
    let sum = protocol::v2::checksum(text).to_string();
    let mut whole = text.to_vec();
    whole.push(b' ');
    whole.extend_from_slice(sum.as_bytes());
    line(&whole);
}

fn line(text: &[u8]) {
    let same = |encoded: Vec<u8>| {
        assert_eq!(encoded.trim_ascii_end(), text, "the canonical form");
    };
    if let Ok(request) = Request::decode(text) {
        same(request.encode());
    }
    if let Ok(greeting) = Greeting::decode(text) {
        same(greeting.encode());
    }
    if let Ok(reply) = Reply::decode(text) {
        same(reply.encode());
    }
    if let Ok(verb) = Verb::decode(text) {
        same(verb.encode());
    }
    if let Ok(status) = StatusReply::decode(text) {
        same(status.encode());
    }
}
