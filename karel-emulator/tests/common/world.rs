//! A cell server without sockets, with two clients, and the judgment of what its arm does.

use std::collections::{BTreeMap, BTreeSet};
use std::net::SocketAddr;
use std::time::Duration;

use super::arm;
use super::wire::{Tokens, opened, sealed};
use karel_emulator::effects::{ConnectionId, Effect, Event, Tag};
use karel_emulator::{CmosMemory, Controller, ControllerConfig, LedgerEvent, Operation};

/// Number of a command: epoch and sequence number.
pub(crate) type Id = (u32, u32);

pub(crate) const COMMANDS: usize = 0;
pub(crate) const STATUS: usize = 1;

/// A controller without sockets, and its two clients.
pub(crate) struct World {
    pub(crate) core: Controller,
    accepting: [bool; 2],
    pub(crate) clients: [Option<ConnectionId>; 2],
    received: BTreeMap<ConnectionId, Vec<u8>>,
    answers: BTreeMap<ConnectionId, u32>,
    last_connection: u64,
    pub(crate) nonces: Vec<String>,
    /// For each command that was sent: how many stops were answered when its greeting came.
    pub(crate) sent: BTreeMap<Id, Vec<u32>>,
    pub(crate) greeted_after: u32,
    pub(crate) stops: u32,
    /// Commands that were acknowledged, and those that were reported as done with a status.
    pub(crate) acknowledged: Vec<Id>,
    pub(crate) done: BTreeMap<Id, i32>,
    pub(crate) fence: u32,
    /// When something that ends or holds a motion was asked for, and when it was certainly done, in s.
    interruptions: Vec<(f64, f64)>,
    ledger_seen: u64,
    started: BTreeSet<Id>,
    last_started: Id,
}

impl World {
    /// A slow processor lets the tasks interrupt each other everywhere.
    pub(crate) fn new(instructions_per_ms: u32) -> Self {
        let mut config = ControllerConfig::cell_server("random", arm());
        config.limits.instructions_per_ms = instructions_per_ms;
        let mut world = Self {
            core: Controller::try_new(&config).unwrap(),
            accepting: [false; 2],
            clients: [None; 2],
            received: BTreeMap::new(),
            answers: BTreeMap::new(),
            last_connection: 0,
            nonces: Vec::new(),
            sent: BTreeMap::new(),
            greeted_after: 0,
            stops: 0,
            acknowledged: Vec::new(),
            done: BTreeMap::new(),
            fence: 0,
            interruptions: Vec::new(),
            ledger_seen: 0,
            started: BTreeSet::new(),
            last_started: (0, 0),
        };
        world.pass(Duration::from_millis(20));
        world
    }

    /// Lets time pass in small pieces, so that clients are there when they are waited for.
    pub(crate) fn pass(&mut self, by: Duration) {
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

    pub(crate) fn apply(&mut self) {
        for effect in self.core.take_effects() {
            match effect {
                Effect::Accept { tag, .. } => self.accepting[slot(tag)] = true,
                Effect::StopAccepting { tag } | Effect::StopListening { tag } => {
                    self.accepting[slot(tag)] = false;
                }
                Effect::Connect { .. } | Effect::Keep { .. } => {}
                Effect::Send { connection, bytes } => self.hear(connection, &bytes),
                Effect::Close { connection } | Effect::Reset { connection } => {
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

    pub(crate) fn connect(&mut self, port: usize) {
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

    pub(crate) fn send(&mut self, port: usize, text: &str) {
        let Some(connection) = self.clients[port] else {
            return;
        };
        self.core.event(Event::Bytes {
            connection,
            bytes: text.as_bytes().to_vec(),
            request_id: None,
        });
    }

    pub(crate) fn leave(&mut self, port: usize) {
        if let Some(connection) = self.clients[port].take() {
            self.core.event(Event::PeerLost { connection });
        }
    }

    pub(crate) fn hear(&mut self, connection: ConnectionId, bytes: &[u8]) {
        let received = self.received.entry(connection).or_default();
        received.extend_from_slice(bytes);
        let mut lines = Vec::new();
        while let Some(end) = received.iter().position(|byte| *byte == b'\n') {
            let line: Vec<u8> = received.drain(..=end).collect();
            lines.push(String::from_utf8(line).unwrap());
        }
        for line in lines {
            *self.answers.entry(connection).or_default() += 1;
            self.answer(&opened(line.trim_end()));
        }
    }

    pub(crate) fn answer(&mut self, tokens: &Tokens) {
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
    pub(crate) fn status(&mut self, verb: &str) {
        self.connect(STATUS);
        let Some(connection) = self.clients[STATUS] else {
            return;
        };
        let before = self.answers.get(&connection).copied();
        let asked = self.now_s();
        self.send(STATUS, &sealed(verb));
        for _ in 0..500 {
            self.pass(Duration::from_millis(4));
            if self.answers.get(&connection).copied() != before {
                break;
            }
        }
        if verb == "X" || verb == "P" {
            self.interruptions.push((asked, self.now_s()));
        }
        if self.answers.get(&connection).copied() == before {
            // The client was disconnected meanwhile, so it knows nothing.
            return;
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
    pub(crate) fn judge(&mut self) {
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
                | LedgerEvent::Passed
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

    /// The command client sends this command.
    pub(crate) fn command(&mut self, id: Id, text: &str) {
        if self.clients[COMMANDS].is_some() {
            self.sent.entry(id).or_default().push(self.greeted_after);
        }
        self.send(COMMANDS, &sealed(text));
    }

    /// Somebody at the controller does this. A CYCLE START may be refused; that is as good.
    pub(crate) fn operate(&mut self, operation: Operation) {
        let _done = self.core.operate(operation);
        self.interruptions.push((self.now_s(), self.now_s()));
    }

    /// Whether something may have ended or held a motion that came to its target at this time: a program that is
    /// aborted in the last moments of its motion finds the arm at the target and yet no line that says so.
    pub(crate) fn was_interrupted_near(&self, end_s: f64) -> bool {
        // The arm brakes for less than this, and no longer takes the program to note its arrival.
        const NEAR_S: f64 = 0.2;
        let mut interruptions = self.interruptions.iter();
        interruptions.any(|(asked, done)| asked - NEAR_S < end_s && end_s < done + NEAR_S)
    }

    fn now_s(&self) -> f64 {
        self.core.now().as_secs_f64()
    }

    pub(crate) fn power_cycle(&mut self) {
        self.interruptions.push((self.now_s(), self.now_s()));
        self.core.power_cycle(CmosMemory::Kept);
        self.clients = [None; 2];
        self.accepting = [false; 2];
        self.pass(Duration::from_millis(1));
    }
}

fn slot(tag: Tag) -> usize {
    if tag.number() == 3 { COMMANDS } else { STATUS }
}
