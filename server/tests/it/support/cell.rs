use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use server::config::{CellSection, RobotSection, ServerSection, SetupSource};
use server::identity::Identity;
use server::{Connector, Plan, Seams, ServeError, SharedJournal, SystemClock, TcpConnector};
use tokio::net::TcpListener;
use tokio::sync::OnceCell;
use tokio::task::JoinHandle;
use tokio_util::sync::CancellationToken;

use super::client::{self, HttpReply};
use super::robot::FakeRobot;

pub(crate) const MODEL: &str = "fanuc-m20ia";

/// A robot `r1` whose controller is at an address.
pub(crate) fn robot_section(controller: SocketAddr) -> RobotSection {
    RobotSection::new("r1", MODEL, controller.to_string())
}

/// A server on a free port with the cell `c1` and the robot `r1`.
pub(crate) struct TestServer {
    pub(crate) address: SocketAddr,
    pub(crate) stop: CancellationToken,
    pub(crate) task: JoinHandle<Result<(), ServeError>>,
    control: OnceCell<String>,
}

impl TestServer {
    /// With everything at its default.
    pub(crate) async fn start(robot: &FakeRobot) -> Self {
        Self::with_robot(robot_section(robot.address)).await
    }

    pub(crate) async fn with_robot(robot: RobotSection) -> Self {
        Self::with(ServerSection::default(), robot, TcpConnector::default()).await
    }

    /// With a journal that a later server may open again.
    pub(crate) async fn with_journal(robot: RobotSection, journal: SharedJournal) -> Self {
        let seams = Seams {
            connector: TcpConnector::default(),
            clock: Arc::new(SystemClock),
            journal,
        };
        Self::with_seams(ServerSection::default(), robot, seams).await
    }

    pub(crate) async fn with<C: Connector>(
        section: ServerSection,
        robot: RobotSection,
        connector: C,
    ) -> Self {
        let seams = Seams {
            connector,
            clock: Arc::new(SystemClock),
            journal: SharedJournal::volatile(),
        };
        Self::with_seams(section, robot, seams).await
    }

    pub(crate) async fn with_seams<C: Connector>(
        section: ServerSection,
        robot: RobotSection,
        seams: Seams<C>,
    ) -> Self {
        let cell = CellSection {
            id: "c1".to_owned(),
            name: None,
            setup: None,
            push_urls: std::collections::BTreeMap::new(),
            robots: vec![robot],
        };
        let section = ServerSection {
            demo: true,
            ..section
        };
        Self::of(Plan::try_new(&section, &[cell]).unwrap(), seams).await
    }

    /// A server that asks callers for tokens.
    pub(crate) async fn with_identity(
        robot: &FakeRobot,
        identity: Identity,
        journal: SharedJournal,
    ) -> Self {
        let cell = CellSection {
            id: "c1".to_owned(),
            name: None,
            robots: vec![robot_section(robot.address)],
            setup: None,
            push_urls: std::collections::BTreeMap::new(),
        };
        let other = CellSection {
            id: "c2".to_owned(),
            ..cell.clone()
        };
        let section = ServerSection {
            legacy_robot: Some("c1/r1".to_owned()),
            ..ServerSection::default()
        };
        let plan = Plan::try_new(&section, &[cell, other]).unwrap();
        let plan = plan.with_identity(identity).unwrap();
        let seams = Seams {
            connector: TcpConnector::default(),
            clock: Arc::new(SystemClock),
            journal,
        };
        Self::of(plan, seams).await
    }

    async fn of<C: Connector>(plan: Plan, seams: Seams<C>) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let stop = CancellationToken::new();
        let task = tokio::spawn(server::run(listener, plan, seams, stop.clone()));
        Self::running(address, stop, task)
    }

    /// A server that runs already.
    pub(crate) fn running(
        address: SocketAddr,
        stop: CancellationToken,
        task: JoinHandle<Result<(), ServeError>>,
    ) -> Self {
        Self {
            address,
            stop,
            task,
            control: OnceCell::new(),
        }
    }

    pub(crate) async fn get(&self, path: &str) -> HttpReply {
        client::request(self.address, "GET", path, &[], "").await
    }

    /// Posts JSON with a new key. Motions are asked for with control of the cell, which is taken for the first of them.
    pub(crate) async fn post(&self, path: &str, body: &str) -> HttpReply {
        self.post_with_key(path, &fresh_key(), body).await
    }

    /// Posts JSON with a key that may have been used before.
    pub(crate) async fn post_with_key(&self, path: &str, key: &str, body: &str) -> HttpReply {
        let headers = [
            ("content-type", "application/json"),
            ("idempotency-key", key),
        ];
        self.request("POST", path, &headers, body).await
    }

    async fn control_for(&self, path: &str) -> Option<&str> {
        if ["/motions", "/resume", "/speed-override"]
            .iter()
            .any(|end| path.ends_with(end))
        {
            Some(self.control().await)
        } else if path.starts_with("/fanuc/") {
            self.control.get().map(String::as_str)
        } else {
            None
        }
    }

    /// The token of control over the cell, taken for a minute.
    pub(crate) async fn control(&self) -> &str {
        let take = || async {
            let body = r#"{"station": "REMOTE", "ttl_s": 60, "reason": "a test"}"#;
            let headers = [("content-type", "application/json")];
            let path = "/api/v1/cells/c1/control-authority";
            let reply = client::request(self.address, "POST", path, &headers, body).await;
            assert_eq!(reply.status, 201, "{reply:?}");
            reply.json()["token"].as_str().unwrap().to_owned()
        };
        self.control.get_or_init(take).await
    }

    /// Sends a request; a motion is asked for with control of the cell, as [`Self::post`] does.
    pub(crate) async fn request(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &str,
    ) -> HttpReply {
        let mut headers = headers.to_vec();
        let control = match method {
            "POST" | "PUT" => self.control_for(path).await,
            _ => None,
        };
        headers.extend(control.map(|token| ("control-token", token)));
        self.bare(method, path, &headers, body).await
    }

    /// Sends a request as it is.
    pub(crate) async fn bare(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &str,
    ) -> HttpReply {
        client::request(self.address, method, path, headers, body).await
    }
}

/// A key nobody has used.
pub(crate) fn fresh_key() -> String {
    static LAST: AtomicU64 = AtomicU64::new(0);
    format!("key-{}", LAST.fetch_add(1, Ordering::Relaxed))
}

/// Where the motions of `r1` are.
pub(crate) const MOTIONS: &str = "/api/v1/cells/c1/robots/r1/motions";

/// A motion the arm can do.
pub(crate) const MOTION: &str = r#"{"type": "JOINT", "speed_mm_s": 200, "target": {"pose":
    {"x_mm": 985, "y_mm": 0, "z_mm": 940, "w_deg": 180, "p_deg": 0, "r_deg": 0}}}"#;

/// The demo's set-up: `mr1`, a station, and a destination.
pub(crate) const DEMO_SETUP: &str = include_str!("../../../../cell/demo.setup.toml");

impl TestServer {
    /// With the demo's set-up, and a journal that a later server may open again.
    pub(crate) async fn with_demo_setup(robot: RobotSection, journal: SharedJournal) -> Self {
        Self::with_setup(robot, DEMO_SETUP, journal).await
    }

    /// With a set-up of its own.
    pub(crate) async fn with_setup(
        robot: RobotSection,
        setup: &str,
        journal: SharedJournal,
    ) -> Self {
        let cell = CellSection {
            id: "c1".to_owned(),
            name: None,
            setup: Some(SetupSource::Memory(setup.to_owned())),
            push_urls: std::collections::BTreeMap::new(),
            robots: vec![robot],
        };
        Self::of_cell(ServerSection::default(), cell, journal).await
    }

    /// With a cell of its own making.
    pub(crate) async fn of_cell(
        section: ServerSection,
        cell: CellSection,
        journal: SharedJournal,
    ) -> Self {
        let section = ServerSection {
            demo: true,
            ..section
        };
        let seams = Seams {
            connector: TcpConnector::default(),
            clock: Arc::new(SystemClock),
            journal,
        };
        Self::of(Plan::try_new(&section, &[cell]).unwrap(), seams).await
    }

    /// Stops it, and waits until nothing of it is left.
    pub(crate) async fn stopped(self) {
        self.stop.cancel();
        self.task.await.unwrap().unwrap();
    }
}
