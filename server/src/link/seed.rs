//! One exchange with a seed controller: connect, one write, one reply.

use std::io;
use std::time::Duration;

use protocol::{CommandBytes, Reply, ReplyDecode, Stream, decode_reply};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt};
use tokio::time::{Instant, sleep, timeout, timeout_at};

use super::connector::Connector;
use super::error::LinkError;
use crate::config::RobotPlan;

/// The most bytes read of one reply, whatever the controller sends.
const REPLY_CAP: usize = 4096;
/// How long the end of the stream is waited for once the reply is known.
const DRAIN: Duration = Duration::from_millis(250);
/// How much of an unknown reply is kept for the record.
const KEPT_TEXT: usize = 200;
/// The first pause before a refused connection is tried again; it doubles.
const FIRST_PAUSE: Duration = Duration::from_millis(5);

/// One command on its way.
pub(super) struct Exchange<'a, C> {
    pub(super) connector: &'a C,
    pub(super) plan: &'a RobotPlan,
    pub(super) request_id: &'a str,
    pub(super) deadline: Instant,
    /// Until when a refused connection means that the controller is reopening its tag after the last command.
    pub(super) reopening_until: Option<Instant>,
}

/// A reply, and the connection it came on, which the controller is about to close.
pub(super) struct Answered<S> {
    pub(super) reply: Reply,
    pub(super) stream: S,
}

impl<C: Connector> Exchange<'_, C> {
    /// Connects. Nothing is sent here, so a connection that is refused may be tried again.
    pub(super) async fn connect(&self) -> Result<C::Stream, LinkError> {
        let address = &self.plan.controller;
        let limit = self
            .deadline
            .min(Instant::now() + self.plan.connect_timeout);
        let mut pause = FIRST_PAUSE;
        loop {
            let source = match timeout_at(limit, self.connector.connect(address)).await {
                Ok(Ok(stream)) => return Ok(stream),
                Ok(Err(source)) => source,
                Err(_) if limit == self.deadline => return Err(LinkError::DeadlinePassed),
                Err(_) => {
                    return Err(LinkError::ConnectTimeout {
                        address: address.to_string(),
                        after: self.plan.connect_timeout,
                    });
                }
            };
            let next = Instant::now() + pause;
            let reopening = source.kind() == io::ErrorKind::ConnectionRefused
                && self.reopening_until.is_some_and(|until| next <= until)
                && next < limit;
            if !reopening {
                return Err(LinkError::Connect {
                    address: address.to_string(),
                    source,
                });
            }
            sleep(pause).await;
            pause *= 2;
        }
    }

    /// Writes the command and reads its reply. From the first byte on, a failure means "it may have moved".
    ///
    /// A whole known reply is enough: no reply is the beginning of another. The caller is answered at once and the
    /// end of the stream is waited for by [`drain`] before the next command.
    pub(super) async fn send(
        &self,
        mut stream: C::Stream,
        command: &CommandBytes,
        received: &mut Vec<u8>,
    ) -> Result<Answered<C::Stream>, LinkError> {
        self.connector.before_send(&stream, self.request_id);
        let started = Instant::now();
        if started >= self.deadline {
            return Err(LinkError::DeadlinePassed);
        }
        let limit = self.deadline.min(started + self.plan.reply_timeout);
        write(&mut stream, command, limit).await?;
        received.clear();
        let read = async {
            loop {
                match decode_reply(received, Stream::Open) {
                    ReplyDecode::Incomplete => {}
                    ReplyDecode::Reply(reply) => return Ok(reply),
                    ReplyDecode::Unknown => return Err(unknown_reply(&mut stream, received).await),
                }
                match stream.read_buf(received).await {
                    Ok(0) => {
                        return Err(LinkError::ClosedEarly {
                            received: received.len(),
                        });
                    }
                    Ok(_) => {}
                    Err(source) => return Err(LinkError::Read(source)),
                }
            }
        };
        match timeout_at(limit, read).await {
            Ok(Ok(reply)) => Ok(Answered { reply, stream }),
            Ok(Err(error)) => Err(error),
            Err(_) => match decode_reply(received, Stream::Open) {
                // The time ran out while the rest of it was collected.
                ReplyDecode::Unknown => Err(LinkError::UnknownReply {
                    text: kept_text(received),
                }),
                ReplyDecode::Incomplete | ReplyDecode::Reply(_) => Err(LinkError::NoReply {
                    after: started.elapsed(),
                    received: received.len(),
                }),
            },
        }
    }
}

/// Hands the command to the kernel in one write; a short write is continued, and a failure after it is in doubt.
async fn write<S: AsyncWriteExt + Unpin>(
    stream: &mut S,
    command: &[u8],
    limit: Instant,
) -> Result<(), LinkError> {
    let mut written = 0;
    while written < command.len() {
        let rest = command.get(written..).unwrap_or_default();
        let result = match timeout_at(limit, stream.write(rest)).await {
            Ok(Ok(0)) => Err(io::ErrorKind::WriteZero.into()),
            Ok(result) => result,
            Err(elapsed) => Err(elapsed.into()),
        };
        match result {
            Ok(count) => written += count,
            Err(source) if written == 0 => return Err(LinkError::WriteNothing(source)),
            Err(source) => {
                return Err(LinkError::WritePart {
                    written,
                    len: command.len(),
                    source,
                });
            }
        }
    }
    Ok(())
}

/// Reads what else an unknown reply consists of, for the record, up to the cap and a short while.
async fn unknown_reply<S: AsyncRead + Unpin>(stream: &mut S, received: &mut Vec<u8>) -> LinkError {
    let rest = async {
        while received.len() < REPLY_CAP && stream.read_buf(received).await.is_ok_and(|n| n > 0) {}
    };
    // Either way what has come is reported.
    let _ = timeout(DRAIN, rest).await;
    LinkError::UnknownReply {
        text: kept_text(received),
    }
}

/// The beginning of what the controller said, without anything that could forge a log line.
fn kept_text(received: &[u8]) -> String {
    let kept = received.get(..KEPT_TEXT).unwrap_or(received);
    kept.escape_ascii().to_string()
}

/// What came after the reply.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(super) enum Drained {
    /// The controller closed its side.
    Closed,
    /// Bytes came behind the reply: whoever answered, it was not the seed program.
    MoreBytes,
    /// The controller did not close in time; the connection is closed from here.
    LeftOpen,
}

/// Waits for the controller to close the connection: only then is it free to take the next one.
pub(super) async fn drain<S: AsyncRead + Unpin>(mut stream: S, received: &mut Vec<u8>) -> Drained {
    received.clear();
    let ended = async {
        while received.len() < REPLY_CAP {
            match stream.read_buf(received).await {
                Ok(0) | Err(_) => return Drained::Closed,
                Ok(_) => {}
            }
        }
        Drained::MoreBytes
    };
    let drained = timeout(DRAIN, ended).await;
    match drained {
        _ if !received.is_empty() => Drained::MoreBytes,
        Ok(drained) => drained,
        Err(_) => Drained::LeftOpen,
    }
}
