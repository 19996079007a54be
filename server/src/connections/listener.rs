use std::future::Future;
use std::io;
use std::net::SocketAddr;
use std::time::Duration;

use socket2::SockRef;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio::net::{TcpListener, TcpStream};

/// How many connections may wait in the kernel; it may allow fewer. Where the backlog is full, a caller's next try is a
/// second later, and a burst of slow callers would cost honest ones that second. The library's own is 128.
const BACKLOG: i32 = 4_096;
/// The first pause after a connection could not be accepted; it doubles.
const FIRST_PAUSE: Duration = Duration::from_millis(5);
/// The longest.
const LONGEST_PAUSE: Duration = Duration::from_millis(500);

/// Where connections come from. The seam through which a test puts another network.
pub trait Listener: Send + 'static {
    /// A connection.
    type Io: AsyncRead + AsyncWrite + Send + Unpin + 'static;

    /// Called once, before the first connection is accepted.
    ///
    /// # Errors
    /// It cannot be made ready; the server serves all the same.
    fn prepare(&mut self) -> io::Result<()> {
        Ok(())
    }

    /// The next connection, and where it comes from.
    ///
    /// # Errors
    /// There was none to be had; the server waits a little and asks again. A handshake on top of a connection does
    /// not belong here: while this waits, nobody else is accepted.
    fn accept(&mut self) -> impl Future<Output = io::Result<(Self::Io, SocketAddr)>> + Send;
}

impl Listener for TcpListener {
    type Io = TcpStream;

    fn prepare(&mut self) -> io::Result<()> {
        // Asking again changes the length of the backlog.
        SockRef::from(&*self).listen(BACKLOG)
    }

    async fn accept(&mut self) -> io::Result<(TcpStream, SocketAddr)> {
        let (stream, peer) = TcpListener::accept(self).await?;
        // Events are small and come one by one: each would wait for the acknowledgment of the one before.
        stream.set_nodelay(true)?;
        Ok((stream, peer))
    }
}

/// Failures to accept, in a row.
#[derive(Debug)]
pub(crate) struct AcceptFailures {
    pause: Duration,
}

impl AcceptFailures {
    pub(crate) fn none() -> Self {
        Self { pause: FIRST_PAUSE }
    }

    /// What to do about one: `None` where it concerned one caller only, else how long to wait.
    pub(crate) fn note(&mut self, error: &io::Error) -> Option<Duration> {
        use io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset};
        let gone = [ConnectionAborted, ConnectionRefused, ConnectionReset];
        if gone.contains(&error.kind()) {
            return None;
        }
        let pause = self.pause;
        if pause == FIRST_PAUSE {
            tracing::error!(
                error = error as &dyn std::error::Error,
                "connections cannot be accepted; trying again, less and less often"
            );
        }
        self.pause = (pause * 2).min(LONGEST_PAUSE);
        Some(pause)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Covers: R2.
    #[test]
    fn failures_to_accept_are_waited_out_longer_and_longer() {
        let mut failures = AcceptFailures::none();
        let exhausted = || io::Error::from_raw_os_error(24);
        let pauses: Vec<_> = (0..9)
            .filter_map(|_| failures.note(&exhausted()))
            .map(|pause| pause.as_millis())
            .collect();
        assert_eq!(pauses, [5, 10, 20, 40, 80, 160, 320, 500, 500]);
        assert_eq!(
            failures.note(&io::ErrorKind::ConnectionAborted.into()),
            None
        );
    }
}
