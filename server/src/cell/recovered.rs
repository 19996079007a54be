//! A cell as its journal left it: its snapshot, and the decisions behind it.

use jiff::Timestamp;
use journal::{Head, Kept, NewSnapshot, Position, ReadError, Record, SnapshotTaken, Stored};
use serde::{Deserialize, Serialize};
use thiserror::Error;
use workflow::{Cell, Fact, Setup, Snapshot};

use super::places::{KeptPlaces, Places};
use super::told::{KeptTimes, TellTimes};
use crate::journal::SharedJournal;

/// Decisions read at a time.
const PAGE: usize = 1_000;
/// How the text of a snapshot is written here, beside how the cell's state in it is.
const FORMAT: u32 = 1;

/// Why a cell did not start.
#[derive(Debug, Error)]
pub enum StartError {
    /// The journal cannot be read.
    #[error("reading the decisions of cell `{cell}`")]
    Read {
        /// The cell.
        cell: String,
        /// Why.
        #[source]
        source: ReadError,
    },
    /// A decision is none that this program knows. Nothing is guessed: it was written by a newer one, or damaged.
    #[error("the decision of cell `{cell}` at {position:?} is not understood")]
    Decision {
        /// The cell.
        cell: String,
        /// Where it stands.
        position: Position,
        /// Why.
        #[source]
        source: serde_json::Error,
    },
    /// The older decisions were removed, and what stands for them cannot be used.
    #[error(
        "the records up to {base} were removed, and the snapshot of cell `{cell}` that stands for its decisions among \
         them cannot be used: {how}"
    )]
    Snapshot {
        /// The cell.
        cell: String,
        /// The last record that was removed.
        base: Position,
        /// Why not.
        how: String,
    },
}

/// A cell as its journal left it.
#[derive(Debug)]
pub(crate) struct Recovered {
    pub(super) cell: Cell,
    pub(super) told: TellTimes,
    pub(super) places: Places,
    /// How many decisions were folded.
    pub(crate) decisions: usize,
    /// The size of the snapshot before them; 0: there was none.
    pub(crate) snapshot_bytes: u64,
}

/// What is kept of a cell.
#[derive(Debug, Serialize, Deserialize)]
struct Text {
    state: Snapshot,
    places: KeptPlaces,
    told: KeptTimes,
}

/// The number of the format this program writes and reads.
const fn format() -> u32 {
    Snapshot::FORMAT * 1_000 + FORMAT
}

/// What is to be kept of a cell, taken while its driver stands still and written out beside it.
#[derive(Debug)]
pub(super) struct Taken {
    cell: String,
    covers: Head,
    text: Text,
}

impl Taken {
    /// Of the state after the decision at `covers`.
    pub(super) fn new(
        id: &str,
        covers: Head,
        cell: &Cell,
        places: &Places,
        told: &TellTimes,
    ) -> Self {
        Self {
            cell: id.to_owned(),
            covers,
            text: Text {
                state: cell.snapshot(),
                places: places.kept(),
                told: told.kept(),
            },
        }
    }

    /// As text. What is not read again as the same is not kept: the decisions are.
    pub(super) fn write(self) -> Result<NewSnapshot, String> {
        let body = serde_json::to_string(&self.text).map_err(|error| error.to_string())?;
        let again: Text = serde_json::from_str(&body).map_err(|error| error.to_string())?;
        if again.state != self.text.state {
            return Err("it would not be read as what it was".to_owned());
        }
        Ok(NewSnapshot {
            cell: self.cell,
            covers: self.covers,
            format: format(),
            body,
        })
    }
}

/// Whether a start of this program could begin with what was kept.
///
/// # Errors
/// Why not.
pub(crate) fn readable(kept: &Kept) -> Result<(), String> {
    read(kept).map(drop)
}

fn read(kept: &Kept) -> Result<(&SnapshotTaken, Text), String> {
    let snapshot = match kept {
        Kept::Whole(snapshot) => snapshot,
        Kept::Damaged { how } => return Err(how.clone()),
    };
    if snapshot.taken.format != format() {
        return Err(format!(
            "it has format {}, this program reads format {}",
            snapshot.taken.format,
            format()
        ));
    }
    let text = serde_json::from_str(&snapshot.body).map_err(|error| error.to_string())?;
    Ok((&snapshot.taken, text))
}

impl Recovered {
    /// Folds the decisions of a cell behind its snapshot, or all of them. Nothing follows from them: their effects are
    /// of an earlier time.
    ///
    /// # Errors
    /// They cannot be read or understood.
    pub(crate) async fn read(
        id: &str,
        setup: Setup,
        journal: &SharedJournal,
        now: Timestamp,
    ) -> Result<Self, StartError> {
        let unread = |source| StartError::Read {
            cell: id.to_owned(),
            source,
        };
        let mut this = Self {
            cell: Cell::new(setup),
            told: TellTimes::of(journal, now),
            places: Places::default(),
            decisions: 0,
            snapshot_bytes: 0,
        };
        let mut after = match journal.snapshot(id).await.map_err(unread)? {
            None => Position::START,
            Some(kept) => match this.take_up(&kept) {
                Ok(covers) => covers,
                Err(how) => {
                    let base = journal.retained(now).await.map_err(unread)?.base.position;
                    if base > Position::START {
                        let cell = id.to_owned();
                        return Err(StartError::Snapshot { cell, base, how });
                    }
                    tracing::warn!(
                        cell.id = id,
                        how,
                        "the snapshot is not used; all decisions are read"
                    );
                    Position::START
                }
            },
        };
        loop {
            let page = journal.decided(id, after, PAGE).await.map_err(unread)?;
            for stored in &page {
                after = stored.position;
                this.fold(id, stored)?;
            }
            if page.len() < PAGE {
                return Ok(this);
            }
        }
    }

    /// Begins with what was kept; the last decision in it. Otherwise nothing has changed.
    fn take_up(&mut self, kept: &Kept) -> Result<Position, String> {
        let (taken, text) = read(kept)?;
        self.cell = Cell::of_snapshot(text.state);
        self.places = Places::of_kept(text.places);
        self.told.take_up(text.told);
        self.snapshot_bytes = taken.bytes;
        Ok(taken.covers.position)
    }

    fn fold(&mut self, id: &str, stored: &Stored) -> Result<(), StartError> {
        self.decisions += 1;
        let Record::CellDecided(decided) = &stored.record else {
            return Ok(());
        };
        let facts: Vec<Fact> =
            serde_json::from_str(&decided.facts).map_err(|source| StartError::Decision {
                cell: id.to_owned(),
                position: stored.position,
                source,
            })?;
        self.places.note(stored.position, facts.iter());
        for fact in &facts {
            self.cell.replay(fact);
            if let Fact::Told { mobile_robot, .. } = fact
                && let Some(last) = self.cell.outbox(mobile_robot, 0).last()
            {
                self.told.note(mobile_robot, last.n, stored.at.wall);
            }
        }
        Ok(())
    }
}
