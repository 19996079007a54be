use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

use super::standing::{Phase, Standing};

/// A connection that notes in its standing when bytes come, when the peer takes none, and when an answer has left.
#[derive(Debug)]
pub(crate) struct Watched<S> {
    stream: S,
    standing: Arc<Standing>,
    blocked: bool,
}

impl<S> Watched<S> {
    pub(crate) fn new(stream: S, standing: Arc<Standing>) -> Self {
        Self {
            stream,
            standing,
            blocked: false,
        }
    }

    fn wrote<T>(&mut self, polled: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        match (polled.is_pending(), self.blocked) {
            (true, false) => self.standing.block(),
            (false, true) => self.standing.unblock(),
            (true, true) | (false, false) => {}
        }
        self.blocked = polled.is_pending();
        polled
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Watched<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let polled = Pin::new(&mut self.stream).poll_read(context, buffer);
        if polled.is_pending() {
            // From here on it is the peer the server waits for.
            self.standing.pass(Phase::Accepted, Phase::Arriving);
        } else if buffer.filled().len() > before {
            self.standing.pass(Phase::Idle, Phase::Head);
        }
        polled
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Watched<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let polled = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.wrote(polled)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let polled = Pin::new(&mut self.stream).poll_write_vectored(context, parts);
        self.wrote(polled)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let polled = Pin::new(&mut self.stream).poll_flush(context);
        if polled.is_ready() {
            // hyper flushes here once its own buffer is empty.
            self.standing.pass(Phase::Sent, Phase::Idle);
        }
        self.wrote(polled)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let polled = Pin::new(&mut self.stream).poll_shutdown(context);
        self.wrote(polled)
    }
}
