//! A record as events.

use std::collections::BTreeMap;
use std::sync::Arc;

use api::{CellEvent, CellEventData};
use bytes::Bytes;
use journal::{Intent, MotionId, Position, Record, Stored};
use serde_json::{Map, Value};
use uuid::Uuid;
use workflow::Fact;

use super::id::{Epochs, EventId};
use super::known::Known;
use super::{motions, sentence};
use crate::cell::CellHandle;
use crate::journal::SharedJournal;

/// Motions whose beginnings are remembered, so that their ends need no look into the journal.
const MOTIONS: usize = 512;

/// The events of one record, made once for all streams.
#[derive(Debug)]
pub(super) struct Batch {
    pub(super) id: EventId,
    pub(super) events: Vec<Ready>,
}

/// An event as it is sent.
#[derive(Debug)]
pub(super) struct Ready {
    pub(super) kind: &'static str,
    pub(super) job: Option<Uuid>,
    /// The event in JSON, for each cell that may see it.
    pub(super) json: Vec<(Arc<str>, Bytes)>,
}

impl Batch {
    pub(super) fn bytes(&self) -> usize {
        let of_event = |event: &Ready| event.json.iter().map(|(_, json)| json.len()).sum::<usize>();
        self.events.iter().map(of_event).sum()
    }
}

/// Makes events of records, one after the other.
#[derive(Clone, Debug)]
pub(super) struct Projector {
    journal: SharedJournal,
    epochs: Epochs,
    /// The cells, and what is known of each.
    cells: BTreeMap<Arc<str>, Known>,
    intents: BTreeMap<MotionId, Intent>,
}

impl Projector {
    /// With what the cells remember now.
    pub(super) fn new(
        journal: SharedJournal,
        epochs: Epochs,
        cells: &[(Arc<str>, CellHandle)],
    ) -> Self {
        let cells = cells.iter().map(|(id, handle)| {
            let mut known = Known::default();
            known.learn_from(&handle.view());
            (Arc::clone(id), known)
        });
        Self {
            cells: cells.collect(),
            journal,
            epochs,
            intents: BTreeMap::new(),
        }
    }

    pub(super) async fn events(&mut self, stored: &Stored) -> Batch {
        let id = EventId {
            epoch: self.epochs.shown(stored.epoch),
            position: stored.position,
        };
        let mut batch = Batch {
            id,
            events: Vec::new(),
        };
        if let Record::CellDecided(decided) = &stored.record {
            self.decided(&mut batch, stored, &decided.cell, &decided.facts);
        } else {
            self.noted(&mut batch, stored).await;
        }
        batch
    }

    fn decided(&mut self, batch: &mut Batch, stored: &Stored, cell: &str, facts: &str) {
        let cell = self.cells.get_key_value(cell).map(|(id, _)| Arc::clone(id));
        let Some((cell, known)) = cell.and_then(|id| Some((id.clone(), self.cells.get_mut(&id)?)))
        else {
            return;
        };
        let facts: Vec<Fact> = match serde_json::from_str(facts) {
            Ok(facts) => facts,
            Err(error) => {
                tracing::error!(position = %stored.position, %error, "a decision has no event");
                return;
            }
        };
        for (index, fact) in facts.iter().enumerate() {
            known.learn(fact);
            let Some(said) = sentence::of_fact(known, fact) else {
                continue;
            };
            let event = Event {
                index,
                kind: said.kind,
                text: said.text,
                job: said.job,
                subject: said.subject,
                more: fields(fact),
            };
            batch.events.push(Ready {
                kind: event.kind,
                job: event.job,
                json: vec![(Arc::clone(&cell), event.json(batch.id, stored, &cell))],
            });
        }
    }

    async fn noted(&mut self, batch: &mut Batch, stored: &Stored) {
        let intent = self.intent(&stored.record).await;
        let Some(noted) = motions::of_record(&stored.record, intent.as_ref()) else {
            return;
        };
        let of_motion = intent.as_ref();
        let cell = of_motion.map(|intent| &*intent.cell);
        if motions::motion_of(&stored.record).is_some() && cell.is_none() {
            return;
        }
        let job = of_motion.and_then(|intent| intent.job).map(|job| job.0);
        let event = Event {
            index: 0,
            kind: noted.kind,
            text: noted.text,
            job,
            subject: noted.subject,
            more: noted.more,
        };
        let shown_to = self
            .cells
            .keys()
            .filter(|id| cell.is_none_or(|cell| cell == &***id));
        let json: Vec<_> = shown_to
            .map(|id| (Arc::clone(id), event.json(batch.id, stored, id)))
            .collect();
        batch.events.push(Ready {
            kind: event.kind,
            job,
            json,
        });
    }

    /// The beginning of the motion a record is about.
    async fn intent(&mut self, record: &Record) -> Option<Intent> {
        if let Record::Intent(intent) = record {
            let _before = self.intents.insert(intent.motion, (**intent).clone());
            while self.intents.len() > MOTIONS {
                let _oldest = self.intents.pop_first();
            }
            return Some((**intent).clone());
        }
        let motion = motions::motion_of(record)?;
        if let Some(known) = self.intents.get(&motion) {
            return Some(known.clone());
        }
        match self.journal.motion(motion).await {
            Ok(story) => {
                let begun = story.map(|story| story.intent.record);
                if let Some(Record::Intent(intent)) = begun {
                    Some(*intent)
                } else {
                    None
                }
            }
            Err(error) => {
                tracing::warn!(%motion, %error, "a motion has no beginning that can be read");
                None
            }
        }
    }
}

struct Event {
    index: usize,
    kind: &'static str,
    text: String,
    job: Option<Uuid>,
    subject: Option<String>,
    more: Map<String, Value>,
}

impl Event {
    fn json(&self, id: EventId, stored: &Stored, cell: &str) -> Bytes {
        let event = CellEvent {
            specversion: "1.0".to_owned(),
            id: format!("{id}-{}", self.index),
            source: format!("/api/v1/cells/{cell}"),
            event_type: self.kind.to_owned(),
            time: stored.at.wall,
            subject: self.subject.clone(),
            datacontenttype: "application/json".to_owned(),
            data: CellEventData {
                text: self.text.clone(),
                job: self.job,
                more: self.more.clone(),
            },
        };
        // An event is made of texts and numbers that JSON can say.
        Bytes::from(serde_json::to_vec(&event).unwrap_or_default())
    }
}

/// The fields of a fact, without its name and what an event says elsewhere. A set-up is fetched where set-ups are.
fn fields(fact: &Fact) -> Map<String, Value> {
    let Ok(Value::Object(mut fields)) = serde_json::to_value(fact) else {
        return Map::new();
    };
    for elsewhere in ["fact", "job", "text", "setup", "steps"] {
        let _none = fields.remove(elsewhere);
    }
    fields
}

/// Where a stream that has everything up to `id` reads on.
#[derive(Debug, Eq, PartialEq)]
pub(super) enum Resume {
    After(Position),
    Gap(api::GapReason),
}

impl Projector {
    /// Whether the journal still has what follows `id`.
    pub(super) async fn resume(&self, id: EventId) -> Resume {
        if id == EventId::START {
            // Everything that is kept, whatever that is.
            return Resume::After(Position::START);
        }
        let before = Position(id.position.0.saturating_sub(1));
        let at = match self.journal.page(before, 1).await {
            Ok(page) => page,
            Err(error) => {
                tracing::warn!(%error, "the journal cannot be read for a stream of events");
                return Resume::Gap(api::GapReason::Forgotten);
            }
        };
        match at.first() {
            Some(first) if first.position == id.position => {
                if self.epochs.shown(first.epoch) == id.epoch {
                    Resume::After(id.position)
                } else {
                    Resume::Gap(api::GapReason::OtherJournal)
                }
            }
            Some(_) if id.position > Position::START => Resume::Gap(api::GapReason::Forgotten),
            Some(_) | None => Resume::Gap(api::GapReason::OtherJournal),
        }
    }
}
