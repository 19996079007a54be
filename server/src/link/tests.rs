//! The link in virtual time, over pipes instead of sockets.

use std::collections::VecDeque;
use std::io;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use api::{Outcome, ProblemCode};
use axum::http::HeaderMap;
use jiff::Timestamp;
use protocol::{Reply, decode_command};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _, DuplexStream, duplex};
use tokio::time::{Instant, sleep};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use units::MmPerSec;

use super::{Answer, Base, Connector, ControllerAddress, Link, LinkError, Order, Owner, spawn};
use crate::SystemClock;
use crate::authority::{CellControl, Claim, LeaseClock, MemoryEpochs};
use crate::config::{CellSection, Plan, RobotPlan, RobotSection, ServerSection};
use crate::identity::TracingAudit;
use crate::journal::SharedJournal;
use crate::metrics::Metrics;
use crate::motions::{Asked, Entry, Motions};
use crate::request_id::RequestId;

/// What a connection attempt runs into; an attempt beyond the script is taken and accepted at once.
#[derive(Clone, Copy, Debug)]
enum Attempt {
    Refused,
    BlackHole,
    /// Taken; the robot answers after a while.
    Answered(Reply, Duration),
}

#[derive(Clone, Debug, Default)]
struct Pipes {
    script: Arc<Mutex<VecDeque<Attempt>>>,
    attempts: Arc<Mutex<Vec<Instant>>>,
}

impl Pipes {
    fn then(&self, attempts: impl IntoIterator<Item = Attempt>) {
        self.script.lock().unwrap().extend(attempts);
    }

    fn attempts(&self) -> Vec<Instant> {
        std::mem::take(&mut self.attempts.lock().unwrap())
    }
}

impl Connector for Pipes {
    type Stream = DuplexStream;

    async fn connect(&self, _: &ControllerAddress) -> io::Result<DuplexStream> {
        self.attempts.lock().unwrap().push(Instant::now());
        let attempt = self.script.lock().unwrap().pop_front();
        let (reply, after) = match attempt {
            Some(Attempt::Refused) => return Err(io::ErrorKind::ConnectionRefused.into()),
            Some(Attempt::BlackHole) => return std::future::pending().await,
            Some(Attempt::Answered(reply, after)) => (reply, after),
            None => (Reply::Accepted, Duration::ZERO),
        };
        let (ours, mut robots) = duplex(4096);
        drop(tokio::spawn(async move {
            let mut received = Vec::new();
            while decode_command(&received).is_err() && received != *protocol::seed_fence() {
                let count = robots.read_buf(&mut received).await.unwrap();
                assert!(count > 0, "the link hung up in the middle of a command");
            }
            sleep(after).await;
            // The link may have given up.
            let _written = robots.write_all(reply.encode()).await;
        }));
        Ok(ours)
    }
}

/// A link with a connect timeout of 1 s, a reply timeout of 2 s.
fn link(pipes: &Pipes) -> (Link, Arc<RobotPlan>, Arc<Motions>) {
    let robot = RobotSection {
        connect_timeout_ms: 1_000,
        reply_timeout_ms: 2_000,
        ..RobotSection::new("r1", "fanuc-m20ia", "127.0.0.1:1")
    };
    let cell = CellSection {
        id: "c1".to_owned(),
        name: None,
        setup: None,
        push_urls: std::collections::BTreeMap::new(),
        robots: vec![robot],
    };
    let plan = Plan::try_new(&ServerSection::default(), &[cell]).unwrap();
    let plan = Arc::new(plan.cells[0].robots[0].clone());
    let motions = Arc::new(Motions::new(
        Arc::clone(&plan),
        Arc::new(SystemClock),
        SharedJournal::volatile(),
        TaskTracker::new(),
    ));
    let owner = Owner {
        plan: Arc::clone(&plan),
        motions: Arc::clone(&motions),
        connector: Arc::new(pipes.clone()),
        metrics: Metrics::new(std::iter::empty()).unwrap().link(&plan),
    };
    let link = spawn(owner, &TaskTracker::new(), CancellationToken::new());
    (link, plan, motions)
}

/// Sends a move home, with a deadline.
async fn home(robot: &(Link, Arc<RobotPlan>, Arc<Motions>), within: Duration) -> Answer {
    home_as(robot, within, Claim::of_legacy(control())).await
}

async fn home_as(
    (link, plan, motions): &(Link, Arc<RobotPlan>, Arc<Motions>),
    within: Duration,
    claim: Claim,
) -> Answer {
    let prepared = plan.prepare_home(MmPerSec(100.0)).unwrap();
    let request_id = RequestId::of(&HeaderMap::new(), || Timestamp::UNIX_EPOCH);
    let entry = Entry {
        asked: Asked::of(&prepared),
        request_id: request_id.clone(),
        principal: Arc::from("anyone"),
        reason: None,
        not_after: None,
    };
    let place = link.reserve().unwrap();
    let permit = motions.begin_in_link(entry).await.unwrap();
    let order = Order::Move { permit, prepared };
    let deadline = Instant::now() + within;
    place
        .send(order, deadline, deadline, request_id, claim)
        .await
        .unwrap()
}

/// Control that nobody holds.
fn control() -> Arc<CellControl> {
    let clock = LeaseClock::new(Arc::new(SystemClock));
    let (epochs, audit) = (Arc::new(MemoryEpochs::default()), Arc::new(TracingAudit));
    Arc::new(CellControl::new("c1", clock, epochs, audit))
}

const LONG: Duration = Duration::from_secs(10);

fn error_of(answer: Answer) -> LinkError {
    match answer {
        Answer::Failed { error, .. } => error,
        Answer::Replied { .. }
        | Answer::Refused(_)
        | Answer::Forbidden(_)
        | Answer::NoBase(_)
        | Answer::Unkept(_) => {
            panic!("{answer:?} is no failure")
        }
    }
}

fn assert_accepted(answer: &Answer) {
    assert!(
        matches!(
            answer,
            Answer::Replied {
                reply: Reply::Accepted,
                ..
            }
        ),
        "{answer:?}"
    );
}

/// Covers: C7.
#[tokio::test(start_paused = true)]
async fn a_tag_that_reopens_after_an_answer_is_waited_for_with_growing_pauses() {
    let pipes = Pipes::default();
    let robot = link(&pipes);
    assert_accepted(&home(&robot, LONG).await);
    let _first = pipes.attempts();

    pipes.then([Attempt::Refused, Attempt::Refused, Attempt::Refused]);
    assert_accepted(&home(&robot, LONG).await);
    let attempts = pipes.attempts();
    let pauses: Vec<_> = attempts
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).as_millis())
        .collect();
    // The timer's resolution is a millisecond.
    assert!(
        matches!(pauses[..], [5..=6, 10..=11, 20..=21]),
        "{pauses:?}"
    );
}

/// Covers: C7.
#[tokio::test(start_paused = true)]
async fn a_tag_that_does_not_reopen_is_given_up_in_time() {
    let pipes = Pipes::default();
    let robot = link(&pipes);
    assert_accepted(&home(&robot, LONG).await);
    let _first = pipes.attempts();
    let answered = Instant::now();
    pipes.then([Attempt::Refused; 100]);
    let error = error_of(home(&robot, LONG).await);
    assert!(matches!(error, LinkError::Connect { .. }), "{error:?}");
    assert!(answered.elapsed() <= Duration::from_millis(300));
    // At 0, 5, 15, 35, 75 and 155 ms; the next would be at 315.
    assert_eq!(pipes.attempts().len(), 6);

    // From then on it is known to be away.
    let error = error_of(home(&robot, LONG).await);
    assert!(matches!(error, LinkError::Connect { .. }), "{error:?}");
    assert_eq!(pipes.attempts().len(), 1);
}

#[tokio::test(start_paused = true)]
async fn a_connection_refused_long_after_an_answer_is_not_tried_again() {
    let pipes = Pipes::default();
    let robot = link(&pipes);
    assert_accepted(&home(&robot, LONG).await);
    let _first = pipes.attempts();
    sleep(Duration::from_millis(301)).await;
    pipes.then([Attempt::Refused]);
    let error = error_of(home(&robot, LONG).await);
    assert!(matches!(error, LinkError::Connect { .. }), "{error:?}");
    assert_eq!(pipes.attempts().len(), 1);
}

#[tokio::test(start_paused = true)]
async fn the_shorter_of_timeout_and_deadline_ends_a_connection_attempt() {
    let pipes = Pipes::default();
    let robot = link(&pipes);
    let cases = [
        (LONG, 1_000, ProblemCode::ControllerDisconnected),
        (Duration::from_millis(700), 700, ProblemCode::DeadlinePassed),
    ];
    for (within, expected, code) in cases {
        pipes.then([Attempt::BlackHole]);
        let started = Instant::now();
        let error = error_of(home(&robot, within).await);
        assert_eq!((error.code(), error.outcome()), (code, Outcome::NotSent));
        let took = started.elapsed().as_millis();
        assert!((expected..=expected + 1).contains(&took), "{took} ms");
    }
    assert_eq!(robot.0.status().base, Base::Nothing);
}

#[tokio::test(start_paused = true)]
async fn a_reply_counts_until_its_time_is_over_and_not_after() {
    let pipes = Pipes::default();
    let robot = link(&pipes);
    pipes.then([Attempt::Answered(
        Reply::Accepted,
        Duration::from_millis(1_990),
    )]);
    assert_accepted(&home(&robot, LONG).await);
    assert!(matches!(robot.0.status().base, Base::Target(_)));

    pipes.then([Attempt::Answered(
        Reply::Accepted,
        Duration::from_millis(2_010),
    )]);
    let error = error_of(home(&robot, LONG).await);
    assert!(
        matches!(error, LinkError::NoReply { received: 0, .. }),
        "{error:?}"
    );
    assert_eq!(robot.0.status().base, Base::InDoubt);

    // The late reply belongs to a connection that is gone: the next command gets its own.
    pipes.then([Attempt::Answered(Reply::Unreachable, Duration::ZERO)]);
    let answer = home(&robot, LONG).await;
    assert!(
        matches!(
            answer,
            Answer::Replied {
                reply: Reply::Unreachable,
                ..
            }
        ),
        "{answer:?}"
    );
    assert_eq!(robot.0.status().base, Base::InDoubt);
}

#[tokio::test(start_paused = true)]
async fn a_deadline_counts_the_wait_in_the_queue() {
    let pipes = Pipes::default();
    let robot = link(&pipes);
    pipes.then([Attempt::Answered(
        Reply::Accepted,
        Duration::from_millis(500),
    )]);
    let (first, second) =
        tokio::join!(home(&robot, LONG), home(&robot, Duration::from_millis(499)));
    assert_accepted(&first);
    let error = error_of(second);
    assert!(matches!(error, LinkError::DeadlinePassed), "{error:?}");
    assert_eq!(pipes.attempts().len(), 1);
}

/// O4, SM-3: the lease ends while its command waits.
#[tokio::test(start_paused = true)]
async fn a_command_whose_holder_lost_control_while_it_waited_is_not_sent() {
    let pipes = Pipes::default();
    pipes.then([Attempt::Answered(
        Reply::Accepted,
        Duration::from_millis(1_900),
    )]);
    let robot = link(&pipes);
    let control = control();
    let terms = crate::authority::Terms {
        holder: "anna".to_owned(),
        station: api::Station::Remote,
        ttl: Duration::from_secs(2),
        loss: api::LossBehavior::Stop1,
        reason: "a test".to_owned(),
    };
    let lease = control.acquire(terms, crate::authority::Force::ByStation);
    let lease = lease.await.unwrap();
    let claim = Claim::of_lease(&control, lease.token, "anna");
    let first = home_as(&robot, LONG, claim.clone());
    let second = async {
        // Half a second later, so that it is still in control when it asks and not any more when its turn comes.
        sleep(Duration::from_millis(500)).await;
        home_as(&robot, LONG, claim.clone()).await
    };
    let third = async {
        sleep(Duration::from_millis(500)).await;
        pipes.then([Attempt::Answered(
            Reply::Accepted,
            Duration::from_millis(500),
        )]);
        home_as(&robot, LONG, claim.clone()).await
    };
    let (first, second, third) = tokio::join!(first, second, third);
    assert!(matches!(first, Answer::Replied { .. }), "{first:?}");
    assert!(matches!(second, Answer::Replied { .. }), "{second:?}");
    let error = error_of(third);
    assert_eq!(
        (error.code(), error.outcome()),
        (ProblemCode::ControlLost, Outcome::NotSent)
    );
    assert_eq!(pipes.attempts().len(), 2);
}

#[tokio::test(start_paused = true)]
async fn a_fence_is_proven_by_the_refusal_and_by_nothing_else() {
    let pipes = Pipes::default();
    let robot = link(&pipes);
    pipes.then([Attempt::Answered(Reply::Unreachable, Duration::ZERO)]);
    robot.0.fence().await.unwrap();
    pipes.then([Attempt::Answered(Reply::Accepted, Duration::ZERO)]);
    let error = robot.0.fence().await.unwrap_err();
    assert!(matches!(error, LinkError::UnknownReply { .. }), "{error:?}");
    sleep(Duration::from_secs(1)).await;
    pipes.then([Attempt::Refused]);
    let error = robot.0.fence().await.unwrap_err();
    assert!(matches!(error, LinkError::Connect { .. }), "{error:?}");
    pipes.then([Attempt::Answered(
        Reply::Unreachable,
        Duration::from_secs(3),
    )]);
    let error = robot.0.fence().await.unwrap_err();
    assert!(matches!(error, LinkError::NoReply { .. }), "{error:?}");
}

#[tokio::test(start_paused = true)]
async fn a_fence_comes_after_the_command_in_hand_and_before_those_that_wait() {
    let pipes = Pipes::default();
    let robot = link(&pipes);
    pipes.then([
        Attempt::Answered(Reply::Accepted, Duration::from_millis(500)),
        Attempt::Answered(Reply::Unreachable, Duration::ZERO),
    ]);
    let fence = async {
        sleep(Duration::from_millis(100)).await;
        robot.0.fence().await
    };
    let (first, second, fenced) = tokio::join!(home(&robot, LONG), home(&robot, LONG), fence);
    assert_accepted(&first);
    assert_accepted(&second);
    fenced.unwrap();
}
