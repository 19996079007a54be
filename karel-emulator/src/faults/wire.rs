//! The wire between the sockets and the controller, with its faults.
//!
//! Each connection has two lanes, in and out. What a fault delays waits in its lane; what comes behind it waits, too,
//! because TCP keeps the order.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::time::Duration;

use super::dice::Dice;
use super::{Direction, FaultKind, Scope};
use crate::effects::{ConnectionId, Effect, Event, Tag};

/// Connections that may be half-open at a time; beyond it a close passes.
const DEAD_CONNECTIONS: usize = 64;

/// A wire fault that is active.
#[derive(Debug)]
struct Rule {
    id: u64,
    kind: FaultKind,
    scope: Scope,
    times_left: Option<u32>,
    struck: u64,
}

/// One way of a connection. `true` is to the program.
type LaneKey = (ConnectionId, bool);

#[derive(Debug)]
enum Item {
    In(Event),
    Out(Effect),
}

/// What passed the wire.
#[derive(Debug, Default)]
pub(crate) struct Passed {
    /// To the controller.
    pub(crate) events: Vec<Event>,
    /// To the sockets.
    pub(crate) effects: Vec<Effect>,
}

/// Lanes and faults.
#[derive(Debug)]
pub(crate) struct Wire {
    dice: Dice,
    rules: Vec<Rule>,
    lanes: BTreeMap<LaneKey, VecDeque<(Duration, Item)>>,
    /// Where each connection came in.
    places: BTreeMap<ConnectionId, (Tag, Option<u16>)>,
    /// Connections without a peer, by the fault that cut them.
    dead: BTreeMap<ConnectionId, u64>,
}

impl Wire {
    pub(crate) fn new(seed: u64) -> Self {
        Self {
            dice: Dice::new(seed),
            rules: Vec::new(),
            lanes: BTreeMap::new(),
            places: BTreeMap::new(),
            dead: BTreeMap::new(),
        }
    }

    /// Whether there is nothing to do: no fault, nothing held.
    #[cfg(test)]
    fn is_plain(&self) -> bool {
        self.rules.is_empty() && self.lanes.is_empty() && self.dead.is_empty()
    }

    /// Adds a fault. The connections that it resets.
    pub(crate) fn add(
        &mut self,
        id: u64,
        kind: FaultKind,
        scope: Scope,
        times: Option<u32>,
    ) -> Vec<ConnectionId> {
        let rule = Rule {
            id,
            kind,
            scope,
            times_left: times,
            struck: 0,
        };
        if rule.kind == FaultKind::Reset {
            let hit = |connection: &ConnectionId| {
                let place = self.places.get(connection);
                place.is_some_and(|place| rule.is_about(*connection, *place, true))
            };
            return self.places.keys().copied().filter(hit).collect();
        }
        self.rules.push(rule);
        Vec::new()
    }

    /// Ends a fault; what it held passes at the next [`Self::release`].
    pub(crate) fn remove(&mut self, id: u64) {
        self.rules.retain(|rule| rule.id != id);
        self.dead.retain(|_, by| *by != id);
    }

    /// How often a fault has struck, and how often it still does; `None` once it is over.
    pub(crate) fn rule(&self, id: u64) -> Option<(u64, Option<u32>)> {
        let rule = self.rules.iter().find(|rule| rule.id == id)?;
        Some((rule.struck, rule.times_left))
    }

    /// Whether a fault has struck as often as it should and nothing is left of it.
    pub(crate) fn is_spent(&self, id: u64) -> bool {
        let rule = self.rules.iter().find(|rule| rule.id == id);
        rule.is_some_and(|rule| rule.times_left == Some(0))
            && !self.dead.values().any(|by| *by == id)
    }

    /// A client came.
    pub(crate) fn connected(&mut self, connection: ConnectionId, tag: Tag, port: Option<u16>) {
        let _new = self.places.insert(connection, (tag, port));
    }

    /// Bytes that are held on their way to the program.
    pub(crate) fn held(&self, connection: ConnectionId) -> usize {
        let lane = self.lanes.get(&(connection, true));
        lane.into_iter().flatten().map(|(_, item)| item.len()).sum()
    }

    /// When something that is held passes by itself.
    pub(crate) fn next_due(&self) -> Option<Duration> {
        let lanes = self.lanes.iter();
        let moving = lanes.filter(|(key, _)| !self.is_stalled(**key));
        let fronts = moving.filter_map(|(_, lane)| lane.front().map(|(due, _)| *due));
        fronts.min()
    }

    /// Something from the sockets.
    pub(crate) fn incoming(&mut self, now: Duration, event: Event, passed: &mut Passed) {
        let connection = match &event {
            Event::Bytes { connection, .. }
            | Event::PeerClosed { connection }
            | Event::PeerLost { connection } => *connection,
            // What the operating system took is behind the faults.
            Event::Connected { .. } | Event::ListenFailed { .. } | Event::Sent { .. } => {
                passed.events.push(event);
                return;
            }
        };
        self.enter(now, (connection, true), Item::In(event), passed);
    }

    /// Something from the controller.
    pub(crate) fn outgoing(&mut self, now: Duration, effect: Effect, passed: &mut Passed) {
        let connection = match &effect {
            Effect::Send { connection, .. } | Effect::Close { connection } => *connection,
            Effect::Reset { connection } => {
                self.forget(*connection);
                passed.effects.push(effect);
                return;
            }
            Effect::Accept { .. }
            | Effect::Connect { .. }
            | Effect::Keep { .. }
            | Effect::StopAccepting { .. }
            | Effect::StopListening { .. } => {
                passed.effects.push(effect);
                return;
            }
        };
        self.enter(now, (connection, false), Item::Out(effect), passed);
    }

    /// Lets through what is due.
    pub(crate) fn release(&mut self, now: Duration, passed: &mut Passed) {
        if self.lanes.is_empty() {
            return;
        }
        let keys: Vec<LaneKey> = self.lanes.keys().copied().collect();
        for key in keys {
            if self.is_stalled(key) {
                continue;
            }
            while let Some(lane) = self.lanes.get_mut(&key)
                && lane.front().is_some_and(|(due, _)| *due <= now)
            {
                if let Some((_, item)) = lane.pop_front() {
                    self.leave(key.0, item, passed);
                }
            }
            if self.lanes.get(&key).is_some_and(VecDeque::is_empty) {
                let _empty = self.lanes.remove(&key);
            }
        }
    }

    fn enter(&mut self, now: Duration, key: LaneKey, item: Item, passed: &mut Passed) {
        let (connection, inward) = key;
        if self.is_cut(key, &item) {
            return;
        }
        let mut pieces = vec![(now, item)];
        for index in 0..self.rules.len() {
            let has_bytes = pieces.iter().any(|(_, item)| item.len() > 0);
            if !has_bytes || !self.strikes(index, connection, inward) {
                continue;
            }
            pieces = self.change(index, connection, pieces, passed);
        }
        for (due, item) in pieces {
            let waits_behind = self.lanes.get(&key).and_then(|lane| lane.back());
            let due = waits_behind.map_or(due, |(last, _)| due.max(*last));
            let waits = waits_behind.is_some() || due > now || self.is_stalled(key);
            if waits {
                self.lanes.entry(key).or_default().push_back((due, item));
            } else {
                self.leave(connection, item, passed);
            }
        }
    }

    /// Whether the fault at `index` is about these bytes now; counts it.
    fn strikes(&mut self, index: usize, connection: ConnectionId, inward: bool) -> bool {
        let Some(rule) = self.rules.get_mut(index) else {
            return false;
        };
        let place = self.places.get(&connection);
        if !place.is_some_and(|place| rule.is_about(connection, *place, inward)) {
            return false;
        }
        match &mut rule.times_left {
            Some(0) => return false,
            Some(left) => *left -= 1,
            None => {}
        }
        rule.struck += 1;
        true
    }

    /// What a fault makes of what comes in at once.
    fn change(
        &mut self,
        index: usize,
        connection: ConnectionId,
        pieces: Vec<(Duration, Item)>,
        passed: &mut Passed,
    ) -> Vec<(Duration, Item)> {
        let Some(kind) = self.rules.get(index).map(|rule| rule.kind.clone()) else {
            return pieces;
        };
        let mut changed = Vec::new();
        for (due, mut item) in pieces {
            match &kind {
                FaultKind::Drop => {
                    lost(connection, &item, item.len(), passed);
                }
                FaultKind::Delay { ms, jitter_ms } => {
                    let ms = ms.saturating_add(self.dice.up_to(*jitter_ms));
                    changed.push((due.saturating_add(Duration::from_millis(ms)), item));
                }
                FaultKind::Split { bytes, gap_ms } => {
                    let gap = Duration::from_millis(*gap_ms);
                    let mut due = due;
                    for part in item.split(*bytes) {
                        changed.push((due, part));
                        due = due.saturating_add(gap);
                    }
                }
                FaultKind::Truncate { keep } => {
                    let cut = item.len().saturating_sub(*keep);
                    lost(connection, &item, cut, passed);
                    if *keep > 0 {
                        if let Some(bytes) = item.bytes_mut() {
                            bytes.truncate(*keep);
                        }
                        changed.push((due, item));
                    }
                }
                FaultKind::Corrupt { bytes: count } => {
                    self.corrupt(&mut item, *count);
                    changed.push((due, item));
                }
                FaultKind::Stall
                | FaultKind::HalfOpen
                | FaultKind::Reset
                | FaultKind::Freeze
                | FaultKind::WedgeTag { .. }
                | FaultKind::PowerLoss { .. }
                | FaultKind::ServoOff
                | FaultKind::WrongToolFrame { .. }
                | FaultKind::OptionMissing { .. }
                | FaultKind::SlowOverride { .. } => changed.push((due, item)),
            }
        }
        changed
    }

    /// Changes `count` bytes at different places, each into another byte.
    fn corrupt(&mut self, item: &mut Item, count: usize) {
        let Some(bytes) = item.bytes_mut() else {
            return;
        };
        let mut places = BTreeSet::new();
        while places.len() < count.min(bytes.len()) {
            let last = u64::try_from(bytes.len() - 1).unwrap_or(u64::MAX);
            let _new = places.insert(usize::try_from(self.dice.up_to(last)).unwrap_or(0));
        }
        for place in places {
            let flip = u8::try_from(self.dice.up_to(254) + 1).unwrap_or(1);
            if let Some(byte) = bytes.get_mut(place) {
                *byte ^= flip;
            }
        }
    }

    /// Whether the connection has no peer any more; the fault that cuts it counts it once.
    fn is_cut(&mut self, (connection, inward): LaneKey, item: &Item) -> bool {
        if !self.dead.contains_key(&connection) {
            let half_open = |rule: &&mut Rule| rule.kind == FaultKind::HalfOpen;
            let place = self.places.get(&connection);
            let mut rules = self.rules.iter_mut().filter(half_open);
            let rule = rules.find(|rule| {
                let about = place.is_some_and(|place| rule.is_about(connection, *place, inward));
                about && rule.times_left != Some(0)
            });
            let Some(rule) = rule else {
                return false;
            };
            if self.dead.len() >= DEAD_CONNECTIONS {
                return false;
            }
            rule.struck += 1;
            if let Some(left) = &mut rule.times_left {
                *left -= 1;
            }
            let _new = self.dead.insert(connection, rule.id);
        }
        // A program that closes a dead connection frees its socket here; the peer, in the story, never hears of it.
        if matches!(item, Item::Out(Effect::Close { .. })) {
            self.forget(connection);
            return false;
        }
        true
    }

    fn is_stalled(&self, (connection, inward): LaneKey) -> bool {
        let place = self.places.get(&connection);
        self.rules.iter().any(|rule| {
            rule.kind == FaultKind::Stall
                && place.is_some_and(|place| rule.is_about(connection, *place, inward))
        })
    }

    fn leave(&mut self, connection: ConnectionId, item: Item, passed: &mut Passed) {
        match item {
            Item::In(event) => passed.events.push(event),
            Item::Out(effect) => {
                if matches!(effect, Effect::Close { .. }) {
                    self.forget(connection);
                }
                passed.effects.push(effect);
            }
        }
    }

    /// The connection is gone for the program.
    fn forget(&mut self, connection: ConnectionId) {
        let _place = self.places.remove(&connection);
        let _dead = self.dead.remove(&connection);
        let _lane = self.lanes.remove(&(connection, true));
        let _lane = self.lanes.remove(&(connection, false));
    }
}

/// The program's bytes count as sent although they never were.
fn lost(connection: ConnectionId, item: &Item, count: usize, passed: &mut Passed) {
    if count > 0 && matches!(item, Item::Out(_)) {
        passed.events.push(Event::Sent { connection, count });
    }
}

impl Rule {
    fn is_about(
        &self,
        connection: ConnectionId,
        (tag, port): (Tag, Option<u16>),
        inward: bool,
    ) -> bool {
        let Scope {
            port: wanted_port,
            tag: wanted_tag,
            connection: wanted_connection,
            direction,
        } = &self.scope;
        let way = match direction {
            Direction::In => inward,
            Direction::Out => !inward,
            Direction::Both => true,
        };
        way && wanted_port.is_none_or(|wanted| port == Some(wanted))
            && wanted_connection.is_none_or(|wanted| connection.0 == wanted)
            && wanted_tag
                .as_deref()
                .is_none_or(|wanted| Tag::parse(wanted) == Some(tag))
    }
}

impl Item {
    fn len(&self) -> usize {
        match self {
            Item::In(Event::Bytes { bytes, .. }) | Item::Out(Effect::Send { bytes, .. }) => {
                bytes.len()
            }
            Item::In(_) | Item::Out(_) => 0,
        }
    }

    fn bytes_mut(&mut self) -> Option<&mut Vec<u8>> {
        match self {
            Item::In(Event::Bytes { bytes, .. }) | Item::Out(Effect::Send { bytes, .. }) => {
                Some(bytes)
            }
            Item::In(_) | Item::Out(_) => None,
        }
    }

    /// In pieces of `size` bytes; what has no bytes is one piece.
    fn split(self, size: usize) -> Vec<Item> {
        let size = size.max(1);
        match self {
            Item::In(Event::Bytes {
                connection,
                bytes,
                request_id,
            }) => {
                let piece = |part: &[u8]| {
                    Item::In(Event::Bytes {
                        connection,
                        bytes: part.to_vec(),
                        request_id: request_id.clone(),
                    })
                };
                bytes.chunks(size).map(piece).collect()
            }
            Item::Out(Effect::Send { connection, bytes }) => {
                let piece = |part: &[u8]| {
                    Item::Out(Effect::Send {
                        connection,
                        bytes: part.to_vec(),
                    })
                };
                bytes.chunks(size).map(piece).collect()
            }
            other @ (Item::In(_) | Item::Out(_)) => vec![other],
        }
    }
}

#[cfg(test)]
mod tests;
