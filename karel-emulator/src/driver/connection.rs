//! One accepted socket: what is still to be sent, and how it is closed without losing it.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::net::SocketAddr;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use socket2::SockRef;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio_util::sync::CancellationToken;

/// Bytes that one read takes at most.
const READ_SIZE: usize = 16 * 1024;
/// How long a closed connection waits for its peer to take the last bytes and close, too.
const LINGER: Duration = Duration::from_secs(2);
/// How many bytes of a peer that goes on sending are thrown away meanwhile.
const LINGER_BYTES: usize = 1 << 20;

/// What a socket has to say.
#[derive(Debug)]
pub(super) enum Report {
    Bytes(Vec<u8>),
    Sent(usize),
    Closed,
    Lost,
}

/// An accepted socket.
#[derive(Debug)]
pub(super) struct Live {
    stream: TcpStream,
    pub(super) peer: SocketAddr,
    outbox: VecDeque<Vec<u8>>,
    /// Nothing more will be read.
    deaf: bool,
    /// Nothing more can be sent.
    lost: bool,
}

impl Live {
    pub(super) fn new(stream: TcpStream, peer: SocketAddr) -> Self {
        // One WRITE is one segment, at once: clients of controllers read it with one call.
        if let Err(error) = stream.set_nodelay(true) {
            tracing::debug!(%peer, %error, "TCP_NODELAY could not be set.");
        }
        Self {
            stream,
            peer,
            outbox: VecDeque::new(),
            deaf: false,
            lost: false,
        }
    }

    /// Queues the bytes of one WRITE; [`Self::flush`] sends them.
    pub(super) fn queue(&mut self, bytes: Vec<u8>) {
        self.outbox.push_back(bytes);
    }

    /// Sends what the operating system takes now, without asking the runtime whether it is ready to.
    pub(super) fn flush(&mut self) -> Option<Report> {
        let mut sent = 0;
        while let Some(front) = self.outbox.front_mut() {
            match (&*SockRef::from(&self.stream)).write(front) {
                Ok(count) => {
                    sent += count;
                    drop(front.drain(..count.min(front.len())));
                    if front.is_empty() {
                        let _sent = self.outbox.pop_front();
                    }
                }
                Err(error) if is_passing(&error) => break,
                Err(_) => return self.lose(),
            }
        }
        (sent > 0).then_some(Report::Sent(sent))
    }

    /// Reads what the operating system has now, at most `room` bytes, without asking the runtime.
    pub(super) fn read_now(&mut self, room: usize) -> Option<Report> {
        if self.deaf || room == 0 {
            return None;
        }
        let mut buffer = vec![0; room.min(READ_SIZE)];
        let result = (&*SockRef::from(&self.stream)).read(&mut buffer);
        self.report_read(result, buffer)
    }

    /// The next report, when there is one.
    pub(super) fn poll(&mut self, cx: &mut Context<'_>, room: usize) -> Poll<Report> {
        if let Poll::Ready(report) = self.poll_write(cx) {
            return Poll::Ready(report);
        }
        self.poll_read(cx, room)
    }

    fn poll_write(&mut self, cx: &mut Context<'_>) -> Poll<Report> {
        while let Some(front) = self.outbox.front_mut() {
            if ready!(self.stream.poll_write_ready(cx)).is_err() {
                return self.lose().map_or(Poll::Pending, Poll::Ready);
            }
            match self.stream.try_write(front) {
                Ok(count) => {
                    drop(front.drain(..count.min(front.len())));
                    if front.is_empty() {
                        let _sent = self.outbox.pop_front();
                    }
                    return Poll::Ready(Report::Sent(count));
                }
                Err(error) if is_passing(&error) => {}
                Err(_) => return self.lose().map_or(Poll::Pending, Poll::Ready),
            }
        }
        Poll::Pending
    }

    fn poll_read(&mut self, cx: &mut Context<'_>, room: usize) -> Poll<Report> {
        while !self.deaf && room > 0 {
            let result = match ready!(self.stream.poll_read_ready(cx)) {
                Ok(()) => {
                    let mut buffer = vec![0; room.min(READ_SIZE)];
                    let result = self.stream.try_read(&mut buffer);
                    self.report_read(result, buffer)
                }
                Err(error) => self.report_read(Err(error), Vec::new()),
            };
            if let Some(report) = result {
                return Poll::Ready(report);
            }
        }
        Poll::Pending
    }

    fn report_read(&mut self, result: io::Result<usize>, mut buffer: Vec<u8>) -> Option<Report> {
        match result {
            Ok(0) => {
                self.deaf = true;
                Some(Report::Closed)
            }
            Ok(count) => {
                buffer.truncate(count);
                Some(Report::Bytes(buffer))
            }
            Err(error) if is_passing(&error) => None,
            Err(_) => self.lose(),
        }
    }

    fn lose(&mut self) -> Option<Report> {
        self.outbox.clear();
        self.deaf = true;
        let news = !self.lost;
        self.lost = true;
        news.then_some(Report::Lost)
    }

    /// Closes the connection so that the peer sees a reset.
    pub(super) fn reset(self) {
        if let Err(error) = SockRef::from(&self.stream).set_linger(Some(Duration::ZERO)) {
            tracing::debug!(peer = %self.peer, %error, "A connection cannot be reset, it is closed.");
        }
    }

    /// Closes the connection so that the peer reads everything that was written.
    ///
    /// A socket that is dropped with unread bytes is reset, and the reset overtakes the reply. So: send, say that
    /// nothing more comes, and read away what the peer still sends until it closes, for a while.
    pub(super) async fn linger(mut self, stop: CancellationToken) {
        if self.lost {
            return;
        }
        let farewell = async {
            for bytes in std::mem::take(&mut self.outbox) {
                self.stream.write_all(&bytes).await?;
            }
            self.stream.shutdown().await?;
            let mut buffer = vec![0; READ_SIZE];
            let mut thrown_away = 0;
            while thrown_away < LINGER_BYTES {
                match self.stream.read(&mut buffer).await? {
                    0 => break,
                    count => thrown_away += count,
                }
            }
            io::Result::Ok(())
        };
        tokio::select! {
            result = tokio::time::timeout(LINGER, farewell) => {
                let peer = self.peer;
                match result {
                    Ok(Ok(())) => tracing::debug!(%peer, "A connection was closed."),
                    Ok(Err(error)) => tracing::debug!(%peer, %error, "A connection broke while it was closed."),
                    Err(_) => tracing::debug!(%peer, "A peer did not close its side in time."),
                }
            }
            () = stop.cancelled() => {}
        }
    }
}

/// Not now, but later.
fn is_passing(error: &io::Error) -> bool {
    matches!(
        error.kind(),
        io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted
    )
}
