//! The command port of the seed's pose server: one connection a command, eight numbers, one of three texts.

use std::io;
use std::time::Duration;

use protocol::{Reply, ReplyDecode, Stream, decode_reply, seed_fence};
use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWrite};
use tokio::time::{Instant, timeout_at};

use super::error::ReadError;
use super::exchange::{Written, write_once};

/// The most bytes of a reply that are looked at.
const REPLY_CAP: usize = 4096;
/// How much of an unknown reply is kept for the record.
const KEPT: usize = 120;

/// A connection, read up to its one reply.
#[derive(Debug)]
pub(super) struct SeedStream<S> {
    pub(super) stream: S,
    received: Vec<u8>,
}

impl<S: AsyncRead + Unpin> SeedStream<S> {
    pub(super) fn new(stream: S) -> Self {
        Self {
            stream,
            received: Vec::with_capacity(64),
        }
    }

    /// The reply. Dropping the future loses nothing.
    pub(super) async fn next(&mut self) -> Result<Reply, ReadError> {
        loop {
            match decode_reply(&self.received, Stream::Open) {
                ReplyDecode::Reply(reply) => return Ok(reply),
                ReplyDecode::Unknown => {
                    let kept = self.received.get(..KEPT).unwrap_or(&self.received);
                    return Err(ReadError::UnknownReply {
                        text: kept.escape_ascii().to_string(),
                    });
                }
                ReplyDecode::Incomplete if self.received.len() >= REPLY_CAP => {
                    return Err(ReadError::TooLong);
                }
                ReplyDecode::Incomplete => {}
            }
            match self.stream.read_buf(&mut self.received).await {
                Ok(0) => return Err(ReadError::Closed),
                Ok(_) => {}
                Err(source) => return Err(ReadError::Io(source)),
            }
        }
    }
}

/// Has the pose server refuse a message, which it does when it has read and answered everything before.
///
/// # Errors
/// It did not: nothing is shown.
pub(super) async fn fence<S: AsyncRead + AsyncWrite + Unpin>(
    stream: S,
    within: Duration,
) -> Result<(), ReadError> {
    let limit = Instant::now() + within;
    let mut stream = SeedStream::new(stream);
    match write_once(&mut stream.stream, &seed_fence(), limit).await {
        Ok(Written::Whole) => {}
        Ok(Written::Part(error)) => return Err(error),
        Err(source) => return Err(ReadError::Io(source)),
    }
    match timeout_at(limit, stream.next()).await {
        Ok(Ok(Reply::Unreachable)) => Ok(()),
        Ok(Ok(reply @ (Reply::Accepted | Reply::IncorrectInput))) => Err(ReadError::UnknownReply {
            text: reply.text().to_owned(),
        }),
        Ok(Err(error)) => Err(error),
        Err(_) => Err(ReadError::Io(io::ErrorKind::TimedOut.into())),
    }
}
