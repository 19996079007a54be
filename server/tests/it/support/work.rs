//! A cell at work: the demo's set-up, an arm that answers moves and takes part in no job, and a journal.

use std::ops::Deref;
use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use journal::{Clocks, KeyRetention, MemoryDisk, MemoryJournal, Opening};
use server::config::{CellSection, ServerSection, SetupSource};
use server::{Plan, Seams, SharedJournal, SystemClock, TcpConnector};
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use super::cell::{DEMO_SETUP, TestServer, robot_section};
use super::robot::FakeRobot;
use super::until;

/// A journal on a disk that a later server may open again.
pub(crate) fn opened(disk: &MemoryDisk) -> SharedJournal {
    let opening = Opening {
        at: Clocks {
            wall: Timestamp::now(),
            monotonic: Duration::ZERO,
        },
        program: "test".into(),
        keys: KeyRetention::default(),
    };
    SharedJournal::durable(MemoryJournal::open(disk, &opening).unwrap())
}

/// A server of the cell `c1` with the demo's set-up.
pub(crate) struct WorkCell {
    server: TestServer,
    _robot: FakeRobot,
}

impl WorkCell {
    pub(crate) async fn start() -> Self {
        Self::on(&MemoryDisk::new()).await
    }

    /// With the journal of a disk; ready once the cell has its set-up.
    pub(crate) async fn on(disk: &MemoryDisk) -> Self {
        Self::with_setup(disk, DEMO_SETUP).await
    }

    /// With a set-up that has the demo's loads.
    pub(crate) async fn with_setup(disk: &MemoryDisk, setup: &str) -> Self {
        let robot = FakeRobot::accepting().await;
        let cell = CellSection {
            id: "c1".to_owned(),
            name: None,
            setup: Some(SetupSource::Memory(setup.to_owned())),
            push_urls: std::collections::BTreeMap::new(),
            robots: vec![robot_section(robot.address)],
        };
        let section = ServerSection {
            demo: true,
            ..ServerSection::default()
        };
        let seams = Seams {
            connector: TcpConnector::default(),
            clock: Arc::new(SystemClock),
            journal: opened(disk),
        };
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let stop = CancellationToken::new();
        let plan = Plan::try_new(&section, &[cell]).unwrap();
        let task = tokio::spawn(server::run(listener, plan, seams, stop.clone()));
        let server = TestServer::running(address, stop, task);
        until("the cell has its set-up", async || {
            let loads = server.get("/api/v1/cells/c1/loads").await.json();
            !loads["loads"].as_array().unwrap().is_empty()
        })
        .await;
        Self {
            server,
            _robot: robot,
        }
    }
}

impl Deref for WorkCell {
    type Target = TestServer;

    fn deref(&self) -> &TestServer {
        &self.server
    }
}
