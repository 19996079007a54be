//! What the tests of the robot share: a scripted cell, and robots whose time the test moves.
#![allow(dead_code, reason = "every test file uses its own part")]
#![allow(
    clippy::wildcard_enum_match_arm,
    reason = "a test looks for the events it is about"
)]
#![allow(clippy::unwrap_used, reason = "a helper that fails stops its test")]

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use api::{
    FloorAreaBody, FloorPoseBody, MobileMessage, Outbox, OutboxMessage, OutboxQuery, SignalAnswer,
    SignalBody, SignalName, TransportOrderBody,
};
use axum::extract::{Query, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Json, Router};
use mobile_emulator::{
    CellAddress, Clock, LedgerEntry, LedgerEvent, MobileConfig, MobileRobot, Phase, Stepper,
    Violation,
};
use tokio::net::TcpListener;
use tokio::sync::oneshot;
use tokio::time::timeout;
use uuid::Uuid;

/// Longer than any test should take; reached only when something is broken.
const PATIENCE: Duration = Duration::from_secs(30);
pub(crate) const GOAL: &str = "s1/p1";

/// A cell that records what it is told, answers as scripted, and sends what the test says.
///
/// It judges as the contract says: the same (boot, seq) again is a duplicate, the next but one is parked.
#[derive(Clone)]
pub(crate) struct FakeCell {
    inner: Arc<Mutex<Inner>>,
    pub(crate) address: SocketAddr,
    stop: Arc<Mutex<Option<oneshot::Sender<()>>>>,
}

#[derive(Default)]
struct Inner {
    /// As they arrived, duplicates too.
    arrived: Vec<SignalBody>,
    /// Each once, in the order of their numbers.
    taken: Vec<SignalBody>,
    parked: Vec<SignalBody>,
    /// Refused, and their numbers with them: (boot, seq).
    refused: Vec<(u64, u64)>,
    outbox: Vec<OutboxMessage>,
    last_n: u64,
    polls: Vec<u64>,
    /// Statuses to answer signals of this name with, first come first served.
    refusals: BTreeMap<SignalName, Vec<u16>>,
    /// What the cell does when a signal is taken.
    reactions: BTreeMap<SignalName, Vec<(Option<Uuid>, MobileMessage)>>,
}

impl FakeCell {
    pub(crate) async fn start() -> Self {
        Self::start_at("127.0.0.1:0".parse().unwrap(), Arc::default()).await
    }

    async fn start_at(address: SocketAddr, inner: Arc<Mutex<Inner>>) -> Self {
        let listener = TcpListener::bind(address).await.unwrap();
        let address = listener.local_addr().unwrap();
        let path = "/api/v1/cells/demo/mobile-robots/mr1";
        let router = Router::new()
            .route(&format!("{path}/signals"), post(signal))
            .route(&format!("{path}/outbox"), get(outbox))
            .with_state(Arc::clone(&inner));
        let (stop, stopped) = oneshot::channel();
        drop(tokio::spawn(async move {
            tokio::select! {
                served = axum::serve(listener, router) => served,
                _ = stopped => Ok(()),
            }
        }));
        Self {
            inner,
            address,
            stop: Arc::new(Mutex::new(Some(stop))),
        }
    }

    /// The server's process is gone; what it knows is kept.
    pub(crate) async fn kill(&self) {
        drop(self.stop.lock().unwrap().take());
        // The port is free when nobody can connect any more.
        for _ in 0..10_000 {
            if tokio::net::TcpStream::connect(self.address).await.is_err() {
                return;
            }
            tokio::task::yield_now().await;
        }
        panic!("the fake cell does not stop");
    }

    /// It is back, at the same address.
    pub(crate) async fn revive(&self) -> Self {
        Self::start_at(self.address, Arc::clone(&self.inner)).await
    }

    pub(crate) fn cell(&self) -> CellAddress {
        CellAddress::new(&format!("http://{}", self.address), "demo").unwrap()
    }

    pub(crate) fn send(&self, session: Option<Uuid>, message: MobileMessage) -> u64 {
        let mut inner = self.inner.lock().unwrap();
        inner.last_n += 1;
        let message = OutboxMessage {
            n: inner.last_n,
            at: jiff::Timestamp::UNIX_EPOCH,
            session,
            message,
        };
        inner.outbox.push(message);
        inner.last_n
    }

    /// When a signal of this name is taken, send this.
    pub(crate) fn react(&self, signal: SignalName, session: Uuid, messages: &[MobileMessage]) {
        let messages = messages.iter().map(|one| (Some(session), one.clone()));
        let mut inner = self.inner.lock().unwrap();
        inner.reactions.entry(signal).or_default().extend(messages);
    }

    /// Answer signals of this name with these statuses before any is taken.
    pub(crate) fn refuse(&self, signal: SignalName, statuses: &[u16]) {
        let mut inner = self.inner.lock().unwrap();
        inner.refusals.entry(signal).or_default().extend(statuses);
    }

    /// Every signal as it arrived.
    pub(crate) fn arrived(&self) -> Vec<SignalBody> {
        self.inner.lock().unwrap().arrived.clone()
    }

    /// Signals that were taken, without heartbeats, in the order of their numbers.
    pub(crate) fn taken(&self) -> Vec<SignalBody> {
        let inner = self.inner.lock().unwrap();
        let told = inner
            .taken
            .iter()
            .filter(|signal| signal.signal != SignalName::MrHeartbeat);
        told.cloned().collect()
    }

    pub(crate) fn names(&self) -> Vec<SignalName> {
        self.taken().iter().map(|signal| signal.signal).collect()
    }

    pub(crate) fn last(&self) -> SignalBody {
        let inner = self.inner.lock().unwrap();
        inner.taken.last().unwrap().clone()
    }

    pub(crate) fn heartbeats(&self) -> usize {
        let inner = self.inner.lock().unwrap();
        let beats = inner
            .taken
            .iter()
            .filter(|signal| signal.signal == SignalName::MrHeartbeat);
        beats.count()
    }

    pub(crate) fn polls(&self) -> Vec<u64> {
        self.inner.lock().unwrap().polls.clone()
    }

    pub(crate) fn unacknowledged(&self) -> usize {
        self.inner.lock().unwrap().outbox.len()
    }
}

impl Inner {
    fn take(&mut self, signal: SignalBody) {
        for (session, message) in self.reactions.remove(&signal.signal).unwrap_or_default() {
            self.last_n += 1;
            self.outbox.push(OutboxMessage {
                n: self.last_n,
                at: jiff::Timestamp::UNIX_EPOCH,
                session,
                message,
            });
        }
        self.taken.push(signal);
    }

    fn judge(&mut self, signal: SignalBody) -> (StatusCode, SignalAnswer) {
        let of_boot = |known: &&SignalBody| known.boot == signal.boot;
        let last = self.taken.iter().filter(of_boot).map(|known| known.seq);
        let of_boot = self.refused.iter().filter(|(boot, _)| *boot == signal.boot);
        let last = last.chain(of_boot.map(|(_, seq)| *seq)).max().unwrap_or(0);
        let mut answer = SignalAnswer {
            accepted: true,
            ..SignalAnswer::default()
        };
        if signal.seq <= last || self.parked.contains(&signal) {
            answer.duplicate = true;
            return (StatusCode::OK, answer);
        }
        if signal.seq == last + 2 {
            answer.parked = true;
            self.parked.push(signal);
            return (StatusCode::ACCEPTED, answer);
        }
        if signal.seq > last + 1 && !signal.resync {
            return (StatusCode::CONFLICT, SignalAnswer::default());
        }
        let next = signal.seq + 1;
        self.take(signal);
        if let Some(index) = self.parked.iter().position(|one| one.seq == next) {
            let parked = self.parked.remove(index);
            self.take(parked);
        }
        (StatusCode::OK, answer)
    }
}

async fn signal(
    State(inner): State<Arc<Mutex<Inner>>>,
    Json(signal): Json<SignalBody>,
) -> Response {
    let mut inner = inner.lock().unwrap();
    inner.arrived.push(signal.clone());
    if let Some(statuses) = inner.refusals.get_mut(&signal.signal)
        && !statuses.is_empty()
    {
        let status = statuses.remove(0);
        if matches!(status, 409 | 410 | 422) {
            inner.refused.push((signal.boot, signal.seq));
        }
        return problem(status);
    }
    let (status, answer) = inner.judge(signal);
    if status == StatusCode::CONFLICT {
        return gap(inner.taken.last().map_or(1, |known| known.seq + 1));
    }
    (status, Json(answer)).into_response()
}

/// More than one number is missing.
fn gap(expected: u64) -> Response {
    let body = serde_json::json!({
        "type": "/problems/handover-conflict", "title": "conflict", "status": 409, "detail": "a gap",
        "code": "handover-conflict", "outcome": "NONE", "retryable": false,
        "violations": [{"item": "expected.seq", "message": expected.to_string()}],
    });
    let kind = [(header::CONTENT_TYPE, "application/problem+json")];
    (StatusCode::CONFLICT, kind, body.to_string()).into_response()
}

fn problem(status: u16) -> Response {
    let code = match status {
        409 => "handover-conflict",
        410 => "session-closed",
        404 => "not-found",
        _ => "internal",
    };
    let body = serde_json::json!({
        "type": format!("/problems/{code}"), "title": code, "status": status, "detail": "as scripted",
        "code": code, "outcome": "NONE", "retryable": false,
    });
    let kind = [(header::CONTENT_TYPE, "application/problem+json")];
    let status = StatusCode::from_u16(status).unwrap();
    (status, kind, body.to_string()).into_response()
}

async fn outbox(
    State(inner): State<Arc<Mutex<Inner>>>,
    Query(query): Query<OutboxQuery>,
) -> Json<Outbox> {
    let mut inner = inner.lock().unwrap();
    inner.polls.push(query.after);
    inner.outbox.retain(|message| message.n > query.after);
    let messages = inner.outbox.clone();
    let next = messages.last().map_or(query.after, |last| last.n);
    Json(Outbox { messages, next })
}

pub(crate) async fn within<T>(future: impl Future<Output = T>) -> T {
    timeout(PATIENCE, future)
        .await
        .expect("this takes too long")
}

/// A robot whose time stands until the test moves it, and its cell.
pub(crate) struct Scene {
    pub(crate) cell: FakeCell,
    pub(crate) robot: MobileRobot,
    pub(crate) stepper: Stepper,
}

/// 3 m in front of the robot, in a zone of its own.
pub(crate) fn order() -> TransportOrderBody {
    TransportOrderBody {
        order: Uuid::from_u128(1),
        update: 0,
        goal: GOAL.to_owned(),
        dock: FloorPoseBody {
            x_mm: 3000.0,
            y_mm: 1000.0,
            heading_deg: 90.0,
        },
        dock_tolerance: None,
        zone: Some(zone()),
        route: Vec::new(),
        then_to: None,
        then_pose: None,
        then_route: Vec::new(),
        unload: None,
    }
}

pub(crate) fn zone() -> FloorAreaBody {
    FloorAreaBody {
        min_x_mm: 2000.0,
        min_y_mm: 0.0,
        max_x_mm: 4000.0,
        max_y_mm: 2000.0,
    }
}

pub(crate) fn session() -> Uuid {
    Uuid::from_u128(77)
}

impl Scene {
    pub(crate) async fn start(config: MobileConfig) -> Self {
        let cell = FakeCell::start().await;
        let (clock, stepper) = Clock::stepped();
        let robot = MobileRobot::start(&config, clock, &cell.cell()).unwrap();
        Self {
            cell,
            robot,
            stepper,
        }
    }

    pub(crate) async fn new() -> Self {
        Self::start(config()).await
    }

    pub(crate) async fn advance(&self, seconds: f64) {
        let by = Duration::from_secs_f64(seconds);
        let _now = within(self.stepper.advance(by)).await.unwrap();
    }

    pub(crate) fn tell(&self, message: MobileMessage) {
        let _n = self.cell.send(Some(session()), message);
    }

    pub(crate) fn order(&self, order: TransportOrderBody) {
        self.tell(MobileMessage::TransportOrder(Box::new(order)));
    }

    pub(crate) fn permit(&self, granted: bool) {
        self.tell(MobileMessage::MovePermit { granted });
    }

    pub(crate) fn exit(&self) {
        self.tell(MobileMessage::ExitGranted);
    }

    /// Steps until the cell has taken this signal (again).
    pub(crate) async fn until(&self, name: SignalName) -> SignalBody {
        let before = self.count(name);
        self.until_count(name, before + 1).await
    }

    pub(crate) fn count(&self, name: SignalName) -> usize {
        self.cell.names().iter().filter(|one| **one == name).count()
    }

    /// Steps until the cell has taken so many of these signals.
    pub(crate) async fn until_count(&self, name: SignalName, count: usize) -> SignalBody {
        for _ in 0..1200 {
            if self.count(name) >= count {
                let taken = self.cell.taken();
                return taken.into_iter().rfind(|one| one.signal == name).unwrap();
            }
            self.advance(0.1).await;
        }
        panic!(
            "no {name:?} in two minutes; signals: {:?}; state: {:#?}",
            self.cell.names(),
            self.robot.state().await
        );
    }

    pub(crate) async fn until_phase(&self, phase: Option<Phase>) {
        for _ in 0..1200 {
            if self.robot.state().await.unwrap().phase == phase {
                return;
            }
            self.advance(0.1).await;
        }
        panic!("never {phase:?}: {:#?}", self.robot.state().await);
    }

    /// Takes the order, and brings the robot to its dock, the permit withdrawn.
    pub(crate) async fn until_ready(&self, order: TransportOrderBody) {
        self.order(order);
        self.permit(true);
        let _docked = self.until(SignalName::MrDocked).await;
        self.permit(false);
        let _ready = self.until(SignalName::MrReady).await;
    }

    /// Lets it out of the zone.
    pub(crate) async fn until_clear(&self) {
        self.permit(true);
        self.exit();
        let _clear = self.until(SignalName::MrClear).await;
    }

    pub(crate) async fn ledger(&self) -> Vec<LedgerEntry> {
        self.robot.ledger().await.unwrap()
    }

    pub(crate) async fn events(&self) -> Vec<LedgerEvent> {
        self.ledger()
            .await
            .into_iter()
            .map(|one| one.event)
            .collect()
    }

    pub(crate) async fn violations(&self) -> Vec<Violation> {
        let events = self.events().await;
        let found = events.into_iter().filter_map(|event| match event {
            LedgerEvent::Violation { what, .. } => Some(what),
            _ => None,
        });
        found.collect()
    }
}

pub(crate) fn config() -> MobileConfig {
    MobileConfig::new("mr1")
        .with_slot("a", Some("box-1"))
        .with_slot("b", None)
}
