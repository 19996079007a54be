//! What an earlier process left behind: shown again, and decided as far as it can be.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::Ordering;

use api::ProblemCode;
use journal::{MotionPhase, Position, ReadError};
use uuid::Uuid;

use super::book::CAPACITY;
use super::record::{End, Record};
use super::{Motions, intent};
use crate::journal::SharedJournal;

/// Motions read at a time.
const PAGE: usize = 500;

/// Takes up the motions of earlier processes: the newest of each robot for the record, and each one without an end.
///
/// A controller of tier 0 cannot be asked what became of a motion, and an intent alone does not tell whether its bytes
/// had left: those end in doubt. Where a person had decided and the end that follows from it was not written, it is
/// written now.
///
/// # Errors
/// The journal cannot be read.
pub(crate) async fn recover(
    journal: &SharedJournal,
    robots: &[Arc<Motions>],
) -> Result<(), ReadError> {
    let by_name: BTreeMap<(&str, &str), &Arc<Motions>> = robots
        .iter()
        .map(|motions| {
            (
                (motions.plan.cell.as_str(), motions.plan.id.as_str()),
                motions,
            )
        })
        .collect();
    let mut open = 0_usize;
    for (phase, first) in [
        // What is not at its end, whatever its age, and then the newest of the others.
        (Some(MotionPhase::Decided), Position::START),
        (Some(MotionPhase::InDoubt), Position::START),
        (Some(MotionPhase::Open), Position::START),
        (Some(MotionPhase::Accepted), Position::START),
        (None, journal.head().position.next()),
    ] {
        let mut place = first;
        let mut seen = 0;
        loop {
            let entries = match phase {
                Some(phase) => journal.motions(&[phase], place, PAGE).await?,
                None => journal.latest_motions(place, PAGE).await?,
            };
            let Some(last) = entries.last() else { break };
            place = last.intent;
            seen += entries.len();
            for entry in entries {
                if phase.is_none() && entry.phase != MotionPhase::Closed {
                    continue;
                }
                let Some(story) = journal.motion(entry.motion).await? else {
                    continue;
                };
                let journal::Record::Intent(of) = &story.intent.record else {
                    continue;
                };
                let motions = by_name.get(&(of.cell.as_str(), of.robot.as_str()));
                let (Some(motions), Some(record)) = (motions, intent::restored(&story)) else {
                    if phase.is_some() {
                        tracing::warn!(
                            motion = %entry.motion,
                            cell = of.cell,
                            robot.id = of.robot,
                            "a motion without an end is of a robot the configuration does not have"
                        );
                    }
                    continue;
                };
                motions.book.restore(record.clone());
                if phase.is_some() {
                    open += 1;
                    motions.take_up(record, entry.phase, &story).await;
                }
            }
            // The newest motions of all robots together; one that is older is found by its id.
            if phase.is_none() && seen >= CAPACITY {
                break;
            }
        }
    }
    if open > 0 {
        tracing::warn!(motions = open, "motions of an earlier process had no end");
    }
    Ok(())
}

impl Motions {
    async fn take_up(&self, record: Record, phase: MotionPhase, story: &journal::MotionStory) {
        match phase {
            MotionPhase::Open | MotionPhase::Accepted => {
                let accepted = phase == MotionPhase::Accepted;
                if self.plan.completion() == api::Completion::Observable
                    && let journal::Record::Intent(intent) = &story.intent.record
                    && let Some(leftover) = self.leftover(&record, intent, accepted)
                {
                    self.leftovers().push(leftover);
                    let _before = self.recovering.fetch_add(1, Ordering::AcqRel);
                    return;
                }
                let end = End::InDoubt {
                    code: ProblemCode::ServerRestarted,
                    text: None,
                    why: Some("the server restarted before the end was known".into()),
                    seen: None,
                };
                let _at = self.end(record.id, end).await;
            }
            MotionPhase::Decided => self.apply_decision(&record, story).await,
            MotionPhase::InDoubt | MotionPhase::Closed => {}
        }
    }

    /// A motion, from the book or from the journal.
    pub(crate) async fn find(&self, id: Uuid) -> Result<Option<Record>, ReadError> {
        if let Some(record) = self.book.get(id) {
            return Ok(Some(record));
        }
        let story = self.journal.motion(journal::MotionId(id)).await?;
        Ok(story.and_then(|story| {
            let journal::Record::Intent(of) = &story.intent.record else {
                return None;
            };
            let is_ours = of.cell == self.plan.cell && of.robot == self.plan.id;
            is_ours.then(|| intent::restored(&story)).flatten()
        }))
    }
}
