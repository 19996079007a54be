//! One direction of one connection through the proxy.

use std::io;
use std::sync::atomic::{AtomicUsize, Ordering};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};

use crate::Gate;

/// Which way bytes go.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum Direction {
    /// Commands: from whoever connected to the proxy, to its target.
    ToTarget,
    /// Replies: from the target, back.
    ToClient,
}

/// What is done to the bytes of one direction.
#[derive(Clone, Debug)]
pub(crate) enum Treatment {
    Pass,
    CutAfter(usize),
    HoldAt(Gate),
    SplitIntoBytes,
    CorruptFirstByte,
    Twice,
}

/// Why a direction is over.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum End {
    /// The sender has no more; the other direction may go on.
    Finished,
    /// The connection is to be cut, both ways.
    Cut,
}

/// Carries bytes until the sender ends or the treatment cuts, and counts those received.
pub(crate) async fn pump(
    mut from: OwnedReadHalf,
    mut to: OwnedWriteHalf,
    treatment: Treatment,
    received: &AtomicUsize,
) -> io::Result<End> {
    let mut buffer = vec![0; 16 * 1024];
    let mut carried = 0;
    loop {
        let count = from.read(&mut buffer).await?;
        let _ = received.fetch_add(count, Ordering::SeqCst);
        let Some(chunk) = buffer.get_mut(..count) else {
            return Err(io::Error::other("a read of more than its buffer"));
        };
        if chunk.is_empty() {
            // An end travels like a byte: behind a gate it waits, too.
            if let Treatment::HoldAt(gate) = &treatment {
                gate.pass().await;
            }
            to.shutdown().await?;
            return Ok(End::Finished);
        }
        match &treatment {
            Treatment::Pass => to.write_all(chunk).await?,
            Treatment::HoldAt(gate) => {
                gate.pass().await;
                to.write_all(chunk).await?;
            }
            Treatment::CutAfter(limit) => {
                let rest = limit.saturating_sub(carried);
                to.write_all(chunk.get(..rest).unwrap_or(chunk)).await?;
                if count >= rest {
                    return Ok(End::Cut);
                }
            }
            Treatment::SplitIntoBytes => {
                for byte in chunk.iter() {
                    to.write_all(std::slice::from_ref(byte)).await?;
                    // The receiver's turn, so that it sees the bytes one by one where it runs in this process.
                    tokio::task::yield_now().await;
                }
            }
            Treatment::CorruptFirstByte => {
                if let (0, Some(first)) = (carried, chunk.first_mut()) {
                    *first ^= 1;
                }
                to.write_all(chunk).await?;
            }
            Treatment::Twice => {
                to.write_all(chunk).await?;
                to.write_all(chunk).await?;
            }
        }
        carried += count;
    }
}
