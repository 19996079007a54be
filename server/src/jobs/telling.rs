//! The story of a job that ran alone, as lists: what arms did, permits, custody, questions.

use std::collections::BTreeMap;

use api::{Load, SimulatedCustody, SimulatedMotion, SimulatedPermit, SimulatedQuestion};
use journal::Position;
use uuid::Uuid;
use workflow::{Action, Cell, Fact, Setup};

use super::events::ended;
use super::report::Elapsed;
use super::shown::{fault_name, load, load_location, permits};
use super::story::{Chapter, History, Picker, for_each};
use crate::journal::SharedJournal;
use crate::problem::Problem;
use crate::words::{action, word};

/// Everything a cell decided, the oldest first.
///
/// # Errors
/// As [`super::story()`].
pub(crate) async fn all_chapters(
    journal: &SharedJournal,
    cell: &str,
) -> Result<Vec<Chapter>, Problem> {
    let mut chapters = Vec::new();
    let end = journal.head().position;
    for_each(journal, cell, Position::default(), end, |chapter| {
        chapters.push(chapter);
    })
    .await?;
    Ok(chapters)
}

impl History {
    /// What of all that a cell decided belongs to a job.
    pub(crate) fn of(job: Uuid, chapters: Vec<Chapter>) -> Self {
        let mut picker = Picker::new(job);
        let chapters = chapters.into_iter();
        Self {
            job,
            chapters: chapters
                .filter_map(|chapter| picker.pick(chapter))
                .collect(),
        }
    }
}

/// What is told. Milliseconds count from the job's creation.
#[derive(Debug, Default)]
pub(crate) struct Told {
    pub(crate) motions: Vec<SimulatedMotion>,
    pub(crate) permits: Vec<SimulatedPermit>,
    pub(crate) custody: Vec<SimulatedCustody>,
    pub(crate) interventions: Vec<SimulatedQuestion>,
    pub(crate) loads: Vec<Load>,
}

/// Folds what a cell decided while one job ran in it, and notes what changed.
#[derive(Debug)]
pub(crate) struct Telling {
    job: Uuid,
    cell: Cell,
    elapsed: Elapsed,
    begun: bool,
    /// The motions that run, by their operations.
    running: BTreeMap<Uuid, usize>,
    told: Told,
}

impl Telling {
    pub(crate) fn new(job: Uuid) -> Self {
        Self {
            job,
            cell: Cell::new(Setup::default()),
            elapsed: Elapsed::default(),
            begun: false,
            running: BTreeMap::new(),
            told: Told::default(),
        }
    }

    pub(crate) fn take(&mut self, chapter: &Chapter) {
        self.begun |= chapter
            .facts
            .iter()
            .any(|(_, fact)| matches!(fact, Fact::JobCreated { job, .. } if *job == self.job));
        // Time begins with the job.
        let at_ms = if self.begun {
            self.elapsed.at(chapter)
        } else {
            0
        };
        let before = permits(&self.cell, &[]);
        for (_, fact) in &chapter.facts {
            // Replayed facts grant no permit; these are of this process, and their effects were carried out.
            drop(self.cell.apply(at_ms, fact));
            if self.begun {
                self.note(at_ms, fact);
            }
        }
        if !self.begun {
            return;
        }
        for now in permits(&self.cell, &[]) {
            let was = before.iter().find(|was| was.point == now.point);
            let same = was.is_some_and(|was| {
                (was.arm_entry_permit, was.mr_move_permit)
                    == (now.arm_entry_permit, now.mr_move_permit)
            });
            if !same {
                self.told.permits.push(SimulatedPermit {
                    at_ms,
                    point: now.point,
                    arm_entry_permit: now.arm_entry_permit,
                    mr_move_permit: now.mr_move_permit,
                });
            }
        }
    }

    fn note(&mut self, at_ms: u64, fact: &Fact) {
        if let Fact::OpStarted {
            op,
            step,
            arm,
            action: what,
            ..
        } = fact
            && !matches!(what, Action::Precheck { .. })
        {
            let _new = self.running.insert(*op, self.told.motions.len());
            self.told.motions.push(SimulatedMotion {
                arm: arm.clone(),
                step: *step,
                action: action(what),
                begin_ms: at_ms,
                duration_ms: 0,
                end: None,
            });
        } else if let Fact::OpEnded { op, result } = fact
            && let Some(index) = self.running.remove(op)
            && let Some(motion) = self.told.motions.get_mut(index)
        {
            motion.duration_ms = at_ms.saturating_sub(motion.begin_ms);
            motion.end = Some(ended(result));
        } else if let Fact::CustodyMoved { load, to, .. } = fact {
            self.told.custody.push(SimulatedCustody {
                at_ms,
                load: load.clone(),
                to: load_location(to),
            });
        } else if let Fact::Asked { question } = fact {
            self.told.interventions.push(SimulatedQuestion {
                at_ms,
                fault: fault_name(question.fault),
                question: question.question.clone(),
                answers: question.answers.iter().map(word).collect(),
            });
        }
    }

    pub(crate) fn finish(mut self) -> Told {
        self.told.loads = self.cell.custody().iter().map(load).collect();
        self.told
    }
}
