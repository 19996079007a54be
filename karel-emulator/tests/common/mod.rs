//! What the tests of the emulator share: controllers on free ports, and clients that never wait for ever.
#![allow(dead_code, reason = "every test file uses its own part")]
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    reason = "a helper that fails stops its test"
)]

pub(crate) mod panel;
pub(crate) mod tp;
pub(crate) mod wire;
pub(crate) mod world;

use std::net::SocketAddr;
use std::time::Duration;

use karel_emulator::state::TaskWord;
use karel_emulator::{
    Clock, ControllerConfig, LedgerEvent, PeerLabels, ProgramSource, State, Stepper,
    VirtualController,
};
use kinematics::ArmModel;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;

/// The line of the examples: a pose in front of the arm at 300 mm/s.
pub(crate) const LINE: &[u8] = b"600000 200000 600000 -180000 30000 0 300 1";
pub(crate) const ACCEPTED: &str = "SUCESS: MOVEMENT COMPLETE";
pub(crate) const UNREACHABLE: &str = "ERROR: POINT UNREACHABLE";
pub(crate) const INCORRECT: &str = "ERROR: INCORRECT INPUT";
pub(crate) const PORT: u16 = 59_002;

/// Longer than any test should take; reached only when something is broken.
const PATIENCE: Duration = Duration::from_secs(20);

pub(crate) fn arm() -> &'static ArmModel {
    ArmModel::builtin("fanuc-m20ia").unwrap()
}

/// A controller with this program and every port of `ports` on a free port.
pub(crate) fn config_of(program: &str, ports: &[u16]) -> ControllerConfig {
    let mut config =
        ControllerConfig::new("test", arm()).with_program(ProgramSource::new("test.kl", program));
    for &port in ports {
        config = config.with_port(port, 0);
    }
    config
}

/// The socket server that this project ships.
pub(crate) fn sock_server() -> ControllerConfig {
    config_of(include_str!("../../../programs/sock_server.kl"), &[PORT])
}

/// A controller whose time stands still until the test moves it.
pub(crate) struct Stepped {
    pub(crate) controller: VirtualController,
    pub(crate) stepper: Stepper,
}

impl Stepped {
    pub(crate) fn start(config: &ControllerConfig) -> Self {
        Self::start_labeled(config, PeerLabels::new())
    }

    pub(crate) fn start_labeled(config: &ControllerConfig, labels: PeerLabels) -> Self {
        let (clock, stepper) = Clock::stepped();
        let controller = VirtualController::start(config, clock, labels).unwrap();
        Self {
            controller,
            stepper,
        }
    }

    pub(crate) async fn advance(&self, seconds: f64) {
        let by = Duration::from_secs_f64(seconds);
        let _now = within(self.stepper.advance(by)).await.unwrap();
    }

    pub(crate) async fn address(&self) -> SocketAddr {
        within(self.controller.address_of_port(PORT)).await.unwrap()
    }

    pub(crate) async fn events(&self) -> Vec<(u64, LedgerEvent)> {
        let ledger = self.controller.ledger().await.unwrap();
        ledger
            .iter()
            .map(|entry| (entry.motion, entry.event))
            .collect()
    }

    /// What the first task does, in one word.
    pub(crate) async fn task_word(&self) -> TaskWord {
        let state = self.controller.state().await.unwrap();
        state.tasks.first().unwrap().state
    }

    /// Steps until the arm stands still.
    pub(crate) async fn until_standstill(&self) {
        for _ in 0..600 {
            self.advance(0.1).await;
            let state = self.controller.state().await.unwrap();
            if !state.moving {
                return;
            }
        }
        panic!(
            "the arm moves for ever: {:#?}",
            self.controller.state().await
        );
    }
}

pub(crate) async fn within<T>(future: impl Future<Output = T>) -> T {
    timeout(PATIENCE, future)
        .await
        .expect("this takes too long")
}

/// Waits until the controller's state is as wanted.
pub(crate) async fn wait_until(controller: &VirtualController, wanted: impl FnMut(&State) -> bool) {
    let mut states = controller.subscribe();
    let found = timeout(PATIENCE, states.wait_for(wanted))
        .await
        .map(|state| state.is_ok());
    assert_eq!(found, Ok(true), "last: {:#?}", controller.state().await);
}

/// Sends `bytes`, reads until the controller closes.
pub(crate) async fn call(address: SocketAddr, bytes: &[u8]) -> String {
    let mut stream = within(TcpStream::connect(address)).await.unwrap();
    stream.write_all(bytes).await.unwrap();
    read_to_end(&mut stream).await
}

pub(crate) async fn read_to_end(stream: &mut TcpStream) -> String {
    let mut reply = Vec::new();
    let _count = within(stream.read_to_end(&mut reply)).await.unwrap();
    String::from_utf8(reply).unwrap()
}

/// One HTTP request, the whole answer as text.
pub(crate) async fn http_get(address: SocketAddr, path: &str, host: &str) -> String {
    let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    call(address, request.as_bytes()).await
}

/// One HTTP request with a JSON body, its status and the JSON of the answer.
pub(crate) async fn http(
    address: SocketAddr,
    method: &str,
    path: &str,
    body: Option<&serde_json::Value>,
) -> (u16, serde_json::Value) {
    let body = body.map_or(String::new(), ToString::to_string);
    let request = format!(
        "{method} {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: application/json\r\n\
         Content-Length: {}\r\n\r\n{body}",
        body.len()
    );
    let answer = call(address, request.as_bytes()).await;
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    let status = head.get(9..12).unwrap().parse().unwrap();
    let body = if body.is_empty() {
        serde_json::Value::Null
    } else {
        serde_json::from_str(body).unwrap()
    };
    (status, body)
}
