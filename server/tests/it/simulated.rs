//! The whole server in a simulated network that loses, holds and delays, against a robot that keeps count.
//!
//! What an answer says must be true of the robot: `NOT_SENT` and `REJECTED` mean that it never moved, 202 that it
//! moved once, `UNKNOWN` that it moved once at most. Time is simulated, so each run takes the same way.

use std::collections::HashMap;
use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use jiff::Timestamp;
use serde_json::Value;
use server::config::{CellSection, RobotSection, ServerSection};
use server::{Connector, ControllerAddress, Listener, Plan, Seams, SharedJournal, WallClock};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::time::sleep;
use tokio_util::sync::CancellationToken;
use turmoil::net::{TcpListener, TcpStream};

use crate::support::{ACCEPTED, MODEL, MOTION, MOTIONS};

/// How many runs a test makes, where `SIMULATED_SEEDS` does not say.
const SEEDS: u64 = 10;
const MOTIONS_A_SEED: u64 = 12;

/// How often the robot carried out each command; a command is told by its speed.
type Ledger = Arc<Mutex<HashMap<u64, u32>>>;

/// What the caller was told of each command.
type Told = Arc<Mutex<Vec<(u64, Answer)>>>;

#[derive(Clone, Debug, Eq, PartialEq)]
struct Answer {
    status: u16,
    outcome: String,
}

/// Numbers that look random and are the same for the same seed.
struct Dice(u64);

impl Dice {
    /// A number below `sides`.
    fn roll(&mut self, sides: u64) -> u64 {
        // SplitMix64: Steele, Lea, Flood, Fast splittable pseudorandom number generators, 2014.
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) % sides
    }
}

#[derive(Debug)]
struct SimulatedNetwork;

impl Connector for SimulatedNetwork {
    type Stream = TcpStream;

    async fn connect(&self, address: &ControllerAddress) -> io::Result<TcpStream> {
        match address {
            ControllerAddress::Numeric(address) => TcpStream::connect(*address).await,
            ControllerAddress::Named { host, port } => {
                TcpStream::connect((host.as_str(), *port)).await
            }
        }
    }
}

struct SimulatedListener(TcpListener);

impl Listener for SimulatedListener {
    type Io = TcpStream;

    async fn accept(&mut self) -> io::Result<(TcpStream, SocketAddr)> {
        self.0.accept().await
    }
}

#[derive(Debug)]
struct SimulatedClock;

impl WallClock for SimulatedClock {
    fn now(&self) -> Timestamp {
        let since = turmoil::since_epoch().unwrap_or_default();
        Timestamp::from_nanosecond(i128::try_from(since.as_nanos()).unwrap()).unwrap()
    }
}

async fn serve() -> turmoil::Result {
    let robot = RobotSection {
        connect_timeout_ms: 100,
        reply_timeout_ms: 200,
        deadline_ms: 400,
        ..RobotSection::new("r1", MODEL, "robot:59002")
    };
    let cell = CellSection {
        id: "c1".to_owned(),
        name: None,
        setup: None,
        push_urls: std::collections::BTreeMap::new(),
        robots: vec![robot],
    };
    let section = ServerSection {
        demo: true,
        ..ServerSection::default()
    };
    let plan = Plan::try_new(&section, &[cell])?;
    let seams = Seams {
        connector: SimulatedNetwork,
        clock: Arc::new(SimulatedClock),
        journal: SharedJournal::volatile(),
    };
    let listener = SimulatedListener(TcpListener::bind("0.0.0.0:8080").await?);
    server::run(listener, plan, seams, CancellationToken::new()).await?;
    Ok(())
}

/// One connection at a time, as a controller's tag; what it carries out, it counts before it answers.
async fn robot(ledger: Ledger, seed: u64) -> turmoil::Result {
    let mut dice = Dice(seed);
    let listener = TcpListener::bind("0.0.0.0:59002").await?;
    loop {
        let (stream, _) = listener.accept().await?;
        // An error is the server hanging up.
        let _ended = take_command(stream, &ledger, &mut dice).await;
    }
}

async fn take_command(mut stream: TcpStream, ledger: &Ledger, dice: &mut Dice) -> io::Result<()> {
    let mut received = Vec::new();
    let command = loop {
        if let Ok(command) = protocol::decode_command(&received) {
            break command.command();
        }
        if stream.read_buf(&mut received).await? == 0 {
            return Ok(());
        }
    };
    let fate = dice.roll(8);
    if fate == 0 {
        return stream.write_all(b"ERROR: POINT UNREACHABLE").await;
    }
    let key = format!("{:.0}", command.speed.0).parse().unwrap();
    *ledger.lock().unwrap().entry(key).or_default() += 1;
    match fate {
        1 => Ok(()),
        2 => stream.write_all(&ACCEPTED.as_bytes()[..9]).await,
        3 => {
            sleep(Duration::from_millis(300)).await;
            stream.write_all(ACCEPTED.as_bytes()).await
        }
        _ => stream.write_all(ACCEPTED.as_bytes()).await,
    }
}

/// Asks for one motion after the other while the network between server and robot misbehaves.
async fn operate(told: Told, seed: u64) -> turmoil::Result {
    let mut dice = Dice(!seed);
    let take = r#"{"station": "REMOTE", "ttl_s": 60, "reason": "a simulation"}"#;
    let (_, taken) = send("/api/v1/cells/c1/control-authority", "take", "", take).await?;
    let control = taken["token"].as_str().unwrap().to_owned();
    for speed in 1..=MOTIONS_A_SEED {
        let fault = async {
            sleep(Duration::from_millis(dice.roll(40))).await;
            let lasting = Duration::from_millis(20 + dice.roll(500));
            match dice.roll(5) {
                0 => {
                    turmoil::hold("server", "robot");
                    sleep(lasting).await;
                    turmoil::release("server", "robot");
                }
                1 => {
                    turmoil::partition("server", "robot");
                    sleep(lasting).await;
                    turmoil::repair("server", "robot");
                }
                2 => {
                    turmoil::partition_oneway("robot", "server");
                    sleep(lasting).await;
                    turmoil::repair_oneway("robot", "server");
                }
                _ => {}
            }
        };
        let ((), answer) = tokio::join!(fault, post(speed, &control));
        let (answer, motion) = answer?;
        if answer.outcome == "UNKNOWN" {
            decide(&motion, speed).await?;
        }
        told.lock().unwrap().push((speed, answer));
    }
    // What is still on its way arrives: a command that was called not sent must not.
    sleep(Duration::from_secs(1)).await;
    Ok(())
}

/// The answer, and the motion it is about.
async fn post(speed: u64, control: &str) -> io::Result<(Answer, String)> {
    let body = MOTION.replace("200", &speed.to_string());
    let (status, body) = send(MOTIONS, &format!("motion-{speed}"), control, &body).await?;
    let text = |name: &str| body[name].as_str().unwrap_or_default().to_owned();
    let answer = Answer {
        status,
        outcome: text("outcome"),
    };
    Ok((answer, text("motion")))
}

/// While a motion is in doubt there is no other: a person looks at the arm and answers.
async fn decide(motion: &str, speed: u64) -> io::Result<()> {
    let path = format!("/api/v1/cells/c1/interventions/{motion}/respond");
    let body = r#"{"answer": "abort", "reason": "looked at it"}"#;
    let (status, body) = send(&path, &format!("answer-{speed}"), "", body).await?;
    assert_eq!(status, 200, "{body}");
    Ok(())
}

async fn send(path: &str, key: &str, control: &str, body: &str) -> io::Result<(u16, Value)> {
    let control = match control {
        "" => String::new(),
        token => format!("control-token: {token}\r\n"),
    };
    let mut stream = TcpStream::connect("server:8080").await?;
    let request = format!(
        "POST {path} HTTP/1.1\r\nhost: localhost\r\n{control}connection: close\r\ncontent-type: application/json\r\nidempotency-key: {key}\r\ncontent-length: {}\r\n\r\n{body}",
        body.len()
    );
    stream.write_all(request.as_bytes()).await?;
    let mut answer = Vec::new();
    let _count = stream.read_to_end(&mut answer).await?;
    let answer = String::from_utf8(answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    let body: Value = serde_json::from_str(body).unwrap();
    Ok((head[9..12].parse().unwrap(), body))
}

fn run(seed: u64) -> Vec<(u64, Answer)> {
    let mut simulation = turmoil::Builder::new()
        .rng_seed(seed)
        .tick_duration(Duration::from_millis(2))
        .simulation_duration(Duration::from_mins(2))
        .max_message_latency(Duration::from_millis(20))
        .build();
    let (ledger, told) = (Ledger::default(), Told::default());
    simulation.host("server", serve);
    let robots = Arc::clone(&ledger);
    simulation.host("robot", move || robot(Arc::clone(&robots), seed));
    simulation.client("operator", operate(Arc::clone(&told), seed));
    simulation.run().unwrap();

    let (ledger, told) = (ledger.lock().unwrap(), told.lock().unwrap());
    for (speed, answer) in told.iter() {
        let moved = ledger.get(speed).copied().unwrap_or(0);
        let true_of_the_robot = match (answer.status, answer.outcome.as_str()) {
            (202, _) => moved == 1,
            (_, "NOT_SENT" | "REJECTED") => moved == 0,
            (_, "UNKNOWN") => moved <= 1,
            _ => false,
        };
        assert!(
            true_of_the_robot,
            "seed {seed}: command {speed} was answered {answer:?} and carried out {moved} times"
        );
    }
    told.clone()
}

/// Covers: W2, W5.
#[test]
fn what_an_answer_says_is_true_of_the_robot_whatever_the_network_does() {
    let mut seen: HashMap<String, usize> = HashMap::new();
    let seeds = std::env::var("SIMULATED_SEEDS").map_or(SEEDS, |seeds| seeds.parse().unwrap());
    for seed in 0..seeds {
        for (_, answer) in run(seed) {
            *seen
                .entry(format!("{} {}", answer.status, answer.outcome))
                .or_default() += 1;
        }
    }
    // The faults did happen, each kind of them.
    for kind in ["202 ", "409 REJECTED", "503 NOT_SENT", "504 UNKNOWN"] {
        assert!(seen.get(kind).is_some_and(|count| *count >= 3), "{seen:?}");
    }
}

#[test]
fn a_simulated_run_is_the_same_each_time() {
    assert_eq!(run(7), run(7));
}
