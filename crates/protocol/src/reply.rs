use std::fmt;

/// A controller's answer to a command.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum Reply {
    /// The motion was taken. It says `COMPLETE` and means "accepted": it is written before the motion begins.
    Accepted,
    /// The point cannot be reached, or the speed is out of range. Not executed.
    Unreachable,
    /// A value was missing or not a number. Not executed.
    IncorrectInput,
}

impl Reply {
    /// Every reply.
    pub const ALL: [Self; 3] = [Self::Accepted, Self::Unreachable, Self::IncorrectInput];

    /// The reply's text, exactly as on the wire.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Accepted => "SUCESS: MOVEMENT COMPLETE",
            Self::Unreachable => "ERROR: POINT UNREACHABLE",
            Self::IncorrectInput => "ERROR: INCORRECT INPUT",
        }
    }

    /// The reply's bytes, without a line end.
    #[must_use]
    pub const fn encode(self) -> &'static [u8] {
        self.text().as_bytes()
    }
}

impl fmt::Display for Reply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.text())
    }
}

/// Whether more bytes may follow those received.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Stream {
    /// The peer may write more.
    Open,
    /// The peer has closed its side.
    Ended,
}

/// What the bytes received so far mean.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum ReplyDecode {
    /// The beginning of a reply, or nothing yet, and more may come.
    Incomplete,
    /// One whole reply and nothing else. No reply is the beginning of another, so there is no need to wait for
    /// the end of the stream.
    Reply(Reply),
    /// Not a reply, and no further bytes can make it one.
    Unknown,
}

/// Reads the bytes received so far. They match a reply exactly or they are not a reply: a changed letter, a line
/// end or a byte too many makes them unknown.
#[must_use]
pub fn decode_reply(bytes: &[u8], stream: Stream) -> ReplyDecode {
    let mut prefix = false;
    for reply in Reply::ALL {
        if bytes == reply.encode() {
            return ReplyDecode::Reply(reply);
        }
        prefix |= reply.encode().starts_with(bytes);
    }
    match stream {
        Stream::Open if prefix => ReplyDecode::Incomplete,
        Stream::Open | Stream::Ended => ReplyDecode::Unknown,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_proper_prefix_of_a_reply_is_incomplete() {
        for reply in Reply::ALL {
            let text = reply.encode();
            for cut in 0..text.len() {
                let prefix = &text[..cut];
                assert_eq!(decode_reply(prefix, Stream::Open), ReplyDecode::Incomplete);
                assert_eq!(decode_reply(prefix, Stream::Ended), ReplyDecode::Unknown);
            }
            assert_eq!(decode_reply(text, Stream::Open), ReplyDecode::Reply(reply));
            assert_eq!(decode_reply(text, Stream::Ended), ReplyDecode::Reply(reply));
        }
    }

    #[test]
    fn a_reply_with_anything_behind_it_is_unknown() {
        for reply in Reply::ALL {
            for extra in ["\n", "\r\n", " ", "\0", "E"] {
                let text = format!("{reply}{extra}");
                assert_eq!(
                    decode_reply(text.as_bytes(), Stream::Open),
                    ReplyDecode::Unknown
                );
            }
        }
    }

    #[test]
    fn the_correctly_spelled_word_is_not_the_reply() {
        let decoded = decode_reply(b"SUCCESS: MOVEMENT COMPLETE", Stream::Open);
        assert_eq!(decoded, ReplyDecode::Unknown);
    }
}
