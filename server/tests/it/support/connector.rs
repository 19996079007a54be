use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex};

use server::{Connector, ControllerAddress, TcpConnection, TcpConnector};

/// What a connection attempt runs into.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Attempt {
    /// It is refused.
    Refused,
    /// Nobody answers.
    BlackHole,
}

/// A network that follows a script; once the script is over, every connection is made.
#[derive(Clone, Debug, Default)]
pub(crate) struct ScriptedNetwork {
    script: Arc<Mutex<VecDeque<Attempt>>>,
    labels: Arc<Mutex<Vec<String>>>,
}

impl ScriptedNetwork {
    pub(crate) fn new(script: impl IntoIterator<Item = Attempt>) -> Self {
        let network = Self::default();
        network.then(script);
        network
    }

    /// Adds to the script.
    pub(crate) fn then(&self, script: impl IntoIterator<Item = Attempt>) {
        self.script.lock().unwrap().extend(script);
    }

    /// How many attempts of the script have not happened.
    pub(crate) fn left(&self) -> usize {
        self.script.lock().unwrap().len()
    }

    /// The request ids given for the connections made.
    pub(crate) fn labels(&self) -> Vec<String> {
        self.labels.lock().unwrap().clone()
    }
}

impl Connector for ScriptedNetwork {
    type Stream = TcpConnection;

    async fn connect(&self, address: &ControllerAddress) -> io::Result<TcpConnection> {
        let attempt = self.script.lock().unwrap().pop_front();
        match attempt {
            None => TcpConnector::default().connect(address).await,
            Some(Attempt::Refused) => Err(io::ErrorKind::ConnectionRefused.into()),
            Some(Attempt::BlackHole) => std::future::pending().await,
        }
    }

    fn before_send(&self, stream: &TcpConnection, request_id: &str) {
        assert!(stream.local_addr().is_ok());
        self.labels.lock().unwrap().push(request_id.to_owned());
    }
}
