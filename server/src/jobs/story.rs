//! What the journal says of one job, or of one load.

use std::collections::BTreeMap;

use api::{CustodyEvent, CustodyEvidence, ProblemCode};
use journal::{Clocks, Epoch, Position, Record};
use uuid::Uuid;
use workflow::view::JobView;
use workflow::{Cell, Evidence, Fact, Setup};

use super::shown::load_location;
use crate::cell::{Span, Subject, subject};
use crate::journal::SharedJournal;
use crate::problem::Problem;

/// Records read at a time.
const PAGE: usize = 1_000;
/// How many moves of a load are told.
const MOVES: usize = 100;

/// One record of a job's story: what happened together.
#[derive(Clone, Debug)]
pub(crate) struct Chapter {
    pub(crate) position: Position,
    pub(crate) epoch: Epoch,
    pub(crate) at: Clocks,
    /// With their places in the record.
    pub(crate) facts: Vec<(usize, Fact)>,
}

/// A job's story, the oldest first.
#[derive(Clone, Debug)]
pub(crate) struct History {
    pub(crate) job: Uuid,
    pub(crate) chapters: Vec<Chapter>,
}

/// Reads the facts of a job, and the starts of the server meanwhile.
///
/// # Errors
/// `journal-unavailable`; `internal` where a record is not understood, which the start would have noticed.
pub(crate) async fn story(
    journal: &SharedJournal,
    cell: &str,
    span: Span,
    job: Uuid,
) -> Result<History, Problem> {
    let mut picker = Picker::new(job);
    let mut chapters = Vec::new();
    let before = Position(span.first.0.saturating_sub(1));
    for_each(journal, cell, before, span.last, |chapter| {
        chapters.extend(picker.pick(chapter));
    })
    .await?;
    Ok(History { job, chapters })
}

/// Picks what belongs to a job.
#[derive(Debug)]
pub(super) struct Picker {
    job: Uuid,
    /// The jobs of operations, sessions and questions.
    owners: BTreeMap<Uuid, Uuid>,
    begun: bool,
}

impl Picker {
    pub(super) fn new(job: Uuid) -> Self {
        Self {
            job,
            owners: BTreeMap::new(),
            begun: false,
        }
    }

    /// What of a record belongs to the job, or is a start of the server meanwhile.
    pub(super) fn pick(&mut self, mut chapter: Chapter) -> Option<Chapter> {
        chapter.facts.retain(|(_, fact)| {
            self.begun && *fact == Fact::Recovered
                || match subject(fact) {
                    Subject::Job(job) => {
                        self.begun |= job == self.job;
                        job == self.job
                    }
                    Subject::Opens { job, what } => {
                        let _new = self.owners.insert(what, job);
                        job == self.job
                    }
                    // The end of an operation and what it did to a load are told one after the other.
                    Subject::Of(what) | Subject::Closes(what) => {
                        self.owners.get(&what) == Some(&self.job)
                    }
                    Subject::None => false,
                }
        });
        (!chapter.facts.is_empty()).then_some(chapter)
    }
}

/// A job the cell has forgotten, as its story leaves it.
pub(crate) fn remembered(history: &History) -> Option<JobView> {
    let mut cell = Cell::new(Setup::default());
    let facts = history.chapters.iter().flat_map(|chapter| &chapter.facts);
    for (_, fact) in facts {
        if *fact != Fact::Recovered {
            cell.replay(fact);
        }
    }
    cell.job(0, history.job)
}

/// How a load came to where it is, the newest first.
pub(crate) async fn history_of_load(
    journal: &SharedJournal,
    cell: &str,
    load: &str,
) -> Result<Vec<CustodyEvent>, Problem> {
    let mut moves = std::collections::VecDeque::new();
    let end = journal.head().position;
    for_each(journal, cell, Position::default(), end, |chapter| {
        for (_, fact) in &chapter.facts {
            let event = if let Fact::CustodyMoved { load: of, to, by } = fact
                && of == load
            {
                custody_event(chapter.at, to, by)
            } else if let Fact::LoadRegistered {
                load: of, location, ..
            } = fact
                && of == load
            {
                CustodyEvent {
                    at: chapter.at.wall,
                    to: load_location(location),
                    evidence: CustodyEvidence::MobileRobot,
                    text: "it came into the cell".to_owned(),
                    principal: None,
                }
            } else if let Fact::SetupChanged { setup } = fact
                // A set-up places only loads that are not known yet.
                && moves.is_empty()
                && let Some(listed) = setup.loads.iter().find(|listed| listed.id == load)
            {
                CustodyEvent {
                    at: chapter.at.wall,
                    to: load_location(&listed.at),
                    evidence: CustodyEvidence::Setup,
                    text: "the set-up has it there".to_owned(),
                    principal: None,
                }
            } else {
                continue;
            };
            moves.push_front(event);
            moves.truncate(MOVES);
        }
    })
    .await?;
    Ok(moves.into())
}

fn custody_event(at: Clocks, to: &workflow::Location, by: &Evidence) -> CustodyEvent {
    let (evidence, text, principal) = match by {
        Evidence::Gripper { .. } => (
            CustodyEvidence::Gripper,
            "confirmed by the gripper's inputs".to_owned(),
            None,
        ),
        Evidence::Doubt { text } => (CustodyEvidence::Doubt, text.clone(), None),
        Evidence::MobileRobot { mobile_robot } => (
            CustodyEvidence::MobileRobot,
            format!("reported by {mobile_robot}"),
            None,
        ),
        Evidence::Human { principal, reason } => (
            CustodyEvidence::Person,
            reason.clone(),
            Some(principal.clone()),
        ),
    };
    CustodyEvent {
        at: at.wall,
        to: load_location(to),
        evidence,
        text,
        principal,
    }
}

/// Reads the decisions of a cell behind `after`, up to and including `last`.
pub(super) async fn for_each(
    journal: &SharedJournal,
    cell: &str,
    mut after: Position,
    last: Position,
    mut take: impl FnMut(Chapter),
) -> Result<(), Problem> {
    loop {
        let page = journal.decided(cell, after, PAGE).await.map_err(|error| {
            Problem::new(ProblemCode::JournalUnavailable, error.to_string()).retryable()
        })?;
        let is_last = page.len() < PAGE;
        for stored in page {
            after = stored.position;
            if after > last {
                return Ok(());
            }
            let Record::CellDecided(decided) = &stored.record else {
                continue;
            };
            let facts: Vec<Fact> = serde_json::from_str(&decided.facts).map_err(|error| {
                let detail = format!("record {after} is not understood: {error}");
                Problem::new(ProblemCode::Internal, detail)
            })?;
            take(Chapter {
                position: after,
                epoch: stored.epoch,
                at: stored.at,
                facts: facts.into_iter().enumerate().collect(),
            });
        }
        if is_last {
            return Ok(());
        }
    }
}
