//! What one caller may use up, so that all others go on: memory, computing, the log, and the patience of the disk.

use std::fmt::Write as _;
use std::io;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use api::Tier;
use journal::{Fault, MemoryDisk};
use server::config::ServerSection;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use tokio::time::timeout;

use crate::support::{
    DEMO_SETUP, FakeRobot, MOTION, MOTIONS, TestServer, opened, robot_section, until,
};

const STATE: &str = "/api/v1/cells/c1/robots/r1/state";
const STOP: &str = "/api/v1/cells/c1/robots/r1/stop";
const SETUP: &str = "/api/v1/cells/c1/setup";
const CHECK: &str = "/api/v1/cells/c1/setup/check";
const TOML: (&str, &str) = ("content-type", "application/toml");
/// Ends a test that hangs; says nothing about speed.
const PATIENCE: Duration = Duration::from_mins(1);

/// A demand for a check whose body never comes.
async fn announces_a_large_body(server: &TestServer) -> TcpStream {
    let mut stream = TcpStream::connect(server.address).await.unwrap();
    let head = format!(
        "POST {CHECK} HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/toml\r\ncontent-length: 900000\r\n\r\n#"
    );
    stream.write_all(head.as_bytes()).await.unwrap();
    stream
}

#[tokio::test]
async fn r4_each_body_is_bounded_and_so_are_all_large_ones_together() {
    let robot = FakeRobot::accepting().await;
    let section = ServerSection {
        body_timeout_ms: 60_000,
        request_timeout_ms: 200_000,
        ..ServerSection::default()
    };
    let connector = server::TcpConnector::default();
    let server = TestServer::with(section, robot_section(robot.address), connector).await;
    let limit = usize::try_from(ServerSection::default().max_body_bytes).unwrap();
    for path in [
        "/fanuc/move",
        MOTIONS,
        "/api/v1/cells/c1/jobs",
        "/api/v1/cells/c1/control-authority",
    ] {
        let reply = server.post(path, &" ".repeat(limit + 1)).await;
        assert!(matches!(reply.status, 413 | 422), "{path}: {reply:?}");
        assert!(reply.body.contains(&limit.to_string()), "{path}: {reply:?}");
    }
    let huge = "#".repeat(1024 * 1024 + 1);
    let reply = server.request("POST", CHECK, &[TOML], &huge).await;
    assert_eq!(reply.status, 413, "{reply:?}");

    // Those that come slowly hold all the places there are for large ones.
    let mut slow = Vec::new();
    for _ in 0..4 {
        slow.push(announces_a_large_body(&server).await);
    }
    let large = format!("{DEMO_SETUP}{}", "#".repeat(limit));
    until("all places are taken", async || {
        let reply = server.request("POST", CHECK, &[TOML], &large).await;
        reply.status == 503
    })
    .await;
    let refused = server.request("POST", CHECK, &[TOML], &large).await;
    let _problem = refused.problem(503, "server-busy", "NOT_SENT");
    assert!(refused.header("retry-after").is_some());
    // A small one needs no such place, and motions go on.
    assert_eq!(
        server
            .request("POST", CHECK, &[TOML], DEMO_SETUP)
            .await
            .status,
        200
    );
    assert_eq!(server.post(MOTIONS, MOTION).await.status, 202);
    drop(slow);
    until("the places are free again", async || {
        let reply = server.request("POST", CHECK, &[TOML], &large).await;
        reply.status == 200
    })
    .await;
}

/// The demo's set-up with very many taught poses: tens of thousands of inverse kinematics to check.
fn laborious() -> String {
    let mut text = DEMO_SETUP.to_owned();
    for number in 0..900 {
        write!(
            text,
            "\n[[places]]\nid = 'store/{number}'\nkind = 'FIXED'\naccepts = ['crate']\n\
             [[taught_poses]]\narm = 'r1'\nplace = 'store/{number}'\nconfiguration = 'N U T, 0, 0, 0'\napproach_mm = 150\n\
             pose = {{ x_mm = {}, y_mm = 1000, z_mm = 650, w_deg = 180, p_deg = 0, r_deg = 90 }}\n",
            f64::from(number) / 10.0
        )
        .unwrap();
    }
    text
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn r7_who_asks_for_much_computing_delays_nobody_and_is_not_computed_for_once_gone() {
    let robot = FakeRobot::accepting().await;
    let server = Arc::new(TestServer::start(&robot).await);
    let etag = server.get(SETUP).await.header("etag").unwrap().to_owned();
    let put = server
        .request("PUT", SETUP, &[TOML, ("if-match", &etag)], DEMO_SETUP)
        .await;
    assert_eq!(put.status, 200, "{put:?}");
    let text = Arc::new(laborious());
    let asking: Vec<_> = (0..4)
        .map(|_| {
            let (server, text) = (Arc::clone(&server), Arc::clone(&text));
            tokio::spawn(async move { server.request("POST", CHECK, &[TOML], &text).await.status })
        })
        .collect();
    // Several times as many requests as there are threads to answer them.
    for _ in 0..20 {
        let state = timeout(PATIENCE, server.get(STATE)).await;
        assert_eq!(state.expect("a state in time").status, 200);
    }
    let motion = timeout(PATIENCE, server.post(MOTIONS, MOTION)).await;
    assert_eq!(motion.expect("a motion in time").status, 202);
    let stop = timeout(PATIENCE, server.request("POST", STOP, &[], "")).await;
    assert_eq!(stop.expect("a stop in time").status, 200);
    for caller in &asking {
        caller.abort();
    }
    // The place for computing is free as soon as those who held it are gone.
    let mine = timeout(PATIENCE, server.request("POST", CHECK, &[], "")).await;
    assert_eq!(mine.expect("a check in time").json()["passed"], true);
    // Nobody computes on for somebody who is not there: the server stops at once.
    let server = Arc::into_inner(server).or_else(|| None);
    if let Some(server) = server {
        timeout(PATIENCE, server.stopped()).await.expect("stopped");
    }
}

/// What a server logs, and from which level on, while the guard lives and on this thread.
struct Log(
    Arc<Mutex<Vec<u8>>>,
    #[expect(dead_code, reason = "a guard")] tracing::subscriber::DefaultGuard,
);

struct Tap(Arc<Mutex<Vec<u8>>>);

impl io::Write for Tap {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Log {
    fn begin() -> Self {
        let bytes = Arc::new(Mutex::new(Vec::new()));
        let tap = Arc::clone(&bytes);
        let subscriber = tracing_subscriber::fmt()
            .with_max_level(tracing::Level::INFO)
            .with_ansi(false)
            .with_writer(move || Tap(Arc::clone(&tap)))
            .finish();
        Self(bytes, tracing::subscriber::set_default(subscriber))
    }

    fn lines(&self, with: &str) -> usize {
        let all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let text = String::from_utf8_lossy(&all);
        text.lines().filter(|line| line.contains(with)).count()
    }
}

/// A controller that hangs up whenever it is called: a fault that stays.
#[tokio::test]
async fn r10_a_controller_that_stays_away_is_one_line_of_the_log() {
    let log = Log::begin();
    let dead = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let mut section = robot_section(dead.local_addr().unwrap());
    section.tier = Tier::CellServer;
    section.status_controller = Some(section.controller.clone());
    let server = TestServer::with_robot(section).await;
    let called = tokio::spawn(async move {
        for _ in 0..4 {
            let (mut stream, _) = dead.accept().await.unwrap();
            let mut bytes = [0; 64];
            let _some = timeout(Duration::from_millis(1), stream.read(&mut bytes)).await;
        }
    });
    timeout(PATIENCE, called)
        .await
        .expect("called again and again")
        .unwrap();
    assert_eq!(server.get(STATE).await.status, 200);
    assert_eq!(log.lines("status port is not connected"), 1);
}

/// A journal that cannot be written: said once, however many ask for what it would have to keep.
#[tokio::test]
async fn r10_a_journal_that_stays_broken_is_one_line_of_the_log() {
    let log = Log::begin();
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    let server = TestServer::with_journal(robot_section(robot.address), opened(&disk)).await;
    assert_eq!(server.post(MOTIONS, MOTION).await.status, 202);
    disk.fail_next("intent", Fault::RefuseAndKeep);
    for _ in 0..20 {
        let refused = server.post(MOTIONS, MOTION).await;
        let _problem = refused.problem(503, "journal-unavailable", "NOT_SENT");
    }
    assert_eq!(log.lines("the journal cannot be written"), 1);
    assert!(
        log.lines("ERROR") <= 2,
        "the fault, and the one motion it met"
    );
    assert_eq!(robot.commands().len(), 1);
}

/// The disk stalls while every connection the server has is held by somebody who is slow.
///
/// Covers: D9, X7.
#[tokio::test]
async fn d9_a_stalled_disk_under_attack_holds_motions_and_neither_reads_nor_the_stop() {
    let robot = FakeRobot::accepting().await;
    let disk = MemoryDisk::new();
    let server = TestServer::with_journal(robot_section(robot.address), opened(&disk)).await;
    let server = Arc::new(server);
    let _held = server.control().await;
    let mut attack = Vec::new();
    for number in 0..256 {
        let mut stream = TcpStream::connect(server.address).await.unwrap();
        let _written = match number % 3 {
            // A head that never ends.
            0 => {
                stream
                    .write_all(&b"GET /api/v1/cells HTTP/1.1\r\nhost: loc"[..])
                    .await
            }
            // A body that never ends.
            1 => {
                let head = format!(
                    "POST {MOTIONS} HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\n\
                     idempotency-key: slow-{number}\r\ncontent-length: 500\r\n\r\n{{"
                );
                stream.write_all(head.as_bytes()).await
            }
            // Large answers that nobody reads.
            _ => {
                let one = b"GET /docs/swagger-ui-bundle.js HTTP/1.1\r\nhost: localhost\r\n\r\n";
                stream.write_all(&one.repeat(8)).await
            }
        };
        attack.push(stream);
    }
    disk.hold_syncs();
    let posting = Arc::clone(&server);
    let waiting = tokio::spawn(async move { posting.post(MOTIONS, MOTION).await });
    let patient = async {
        while server.get(STATE).await.json()["queued"] != 1 {}
        for _ in 0..20 {
            assert_eq!(server.get(STATE).await.status, 200);
            assert_eq!(server.request("POST", STOP, &[], "").await.status, 200);
        }
    };
    timeout(PATIENCE, patient)
        .await
        .expect("states and stops in time");
    robot.assert_untouched();
    disk.release_syncs();
    let _problem = waiting
        .await
        .unwrap()
        .problem(409, "motion-canceled", "NOT_SENT");
    robot.assert_untouched();
    drop(attack);
}
