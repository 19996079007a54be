//! Controllers over TCP.

use std::fmt;
use std::io;
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use socket2::{Domain, Protocol, SockRef, Socket, Type};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::{TcpStream, lookup_host};

use super::connector::{Connector, ControllerAddress};

type Label = dyn Fn(SocketAddr, &str) + Send + Sync;

/// Connects over TCP.
#[derive(Clone, Default)]
pub struct TcpConnector {
    label: Option<Arc<Label>>,
}

impl TcpConnector {
    /// A connector that tells `label` the local address and the request id of every connection before it is used.
    ///
    /// An emulator in the same process finds by it which request the bytes it receives belong to.
    pub fn with_label(label: impl Fn(SocketAddr, &str) + Send + Sync + 'static) -> Self {
        Self {
            label: Some(Arc::new(label)),
        }
    }
}

impl Connector for TcpConnector {
    type Stream = TcpConnection;

    async fn connect(&self, address: &ControllerAddress) -> io::Result<TcpConnection> {
        match address {
            ControllerAddress::Numeric(address) => TcpConnection::open(*address).await,
            ControllerAddress::Named { host, port } => {
                let mut last = None;
                for address in lookup_host((host.as_str(), *port)).await? {
                    match TcpConnection::open(address).await {
                        Ok(connection) => return Ok(connection),
                        Err(error) => last = Some(error),
                    }
                }
                Err(last.unwrap_or_else(|| io::ErrorKind::AddrNotAvailable.into()))
            }
        }
    }

    fn before_send(&self, connection: &TcpConnection, request_id: &str) {
        if let Some(label) = &self.label
            && let Ok(local) = connection.local_addr()
        {
            label(local, request_id);
        }
    }
}

impl fmt::Debug for TcpConnector {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("TcpConnector")
            .field("labels", &self.label.is_some())
            .finish()
    }
}

/// An open connection to a controller.
///
/// A seed controller takes one connection a command, so opening one is most of what a command costs. Where the
/// handshake is over when `connect` returns, as on one machine, nothing is waited for: neither for the connection nor
/// for room to write the one command. `docs/benchmarks.md` says what that is worth.
#[derive(Debug)]
pub struct TcpConnection {
    stream: TcpStream,
    written: Written,
}

/// How often this end has written.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
enum Written {
    /// Never: the kernel has room for it, and need not be asked first.
    Nothing,
    /// The one command, which left at once: nothing before it waits for an acknowledgment.
    Once,
    /// More than that, with `TCP_NODELAY`.
    More,
}

impl TcpConnection {
    /// The address of this end.
    ///
    /// # Errors
    /// The system does not say.
    pub fn local_addr(&self) -> io::Result<SocketAddr> {
        self.stream.local_addr()
    }

    async fn open(address: SocketAddr) -> io::Result<Self> {
        let socket = socket(Domain::for_address(address))?;
        // In progress is an error here, too; which one it was matters only if there is no connection in the end.
        let begun = socket.connect(&address.into());
        let stream = TcpStream::from_std(socket.into())?;
        if stream.peer_addr().is_err() {
            stream.writable().await?;
            if let Some(error) = stream.take_error()? {
                return Err(error);
            }
            if let Err(not_connected) = stream.peer_addr() {
                return Err(begun.err().unwrap_or(not_connected));
            }
        }
        Ok(Self {
            stream,
            written: Written::Nothing,
        })
    }
}

/// A socket that keeps nobody waiting. Linux makes it so in one call.
#[cfg(target_os = "linux")]
fn socket(domain: Domain) -> io::Result<Socket> {
    Socket::new(domain, Type::STREAM.nonblocking(), Some(Protocol::TCP))
}

/// A socket that keeps nobody waiting.
#[cfg(not(target_os = "linux"))]
fn socket(domain: Domain) -> io::Result<Socket> {
    let socket = Socket::new(domain, Type::STREAM, Some(Protocol::TCP))?;
    socket.set_nonblocking(true)?;
    Ok(socket)
}

impl AsyncRead for TcpConnection {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, buffer)
    }
}

impl AsyncWrite for TcpConnection {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        match self.written {
            Written::Nothing => {
                self.written = Written::Once;
                match SockRef::from(&self.stream).send(bytes) {
                    Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                    sent => return Poll::Ready(sent),
                }
            }
            Written::Once => {
                self.written = Written::More;
                // From here on bytes would wait for the acknowledgment of those before. They get there either way.
                let _refused = self.stream.set_nodelay(true);
            }
            Written::More => {}
        }
        Pin::new(&mut self.stream).poll_write(context, bytes)
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
    use tokio::net::TcpListener;

    use super::*;

    async fn connect(address: SocketAddr) -> io::Result<TcpConnection> {
        let address = ControllerAddress::Numeric(address);
        TcpConnector::default().connect(&address).await
    }

    #[tokio::test]
    async fn bytes_arrive_in_order_whether_they_are_the_first_or_not() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let mut connection = connect(listener.local_addr().unwrap()).await.unwrap();
        let long = vec![b'x'; 1 << 20];
        let sent = async {
            connection.write_all(b"first").await.unwrap();
            connection.write_all(&long).await.unwrap();
            connection.shutdown().await.unwrap();
        };
        let received = async {
            let (mut peer, _) = listener.accept().await.unwrap();
            let mut all = Vec::new();
            let _length = peer.read_to_end(&mut all).await.unwrap();
            all
        };
        let ((), all) = tokio::join!(sent, received);
        assert_eq!(all.len(), 5 + long.len());
        assert!(all.starts_with(b"first"));
    }

    /// What is written in two parts does not wait for an acknowledgment in between.
    #[tokio::test]
    async fn from_the_second_write_on_nothing_is_held_back() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let mut connection = connect(listener.local_addr().unwrap()).await.unwrap();
        connection.write_all(b"one").await.unwrap();
        assert!(!connection.stream.nodelay().unwrap());
        connection.write_all(b"two").await.unwrap();
        assert!(connection.stream.nodelay().unwrap());
    }

    #[tokio::test]
    async fn a_port_nobody_listens_on_refuses() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        drop(listener);
        let error = connect(address).await.unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::ConnectionRefused);
    }

    #[tokio::test]
    async fn an_address_that_cannot_be_reached_is_the_error_of_the_connect() {
        let error = connect("255.255.255.255:9".parse().unwrap())
            .await
            .unwrap_err();
        assert_ne!(error.kind(), io::ErrorKind::NotConnected, "{error}");
    }

    #[tokio::test]
    async fn a_named_controller_is_looked_up() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let port = listener.local_addr().unwrap().port();
        let address = format!("localhost:{port}").parse().unwrap();
        let connected = TcpConnector::default().connect(&address).await;
        assert!(connected.is_ok());
    }
}
