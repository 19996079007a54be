//! What may follow what: the same rules for every store.
//!
//! A store looks up what it knows of a record's motion, job and key, asks [`judge`], and keeps the record together
//! with the [`Change`] in one transaction. The rules see no store and no clock.

use thiserror::Error;

use crate::{
    Claim, Clocks, Completion, End, Epoch, JobId, KeyRetention, MotionId, Position, Record,
    TooLarge,
};

/// How far a motion has come, as the journal knows.
#[derive(Clone, Copy, Debug, Eq, Hash, PartialEq)]
pub enum MotionPhase {
    /// There is an intent and nothing else: it may have been sent.
    Open,
    /// The controller took it, and its outcome is still to come.
    Accepted,
    /// What became of it is not known, and no one has decided.
    InDoubt,
    /// A person has decided; the outcome that follows from it is still to come.
    Decided,
    /// Its story is at an end.
    Closed,
}

/// Where the records of a motion stand.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct MotionEntry {
    /// The motion.
    pub motion: MotionId,
    /// How far it has come.
    pub phase: MotionPhase,
    /// Its intent.
    pub intent: Position,
    /// Its acceptance.
    pub accepted: Option<Position>,
    /// Its latest outcome.
    pub outcome: Option<Position>,
    /// The decision about it.
    pub decision: Option<Position>,
}

/// Where the records of a job stand.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub struct JobEntry {
    /// The job.
    pub job: JobId,
    /// Its creation.
    pub created: Position,
    /// The newest record of it.
    pub latest: Position,
    /// Its end.
    pub ended: Option<Position>,
}

/// A key that is in use.
#[derive(Clone, Debug, Eq, PartialEq)]
pub struct KeyEntry {
    /// The key and the body.
    pub claim: Claim,
    /// The record that took it.
    pub position: Position,
    /// When, in Unix milliseconds of the caller's wall clock.
    pub used_ms: i64,
    /// The motion behind it; none for a job or a decision of a cell.
    pub motion: Option<MotionId>,
}

/// Why a record was not kept. Nothing was written, and the journal goes on.
#[derive(Clone, Debug, Eq, Error, PartialEq)]
pub enum Refusal {
    /// Too long.
    #[error("the record is too long")]
    TooLarge(#[source] TooLarge),
    /// Only the journal itself writes this.
    #[error("a record of kind {kind} is written by the journal itself")]
    Reserved {
        /// The kind.
        kind: &'static str,
    },
    /// A motion is sent in the epoch of the journal or not at all.
    #[error("the intent is of epoch {found}, the journal of epoch {epoch}")]
    WrongEpoch {
        /// The intent's.
        found: Epoch,
        /// The journal's.
        epoch: Epoch,
    },
    /// There is one already.
    #[error("motion {motion} has an intent already")]
    MotionExists {
        /// The motion.
        motion: MotionId,
    },
    /// There is none.
    #[error("motion {motion} has no intent")]
    NoSuchMotion {
        /// The motion.
        motion: MotionId,
    },
    /// It does not fit what is known.
    #[error("a record of kind {kind} cannot follow: motion {motion} is {phase:?}")]
    MotionPhase {
        /// The motion.
        motion: MotionId,
        /// How far it has come.
        phase: MotionPhase,
        /// The record's kind.
        kind: &'static str,
    },
    /// There is one already.
    #[error("job {job} exists already")]
    JobExists {
        /// The job.
        job: JobId,
    },
    /// There is none.
    #[error("there is no job {job}")]
    NoSuchJob {
        /// The job.
        job: JobId,
    },
    /// Nothing follows the end.
    #[error("job {job} has ended at record {at}")]
    JobEnded {
        /// The job.
        job: JobId,
        /// Where.
        at: Position,
    },
    /// What it covers is no decision of that cell.
    #[error("record {covers} is not the decision of cell `{cell}` that the snapshot covers")]
    NotCovered {
        /// The cell.
        cell: String,
        /// The record.
        covers: Position,
    },
    /// The key was used with another body.
    #[error("the idempotency key was used with another body, at record {first}")]
    KeyReused {
        /// The record that took it.
        first: Position,
    },
    /// What the key stands for is under way.
    #[error("motion {motion}, for which the idempotency key stands, has no answer yet")]
    KeyInFlight {
        /// The motion.
        motion: MotionId,
    },
}

/// What a store knows of a record's subjects.
#[derive(Clone, Debug, Default)]
pub(crate) struct Facts {
    pub(crate) motion: Option<MotionEntry>,
    pub(crate) job: Option<JobEntry>,
    pub(crate) key: Option<KeyFacts>,
}

/// A key and how far its motion has come.
#[derive(Clone, Debug)]
pub(crate) struct KeyFacts {
    pub(crate) entry: KeyEntry,
    pub(crate) phase: Option<MotionPhase>,
}

/// What the journal knows beside the records.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Context {
    pub(crate) epoch: Epoch,
    pub(crate) keys: KeyRetention,
    pub(crate) at: Clocks,
    /// Where the record will stand.
    pub(crate) position: Position,
}

/// What to do with a record.
#[derive(Debug)]
pub(crate) enum Verdict {
    /// Keep it, and change this.
    Keep(Change),
    /// It was kept before.
    Replay(KeyEntry),
}

/// What a record changes.
#[derive(Clone, Debug, Default)]
pub(crate) struct Change {
    pub(crate) motion: Option<MotionEntry>,
    pub(crate) job: Option<JobEntry>,
    pub(crate) key: Option<KeyEntry>,
    /// A decision of this cell stands there.
    pub(crate) decided: Option<(Position, String)>,
}

pub(crate) fn wall_ms(at: &Clocks) -> i64 {
    at.wall.as_millisecond()
}

/// Whether the key stands for something, and for what.
pub(crate) fn judge_claim(
    claim: &Claim,
    known: Option<&KeyFacts>,
    keys: KeyRetention,
    now: &Clocks,
) -> Result<Option<KeyEntry>, Refusal> {
    let Some(KeyFacts { entry, phase }) = known else {
        return Ok(None);
    };
    let in_flight = *phase == Some(MotionPhase::Open);
    if !in_flight && keys.is_expired(entry.used_ms, wall_ms(now)) {
        return Ok(None);
    }
    if entry.claim.body != claim.body {
        return Err(Refusal::KeyReused {
            first: entry.position,
        });
    }
    match entry.motion {
        Some(motion) if in_flight => Err(Refusal::KeyInFlight { motion }),
        Some(_) | None => Ok(Some(entry.clone())),
    }
}

/// Decides about a record that is not [`Record::ServerStarted`].
pub(crate) fn judge(record: &Record, facts: &Facts, context: &Context) -> Result<Verdict, Refusal> {
    if let Some(claim) = record.claim() {
        let known = judge_claim(claim, facts.key.as_ref(), context.keys, &context.at)?;
        if let Some(entry) = known {
            return Ok(Verdict::Replay(entry));
        }
    }
    let mut change = Change {
        key: record.claim().map(|claim| KeyEntry {
            claim: claim.clone(),
            position: context.position,
            used_ms: wall_ms(&context.at),
            motion: record.motion(),
        }),
        decided: record
            .decided_cell()
            .map(|cell| (context.position, cell.to_owned())),
        ..Change::default()
    };
    match record {
        Record::ServerStarted(_) => {
            return Err(Refusal::Reserved {
                kind: record.kind(),
            });
        }
        Record::Intent(intent) if intent.epoch != context.epoch => {
            return Err(Refusal::WrongEpoch {
                found: intent.epoch,
                epoch: context.epoch,
            });
        }
        Record::Intent(_) | Record::Accepted(_) | Record::Outcome(_) => {
            change.motion = motion_after(record, facts.motion.as_ref(), context.position)?;
        }
        Record::Decision(_) => {
            change.motion = motion_after(record, facts.motion.as_ref(), context.position)?;
            change.job = job_after(record, facts.job.as_ref(), context.position)?;
        }
        Record::JobCreated(_) | Record::JobStep(_) | Record::JobEnded(_) => {
            change.job = job_after(record, facts.job.as_ref(), context.position)?;
        }
        // Who writes the last two has judged them.
        Record::SignalReceived(_)
        | Record::Audit(_)
        | Record::CellDecided(_)
        | Record::SnapshotTaken(_)
        | Record::Pruned(_) => {}
    }
    Ok(Verdict::Keep(change))
}

fn motion_after(
    record: &Record,
    known: Option<&MotionEntry>,
    position: Position,
) -> Result<Option<MotionEntry>, Refusal> {
    let Some(motion) = record.motion() else {
        return Ok(None);
    };
    let entry = match (record, known) {
        (Record::Intent(_), None) => {
            return Ok(Some(MotionEntry {
                motion,
                phase: MotionPhase::Open,
                intent: position,
                accepted: None,
                outcome: None,
                decision: None,
            }));
        }
        (Record::Intent(_), Some(_)) => return Err(Refusal::MotionExists { motion }),
        (_, None) => return Err(Refusal::NoSuchMotion { motion }),
        (_, Some(entry)) => *entry,
    };
    let wrong = Refusal::MotionPhase {
        motion,
        phase: entry.phase,
        kind: record.kind(),
    };
    let next = match (record, entry.phase) {
        (Record::Accepted(accepted), MotionPhase::Open) => MotionEntry {
            phase: match accepted.completion {
                Completion::Observable => MotionPhase::Accepted,
                Completion::NotObservable => MotionPhase::Closed,
            },
            accepted: Some(position),
            ..entry
        },
        (Record::Outcome(outcome), phase) if phase != MotionPhase::Closed => {
            let phase = match (&outcome.end, phase) {
                (End::InDoubt { .. }, MotionPhase::InDoubt | MotionPhase::Decided) => {
                    return Err(wrong);
                }
                (End::InDoubt { .. }, _) => MotionPhase::InDoubt,
                (
                    End::Done { .. }
                    | End::Rejected { .. }
                    | End::NotExecuted { .. }
                    | End::Interrupted { .. },
                    _,
                ) => MotionPhase::Closed,
            };
            MotionEntry {
                phase,
                outcome: Some(position),
                ..entry
            }
        }
        // One decision about each doubt: the second of two people learns that the first one has spoken.
        (Record::Decision(_), MotionPhase::InDoubt) => MotionEntry {
            phase: MotionPhase::Decided,
            decision: Some(position),
            ..entry
        },
        _ => return Err(wrong),
    };
    Ok(Some(next))
}

fn job_after(
    record: &Record,
    known: Option<&JobEntry>,
    position: Position,
) -> Result<Option<JobEntry>, Refusal> {
    let Some(job) = record.job() else {
        return Ok(None);
    };
    match (record, known) {
        (Record::JobCreated(_), None) => Ok(Some(JobEntry {
            job,
            created: position,
            latest: position,
            ended: None,
        })),
        (Record::JobCreated(_), Some(_)) => Err(Refusal::JobExists { job }),
        (_, None) => Err(Refusal::NoSuchJob { job }),
        (
            _,
            Some(JobEntry {
                ended: Some(at), ..
            }),
        ) => Err(Refusal::JobEnded { job, at: *at }),
        (record, Some(entry)) => Ok(Some(JobEntry {
            latest: position,
            ended: matches!(record, Record::JobEnded(_)).then_some(position),
            ..*entry
        })),
    }
}
