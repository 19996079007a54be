//! What happens to the connections of tags: clients that come, send and go.

use std::net::SocketAddr;

use karel::{Status, TaskId};

use super::{Hardware, Wake};
use crate::effects::{ConnectionId, Effect, Event, Tag};
use crate::tags::{Connection, ServerTag, TagState};

impl Hardware {
    /// Something happened on a socket.
    pub(crate) fn socket_event(&mut self, event: Event) {
        match event {
            Event::Connected {
                tag,
                connection,
                peer,
            } => self.accept(tag, connection, peer),
            Event::ListenFailed { tag, reason } => {
                if let Some(slot) = self.slot(tag)
                    && matches!(slot.state, TagState::Waiting)
                {
                    slot.state = TagState::Failed(reason);
                    self.wakes.push(Wake::Connect(tag));
                }
            }
            Event::Bytes {
                connection,
                bytes,
                request_id,
            } => {
                if let Some(open) = self.connection_mut(connection) {
                    tracing::debug!(
                        peer = %open.peer, request_id = request_id.as_deref(), bytes = bytes.len(),
                        "Bytes arrived."
                    );
                    open.received.extend_from_slice(&bytes);
                    open.request_id = request_id;
                }
                self.wake_files(connection);
            }
            Event::Sent { connection, count } => {
                if let Some(open) = self.connection_mut(connection) {
                    open.unsent = open.unsent.saturating_sub(count);
                }
                self.wake_files(connection);
            }
            Event::PeerClosed { connection } => {
                if let Some(open) = self.connection_mut(connection) {
                    open.end = Some(Status::HOST_PEER_CLOSED);
                }
                self.wake_files(connection);
            }
            Event::PeerLost { connection } => {
                if let Some(open) = self.connection_mut(connection) {
                    open.end = Some(Status::HOST_PEER_CLOSED);
                    open.broken = true;
                }
                self.wake_files(connection);
            }
        }
    }

    /// The task is over: its ports close. Its connections stay open and silent, as on a controller.
    pub(crate) fn release_ports(&mut self, task: TaskId) {
        for slot in &mut self.tags {
            if slot.task == Some(task) {
                if matches!(slot.state, TagState::Waiting | TagState::Failed(_)) {
                    slot.state = TagState::Idle;
                }
                self.effects.push(Effect::StopListening { tag: slot.tag });
            }
        }
    }

    /// ABORT ALL: connections close, too.
    pub(crate) fn close_connections(&mut self) {
        for slot in &mut self.tags {
            let effect = slot.disconnect();
            self.effects.extend(effect);
        }
        self.files.clear();
    }

    /// A fault: the tag answers to nobody any more, or does again. Clients wait in the backlog meanwhile.
    pub(crate) fn wedge(&mut self, tag: Tag, wedged: bool) {
        let Some(slot) = self.slot(tag) else {
            return;
        };
        slot.wedged = wedged;
        if let (TagState::Waiting, Some(port)) = (&slot.state, slot.port) {
            self.effects.push(if wedged {
                Effect::StopAccepting { tag }
            } else {
                Effect::Accept { tag, port }
            });
        }
    }

    /// The tag and the port of a connection.
    pub(crate) fn place_of(&self, tag: Tag) -> Option<u16> {
        let slot = self.tags.iter().find(|slot| slot.tag == tag)?;
        slot.port
    }

    /// How many more bytes a connection may bring now.
    pub(crate) fn room(&self, id: ConnectionId) -> usize {
        self.connection(id).map_or(0, Connection::room)
    }

    pub(super) fn accept(&mut self, tag: Tag, id: ConnectionId, peer: SocketAddr) {
        let name = self.name.clone();
        match self.slot(tag) {
            Some(slot) if matches!(slot.state, TagState::Waiting) => {
                slot.state = TagState::Accepted(Connection::new(id, peer));
                tracing::info!(controller = %name, %tag, %peer, "A client connected.");
                self.wakes.push(Wake::Connect(tag));
            }
            // The program gave up waiting while the client was on its way.
            Some(_) | None => self.effects.push(Effect::Close { connection: id }),
        }
    }

    pub(super) fn slot(&mut self, tag: Tag) -> Option<&mut ServerTag> {
        self.tags.get_mut(tag.index())
    }

    pub(super) fn connection(&self, id: ConnectionId) -> Option<&Connection> {
        self.tags
            .iter()
            .filter_map(ServerTag::connection)
            .find(|c| c.id == id)
    }

    pub(super) fn connection_mut(&mut self, id: ConnectionId) -> Option<&mut Connection> {
        self.tags
            .iter_mut()
            .filter_map(ServerTag::connection_mut)
            .find(|c| c.id == id)
    }

    pub(super) fn wake_files(&mut self, connection: ConnectionId) {
        for (&file, open) in &self.files {
            if open.connection == connection {
                self.wakes
                    .extend([Wake::Readable(file), Wake::Writable(file)]);
            }
        }
    }
}
