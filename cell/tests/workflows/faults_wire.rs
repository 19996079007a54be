//! The lines between the server and a controller, which a test cuts.

use std::net::SocketAddr;

use karel_emulator::VirtualController;
use tokio::io::copy_bidirectional;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;

/// What becomes of what is sent.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
enum State {
    Through,
    /// Connections end, and new ones end at once.
    Cut,
    /// Nothing arrives, and nobody hears that it does not: a cable that was pulled out.
    Silent,
}

/// One line: a port, and what is behind it.
#[derive(Debug)]
pub(crate) struct Wire {
    address: SocketAddr,
    state: watch::Sender<State>,
}

impl Wire {
    async fn to(target: SocketAddr) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let (state, seen) = watch::channel(State::Through);
        drop(tokio::spawn(async move {
            while let Ok((client, _from)) = listener.accept().await {
                drop(tokio::spawn(carry(client, target, seen.clone())));
            }
        }));
        Self { address, state }
    }

    pub(crate) fn address(&self) -> SocketAddr {
        self.address
    }

    pub(crate) fn cut(&self) {
        let _before = self.state.send_replace(State::Cut);
    }

    pub(crate) fn falls_silent(&self) {
        let _before = self.state.send_replace(State::Silent);
    }

    pub(crate) fn mend(&self) {
        let _before = self.state.send_replace(State::Through);
    }
}

/// Both lines to a controller.
#[derive(Debug)]
pub(crate) struct Wires {
    pub(crate) command: Wire,
    pub(crate) status: Wire,
}

impl Wires {
    pub(crate) async fn to(controller: &VirtualController) -> Self {
        let port = async |port| controller.address_of_port(port).await.unwrap();
        Self {
            command: Wire::to(port(karel_emulator::cell_server::COMMAND_PORT).await).await,
            status: Wire::to(port(karel_emulator::cell_server::STATUS_PORT).await).await,
        }
    }
}

async fn carry(mut client: TcpStream, target: SocketAddr, mut state: watch::Receiver<State>) {
    let _set = client.set_nodelay(true);
    let mut server = None;
    loop {
        let now = *state.borrow_and_update();
        match (now, &mut server) {
            (State::Cut, _) => return,
            (State::Silent, _) => {
                if state.changed().await.is_err() {
                    return;
                }
            }
            (State::Through, None) => match TcpStream::connect(target).await {
                Ok(connected) => {
                    let _set = connected.set_nodelay(true);
                    server = Some(connected);
                }
                Err(_refused) => return,
            },
            (State::Through, Some(server)) => {
                tokio::select! {
                    _ended = copy_bidirectional(&mut client, server) => return,
                    changed = state.changed() => if changed.is_err() { return },
                }
            }
        }
    }
}
