//! Tags and the files that are open on them.

use std::net::SocketAddr;

use karel::{FileId, Input, InputEnd, OpenMode, Progress, Status, TaskId, Wait};

use super::{Hardware, OpenFile, Origin, Wake};
use crate::alarms::Severity;
use crate::effects::{Effect, Tag};
use crate::tags::{Connection, HOST_NOT_CONNECTED, TagState};

/// `$STATE` of a tag that programs may use.
const TAG_STARTED: i32 = 3;

/// Files that may be open at a time.
const OPEN_FILES: usize = 64;

impl Hardware {
    /// `MSG_CONNECT`: listens, waits, and reports the client. The machine makes a failure take its time.
    pub(super) fn connect(&mut self, task: TaskId, name: &str) -> Progress<Status> {
        // Who lacks the option lacks the built-in, whatever it is called with; the task ends while it waits.
        if self.lacks_sockets("MSG_CONNECT") {
            return Progress::Pending(Wait::Connect(name.to_owned()));
        }
        self.try_connect(task, name).unwrap_or_else(|status| {
            tracing::debug!(controller = %self.name, tag = name, "MSG_CONNECT fails with {status}.");
            if self.is_kind() {
                self.note_no_connection(name, status);
            }
            Progress::Ready(status)
        })
    }

    fn try_connect(&mut self, task: TaskId, name: &str) -> Result<Progress<Status>, Status> {
        let tag = Tag::parse(name).ok_or(Status::HOST_TAG)?;
        let port = self.port_of(tag)?;
        let wait = || {
            let name = tag.to_string();
            Progress::Pending(Wait::Connect(name.trim_end_matches(':').to_owned()))
        };
        let ask = if tag.is_client() {
            let server = self.server_of(tag, port)?;
            Effect::Connect { tag, server }
        } else {
            Effect::Accept { tag, port }
        };
        let slot = self.slot(tag).ok_or(Status::HOST_TAG)?;
        if slot.wedged {
            return Err(Status::HOST_TAG);
        }
        match std::mem::replace(&mut slot.state, TagState::Idle) {
            TagState::Idle => {
                slot.state = TagState::Waiting;
                slot.task = Some(task);
                slot.port = Some(port);
                self.effects.push(ask);
                tracing::debug!(controller = %self.name, %tag, port, "The program waits for a connection.");
                Ok(wait())
            }
            TagState::Waiting if slot.task == Some(task) => {
                slot.state = TagState::Waiting;
                Ok(wait())
            }
            TagState::Accepted(connection) if slot.task == Some(task) => {
                slot.state = TagState::Connected(connection);
                slot.last_failure = None;
                Ok(Progress::Ready(Status::OK))
            }
            TagState::Failed(reason) => {
                let news = slot.last_failure.as_ref() != Some(&reason);
                slot.last_failure = Some(reason.clone());
                if news {
                    self.post(Status::HOST_TAG, reason, Severity::Warn);
                }
                Err(Status::HOST_TAG)
            }
            busy @ (TagState::Waiting | TagState::Accepted(_) | TagState::Connected(_)) => {
                slot.state = busy;
                Err(Status::HOST_TAG)
            }
        }
    }

    fn port_of(&self, tag: Tag) -> Result<u16, Status> {
        let kind = if tag.is_client() { 'C' } else { 'S' };
        let root = format!("$HOST{kind}_CFG[{}]", tag.number());
        let state = self.variables.integer(&format!("{root}.$STATE"))?;
        if state != TAG_STARTED {
            return Err(Status::HOST_TAG);
        }
        let port = self.variables.integer(&format!("{root}.$SERVER_PORT"))?;
        u16::try_from(port)
            .ok()
            .filter(|&port| port != 0)
            .ok_or(Status::HOST_TAG)
    }

    /// The server of a client tag: `$STRT_REMOTE`, or `$REMOTE` if that is empty.
    fn server_of(&mut self, tag: Tag, port: u16) -> Result<SocketAddr, Status> {
        let root = format!("$HOSTC_CFG[{}]", tag.number());
        let mut name = self.variables.text(&format!("{root}.$STRT_REMOTE"))?;
        if name.trim().is_empty() {
            name = self.variables.text(&format!("{root}.$REMOTE"))?;
        }
        let Some(ip) = self.hosts.find(&name) else {
            let text = format!("{tag} may not connect to the host {:?}", name.trim());
            self.refuse_host(tag, text);
            return Err(Status::HOST_NO_ANSWER);
        };
        Ok(SocketAddr::new(ip, port))
    }

    /// Says it once, however often the program tries.
    fn refuse_host(&mut self, tag: Tag, text: String) {
        let Some(slot) = self.slot(tag) else { return };
        if slot.last_failure.as_ref() != Some(&text) {
            slot.last_failure = Some(text.clone());
            self.post(Status::HOST_NO_ANSWER, text, Severity::Warn);
        }
    }

    /// `MSG_PING`: a host that programs may reach answers.
    ///
    /// ASSUMPTION: nothing is sent; hosts of the list are taken to be there.
    pub(super) fn answer_of(&self, host: &str) -> Status {
        if self.hosts.find(host).is_some() {
            Status::OK
        } else {
            Status::HOST_NO_ANSWER
        }
    }

    /// `MSG_DISCO`: harmless on an idle tag.
    ///
    /// ASSUMPTION: if another task waits for a client there, its `MSG_CONNECT` fails with HOST-144.
    pub(super) fn disconnect(&mut self, task: TaskId, name: &str) -> Status {
        let Some(tag) = Tag::parse(name) else {
            return Status::HOST_TAG;
        };
        let Some(slot) = self.slot(tag) else {
            return Status::HOST_TAG;
        };
        if slot.wedged {
            return Status::HOST_TAG;
        }
        let another_waits = matches!(slot.state, TagState::Waiting | TagState::Accepted(_))
            && slot.task != Some(task);
        let effect = slot.disconnect();
        if another_waits {
            slot.state = TagState::Failed(format!(
                "{tag} was disconnected by another task while a program waited for a client"
            ));
            self.wakes.push(Wake::Connect(tag));
        }
        self.effects.extend(effect);
        Status::OK
    }

    pub(super) fn open(
        &mut self,
        task: TaskId,
        mode: OpenMode,
        name: &str,
    ) -> Result<FileId, Status> {
        let Some(tag) = Tag::parse(name) else {
            if self.files.len() + self.devices.opened() >= OPEN_FILES {
                return Err(Status::INTP_LIMIT);
            }
            self.last_file = self.last_file.wrapping_add(1);
            let file = FileId(self.last_file);
            self.devices.open(file, mode, name)?;
            return Ok(file);
        };
        let slot = self.slot(tag).ok_or(Status::INTP_OPEN_FAILED)?;
        let TagState::Connected(Connection { id: connection, .. }) = slot.state else {
            return Err(Status::INTP_OPEN_FAILED);
        };
        if self.files.len() >= OPEN_FILES {
            return Err(Status::INTP_LIMIT);
        }
        // Four thousand million files later, the first one is long closed.
        self.last_file = self.last_file.wrapping_add(1);
        let file = FileId(self.last_file);
        let open = OpenFile {
            connection,
            task,
            cancelled: false,
        };
        let _new = self.files.insert(file, open);
        Ok(file)
    }

    pub(super) fn close(&mut self, file: FileId) -> Status {
        let _closed = self.files.remove(&file);
        self.devices.close(file);
        self.keep_files();
        Status::OK
    }

    /// Breaks a READ in progress; [`Self::end_cancel`] makes the file usable again.
    ///
    /// A task that cancels its own file has nothing in progress on it.
    pub(super) fn cancel(&mut self, file: FileId) -> Status {
        let running = self.running;
        if let Some(open) = self.files.get_mut(&file)
            && Some(open.task) != running
        {
            open.cancelled = true;
            self.wakes
                .extend([Wake::Readable(file), Wake::Writable(file)]);
        }
        Status::OK
    }

    /// A cancellation reaches only operations that were in progress when it came.
    pub(crate) fn end_cancel(&mut self, task: TaskId) {
        for open in self.files.values_mut().filter(|open| open.task == task) {
            open.cancelled = false;
        }
    }

    /// Files that programs have changed go outside.
    pub(super) fn keep_files(&mut self) {
        let changed = self.devices.take_changed().into_iter();
        let keep = changed.map(|(name, bytes)| Effect::Keep { name, bytes });
        self.effects.extend(keep);
    }

    pub(super) fn input_of(&self, file: FileId) -> Input<'_> {
        if file == FileId::KEYBOARD {
            return Input {
                bytes: &self.keyboard,
                end: InputEnd::Open,
            };
        }
        if self.devices.holds(file) {
            return self.devices.input(file);
        }
        let closed = |status| Input {
            bytes: &[],
            end: InputEnd::Closed(status),
        };
        let Some(open) = self.files.get(&file) else {
            return closed(Status::INTP_NOT_OPEN);
        };
        if open.cancelled {
            return closed(Status::INTP_READ_FAILED);
        }
        match self.connection(open.connection) {
            None => closed(HOST_NOT_CONNECTED),
            Some(connection) => Input {
                bytes: &connection.received,
                end: connection.end.map_or(InputEnd::Open, InputEnd::Closed),
            },
        }
    }

    pub(super) fn consume_input(&mut self, file: FileId, count: usize) {
        if file == FileId::KEYBOARD {
            return drop(self.keyboard.drain(..count.min(self.keyboard.len())));
        }
        if self.devices.holds(file) {
            return self.devices.consume(file, count);
        }
        let Some(OpenFile {
            connection, task, ..
        }) = self.files.get(&file)
        else {
            return;
        };
        let (id, task) = (*connection, *task);
        let Some(connection) = self.connection_mut(id) else {
            return;
        };
        let origin = Origin {
            peer: Some(connection.peer),
            request_id: connection.request_id.clone(),
        };
        connection.take(count);
        let _previous = self.origins.insert(task, origin);
    }

    /// WRITE: all bytes go out together, or the task waits until they can.
    pub(super) fn write(&mut self, file: FileId, bytes: &[u8]) -> Progress<Status> {
        if self.devices.holds(file) {
            let (status, readers) = self.devices.write(file, bytes);
            self.wakes.extend(readers.into_iter().map(Wake::Readable));
            return Progress::Ready(status);
        }
        let Some(open) = self.files.get(&file) else {
            return Progress::Ready(Status::INTP_NOT_OPEN);
        };
        let (id, cancelled) = (open.connection, open.cancelled);
        let Some(connection) = self.connection_mut(id) else {
            return Progress::Ready(HOST_NOT_CONNECTED);
        };
        if connection.broken {
            return Progress::Ready(HOST_NOT_CONNECTED);
        }
        if cancelled {
            return Progress::Ready(Status::INTP_WRITE_FAILED);
        }
        if bytes.is_empty() {
            return Progress::Ready(Status::OK);
        }
        if !connection.takes(bytes.len()) {
            return Progress::Pending(Wait::Writable(file));
        }
        connection.unsent += bytes.len();
        self.effects.push(Effect::Send {
            connection: id,
            bytes: bytes.to_vec(),
        });
        Progress::Ready(Status::OK)
    }
}
