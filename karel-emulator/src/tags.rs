//! Server tags: one client at a time, one task at a time.
//!
//! A tag goes from idle to waiting (`MSG_CONNECT`), to connected (a client came), and back (`MSG_DISCO`). The bytes
//! of a connection are kept here until a READ takes them; a full buffer makes the driver stop reading, so that TCP
//! itself slows the peer down.

use std::net::SocketAddr;

use karel::{Status, TaskId};

use crate::effects::{ConnectionId, Effect, Tag};

/// Bytes that arrived and were not read by the program yet.
pub const RECEIVE_LIMIT: usize = 64 * 1024;
/// Bytes that the program wrote and the operating system did not take yet.
pub const SEND_LIMIT: usize = 64 * 1024;

/// Bytes that were read and are remembered for a note.
const RECENT: usize = 254;

/// HOST-208: the connection does not exist any more. Seen on controllers when a peer vanished.
pub const HOST_NOT_CONNECTED: Status = Status::new(67, 208);

/// One client's connection.
#[derive(Debug)]
pub struct Connection {
    /// Its name at the driver.
    pub id: ConnectionId,
    /// The client.
    pub peer: SocketAddr,
    /// The HTTP request behind the client's latest bytes.
    pub request_id: Option<String>,
    /// Received and not yet read.
    pub received: Vec<u8>,
    /// The last bytes that were read, a few.
    pub recent: Vec<u8>,
    /// Written and not yet taken by the operating system.
    pub unsent: usize,
    /// What a READ beyond the end reports, once the peer has closed.
    pub end: Option<Status>,
    /// Whether writing is over, too.
    pub broken: bool,
}

/// What a tag does.
#[derive(Debug)]
pub enum TagState {
    /// Nothing.
    Idle,
    /// A task waits in `MSG_CONNECT`.
    Waiting,
    /// A client has come and the task has not noticed yet.
    Accepted(Connection),
    /// A client is connected.
    Connected(Connection),
    /// The port could not be opened; the next poll of `MSG_CONNECT` reports it.
    Failed(String),
}

/// One server tag.
#[derive(Debug)]
pub struct ServerTag {
    /// Its number.
    pub tag: Tag,
    /// A fault: the tag answers HOST-144 to everything.
    pub wedged: bool,
    /// What it does.
    pub state: TagState,
    /// The task that used it last.
    pub task: Option<TaskId>,
    /// The port it was last opened on, as the program knows it.
    pub port: Option<u16>,
    /// The last failure that raised an alarm, so that a retrying program does not flood the log.
    pub last_failure: Option<String>,
}

impl ServerTag {
    /// An idle tag.
    #[must_use]
    pub fn new(tag: Tag) -> Self {
        Self {
            tag,
            wedged: false,
            state: TagState::Idle,
            task: None,
            port: None,
            last_failure: None,
        }
    }

    /// The connection, whether the task has noticed it or not.
    #[must_use]
    pub fn connection(&self) -> Option<&Connection> {
        match &self.state {
            TagState::Accepted(connection) | TagState::Connected(connection) => Some(connection),
            TagState::Idle | TagState::Waiting | TagState::Failed(_) => None,
        }
    }

    /// As [`Self::connection`].
    pub fn connection_mut(&mut self) -> Option<&mut Connection> {
        match &mut self.state {
            TagState::Accepted(connection) | TagState::Connected(connection) => Some(connection),
            TagState::Idle | TagState::Waiting | TagState::Failed(_) => None,
        }
    }

    /// `MSG_DISCO`, or the end of the task: back to idle. What to do outside, if anything.
    pub fn disconnect(&mut self) -> Option<Effect> {
        let tag = self.tag;
        match std::mem::replace(&mut self.state, TagState::Idle) {
            TagState::Idle | TagState::Failed(_) => None,
            TagState::Waiting => Some(Effect::StopAccepting { tag }),
            TagState::Accepted(connection) | TagState::Connected(connection) => {
                Some(Effect::Close {
                    connection: connection.id,
                })
            }
        }
    }

    /// One word for people and tests.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self.state {
            TagState::Idle => "idle",
            TagState::Waiting => "listening",
            TagState::Accepted(_) | TagState::Connected(_) => "connected",
            TagState::Failed(_) => "failed",
        }
    }
}

impl Connection {
    /// A fresh connection.
    #[must_use]
    pub fn new(id: ConnectionId, peer: SocketAddr) -> Self {
        Self {
            id,
            peer,
            request_id: None,
            received: Vec::new(),
            recent: Vec::new(),
            unsent: 0,
            end: None,
            broken: false,
        }
    }

    /// Takes bytes that a READ has consumed.
    pub fn take(&mut self, count: usize) {
        let taken = self.received.drain(..count.min(self.received.len()));
        self.recent.extend(taken);
        let surplus = self.recent.len().saturating_sub(RECENT);
        drop(self.recent.drain(..surplus));
    }

    /// How many more bytes may be received now.
    #[must_use]
    pub fn room(&self) -> usize {
        RECEIVE_LIMIT.saturating_sub(self.received.len())
    }

    /// Whether `count` more bytes may be written now. A statement larger than the buffer goes when it is empty.
    #[must_use]
    pub fn takes(&self, count: usize) -> bool {
        self.unsent == 0 || self.unsent + count <= SEND_LIMIT
    }
}
