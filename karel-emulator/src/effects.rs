//! What goes into the deterministic core and what comes out of it.

use std::net::SocketAddr;

/// A TCP connection, named by whoever accepted it. Never reused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ConnectionId(pub u64);

/// A server tag, `S1:` to `S8:`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Tag(u8);

impl Tag {
    /// How many server tags a controller has.
    pub const COUNT: u8 = 8;

    /// The tag with this number, 1 to 8.
    #[must_use]
    pub fn try_new(number: u8) -> Option<Self> {
        (1..=Self::COUNT).contains(&number).then_some(Self(number))
    }

    /// Reads `S3`, `s3:`.
    #[must_use]
    pub fn parse(name: &str) -> Option<Self> {
        let name = name.trim().strip_suffix(':').unwrap_or(name.trim());
        let number = name.strip_prefix(['S', 's'])?;
        Self::try_new(number.parse().ok()?)
    }

    /// 1 to 8.
    #[must_use]
    pub fn number(self) -> u8 {
        self.0
    }

    /// All tags.
    pub fn all() -> impl Iterator<Item = Tag> {
        (1..=Self::COUNT).map(Tag)
    }
}

impl std::fmt::Display for Tag {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "S{}:", self.0)
    }
}

/// Something that happened outside, at the core's present time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Event {
    /// A client connected to a tag that was accepting.
    Connected {
        /// The tag.
        tag: Tag,
        /// The new connection.
        connection: ConnectionId,
        /// The client.
        peer: SocketAddr,
    },
    /// The port of a tag could not be opened.
    ListenFailed {
        /// The tag.
        tag: Tag,
        /// Why, naming the port.
        reason: String,
    },
    /// Bytes arrived.
    Bytes {
        /// Where.
        connection: ConnectionId,
        /// The bytes, at most as many as there was room.
        bytes: Vec<u8>,
        /// The HTTP request behind the peer, if it is known.
        request_id: Option<String>,
    },
    /// Bytes were handed to the operating system.
    Sent {
        /// Where.
        connection: ConnectionId,
        /// How many.
        count: usize,
    },
    /// The peer sends nothing more; it may still read.
    PeerClosed {
        /// Where.
        connection: ConnectionId,
    },
    /// The connection is broken in both directions.
    PeerLost {
        /// Where.
        connection: ConnectionId,
    },
}

/// Something the core wants done outside.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Effect {
    /// Listen on `port` (as the program knows it) and accept one client for `tag`.
    Accept {
        /// The tag.
        tag: Tag,
        /// The program's port.
        port: u16,
    },
    /// The program does not wait for a client any more.
    StopAccepting {
        /// The tag.
        tag: Tag,
    },
    /// The task that used the tag is gone.
    StopListening {
        /// The tag.
        tag: Tag,
    },
    /// Send these bytes at once, in one segment if possible.
    Send {
        /// Where.
        connection: ConnectionId,
        /// The bytes of one WRITE statement.
        bytes: Vec<u8>,
    },
    /// Reset the connection: what is still to be sent is lost.
    Reset {
        /// Where.
        connection: ConnectionId,
    },
    /// Send what is still to be sent, then close.
    Close {
        /// Where.
        connection: ConnectionId,
    },
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_read_as_programs_write_them() {
        assert_eq!(Tag::parse("S3").map(Tag::number), Some(3));
        assert_eq!(
            Tag::parse("s8:").map(|t| t.to_string()).as_deref(),
            Some("S8:")
        );
        for wrong in ["S0", "S9:", "C3:", "S", "3", "S3:x", ""] {
            assert_eq!(Tag::parse(wrong), None, "{wrong:?}");
        }
    }
}
