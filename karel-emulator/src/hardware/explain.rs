//! What a kind controller says about itself. A faithful one is silent.

use karel::{RuntimeError, TaskId, Wait};

use super::Hardware;
use crate::effects::Effect;
use crate::fidelity::Fidelity;
use crate::ledger::seconds;
use crate::tags::Connection;

impl Hardware {
    pub(crate) fn is_kind(&self) -> bool {
        self.fidelity == Fidelity::Kind
    }

    /// Notes something for people, if the controller does that.
    pub(crate) fn note(&mut self, place: Option<(&str, u32)>, text: String) {
        if !self.is_kind() {
            return;
        }
        let told = match place {
            Some((program, line)) => format!("{program}, {line}: {text}"),
            None => text.clone(),
        };
        if self.notes.add(seconds(self.now), place, text) {
            tracing::info!(controller = %self.name, "Note: {told}.");
        }
    }

    /// An error has ended the task. Reported of controllers: its connections stay open and silent, and clients wait until
    /// they give up. A kind controller closes them and says why.
    pub(crate) fn tell_clients(&mut self, task: TaskId, error: &RuntimeError) {
        if !self.is_kind() {
            return;
        }
        let mut texts = Vec::new();
        let mut effects: Vec<Effect> = Vec::new();
        for slot in self.tags.iter_mut().filter(|slot| slot.task == Some(task)) {
            let tag = slot.tag;
            if let Some(connection) = slot.connection() {
                let (peer, last) = (connection.peer, quoted(&connection.recent));
                texts.push(format!(
                    "{} ended the task while {peer} is connected to {tag}; the last that was read is {last}. \
                     A controller leaves the connection open and silent, this one closes it",
                    error.status
                ));
                effects.extend(slot.disconnect());
            }
        }
        self.effects.extend(effects);
        let place = (error.program.clone(), error.line);
        for text in texts {
            self.note(Some((&place.0, place.1)), text);
        }
    }

    /// What a task that waits so waits for, in more words.
    pub(crate) fn hint(&self, wait: &Wait) -> Option<String> {
        if !self.is_kind() {
            return None;
        }
        match wait {
            Wait::Readable(file) | Wait::ReadableUntil(file, _) => {
                let open = self.files.get(file)?;
                let mut slots = self.tags.iter();
                let (tag, connection) = slots.find_map(|slot| {
                    let connection = slot.connection()?;
                    (connection.id == open.connection).then_some((slot.tag, connection))
                })?;
                Some(waits_for_bytes(&tag.to_string(), connection))
            }
            Wait::Motion(_) | Wait::MotionQueue if self.executor.is_held() => {
                let reason = self.start_obstacle();
                let reason = reason.unwrap_or_else(|| "somebody holds it".to_owned());
                Some(format!("the motion is held: {reason}"))
            }
            Wait::Connect(_)
            | Wait::Writable(_)
            | Wait::Motion(_)
            | Wait::MotionQueue
            | Wait::Continue
            | Wait::Until(_) => None,
        }
    }

    /// Why `MSG_CONNECT` fails.
    pub(super) fn note_no_connection(&mut self, name: &str, status: karel::Status) {
        let slot = crate::effects::Tag::parse(name);
        let root = slot.map(|tag| {
            let kind = if tag.is_client() { 'C' } else { 'S' };
            format!("$HOST{kind}_CFG[{}]", tag.number())
        });
        let reason = match root {
            None => "there is no such tag".to_owned(),
            Some(root) => {
                let state = self.variables.integer(&format!("{root}.$STATE"));
                let port = self.variables.integer(&format!("{root}.$SERVER_PORT"));
                match (state, port) {
                    (Ok(3), Ok(0)) => format!("{root}.$SERVER_PORT is 0"),
                    (Ok(3), _) => "the tag is in use, or its port cannot be opened".to_owned(),
                    (Ok(state), _) => format!("{root}.$STATE is {state}, a tag is started with 3"),
                    (Err(_), _) => format!("{root}.$STATE has no value"),
                }
            }
        };
        self.note(
            None,
            format!("MSG_CONNECT of {name} answers {status}: {reason}"),
        );
    }
}

fn waits_for_bytes(tag: &str, connection: &Connection) -> String {
    let peer = connection.peer;
    let count = connection.received.len();
    if count == 0 {
        return format!(
            "nothing more has come from {peer} on {tag}; a READ waits for ever where ATR_TIMEOUT sets no end"
        );
    }
    let bytes = quoted(&connection.received);
    format!(
        "{bytes}, {count} bytes from {peer} on {tag}, do not end the READ: a STRING ends with a line end, a number with a \
         blank or a line end, a width with its last byte"
    )
}

/// The first bytes, as text.
fn quoted(bytes: &[u8]) -> String {
    const MOST: usize = 60;
    let shown: String = bytes
        .iter()
        .take(MOST)
        .flat_map(|byte| std::ascii::escape_default(*byte))
        .map(char::from)
        .collect();
    let rest = if bytes.len() > MOST { ".." } else { "" };
    format!("\"{shown}\"{rest}")
}
