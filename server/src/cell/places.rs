use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use journal::Position;
use serde::{Deserialize, Serialize};
use uuid::Uuid;
use workflow::{Evidence, Fact, Holder};

/// Where in the journal each job's story is, so that one job is read without reading all: some 50 bytes a job.
#[derive(Clone, Debug, Default)]
pub(crate) struct Places(Arc<Mutex<Index>>);

#[derive(Debug, Default)]
struct Index {
    spans: BTreeMap<Uuid, Span>,
    /// The jobs of operations, sessions and questions that are open.
    owners: BTreeMap<Uuid, Uuid>,
}

/// Places as they are kept with a snapshot.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct KeptPlaces {
    spans: Vec<(Uuid, Position, Position)>,
    owners: BTreeMap<Uuid, Uuid>,
}

/// The records of a job: the first, and the last that names it.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) struct Span {
    pub(crate) first: Position,
    pub(crate) last: Position,
}

impl Places {
    /// Takes note of a decision that was kept.
    pub(super) fn note<'a>(&self, position: Position, facts: impl Iterator<Item = &'a Fact>) {
        let mut index = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        for fact in facts {
            if let Some(job) = index.job_of(fact) {
                let span = index.spans.entry(job).or_insert(Span {
                    first: position,
                    last: position,
                });
                span.last = position;
            }
        }
    }

    /// What is kept of them with a snapshot.
    pub(super) fn kept(&self) -> KeptPlaces {
        let index = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let spans = index.spans.iter();
        KeptPlaces {
            spans: spans
                .map(|(job, span)| (*job, span.first, span.last))
                .collect(),
            owners: index.owners.clone(),
        }
    }

    /// As they were kept.
    pub(super) fn of_kept(kept: KeptPlaces) -> Self {
        let spans = kept.spans.into_iter();
        Self(Arc::new(Mutex::new(Index {
            spans: spans
                .map(|(job, first, last)| (job, Span { first, last }))
                .collect(),
            owners: kept.owners,
        })))
    }

    /// The first record of all jobs for which `is_open` holds, or of which an operation, a session or a question is
    /// open: their stories are read as a whole.
    pub(super) fn first_needed(&self, is_open: impl Fn(Uuid) -> bool) -> Option<Position> {
        let index = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let jobs = index.spans.keys().copied().filter(|job| is_open(*job));
        jobs.chain(index.owners.values().copied())
            .filter_map(|job| index.spans.get(&job))
            .map(|span| span.first)
            .min()
    }

    /// The records up to `last` were removed: a story without its beginning is none.
    pub(super) fn forget_through(&self, last: Position) {
        let mut index = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        index.spans.retain(|_, span| span.first > last);
    }

    /// Where a job's story is.
    pub(super) fn of(&self, job: Uuid) -> Option<Span> {
        let index = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        index.spans.get(&job).copied()
    }
}

impl Index {
    fn job_of(&mut self, fact: &Fact) -> Option<Uuid> {
        match subject(fact) {
            Subject::Job(job) => Some(job),
            Subject::Opens { job, what } => {
                let _new = self.owners.insert(what, job);
                Some(job)
            }
            Subject::Of(what) => self.owners.get(&what).copied(),
            Subject::Closes(what) => self.owners.remove(&what),
            Subject::None => None,
        }
    }
}

/// What a fact is about, as far as it belongs to a job.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Subject {
    /// The job itself.
    Job(Uuid),
    /// An operation, a session or a question of the job, the first fact of it.
    Opens { job: Uuid, what: Uuid },
    /// One that was opened before.
    Of(Uuid),
    /// The last fact of one.
    Closes(Uuid),
    /// Nothing of a job's.
    None,
}

/// What a fact is about.
pub(crate) fn subject(fact: &Fact) -> Subject {
    match fact {
        Fact::JobCreated { job, .. }
        | Fact::JobAssigned { job, .. }
        | Fact::JobMoved { job, .. }
        | Fact::FaultNoted { job, .. }
        | Fact::Planned { job, .. }
        | Fact::StepMoved { job, .. }
        | Fact::StepRedirected { job, .. }
        | Fact::StepResent { job, .. }
        | Fact::StepNeeds { job, .. }
        | Fact::ItemChanged { job, .. }
        | Fact::CompensationMoved { job, .. }
        | Fact::LoadsAccepted { job }
        | Fact::Redispatched { job }
        | Fact::ArmByHand { job, .. }
        | Fact::ArmByHandDecided { job }
        | Fact::TransportBegun { job, .. } => Subject::Job(*job),
        Fact::OpStarted { op, job, .. } => Subject::Opens {
            job: *job,
            what: *op,
        },
        Fact::SessionOpened { session, job, .. } => Subject::Opens {
            job: *job,
            what: *session,
        },
        Fact::Asked { question } => match (question.job, question.session) {
            (Some(job), _) => Subject::Opens {
                job,
                what: question.id,
            },
            (None, Some(session)) => Subject::Of(session),
            (None, None) => Subject::None,
        },
        Fact::Claimed { by, .. } | Fact::Released { by, .. } => match by {
            Holder::Job(job) => Subject::Job(*job),
            Holder::Session(session) => Subject::Of(*session),
        },
        Fact::OpDoubted { op, .. }
        | Fact::OpReconciling { op }
        | Fact::CustodyMoved {
            by: Evidence::Gripper { op },
            ..
        } => Subject::Of(*op),
        Fact::OpEnded { op, .. } => Subject::Closes(*op),
        Fact::SessionMoved { session, to, .. } if to.is_closed() => Subject::Closes(*session),
        Fact::SessionMoved { session, .. }
        | Fact::SessionHandedOn { session, .. }
        | Fact::SessionOrdered { session, .. }
        | Fact::SessionResent { session }
        | Fact::SessionRewound { session, .. }
        | Fact::MeasuredAccepted { session }
        | Fact::SessionBacksOut { session }
        | Fact::SessionLeft { session } => Subject::Of(*session),
        Fact::Told { session, .. } => session.map_or(Subject::None, Subject::Of),
        Fact::Signaled { signal, .. } => signal.session.map_or(Subject::None, Subject::Of),
        Fact::Answered { intervention, .. } | Fact::Withdrawn { intervention, .. } => {
            Subject::Closes(*intervention)
        }
        Fact::CustodyMoved { .. }
        | Fact::Recovered
        | Fact::SetupChanged { .. }
        | Fact::ArmStopped { .. }
        | Fact::SafeDue { .. }
        | Fact::OutboxTaken { .. }
        | Fact::SignalsLost { .. }
        | Fact::TriggerSkipped { .. }
        | Fact::InstantActed { .. }
        | Fact::Beat { .. }
        | Fact::TransportEnded { .. }
        | Fact::LoadRegistered { .. }
        | Fact::TimerExpired { .. }
        | Fact::ArmSeen(_)
        | Fact::ArmLost { .. }
        | Fact::MobileLost { .. }
        | Fact::OpPlanned { .. }
        | Fact::ControlChanged { .. }
        | Fact::JournalChanged { .. } => Subject::None,
    }
}
