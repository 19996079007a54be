//! What a job of a private server did, from that server's journal.

use api::{JobReport, Load, SimulatedCustody, SimulatedMotion, SimulatedPermit, SimulatedQuestion};
use jiff::Timestamp;
use thiserror::Error;
use uuid::Uuid;

use crate::jobs;
use crate::journal::SharedJournal;

/// What a simulated job did. Its milliseconds count from the job's creation.
#[derive(Clone, Debug, PartialEq)]
pub struct SimulatedStory {
    /// As that of a real job.
    pub report: JobReport,
    /// What the arms did.
    pub motions: Vec<SimulatedMotion>,
    /// Changes of permits.
    pub permits: Vec<SimulatedPermit>,
    /// Loads that moved.
    pub custody: Vec<SimulatedCustody>,
    /// Questions to people.
    pub interventions: Vec<SimulatedQuestion>,
    /// Where the loads are at the end.
    pub loads: Vec<Load>,
}

/// The journal of a simulation cannot be read.
#[derive(Debug, Error)]
#[error("the journal of the simulation cannot be read: {reason}")]
pub struct StoryError {
    reason: String,
}

/// Reads what a job did out of the journal of the server that ran it, alone in its cell.
///
/// # Errors
/// The journal cannot be read, or has no such job.
pub async fn simulated_story(
    journal: &SharedJournal,
    cell: &str,
    job: Uuid,
    now: Timestamp,
) -> Result<SimulatedStory, StoryError> {
    let unreadable = |reason: &str| StoryError {
        reason: reason.to_owned(),
    };
    let chapters = jobs::all_chapters(journal, cell)
        .await
        .map_err(|problem| unreadable(problem.detail()))?;
    let mut telling = jobs::Telling::new(job);
    for chapter in &chapters {
        telling.take(chapter);
    }
    let told = telling.finish();
    let history = jobs::History::of(job, chapters);
    if history.chapters.is_empty() {
        return Err(unreadable("it has no such job"));
    }
    Ok(SimulatedStory {
        report: jobs::report(cell, &history, (now, journal.epoch())),
        motions: told.motions,
        permits: told.permits,
        custody: told.custody,
        interventions: told.interventions,
        loads: told.loads,
    })
}
