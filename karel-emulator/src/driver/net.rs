//! The sockets of one controller, all polled by one task.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::io;
use std::net::{IpAddr, SocketAddr};
use std::sync::Arc;
use std::task::{Context, Poll};

use socket2::SockRef;
use tokio::net::TcpStream;
use tokio::sync::{Semaphore, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use super::connection::{Live, Report};
use super::port::Port;
use crate::config::{ControllerConfig, SecondClient};
use crate::effects::{ConnectionId, Effect, Event, Tag};
use crate::error::StartError;
use crate::labels::PeerLabels;

/// Clients that wait in the kernel while one is served.
const BACKLOG: u32 = 16;

/// Where the ports of the program are on this machine, once they have been open.
pub(crate) type Addresses = BTreeMap<u16, SocketAddr>;

/// What the handle learns about ports.
#[derive(Debug)]
pub(super) struct News {
    pub(super) addresses: watch::Sender<Addresses>,
    /// The last port that this machine did not give.
    pub(super) port_failure: watch::Sender<Option<String>>,
}

/// Listeners and connections.
#[derive(Debug)]
pub(super) struct Net {
    ip: IpAddr,
    second_client: SecondClient,
    /// By the port as the program names it.
    ports: BTreeMap<u16, Port>,
    /// The ports of the port map, reserved from start to end.
    mapped: BTreeSet<u16>,
    /// The port each tag was opened on last, and whether a program waits for a client there.
    tags: BTreeMap<Tag, TagPort>,
    connections: BTreeMap<ConnectionId, Live>,
    last_connection: u64,
    /// Events that came from effects.
    events: VecDeque<Event>,
    addresses: watch::Sender<Addresses>,
    port_failure: watch::Sender<Option<String>>,
    labels: PeerLabels,
    lingering: Arc<Semaphore>,
    tracker: TaskTracker,
    stop: CancellationToken,
}

#[derive(Clone, Copy, Debug)]
struct TagPort {
    port: u16,
    accepting: bool,
}

impl Net {
    /// Reserves every mapped port.
    pub(super) fn start(
        config: &ControllerConfig,
        labels: PeerLabels,
        news: News,
        tracker: TaskTracker,
        stop: CancellationToken,
    ) -> Result<Self, StartError> {
        let mut ports = BTreeMap::new();
        for (&program_port, &host_port) in &config.port_map {
            let mut port = Port::new(config.ip, host_port);
            port.reserve().map_err(|source| StartError::Port {
                program_port,
                host_port,
                source,
            })?;
            let _new = ports.insert(program_port, port);
        }
        Ok(Self {
            ip: config.ip,
            second_client: config.second_client,
            mapped: ports.keys().copied().collect(),
            ports,
            tags: BTreeMap::new(),
            connections: BTreeMap::new(),
            last_connection: 0,
            events: VecDeque::new(),
            addresses: news.addresses,
            port_failure: news.port_failure,
            labels,
            lingering: Arc::new(Semaphore::new(config.limits.lingering_connections)),
            tracker,
            stop,
        })
    }

    /// Does what the core asked for.
    pub(super) fn apply(&mut self, effect: Effect) {
        match effect {
            Effect::Accept { tag, port } => {
                if let Err(reason) = self.accept(tag, port) {
                    self.events.push_back(Event::ListenFailed { tag, reason });
                }
            }
            Effect::StopAccepting { tag } => {
                if let Some(open) = self.tags.get_mut(&tag) {
                    open.accepting = false;
                }
                if self.second_client == SecondClient::Refuse {
                    self.close_port(tag);
                }
            }
            Effect::StopListening { tag } => self.leave_port(tag),
            Effect::Send { connection, bytes } => {
                if let Some(live) = self.connections.get_mut(&connection) {
                    live.queue(bytes);
                    let report = live.flush();
                    self.note(connection, report);
                }
            }
            Effect::Reset { connection } => {
                if let Some(live) = self.connections.remove(&connection) {
                    live.reset();
                }
            }
            Effect::Close { connection } => self.close(connection),
        }
    }

    /// The next event, when there is one. `room` says how many bytes a connection may bring.
    pub(super) fn poll(
        &mut self,
        cx: &mut Context<'_>,
        room: impl Fn(ConnectionId) -> usize,
    ) -> Poll<Event> {
        if let Some(event) = self.events.pop_front() {
            return Poll::Ready(event);
        }
        for tag in Tag::all() {
            let Some(listener) = self.accepting_on(tag).and_then(Port::listener) else {
                continue;
            };
            while let Poll::Ready(result) = listener.poll_accept(cx) {
                // A client that gave up while it waited is nobody's failure.
                if !result
                    .as_ref()
                    .is_err_and(|e| e.kind() == io::ErrorKind::ConnectionAborted)
                {
                    return Poll::Ready(self.accepted(tag, result));
                }
            }
        }
        for (&id, live) in &mut self.connections {
            if let Poll::Ready(report) = live.poll(cx, room(id)) {
                return Poll::Ready(event_of(id, live.peer, report, &self.labels));
            }
        }
        Poll::Pending
    }

    /// Everything that the operating system has at this moment, without waiting for the runtime to notice it.
    pub(super) fn sweep(&mut self, room: impl Fn(ConnectionId) -> usize) -> Option<Event> {
        if let Some(event) = self.events.pop_front() {
            return Some(event);
        }
        for tag in Tag::all() {
            let Some(listener) = self.accepting_on(tag).and_then(Port::listener) else {
                continue;
            };
            match accept_now(&SockRef::from(listener)) {
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {}
                result => return Some(self.accepted(tag, result)),
            }
        }
        for (&id, live) in &mut self.connections {
            if let Some(report) = live.flush().or_else(|| live.read_now(room(id))) {
                return Some(event_of(id, live.peer, report, &self.labels));
            }
        }
        None
    }

    fn accepting_on(&self, tag: Tag) -> Option<&Port> {
        let open = self.tags.get(&tag).filter(|open| open.accepting)?;
        self.ports.get(&open.port)
    }

    fn accept(&mut self, tag: Tag, program_port: u16) -> Result<(), String> {
        if self
            .tags
            .get(&tag)
            .is_some_and(|open| open.port != program_port)
        {
            self.leave_port(tag);
        }
        let other = self.tags.iter().find(|(other, open)| {
            **other != tag && open.port == program_port && (open.accepting || self.is_open(**other))
        });
        if let Some((other, _)) = other {
            return Err(format!("Port {program_port} of {tag} is used by {other}"));
        }
        let port = self
            .ports
            .entry(program_port)
            .or_insert_with(|| Port::new(self.ip, program_port));
        let backlog = match self.second_client {
            SecondClient::Backlog => BACKLOG,
            SecondClient::Refuse => 1,
        };
        let address = port.open(backlog).map_err(|error| {
            let reason = format!("Port {} for {tag} cannot be opened: {error}", port.number());
            let _previous = self.port_failure.send_replace(Some(reason.clone()));
            reason
        })?;
        let _previous = self.tags.insert(
            tag,
            TagPort {
                port: program_port,
                accepting: true,
            },
        );
        let news = self
            .addresses
            .send_if_modified(|addresses| addresses.insert(program_port, address) != Some(address));
        if news {
            tracing::info!(%tag, "Port {program_port} of the program is open at {address}.");
        }
        Ok(())
    }

    fn is_open(&self, tag: Tag) -> bool {
        let port = self
            .tags
            .get(&tag)
            .and_then(|open| self.ports.get(&open.port));
        port.is_some_and(|port| port.listener().is_some())
    }

    fn close_port(&mut self, tag: Tag) {
        if let Some(port) = self
            .tags
            .get(&tag)
            .and_then(|open| self.ports.get_mut(&open.port))
        {
            port.close();
        }
    }

    fn accepted(&mut self, tag: Tag, result: io::Result<(TcpStream, SocketAddr)>) -> Event {
        if let Some(open) = self.tags.get_mut(&tag) {
            open.accepting = false;
        }
        match result {
            Ok((stream, peer)) => {
                if self.second_client == SecondClient::Refuse {
                    self.close_port(tag);
                }
                self.last_connection += 1;
                let connection = ConnectionId(self.last_connection);
                let _new = self.connections.insert(connection, Live::new(stream, peer));
                Event::Connected {
                    tag,
                    connection,
                    peer,
                }
            }
            Err(error) => {
                let reason = format!("Accepting a client on {tag} failed: {error}");
                Event::ListenFailed { tag, reason }
            }
        }
    }

    /// Closes the port of a tag that needs it no more. Only mapped ports stay reserved: a program could name many.
    fn leave_port(&mut self, tag: Tag) {
        self.close_port(tag);
        if let Some(TagPort { port, .. }) = self.tags.remove(&tag)
            && !self.mapped.contains(&port)
        {
            let _closed = self.ports.remove(&port);
        }
    }

    fn note(&mut self, id: ConnectionId, report: Option<Report>) {
        if let (Some(report), Some(live)) = (report, self.connections.get(&id)) {
            self.events
                .push_back(event_of(id, live.peer, report, &self.labels));
        }
    }

    fn close(&mut self, connection: ConnectionId) {
        let Some(live) = self.connections.remove(&connection) else {
            return;
        };
        match self.lingering.clone().try_acquire_owned() {
            Ok(permit) => {
                let stop = self.stop.clone();
                let _task = self.tracker.spawn(async move {
                    live.linger(stop).await;
                    drop(permit);
                });
            }
            Err(_) => {
                tracing::warn!(
                    peer = %live.peer,
                    "Too many closed connections wait for their peers, one was dropped at once.",
                );
            }
        }
    }
}

fn event_of(
    connection: ConnectionId,
    peer: SocketAddr,
    report: Report,
    labels: &PeerLabels,
) -> Event {
    match report {
        Report::Bytes(bytes) => Event::Bytes {
            connection,
            bytes,
            request_id: labels.get(peer),
        },
        Report::Sent(count) => Event::Sent { connection, count },
        Report::Closed => Event::PeerClosed { connection },
        Report::Lost => Event::PeerLost { connection },
    }
}

fn accept_now(listener: &SockRef<'_>) -> io::Result<(TcpStream, SocketAddr)> {
    let (socket, address) = listener.accept()?;
    socket.set_nonblocking(true)?;
    let peer = address
        .as_socket()
        .ok_or_else(|| io::Error::other("the peer has no internet address"))?;
    Ok((TcpStream::from_std(socket.into())?, peer))
}
