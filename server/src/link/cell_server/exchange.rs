//! The command port up to the one write: connect, greeting, checks.

use std::io;
use std::time::Duration;

use protocol::v2::{Greeting, Request};
use tokio::io::{AsyncWrite, AsyncWriteExt as _};
use tokio::time::{Instant, sleep, timeout_at};

use super::error::{LinkError, ReadError};
use super::order::MotionOrder;
use super::plan::CellServerPlan;
use super::readiness::{Identity, NotReady};
use super::stream::LineStream;
use crate::link::Connector;

/// The first pause before a refused connection is tried again; it doubles. A tag is reopened between two commands.
const FIRST_PAUSE: Duration = Duration::from_millis(5);

/// Connects and reads the greeting. Nothing is sent here, so the future may be dropped.
pub(super) async fn greet<C: Connector>(
    connector: &C,
    plan: &CellServerPlan,
    order: &MotionOrder,
) -> Result<(LineStream<C::Stream>, Greeting), LinkError> {
    let stream = connect(connector, plan, order.not_after).await?;
    connector.before_send(&stream, &order.request_id);
    let mut lines = LineStream::new(stream);
    let limit = order.not_after.min(Instant::now() + plan.reply_timeout);
    match timeout_at(limit, lines.next(Greeting::decode)).await {
        Ok(Ok(greeting)) => Ok((lines, greeting)),
        Ok(Err(source)) => Err(LinkError::ReadGreeting {
            address: plan.command.to_string(),
            source,
        }),
        Err(_) if limit == order.not_after => Err(LinkError::DeadlinePassed),
        Err(_) => Err(LinkError::NoGreeting {
            address: plan.command.to_string(),
            after: plan.reply_timeout,
        }),
    }
}

pub(super) async fn connect<C: Connector>(
    connector: &C,
    plan: &CellServerPlan,
    not_after: Instant,
) -> Result<C::Stream, LinkError> {
    let limit = not_after.min(Instant::now() + plan.connect_timeout);
    let mut pause = FIRST_PAUSE;
    loop {
        let source = match timeout_at(limit, connector.connect(&plan.command)).await {
            Ok(Ok(stream)) => return Ok(stream),
            Ok(Err(source)) => source,
            Err(_) if limit == not_after => return Err(LinkError::DeadlinePassed),
            Err(_) => {
                return Err(LinkError::ConnectTimeout {
                    address: plan.command.to_string(),
                    after: plan.connect_timeout,
                });
            }
        };
        let refused = source.kind() == io::ErrorKind::ConnectionRefused;
        if !refused || Instant::now() + pause >= limit {
            return Err(LinkError::Connect {
                address: plan.command.to_string(),
                source,
            });
        }
        sleep(pause).await;
        pause *= 2;
    }
}

/// Whether the controller that greets is the one that was judged ready, and has not had this number.
pub(super) fn check_greeting(
    greeting: &Greeting,
    order: &MotionOrder,
    boot: u32,
) -> Result<(), LinkError> {
    if greeting.boot != boot {
        return Err(LinkError::RestartedBefore {
            was: boot,
            is: greeting.boot,
        });
    }
    if greeting.epoch_max > order.wire_epoch {
        return Err(LinkError::NotReady(NotReady::Superseded {
            epoch_max: greeting.epoch_max,
            ours: order.wire_epoch,
        }));
    }
    if greeting.epoch_max < order.wire_epoch {
        // The controller behind the status port was fenced with it: this is another one.
        return Err(LinkError::NotReady(NotReady::OtherController {
            is: Identity {
                boot: greeting.boot,
                epoch_max: greeting.epoch_max,
            },
            was: Identity {
                boot,
                epoch_max: order.wire_epoch,
            },
        }));
    }
    if greeting.accepted >= order.number() {
        return Err(LinkError::NumberUsed {
            number: order.number(),
            accepted: greeting.accepted,
        });
    }
    Ok(())
}

/// What is known after the one write.
pub(super) enum Written {
    /// All of it was handed over.
    Whole,
    /// Some of it was: the checksum keeps the controller from taking a part for the whole, but not from having the
    /// rest.
    Part(ReadError),
}

/// Hands the command over, once.
///
/// # Errors
/// Not one byte of it was handed over.
pub(super) async fn send<S: AsyncWrite + Unpin>(
    lines: &mut LineStream<S>,
    request: &Request,
    limit: Instant,
) -> Result<Written, LinkError> {
    let written = write_once(&mut lines.stream, &request.encode(), limit).await;
    written.map_err(LinkError::WriteNothing)
}

/// Writes a whole command.
///
/// # Errors
/// Not one byte of it was handed over.
pub(super) async fn write_once<S: AsyncWrite + Unpin>(
    stream: &mut S,
    line: &[u8],
    limit: Instant,
) -> Result<Written, io::Error> {
    let mut written = 0;
    while let Some(rest) = line.get(written..).filter(|rest| !rest.is_empty()) {
        let result = match timeout_at(limit, stream.write(rest)).await {
            Ok(Ok(0)) => Err(io::ErrorKind::WriteZero.into()),
            Ok(result) => result,
            Err(elapsed) => Err(elapsed.into()),
        };
        match result {
            Ok(count) => written += count,
            Err(source) if written == 0 => return Err(source),
            Err(source) => return Ok(Written::Part(ReadError::Io(source))),
        }
    }
    Ok(Written::Whole)
}
