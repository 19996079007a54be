//! One TCP port of the controller: reserved, then open while a program wants clients.
//!
//! A reserved port is bound but does not listen: it belongs to us, and a client is refused, as by a controller whose
//! program does not run. So a taken port is found at start, and a free port that was chosen stays ours.

use std::io;
use std::net::{IpAddr, SocketAddr};

use tokio::net::{TcpListener, TcpSocket};

/// Whether the port may be shared with sockets that do not listen.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Reuse {
    Refused,
    Permitted,
}

/// A port and its door.
#[derive(Debug)]
pub(super) struct Port {
    ip: IpAddr,
    /// As this machine names it; 0 before the first reservation of "any free port".
    number: u16,
    door: Door,
}

#[derive(Debug)]
enum Door {
    /// Not ours.
    Unbound,
    /// Ours, and clients are refused.
    Reserved(TcpSocket),
    /// Clients are let in, or wait in the kernel's backlog.
    Open(TcpListener),
}

impl Port {
    pub(super) fn new(ip: IpAddr, number: u16) -> Self {
        Self {
            ip,
            number,
            door: Door::Unbound,
        }
    }

    /// The port as this machine names it.
    pub(super) fn number(&self) -> u16 {
        self.number
    }

    /// Makes the port ours.
    pub(super) fn reserve(&mut self) -> io::Result<()> {
        if matches!(self.door, Door::Unbound) {
            // Two sockets that both permit reuse can be bound to one port until one of them listens. So the first
            // try permits none. It fails also for connections of a moment ago, in TIME_WAIT, which harm nobody.
            let socket = match self.bind(Reuse::Refused) {
                Err(error) if error.kind() == io::ErrorKind::AddrInUse => {
                    self.bind(Reuse::Permitted)
                }
                bound => bound,
            }?;
            self.number = socket.local_addr()?.port();
            self.door = Door::Reserved(socket);
        }
        Ok(())
    }

    fn bind(&self, reuse: Reuse) -> io::Result<TcpSocket> {
        let socket = match self.ip {
            IpAddr::V4(_) => TcpSocket::new_v4(),
            IpAddr::V6(_) => TcpSocket::new_v6(),
        }?;
        socket.set_reuseaddr(reuse == Reuse::Permitted)?;
        socket.bind(SocketAddr::new(self.ip, self.number))?;
        Ok(socket)
    }

    /// Lets clients in. Its address.
    pub(super) fn open(&mut self, backlog: u32) -> io::Result<SocketAddr> {
        self.reserve()?;
        match std::mem::replace(&mut self.door, Door::Unbound) {
            Door::Reserved(socket) => {
                // Its connections inherit this, and must not keep the port from the next controller.
                socket.set_reuseaddr(true)?;
                self.door = Door::Open(socket.listen(backlog)?);
            }
            other @ (Door::Open(_) | Door::Unbound) => self.door = other,
        }
        Ok(SocketAddr::new(self.ip, self.number))
    }

    /// Refuses clients, and tries to keep the port ours.
    pub(super) fn close(&mut self) {
        if matches!(self.door, Door::Open(_)) {
            // A listening socket must be gone before its port can be bound again.
            self.door = Door::Unbound;
            if let Err(error) = self.reserve() {
                tracing::warn!(port = self.number, %error, "A closed port could not be kept.");
            }
        }
    }

    /// The listener, while the port is open.
    pub(super) fn listener(&self) -> Option<&TcpListener> {
        match &self.door {
            Door::Open(listener) => Some(listener),
            Door::Unbound | Door::Reserved(_) => None,
        }
    }
}
