//! Random histories of commands, lost clients, stops, fences, operators and power failures: whatever happens, no
//! command moves the arm twice, out of order, or after it was killed.

mod common;

use std::collections::{BTreeMap, BTreeSet};
use std::net::SocketAddr;
use std::time::Duration;

use common::arm;
use common::wire::{Tokens, joints, opened, sealed};
use karel_emulator::effects::{ConnectionId, Effect, Event, Tag};
use karel_emulator::{
    CmosMemory, Controller, ControllerConfig, LedgerEvent, OperatingMode, Operation,
};
use proptest::prelude::*;

/// Number of a command: epoch and sequence number.
type Id = (u32, u32);

const COMMANDS: usize = 0;
const STATUS: usize = 1;

/// What happens next.
#[derive(Clone, Debug)]
enum Step {
    /// A client connects to the command port, if none is there.
    Connect,
    /// It sends a motion; the nonce may be that of an earlier greeting.
    Move {
        epoch: u32,
        seq: u32,
        target: usize,
        percent: u32,
        old_nonce: bool,
    },
    /// It sends the first part of a command and nothing more.
    Half,
    /// It is gone.
    Leave,
    Status(String),
    LeaveStatus,
    Pass(u64),
    PowerCycle,
    Operate(Operation),
}

fn steps() -> impl Strategy<Value = Vec<Step>> {
    let command = (1..5_u32, 1..4_u32, 0..3_usize, 1..100_u32, any::<bool>()).prop_map(
        |(epoch, seq, target, percent, old)| Step::Move {
            epoch,
            seq,
            target,
            percent,
            old_nonce: old && seq == 3,
        },
    );
    let verb = prop_oneof![
        4 => (1..6_u32).prop_map(|e| format!("S {e}")),
        2 => (1..6_u32).prop_map(|e| format!("F {e}")),
        2 => Just("X".to_owned()),
        1 => Just("P".to_owned()),
        1 => Just("C".to_owned()),
        1 => (1..101_u32).prop_map(|p| format!("G {p}")),
    ];
    let operation = prop_oneof![
        Just(Operation::Hold),
        Just(Operation::CycleStart),
        Just(Operation::EmergencyStop(true)),
        Just(Operation::EmergencyStop(false)),
        Just(Operation::Reset),
        Just(Operation::SetPendant(true)),
        Just(Operation::SetPendant(false)),
        Just(Operation::SetMode(OperatingMode::T1)),
        Just(Operation::SetMode(OperatingMode::Auto)),
        Just(Operation::SetOverride(0)),
        Just(Operation::SetOverride(100)),
    ];
    let step = prop_oneof![
        6 => Just(Step::Connect),
        8 => command,
        1 => Just(Step::Half),
        2 => Just(Step::Leave),
        6 => verb.prop_map(Step::Status),
        1 => Just(Step::LeaveStatus),
        8 => (0..400_u64).prop_map(Step::Pass),
        1 => Just(Step::PowerCycle),
        2 => operation.prop_map(Step::Operate),
    ];
    proptest::collection::vec(step, 1..60)
}

const TARGETS: [[f64; 6]; 3] = [
    [20.0, 10.0, -10.0, 5.0, -60.0, 15.0],
    [0.0, 0.0, 0.0, 0.0, -90.0, 0.0],
    [-5.0, 0.0, 5.0, 0.0, -70.0, 0.0],
];

/// A controller without sockets, and its two clients.
struct World {
    core: Controller,
    accepting: [bool; 2],
    clients: [Option<ConnectionId>; 2],
    received: BTreeMap<ConnectionId, Vec<u8>>,
    last_connection: u64,
    nonces: Vec<String>,
    /// For each command that was sent: how many stops were answered when its greeting came.
    sent: BTreeMap<Id, Vec<u32>>,
    greeted_after: u32,
    stops: u32,
    /// Commands that were acknowledged, and those that were reported as done with a status.
    acknowledged: Vec<Id>,
    done: BTreeMap<Id, i32>,
    fence: u32,
    ledger_seen: u64,
    started: BTreeSet<Id>,
    last_started: Id,
}

impl World {
    fn new() -> Self {
        let config = ControllerConfig::cell_server("random", arm());
        let mut world = Self {
            core: Controller::try_new(&config).unwrap(),
            accepting: [false; 2],
            clients: [None; 2],
            received: BTreeMap::new(),
            last_connection: 0,
            nonces: Vec::new(),
            sent: BTreeMap::new(),
            greeted_after: 0,
            stops: 0,
            acknowledged: Vec::new(),
            done: BTreeMap::new(),
            fence: 0,
            ledger_seen: 0,
            started: BTreeSet::new(),
            last_started: (0, 0),
        };
        world.pass(Duration::from_millis(20));
        world
    }

    /// Lets time pass in small pieces, so that clients are there when they are waited for.
    fn pass(&mut self, by: Duration) {
        let until = self.core.now() + by;
        loop {
            let next = (self.core.now() + Duration::from_millis(4)).min(until);
            self.core.advance_fully(next);
            self.apply();
            if self.core.now() >= until {
                return;
            }
        }
    }

    fn apply(&mut self) {
        for effect in self.core.take_effects() {
            match effect {
                Effect::Accept { tag, .. } => self.accepting[slot(tag)] = true,
                Effect::StopAccepting { tag } | Effect::StopListening { tag } => {
                    self.accepting[slot(tag)] = false;
                }
                Effect::Send { connection, bytes } => self.hear(connection, &bytes),
                Effect::Close { connection } => {
                    for client in &mut self.clients {
                        if *client == Some(connection) {
                            *client = None;
                        }
                    }
                }
            }
        }
        self.judge();
    }

    fn connect(&mut self, port: usize) {
        if self.clients[port].is_some() || !self.accepting[port] {
            return;
        }
        self.accepting[port] = false;
        self.last_connection += 1;
        let connection = ConnectionId(self.last_connection);
        self.clients[port] = Some(connection);
        self.core.event(Event::Connected {
            tag: Tag::try_new(if port == COMMANDS { 3 } else { 4 }).unwrap(),
            connection,
            peer: SocketAddr::from(([127, 0, 0, 1], 40_000)),
        });
        self.pass(Duration::from_millis(12));
    }

    fn send(&mut self, port: usize, text: &str) {
        let Some(connection) = self.clients[port] else {
            return;
        };
        self.core.event(Event::Bytes {
            connection,
            bytes: text.as_bytes().to_vec(),
            request_id: None,
        });
    }

    fn leave(&mut self, port: usize) {
        if let Some(connection) = self.clients[port].take() {
            self.core.event(Event::PeerLost { connection });
        }
    }

    fn hear(&mut self, connection: ConnectionId, bytes: &[u8]) {
        let received = self.received.entry(connection).or_default();
        received.extend_from_slice(bytes);
        let mut lines = Vec::new();
        while let Some(end) = received.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = received.drain(..=end).collect();
            lines.push(String::from_utf8(line).unwrap());
        }
        for line in lines {
            self.answer(&opened(line.trim_end()));
        }
    }

    fn answer(&mut self, tokens: &Tokens) {
        let number = |n: usize| tokens[n].parse::<u32>().unwrap();
        match tokens[0].as_str() {
            "V2" => {
                self.nonces.push(tokens[8].clone());
                self.greeted_after = self.stops;
                let acc = (number(3), number(4));
                let last = self.acknowledged.last().copied().unwrap_or_default();
                assert!(acc >= last, "a number was forgotten: {acc:?} < {last:?}");
            }
            "ACK" => {
                let id = (number(1), number(2));
                let last = self.acknowledged.last().copied().unwrap_or_default();
                assert!(id > last, "{id:?} accepted after {last:?}");
                assert!(
                    id.0 >= self.fence,
                    "{id:?} accepted beyond the fence {}",
                    self.fence
                );
                self.acknowledged.push(id);
            }
            "DONE" => {
                let status = tokens[3].parse().unwrap();
                let _before = self.done.insert((number(1), number(2)), status);
            }
            "DUP" | "STALE" | "BUSY" | "ERR" | "ST" => {}
            other => panic!("an unknown answer {other}"),
        }
    }

    /// Sends a line to the status port and waits for its answer.
    fn status(&mut self, verb: &str) {
        self.connect(STATUS);
        let Some(connection) = self.clients[STATUS] else {
            return;
        };
        self.send(STATUS, &sealed(verb));
        for _ in 0..20 {
            self.pass(Duration::from_millis(4));
            if self.received.get(&connection).is_some_and(Vec::is_empty) {
                break;
            }
        }
        // What is answered counts: nothing that was killed may start from here on.
        self.judge();
        if verb == "X" {
            self.stops += 1;
        }
        if let Some(epoch) = verb.strip_prefix("F ") {
            self.fence = self.fence.max(epoch.parse().unwrap());
        }
    }

    /// Compares what the arm did since the last look with what it may do.
    fn judge(&mut self) {
        let entries = self.core.ledger(self.ledger_seen);
        for entry in entries {
            self.ledger_seen = entry.seq;
            let Some(command) = entry.command else {
                continue;
            };
            let id = (command.epoch, command.seq);
            match entry.event {
                LedgerEvent::Started => {
                    assert!(self.started.insert(id), "{id:?} started twice");
                    assert!(
                        id > self.last_started,
                        "{id:?} after {:?}",
                        self.last_started
                    );
                    self.last_started = id;
                    assert!(
                        id.0 >= self.fence,
                        "{id:?} started beyond the fence {}",
                        self.fence
                    );
                    let sent = self.sent.get(&id).expect("nobody sent it");
                    assert!(
                        sent.iter().any(|stops| *stops >= self.stops),
                        "{id:?} started after the stop that killed it"
                    );
                    assert!(
                        !self.done.contains_key(&id),
                        "{id:?} started after it was done"
                    );
                }
                LedgerEvent::Resumed => {
                    assert!(
                        !self.done.contains_key(&id),
                        "{id:?} goes on after it was done"
                    );
                }
                LedgerEvent::Finished
                | LedgerEvent::Refused
                | LedgerEvent::Cancelled
                | LedgerEvent::Held
                | LedgerEvent::Gripped
                | LedgerEvent::Released
                | LedgerEvent::Lost
                | LedgerEvent::Jogged => {}
            }
        }
    }

    fn take(&mut self, step: &Step) {
        match step {
            Step::Connect => self.connect(COMMANDS),
            Step::Move {
                epoch,
                seq,
                target,
                percent,
                old_nonce,
            } => {
                let mut nonces = self.nonces.iter().rev();
                let nonce = nonces.nth(usize::from(*old_nonce)).cloned();
                let nonce = nonce.unwrap_or_else(|| "1".to_owned());
                let id = (*epoch, *seq);
                let text = joints(id, &nonce, TARGETS[*target], *percent);
                if self.clients[COMMANDS].is_some() {
                    self.sent.entry(id).or_default().push(self.greeted_after);
                }
                self.send(COMMANDS, &sealed(&text));
            }
            Step::Half => self.send(COMMANDS, "M 1 1 "),
            Step::Leave => self.leave(COMMANDS),
            Step::Status(verb) => self.status(verb),
            Step::LeaveStatus => self.leave(STATUS),
            Step::Pass(ms) => self.pass(Duration::from_millis(*ms)),
            Step::PowerCycle => {
                self.core.power_cycle(CmosMemory::Kept);
                self.clients = [None; 2];
                self.accepting = [false; 2];
                self.pass(Duration::from_millis(1));
            }
            Step::Operate(operation) => {
                // A CYCLE START may be refused; that is as good.
                let _done = self.core.operate(operation.clone());
            }
        }
    }
}

fn slot(tag: Tag) -> usize {
    if tag.number() == 3 { COMMANDS } else { STATUS }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, max_shrink_iters: 2_000, ..ProptestConfig::default() })]

    #[test]
    fn no_history_moves_the_arm_twice_out_of_order_or_after_a_kill(steps in steps()) {
        let mut world = World::new();
        for step in &steps {
            world.take(step);
            world.judge();
        }
        world.pass(Duration::from_secs(3));
        let state = world.core.state();
        for task in state.tasks.iter().filter(|task| task.name.starts_with("CELL_S") || task.name == "CELL_WATCH") {
            prop_assert!(
                matches!(task.state, karel_emulator::state::TaskWord::Waiting | karel_emulator::state::TaskWord::Running),
                "{task:?}"
            );
        }
        // What was reported as arrived was: the ledger has its end.
        let ledger = world.core.ledger(0);
        for (id, status) in &world.done {
            let ended = ledger.iter().any(|entry| {
                entry.event == LedgerEvent::Finished
                    && entry.command.is_some_and(|c| (c.epoch, c.seq) == *id)
            });
            prop_assert_eq!(*status == 0, ended, "{:?}", id);
        }
    }
}
