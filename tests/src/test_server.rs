use std::net::SocketAddr;
use std::sync::Arc;

use anyhow::Context;
use api::{AcquireBody, Station};
use client::{Client, HeldControl, Robot};
use server::config::{CellSection, RobotSection, ServerSection};
use server::{Connector, Plan, Seams, ServeError, SharedJournal, SystemClock, TcpConnector};
use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_util::sync::{CancellationToken, DropGuard};

/// The id of the only cell.
pub const CELL: &str = "demo";
/// The id of the only robot.
pub const ROBOT: &str = "r1";
/// The arm of the only robot.
pub const MODEL: &str = "fanuc-m20ia";

/// The only robot, with its controller at `controller` and everything else at its default.
#[must_use]
pub fn robot_at(controller: SocketAddr) -> RobotSection {
    RobotSection::new(ROBOT, MODEL, controller.to_string())
}

/// The real server on a free port, with the one cell [`CELL`] and a client. Dropping it stops it without waiting.
#[derive(Debug)]
pub struct TestServer {
    address: SocketAddr,
    client: Client,
    control: Option<HeldControl>,
    task: JoinHandle<Result<(), ServeError>>,
    stop: DropGuard,
}

impl TestServer {
    /// A server whose cell has this one robot.
    ///
    /// # Errors
    /// If the configuration does not hold, or no port can be opened.
    pub async fn start(robot: RobotSection) -> anyhow::Result<Self> {
        Self::with_connector(robot, TcpConnector::default()).await
    }

    /// As [`TestServer::start`], with another way to the controller.
    ///
    /// # Errors
    /// If the configuration does not hold, or no port can be opened.
    pub async fn with_connector<C: Connector>(
        robot: RobotSection,
        connector: C,
    ) -> anyhow::Result<Self> {
        Self::with_journal(robot, connector, SharedJournal::volatile()).await
    }

    /// As [`TestServer::with_connector`], on what a journal has.
    ///
    /// # Errors
    /// If the configuration does not hold, or no port can be opened.
    pub async fn with_journal<C: Connector>(
        robot: RobotSection,
        connector: C,
        journal: SharedJournal,
    ) -> anyhow::Result<Self> {
        let cell = CellSection {
            id: CELL.to_owned(),
            name: None,
            setup: None,
            push_urls: std::collections::BTreeMap::new(),
            robots: vec![robot],
        };
        let section = ServerSection {
            demo: true,
            ..ServerSection::default()
        };
        let plan = Plan::try_new(&section, &[cell]).context("checking the test's configuration")?;
        let listener = TcpListener::bind("127.0.0.1:0").await?;
        let address = listener.local_addr()?;
        let stop = CancellationToken::new();
        let seams = Seams {
            connector,
            clock: Arc::new(SystemClock),
            journal,
        };
        let task = tokio::spawn(server::run(listener, plan, seams, stop.clone()));
        let client = Client::new(&format!("http://{address}"))?;
        let terms = AcquireBody {
            station: Station::Remote,
            ttl_s: Some(60),
            loss_behavior: None,
            reason: "a test".to_owned(),
            preempt: false,
        };
        let control = client.control(CELL).hold(&terms).await?;
        Ok(Self {
            address,
            client: client.with_control(control.token()),
            control: Some(control),
            task,
            stop: stop.drop_guard(),
        })
    }

    /// Gives back control of the cell, which the client holds from the start; it cannot move the robot any more.
    ///
    /// # Errors
    /// If the server does not take it.
    pub async fn give_up_control(&mut self) -> anyhow::Result<()> {
        if let Some(control) = self.control.take() {
            let _view = control.release().await?;
        }
        Ok(())
    }

    /// Where the server listens.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// A client of the server that has control of the cell.
    #[must_use]
    pub fn client(&self) -> &Client {
        &self.client
    }

    /// The only robot, seen through the client.
    #[must_use]
    pub fn robot(&self) -> Robot {
        self.client.robot(CELL, ROBOT)
    }

    /// Stops the server and waits until everything it started has ended.
    ///
    /// # Errors
    /// If the server ended with an error, or panicked.
    pub async fn shutdown(self) -> anyhow::Result<()> {
        drop(self.stop);
        self.task
            .await
            .context("the server's task")?
            .context("the server")
    }
}
