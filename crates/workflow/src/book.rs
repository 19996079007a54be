//! The two halves of the state: what facts say (durable), and what is seen right now (volatile).

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use uuid::Uuid;

use crate::claims::Claims;
use crate::custody::Custody;
use crate::effect::Action;
use crate::ids::Millis;
use crate::input::ArmSeen;
use crate::intervention::Intervention;
use crate::job::{Job, JobState};
use crate::session::Session;
use crate::signal::{MobileState, OutMessage, Signal, SignalAnswer};
use crate::timers::{Running, TimerKey};

/// How many closed jobs, sessions and interventions, and how many messages, are remembered.
pub(crate) const REMEMBERED: usize = 256;

/// Where an operation is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum OpState {
    /// It was handed to the arm.
    Running,
    /// Nobody knows.
    Doubt,
    /// The truth is being read.
    Reconciling,
}

/// An operation that has not ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct Op {
    pub job: Uuid,
    pub step: usize,
    pub arm: String,
    pub action: Action,
    pub state: OpState,
}

/// A drive with loads to a destination.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Transport {
    pub job: Uuid,
    pub order: Uuid,
    pub destination: String,
    pub session: Option<Uuid>,
    pub update: u32,
}

/// What is kept of a mobile robot.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Mobile {
    pub boot: u64,
    pub seq: u64,
    pub answers: VecDeque<(u64, SignalAnswer)>,
    pub parked: Option<Signal>,
    /// Numbers of this boot that were given up, from and to.
    pub lost: VecDeque<(u64, u64)>,
    pub sent: u64,
    pub outbox: VecDeque<OutMessage>,
    pub transport: Option<Transport>,
}

impl Mobile {
    pub(crate) fn remember(&mut self, seq: u64, answer: SignalAnswer) {
        self.answers.push_back((seq, answer));
        if self.answers.len() > 64 {
            drop(self.answers.pop_front());
        }
    }
}

/// Everything that facts say. Equal facts make equal books.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Book {
    /// How many jobs, sessions and questions there were: each kind has its own numbers.
    pub jobs_created: u64,
    pub sessions_created: u64,
    pub questions_asked: u64,
    pub jobs: BTreeMap<Uuid, Arc<Job>>,
    pub sessions: BTreeMap<Uuid, Arc<Session>>,
    pub ops: BTreeMap<Uuid, Op>,
    pub mobiles: BTreeMap<String, Arc<Mobile>>,
    pub custody: Arc<Custody>,
    /// Loads that left the cell, the oldest first; those that came back since are passed over.
    #[serde(default)]
    pub delivered: VecDeque<String>,
    pub claims: Claims,
    pub interventions: BTreeMap<Uuid, Arc<Intervention>>,
}

/// What was seen of a mobile robot in this process.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct MobileLive {
    pub state: Option<MobileState>,
    /// When that came, and when it says that it sent it.
    pub seen_at: Option<Millis>,
    pub told_at: Option<i64>,
    /// Its pose went farther than it can drive, since it was last told to dock.
    pub jump: Option<Jump>,
    /// Signals since it was last lost.
    pub beats: u64,
    /// All signals; re-arms the heartbeat timer.
    pub count: u64,
    /// The heartbeat timer ran out, and too few have come since.
    pub lost: bool,
    /// The last number it used, heartbeats included.
    pub boot: u64,
    pub seq: u64,
    /// Its numbering is followed; not right after a restart, because heartbeats are not kept.
    pub synced: bool,
}

/// A way between two signals that nobody can have driven in the time between them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Jump {
    pub distance_mm: f64,
    pub within_ms: u64,
    pub max_speed_mm_s: u32,
}

impl fmt::Display for Jump {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            distance_mm,
            within_ms,
            max_speed_mm_s,
        } = self;
        write!(
            f,
            "its pose went {distance_mm:.0} mm within {within_ms} ms, and it drives at most {max_speed_mm_s} mm/s: it does not know where it is"
        )
    }
}

/// What was seen of an arm in this process.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ArmLive {
    pub seen: ArmSeen,
    pub count: u64,
    /// Told to stop, and not seen still since.
    pub stopping: bool,
}

/// A wait.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Wait {
    pub running: Running,
    /// If this changes, the wait begins anew.
    pub stamp: u64,
    pub fired: bool,
}

/// Everything that is only true right now.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Live {
    pub recovered: bool,
    pub jobs_may_act: bool,
    pub unwritable: bool,
    pub arms: BTreeMap<String, ArmLive>,
    pub mobiles: BTreeMap<String, Arc<MobileLive>>,
    pub planned: BTreeMap<Uuid, u64>,
    /// Arms that have to be out or still soon (`T_safe`).
    pub safe: BTreeMap<String, u64>,
    pub timers: BTreeMap<TimerKey, Wait>,
}

impl Book {
    pub(crate) fn open_session_of(&self, mobile_robot: &str) -> Option<&Arc<Session>> {
        self.sessions
            .values()
            .find(|s| s.mobile_robot == mobile_robot && !s.state.is_closed())
    }

    pub(crate) fn question_of(&self, job: Uuid) -> Option<&Arc<Intervention>> {
        self.interventions
            .values()
            .find(|i| i.is_open() && i.question.job == Some(job) && i.question.session.is_none())
    }

    pub(crate) fn question_of_session(&self, session: Uuid) -> Option<&Arc<Intervention>> {
        self.interventions
            .values()
            .find(|i| i.is_open() && i.question.session == Some(session))
    }

    /// Forgets the oldest of what is closed.
    pub(crate) fn forget(&mut self) {
        let jobs: Vec<_> = closed(&self.jobs, |j| j.state.is_final(), |j| j.number);
        let sessions: Vec<_> = closed(&self.sessions, |s| s.state.is_closed(), |s| s.number);
        let questions: Vec<_> = closed(&self.interventions, |i| !i.is_open(), |i| i.number);
        for id in jobs {
            drop(self.jobs.remove(&id));
        }
        for id in sessions {
            drop(self.sessions.remove(&id));
        }
        for id in questions {
            drop(self.interventions.remove(&id));
        }
    }

    pub(crate) fn is_live(&self, job: Uuid) -> bool {
        self.jobs
            .get(&job)
            .is_some_and(|j| !j.state.is_final() && j.state != JobState::Idle)
    }
}

fn closed<T>(
    all: &BTreeMap<Uuid, Arc<T>>,
    is_closed: impl Fn(&T) -> bool,
    number: impl Fn(&T) -> u64,
) -> Vec<Uuid> {
    if all.len() <= REMEMBERED {
        return Vec::new();
    }
    let mut ids: Vec<_> = all
        .iter()
        .filter(|(_, t)| is_closed(t))
        .map(|(id, t)| (number(t), *id))
        .collect();
    ids.sort_unstable();
    let surplus = all.len() - REMEMBERED;
    ids.into_iter().take(surplus).map(|(_, id)| id).collect()
}
