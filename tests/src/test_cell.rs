use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;

use anyhow::Context;
use client::{Client, EmulatorClient, Robot};
use karel_emulator::{
    Clock, ControllerConfig, PeerLabels, ProgramSource, State, Stepper, VirtualController,
};
use kinematics::ArmModel;
use server::TcpConnector;

use crate::{ChaosProxy, Look, MODEL, TestServer, TimedOut, robot_at, wait_until};

/// The port the program listens on, as it names it; on this machine it is any free one.
const PROGRAM_PORT: u16 = 59_002;
/// A minute of controller time in little more than half a second.
const TIME_SCALE: f64 = 100.0;

/// A whole cell on free ports: the real server and a virtual controller that runs the shipped socket server.
#[derive(Debug)]
pub struct TestCell {
    server: TestServer,
    emulator: VirtualController,
}

impl TestCell {
    /// A cell whose controller's time runs a hundred times as fast as the world's.
    ///
    /// # Errors
    /// If a part does not start.
    pub async fn start() -> anyhow::Result<Self> {
        let emulator = Emulator::start(scaled()?)?;
        let address = emulator.address().await?;
        emulator.serve(address).await
    }

    /// As [`TestCell::start`], with a proxy between server and controller. The ledger knows no request ids then: the
    /// controller's peer is the proxy.
    ///
    /// # Errors
    /// If a part does not start.
    pub async fn start_behind_proxy() -> anyhow::Result<(Self, ChaosProxy)> {
        let emulator = Emulator::start(scaled()?)?;
        let proxy = ChaosProxy::start(emulator.address().await?).await?;
        let cell = emulator.serve(proxy.address()).await?;
        Ok((cell, proxy))
    }

    /// A cell whose controller's time stands still until the test moves it.
    ///
    /// # Errors
    /// If a part does not start.
    pub async fn start_stepped() -> anyhow::Result<(Self, Stepper)> {
        let (clock, stepper) = Clock::stepped();
        let emulator = Emulator::start(clock)?;
        // The program opens its port in the first moments of controller time.
        let address = while_stepping(&stepper, emulator.address()).await??;
        let cell = emulator.serve(address).await?;
        Ok((cell, stepper))
    }

    /// Gives back control of the cell, which the client holds from the start.
    ///
    /// # Errors
    /// If the server does not take it.
    pub async fn give_up_control(&mut self) -> anyhow::Result<()> {
        self.server.give_up_control().await
    }

    /// Where the server listens.
    #[must_use]
    pub fn server_address(&self) -> SocketAddr {
        self.server.address()
    }

    /// A client of the server.
    #[must_use]
    pub fn client(&self) -> &Client {
        self.server.client()
    }

    /// The only robot, seen through the client.
    #[must_use]
    pub fn robot(&self) -> Robot {
        self.server.robot()
    }

    /// The controller itself: what really happened.
    #[must_use]
    pub fn emulator(&self) -> &VirtualController {
        &self.emulator
    }

    /// A client of the controller's panel.
    ///
    /// # Errors
    /// If the controller has no panel.
    pub fn panel(&self) -> anyhow::Result<EmulatorClient> {
        let address = self.emulator.panel_address().context("there is no panel")?;
        Ok(EmulatorClient::new(&format!("http://{address}"))?)
    }

    /// Waits until `motions` motions have begun and ended, and nothing moves or is about to.
    ///
    /// # Errors
    /// [`TimedOut`], with what the controller was doing.
    pub async fn wait_until_finished(
        &self,
        motions: usize,
        max: Duration,
    ) -> Result<State, TimedOut> {
        let what = format!("the end of {motions} motions");
        wait_until(&what, max, async || {
            let Ok(state) = self.emulator.state().await else {
                return Look::not_yet("the controller has stopped");
            };
            let Ok(ledger) = self.emulator.ledger().await else {
                return Look::not_yet("the controller has stopped");
            };
            let finished = ledger
                .iter()
                .filter(|entry| {
                    use karel_emulator::LedgerEvent::{Finished, Passed};
                    matches!(entry.event, Finished | Passed)
                })
                .count();
            if finished >= motions && !state.moving && state.motion_queue == 0 {
                Look::Ready(state)
            } else {
                Look::not_yet(format!(
                    "{finished} finished, {} in the queue, joints {:?}",
                    state.motion_queue, state.joints_deg
                ))
            }
        })
        .await
    }

    /// Stops both and waits until everything they started has ended.
    ///
    /// # Errors
    /// If the server ended with an error, or panicked.
    pub async fn shutdown(self) -> anyhow::Result<()> {
        let stopped = self.server.shutdown().await;
        self.emulator.shutdown().await;
        stopped
    }
}

/// Lets controller time pass, a millisecond at a time, until `done` is.
///
/// # Errors
/// If the controller has stopped.
pub async fn while_stepping<T>(
    stepper: &Stepper,
    done: impl Future<Output = T>,
) -> anyhow::Result<T> {
    tokio::pin!(done);
    loop {
        tokio::select! {
            biased;
            value = &mut done => return Ok(value),
            stepped = stepper.advance(Duration::from_millis(1)) => {
                let _ = stepped?;
                // The server's tasks have their turn between two steps.
                tokio::task::yield_now().await;
            }
        }
    }
}

fn scaled() -> anyhow::Result<Clock> {
    Clock::scaled(TIME_SCALE).context("the time scale of the tests")
}

/// A controller that waits for its server.
struct Emulator {
    controller: VirtualController,
    labels: PeerLabels,
}

impl Emulator {
    fn start(clock: Clock) -> anyhow::Result<Self> {
        let program = include_bytes!("../../programs/sock_server.kl");
        let model = ArmModel::builtin(MODEL).context("the arm of the tests")?;
        let mut config = ControllerConfig::new("test", model)
            .with_program(ProgramSource::new("sock_server.kl", program))
            .with_port(PROGRAM_PORT, 0);
        config.panel = Some((Ipv4Addr::LOCALHOST, 0).into());
        let labels = PeerLabels::new();
        Ok(Self {
            controller: VirtualController::start(&config, clock, labels.clone())?,
            labels,
        })
    }

    async fn address(&self) -> anyhow::Result<SocketAddr> {
        Ok(self.controller.address_of_port(PROGRAM_PORT).await?)
    }

    async fn serve(self, controller: SocketAddr) -> anyhow::Result<TestCell> {
        let labels = self.labels;
        let connector =
            TcpConnector::with_label(move |local, request_id| labels.set(local, request_id));
        Ok(TestCell {
            server: TestServer::with_connector(robot_at(controller), connector).await?,
            emulator: self.controller,
        })
    }
}
