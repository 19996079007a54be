//! Callers who hold connections without need, and the honest ones beside them.

use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use server::config::{CellSection, ServerSection};
use server::{Listener, Plan, Seams, SharedJournal, SystemClock, TcpConnector};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpSocket, TcpStream};
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;

use crate::support::{
    ACCEPTED, Act, FakeRobot, MOTION, MOTIONS, TestServer, robot_section, wait_until,
};

const STATE: &str = "/api/v1/cells/c1/robots/r1/state";
const GET_STATE: &[u8] =
    b"GET /api/v1/cells/c1/robots/r1/state HTTP/1.1\r\nhost: localhost\r\n\r\n";
/// A large answer.
const GET_BUNDLE: &[u8] = b"GET /docs/swagger-ui-bundle.js HTTP/1.1\r\nhost: localhost\r\n\r\n";
const PATIENCE: Duration = Duration::from_secs(10);

/// Limits of time so long that only making room closes a connection.
fn patient(max_connections: u64) -> ServerSection {
    ServerSection {
        header_timeout_ms: 60_000,
        idle_timeout_ms: 60_000,
        body_timeout_ms: 60_000,
        write_timeout_ms: 60_000,
        request_timeout_ms: 200_000,
        max_connections,
        ..ServerSection::default()
    }
}

async fn with(section: ServerSection, robot: &FakeRobot) -> Arc<TestServer> {
    let robot = robot_section(robot.address);
    Arc::new(TestServer::with(section, robot, TcpConnector::default()).await)
}

/// Connects from `127.0.0.last`.
async fn connect_from(last: u8, server: SocketAddr) -> TcpStream {
    let socket = TcpSocket::new_v4().unwrap();
    let own = SocketAddr::from((Ipv4Addr::new(127, 0, 0, last), 0));
    socket.bind(own).unwrap();
    socket.connect(server).await.unwrap()
}

/// A connection that has been answered once and idles.
async fn idle_after_an_answer(server: &TestServer) -> TcpStream {
    let mut stream = TcpStream::connect(server.address).await.unwrap();
    stream.write_all(GET_STATE).await.unwrap();
    let mut answer = [0; 4096];
    let length = stream.read(&mut answer).await.unwrap();
    assert!(answer[..length].starts_with(b"HTTP/1.1 200"));
    stream
}

/// Whether the other side has closed; what it sent before does not count.
fn is_closed(stream: &TcpStream) -> bool {
    let mut bytes = [0; 1024];
    loop {
        match stream.try_read(&mut bytes) {
            Ok(0) => return true,
            Ok(_) => {}
            Err(error) => return error.kind() != io::ErrorKind::WouldBlock,
        }
    }
}

/// An honest caller's state and motion, both answered.
async fn serves_others(server: &TestServer) {
    let state = timeout(PATIENCE, server.get(STATE)).await;
    assert_eq!(state.expect("a state in time").status, 200);
    let motion = timeout(PATIENCE, server.post(MOTIONS, MOTION)).await;
    assert_eq!(motion.expect("a motion in time").status, 202);
}

/// Covers: R1.
#[tokio::test]
async fn ten_thousand_idle_connections_of_one_address_hold_no_more_than_their_share() {
    let robot = FakeRobot::accepting().await;
    let server = with(patient(256), &robot).await;
    let mut open = Vec::new();
    for made in 1..=10_000 {
        open.push(connect_from(2, server.address).await);
        if made % 100 == 0 {
            open.retain(|stream| !is_closed(stream));
        }
    }
    let share = usize::try_from(ServerSection::default().max_waiting_per_address).unwrap();
    wait_until("all but the share are closed", || {
        open.retain(|stream| !is_closed(stream));
        open.len() <= share
    })
    .await;
    assert_eq!(open.len(), share);
    serves_others(&server).await;
}

/// Covers: X7.
#[tokio::test]
async fn heads_that_never_end_keep_nobody_out() {
    let robot = FakeRobot::accepting().await;
    let server = with(patient(8), &robot).await;
    let mut attack = Vec::new();
    for number in 0..32 {
        // Half of them from an address each, half of them from the honest callers' own.
        let from = if number % 2 == 0 { 1 } else { 100 + number };
        let mut stream = connect_from(from, server.address).await;
        let _written = stream.write_all(&GET_STATE[..20]).await;
        attack.push(stream);
    }
    serves_others(&server).await;
    assert!(attack.iter().filter(|stream| !is_closed(stream)).count() <= 8);
}

/// Covers: X7.
#[tokio::test]
async fn bodies_that_never_end_keep_nobody_out() {
    let robot = FakeRobot::accepting().await;
    let server = with(patient(8), &robot).await;
    let mut attack = Vec::new();
    let head = format!(
        "POST {MOTIONS} HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\nidempotency-key: k1\r\ncontent-length: 500\r\n\r\n{{"
    );
    for number in 0..32 {
        let from = if number % 2 == 0 { 1 } else { 100 + number };
        let mut stream = connect_from(from, server.address).await;
        let _written = stream.write_all(head.as_bytes()).await;
        attack.push(stream);
    }
    serves_others(&server).await;
    assert!(attack.iter().filter(|stream| !is_closed(stream)).count() <= 8);
}

/// Covers: X7.
#[tokio::test]
async fn callers_that_do_not_read_keep_nobody_out() {
    let robot = FakeRobot::accepting().await;
    let server = with(patient(4), &robot).await;
    let mut attack = Vec::new();
    for number in 0..8 {
        let mut stream = connect_from(100 + number, server.address).await;
        // More than all the buffers between here and there take.
        for _ in 0..20 {
            let _written = stream.write_all(GET_BUNDLE).await;
        }
        attack.push(stream);
    }
    serves_others(&server).await;
    drop(attack);
}

#[tokio::test]
async fn an_idle_connection_gives_its_place_to_a_newcomer() {
    let robot = FakeRobot::accepting().await;
    let server = with(patient(2), &robot).await;
    let oldest = idle_after_an_answer(&server).await;
    let newer = idle_after_an_answer(&server).await;
    assert_eq!(server.get(STATE).await.status, 200);
    wait_until("the oldest is closed", || is_closed(&oldest)).await;
    assert!(!is_closed(&newer));
}

#[tokio::test]
async fn whoever_idles_stays_while_others_keep_the_server_waiting() {
    let robot = FakeRobot::accepting().await;
    let server = with(patient(3), &robot).await;
    let idle = idle_after_an_answer(&server).await;
    let mut attack = Vec::new();
    for _ in 0..20 {
        attack.push(connect_from(7, server.address).await);
    }
    wait_until("the others are closed", || {
        attack.iter().filter(|stream| !is_closed(stream)).count() <= 2
    })
    .await;
    assert!(!is_closed(&idle));
}

/// Covers: H10.
#[tokio::test]
async fn who_waits_long_for_a_robot_gives_way_and_the_command_stays() {
    let robot = FakeRobot::start([Act::Held(ACCEPTED)]).await;
    let server = with(patient(1), &robot).await;
    let control = server.control().await.to_owned();
    let mut commander = TcpStream::connect(server.address).await.unwrap();
    let request = format!(
        "POST {MOTIONS} HTTP/1.1\r\nhost: localhost\r\ncontent-type: application/json\r\nidempotency-key: k1\r\n\
         control-token: {control}\r\ncontent-length: {}\r\n\r\n{MOTION}",
        MOTION.len()
    );
    commander.write_all(request.as_bytes()).await.unwrap();
    wait_until("the command is with the robot", || {
        robot.commands().len() == 1
    })
    .await;

    let asked = tokio::spawn({
        let server = Arc::clone(&server);
        async move { server.get(STATE).await }
    });
    for _ in 0..100 {
        tokio::task::yield_now().await;
    }
    assert!(!asked.is_finished(), "it waits for a second");
    assert_eq!(asked.await.unwrap().json()["link"]["state"], "busy");
    wait_until("the place was given", || is_closed(&commander)).await;
    robot.release();
    while server.get(MOTIONS).await.json()["motions"][0]["state"] != "accepted" {}
}

#[tokio::test]
async fn a_connection_that_idles_too_long_is_closed() {
    let robot = FakeRobot::accepting().await;
    let section = ServerSection {
        idle_timeout_ms: 50,
        ..ServerSection::default()
    };
    let server = with(section, &robot).await;
    let idle = idle_after_an_answer(&server).await;
    wait_until("it is closed", || is_closed(&idle)).await;
}

/// A listener that cannot accept at first.
struct Exhausted {
    listener: TcpListener,
    failures: u32,
}

impl Listener for Exhausted {
    type Io = TcpStream;

    async fn accept(&mut self) -> io::Result<(TcpStream, SocketAddr)> {
        if self.failures > 0 {
            self.failures -= 1;
            // EMFILE: the process has too many files open.
            return Err(io::Error::from_raw_os_error(24));
        }
        self.listener.accept().await
    }
}

/// Covers: R2.
#[tokio::test]
async fn a_server_that_cannot_accept_for_a_while_goes_on_afterwards() {
    let robot = FakeRobot::accepting().await;
    let cell = CellSection {
        id: "c1".to_owned(),
        name: None,
        robots: vec![robot_section(robot.address)],
        setup: None,
        push_urls: std::collections::BTreeMap::new(),
    };
    let section = ServerSection {
        demo: true,
        ..ServerSection::default()
    };
    let plan = Plan::try_new(&section, &[cell]).unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    let listener = Exhausted {
        listener,
        failures: 5,
    };
    let stop = CancellationToken::new();
    let seams = Seams {
        connector: TcpConnector::default(),
        clock: Arc::new(SystemClock),
        journal: SharedJournal::volatile(),
    };
    let task = tokio::spawn(server::run(listener, plan, seams, stop.clone()));
    let server = TestServer::running(address, stop, task);
    serves_others(&server).await;
}
