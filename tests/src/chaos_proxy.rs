use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use tokio::io::AsyncReadExt;
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinSet;
use tokio_util::task::AbortOnDropHandle;

use crate::Gate;
use crate::pump::{Direction, End, Treatment, pump};

/// What the proxy does to a connection. The mode at the moment of connecting holds for the whole connection.
#[derive(Clone, Debug, Default)]
pub enum Mode {
    /// Carry everything, both ways.
    #[default]
    Pass,
    /// Refuse connections, as a machine does on which nothing listens.
    Refuse,
    /// Accept, swallow what comes, never answer; the target hears nothing.
    Blackhole,
    /// Carry this many bytes in this direction, then cut the connection both ways; 0 cuts at the first byte.
    CutAfter(Direction, usize),
    /// Carry nothing in this direction until the gate is open.
    HoldAt(Direction, Gate),
    /// Carry everything, both ways, byte by byte.
    SplitIntoBytes,
    /// Change the first byte of the reply.
    CorruptReply,
    /// Carry each piece of the reply twice.
    DuplicateReply,
}

/// What has gone through the proxy since it started.
#[derive(Clone, Copy, Debug, Default, Eq, PartialEq)]
pub struct Traffic {
    /// Connections accepted.
    pub connections: usize,
    /// Bytes that clients sent, carried or not.
    pub bytes_from_clients: usize,
    /// Bytes that the target sent, carried or not.
    pub bytes_from_target: usize,
}

#[derive(Debug, Default)]
struct Counters {
    connections: AtomicUsize,
    from_clients: AtomicUsize,
    from_target: AtomicUsize,
}

/// A TCP proxy on a free port that breaks the network in named ways. Dropping it cuts every connection.
#[derive(Debug)]
pub struct ChaosProxy {
    address: SocketAddr,
    counters: Arc<Counters>,
    modes: mpsc::Sender<(Mode, oneshot::Sender<io::Result<()>>)>,
    _task: AbortOnDropHandle<()>,
}

impl ChaosProxy {
    /// A proxy to `target` that carries everything until told otherwise.
    ///
    /// # Errors
    /// If no port can be opened.
    pub async fn start(target: SocketAddr) -> io::Result<Self> {
        let listener = TcpListener::bind("127.0.0.1:0").await?;
        let address = listener.local_addr()?;
        let counters = Arc::new(Counters::default());
        let (modes, orders) = mpsc::channel(1);
        let owner = Owner {
            address,
            target,
            mode: Mode::Pass,
            port: Port::Open(listener),
            counters: Arc::clone(&counters),
            connections: JoinSet::new(),
        };
        Ok(Self {
            address,
            counters,
            modes,
            _task: AbortOnDropHandle::new(tokio::spawn(owner.run(orders))),
        })
    }

    /// Where to connect instead of to the target. Stays the same whatever the mode.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Treats connections from now on as `mode` says; those that are open go on as they began.
    ///
    /// # Errors
    /// If the port cannot be opened again after [`Mode::Refuse`].
    pub async fn set(&self, mode: Mode) -> io::Result<()> {
        let gone = || io::Error::other("the proxy's task is gone");
        let (done, answer) = oneshot::channel();
        self.modes.send((mode, done)).await.map_err(|_| gone())?;
        answer.await.map_err(|_| gone())?
    }

    /// What has gone through so far.
    #[must_use]
    pub fn traffic(&self) -> Traffic {
        Traffic {
            connections: self.counters.connections.load(Ordering::SeqCst),
            bytes_from_clients: self.counters.from_clients.load(Ordering::SeqCst),
            bytes_from_target: self.counters.from_target.load(Ordering::SeqCst),
        }
    }
}

/// The proxy's port, kept in every mode so that nobody else gets it.
#[derive(Debug)]
enum Port {
    Open(TcpListener),
    /// Bound and not listening: the kernel refuses.
    Shut(#[expect(dead_code, reason = "held for its port")] TcpSocket),
    /// Between the two.
    Lost,
}

/// The task that owns the port and the connections.
struct Owner {
    address: SocketAddr,
    target: SocketAddr,
    mode: Mode,
    port: Port,
    counters: Arc<Counters>,
    connections: JoinSet<()>,
}

impl Owner {
    async fn run(mut self, mut orders: mpsc::Receiver<(Mode, oneshot::Sender<io::Result<()>>)>) {
        loop {
            tokio::select! {
                order = orders.recv() => {
                    let Some((mode, done)) = order else { return };
                    let _ = done.send(self.set(mode));
                }
                Some(client) = accept(&self.port) => {
                    let _ = self.counters.connections.fetch_add(1, Ordering::SeqCst);
                    let connection = carry(client, self.target, self.mode.clone(), Arc::clone(&self.counters));
                    let _ = self.connections.spawn(async move {
                        // A connection that breaks, on whichever side, is what a proxy is for.
                        let _ = connection.await;
                    });
                }
                Some(_) = self.connections.join_next() => {}
            }
        }
    }

    fn set(&mut self, mode: Mode) -> io::Result<()> {
        let refuse = matches!(mode, Mode::Refuse);
        self.mode = mode;
        match (&self.port, refuse) {
            (Port::Open(_), false) | (Port::Shut(_), true) => return Ok(()),
            (Port::Open(_), true) | (Port::Shut(_), false) | (Port::Lost, _) => {}
        }
        self.port = Port::Lost;
        let socket = TcpSocket::new_v4()?;
        socket.set_reuseaddr(true)?;
        socket.bind(self.address)?;
        self.port = if refuse {
            Port::Shut(socket)
        } else {
            Port::Open(socket.listen(64)?)
        };
        Ok(())
    }
}

async fn accept(port: &Port) -> Option<TcpStream> {
    match port {
        Port::Open(listener) => listener.accept().await.ok().map(|(client, _)| client),
        Port::Shut(_) | Port::Lost => std::future::pending().await,
    }
}

async fn carry(
    mut client: TcpStream,
    target: SocketAddr,
    mode: Mode,
    counters: Arc<Counters>,
) -> io::Result<()> {
    let (commands, replies) = match mode {
        // A connection that came in before the port was shut.
        Mode::Refuse => return Ok(()),
        Mode::Blackhole => return swallow(&mut client, &counters.from_clients).await,
        Mode::Pass => (Treatment::Pass, Treatment::Pass),
        Mode::CutAfter(Direction::ToTarget, limit) => (Treatment::CutAfter(limit), Treatment::Pass),
        Mode::CutAfter(Direction::ToClient, limit) => (Treatment::Pass, Treatment::CutAfter(limit)),
        Mode::HoldAt(Direction::ToTarget, gate) => (Treatment::HoldAt(gate), Treatment::Pass),
        Mode::HoldAt(Direction::ToClient, gate) => (Treatment::Pass, Treatment::HoldAt(gate)),
        Mode::SplitIntoBytes => (Treatment::SplitIntoBytes, Treatment::SplitIntoBytes),
        Mode::CorruptReply => (Treatment::Pass, Treatment::CorruptFirstByte),
        Mode::DuplicateReply => (Treatment::Pass, Treatment::Twice),
    };
    let server = TcpStream::connect(target).await?;
    client.set_nodelay(true)?;
    server.set_nodelay(true)?;
    let (from_client, to_client) = client.into_split();
    let (from_server, to_server) = server.into_split();
    let commands = pump(from_client, to_server, commands, &counters.from_clients);
    let replies = pump(from_server, to_client, replies, &counters.from_target);
    tokio::pin!(commands, replies);
    // An end or a cut of one direction decides about the other: a cut drops both sockets, an end lets it finish.
    let ended = tokio::select! {
        end = &mut commands => (end?, Direction::ToTarget),
        end = &mut replies => (end?, Direction::ToClient),
    };
    match ended {
        (End::Cut, _) => {}
        (End::Finished, Direction::ToTarget) => drop(replies.await?),
        (End::Finished, Direction::ToClient) => drop(commands.await?),
    }
    Ok(())
}

async fn swallow(client: &mut TcpStream, received: &AtomicUsize) -> io::Result<()> {
    let mut buffer = vec![0; 4096];
    loop {
        match client.read(&mut buffer).await? {
            0 => return Ok(()),
            count => drop(received.fetch_add(count, Ordering::SeqCst)),
        }
    }
}
