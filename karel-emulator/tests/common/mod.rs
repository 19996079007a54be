//! What the tests of the emulator share: controllers on free ports, and clients that never wait for ever.
#![allow(dead_code, reason = "every test file uses its own part")]

use std::net::SocketAddr;
use std::time::Duration;

use karel_emulator::{
    Clock, ControllerConfig, LedgerEvent, PeerLabels, ProgramSource, State, Stepper,
    VirtualController,
};
use kinematics::ArmModel;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;

/// The line of the examples: a pose in front of the arm at 300 mm/s.
pub const LINE: &[u8] = b"600000 200000 600000 -180000 30000 0 300 1";
pub const ACCEPTED: &str = "SUCESS: MOVEMENT COMPLETE";
pub const UNREACHABLE: &str = "ERROR: POINT UNREACHABLE";
pub const INCORRECT: &str = "ERROR: INCORRECT INPUT";
pub const PORT: u16 = 59_002;

/// Longer than any test should take; reached only when something is broken.
const PATIENCE: Duration = Duration::from_secs(20);

pub fn arm() -> &'static ArmModel {
    ArmModel::builtin("fanuc-m20ia").unwrap()
}

/// A controller with this program and every port of `ports` on a free port.
pub fn config_of(program: &str, ports: &[u16]) -> ControllerConfig {
    let mut config = ControllerConfig::new("test", arm())
        .with_program(ProgramSource::new("test.kl", program));
    for &port in ports {
        config = config.with_port(port, 0);
    }
    config
}

/// The socket server that this project ships.
pub fn sock_server() -> ControllerConfig {
    config_of(include_str!("../../../programs/sock_server.kl"), &[PORT])
}

/// A controller whose time stands still until the test moves it.
pub struct Stepped {
    pub controller: VirtualController,
    pub stepper: Stepper,
}

impl Stepped {
    pub fn start(config: &ControllerConfig) -> Self {
        Self::start_labeled(config, PeerLabels::new())
    }

    pub fn start_labeled(config: &ControllerConfig, labels: PeerLabels) -> Self {
        let (clock, stepper) = Clock::stepped();
        let controller = VirtualController::start(config, clock, labels).unwrap();
        Self { controller, stepper }
    }

    pub async fn advance(&self, seconds: f64) {
        let by = Duration::from_secs_f64(seconds);
        let _now = within(self.stepper.advance(by)).await.unwrap();
    }

    pub async fn address(&self) -> SocketAddr {
        within(self.controller.address_of_port(PORT)).await.unwrap()
    }

    pub async fn events(&self) -> Vec<(u64, LedgerEvent)> {
        let ledger = self.controller.ledger().await.unwrap();
        ledger.iter().map(|entry| (entry.motion, entry.event)).collect()
    }

    /// Steps until the arm stands still.
    pub async fn until_standstill(&self) {
        for _ in 0..600 {
            self.advance(0.1).await;
            let state = self.controller.state().await.unwrap();
            if !state.moving {
                return;
            }
        }
        panic!("the arm moves for ever: {:#?}", self.controller.state().await);
    }
}

pub async fn within<T>(future: impl Future<Output = T>) -> T {
    timeout(PATIENCE, future).await.expect("this takes too long")
}

/// Waits until the controller's state is as wanted.
pub async fn wait_until(controller: &VirtualController, wanted: impl FnMut(&State) -> bool) {
    let mut states = controller.subscribe();
    let found = timeout(PATIENCE, states.wait_for(wanted)).await.map(|state| state.is_ok());
    assert_eq!(found, Ok(true), "last: {:#?}", controller.state().await);
}

/// Sends `bytes`, reads until the controller closes.
pub async fn call(address: SocketAddr, bytes: &[u8]) -> String {
    let mut stream = within(TcpStream::connect(address)).await.unwrap();
    stream.write_all(bytes).await.unwrap();
    read_to_end(&mut stream).await
}

pub async fn read_to_end(stream: &mut TcpStream) -> String {
    let mut reply = Vec::new();
    let _count = within(stream.read_to_end(&mut reply)).await.unwrap();
    String::from_utf8(reply).unwrap()
}

/// One HTTP request, the whole answer as text.
pub async fn http_get(address: SocketAddr, path: &str, host: &str) -> String {
    let request = format!("GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n");
    call(address, request.as_bytes()).await
}
