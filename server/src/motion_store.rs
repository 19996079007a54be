//! What became of the motions of one robot: the last thousand, in memory.
//!
//! Motions that are not final are never forgotten; there are at most as many as the robot's queue holds, and one.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use api::{Motion, MotionState, Outcome, ProblemCode};
use jiff::Timestamp;
use uuid::{ContextV7, Uuid};

use crate::clock::WallClock;
use crate::config::RobotPlan;
use crate::request_id::RequestId;
use crate::target::{Prepared, sent_point};
use crate::wire_bodies::{joints_body, pose_body};

/// How many motions a robot remembers.
pub(crate) const CAPACITY: usize = 1_000;

/// The motions of one robot, oldest first; ids sort by creation.
#[derive(Debug)]
pub(crate) struct MotionStore {
    clock: Arc<dyn WallClock>,
    kept: Mutex<Kept>,
}

#[derive(Debug)]
struct Kept {
    ids: ContextV7,
    records: VecDeque<Record>,
}

#[derive(Clone, Debug)]
pub(crate) struct Record {
    pub(crate) id: Uuid,
    pub(crate) prepared: Prepared,
    pub(crate) created_at: Timestamp,
    pub(crate) request_id: RequestId,
    pub(crate) reason: Option<String>,
    pub(crate) progress: Progress,
}

/// How far a motion has come.
#[derive(Clone, Debug)]
pub(crate) enum Progress {
    Queued,
    Dispatched,
    Ended { at: Timestamp, end: End },
}

/// How a motion ended, as far as the server can know.
#[derive(Clone, Debug)]
pub(crate) enum End {
    Accepted,
    Rejected {
        text: &'static str,
    },
    NotExecuted {
        code: ProblemCode,
    },
    InDoubt {
        code: ProblemCode,
        text: Option<String>,
    },
}

impl MotionStore {
    pub(crate) fn new(clock: Arc<dyn WallClock>) -> Self {
        Self {
            clock,
            kept: Mutex::new(Kept {
                ids: ContextV7::new(),
                records: VecDeque::new(),
            }),
        }
    }

    /// Records a motion that is about to wait for the link.
    pub(crate) fn queue(
        &self,
        prepared: Prepared,
        request_id: RequestId,
        reason: Option<String>,
    ) -> Uuid {
        let created_at = self.clock.now();
        let mut kept = self.lock();
        let id = new_id(&kept.ids, created_at);
        if kept.records.len() >= CAPACITY {
            let oldest_ended = kept
                .records
                .iter()
                .position(|record| matches!(record.progress, Progress::Ended { .. }));
            if let Some(index) = oldest_ended {
                drop(kept.records.remove(index));
            }
        }
        kept.records.push_back(Record {
            id,
            prepared,
            created_at,
            request_id,
            reason,
            progress: Progress::Queued,
        });
        id
    }

    /// From here on bytes may be on their way.
    pub(crate) fn dispatch(&self, id: Uuid) {
        self.update(id, Progress::Dispatched);
    }

    /// Records a motion's end and returns when that was.
    pub(crate) fn end(&self, id: Uuid, end: End) -> Timestamp {
        let at = self.clock.now();
        self.update(id, Progress::Ended { at, end });
        at
    }

    pub(crate) fn get(&self, id: Uuid) -> Option<Record> {
        let kept = self.lock();
        let index = kept.position(id)?;
        kept.records.get(index).cloned()
    }

    /// Up to `limit` motions, newest first, all older than `before`, and whether there are more.
    pub(crate) fn page(&self, before: Option<Uuid>, limit: usize) -> (Vec<Record>, bool) {
        let kept = self.lock();
        let mut older = kept
            .records
            .iter()
            .rev()
            .skip_while(|record| before.is_some_and(|before| record.id >= before));
        let page: Vec<_> = older.by_ref().take(limit).cloned().collect();
        (page, older.next().is_some())
    }

    fn update(&self, id: Uuid, progress: Progress) {
        let mut kept = self.lock();
        if let Some(index) = kept.position(id)
            && let Some(record) = kept.records.get_mut(index)
        {
            record.progress = progress;
        }
    }

    fn lock(&self) -> MutexGuard<'_, Kept> {
        // A panic while the lock is held leaves the records as they are: each change is one assignment.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Kept {
    fn position(&self, id: Uuid) -> Option<usize> {
        // The motion asked for is the newest one in nearly every call.
        match self.records.back() {
            Some(newest) if newest.id == id => Some(self.records.len() - 1),
            _ => self
                .records
                .binary_search_by(|record| record.id.cmp(&id))
                .ok(),
        }
    }
}

impl Record {
    /// The resource as the API shows it.
    pub(crate) fn body(&self, plan: &RobotPlan) -> Motion {
        let (state, ended_at, controller_text, code, outcome) = match &self.progress {
            Progress::Queued => (MotionState::Queued, None, None, None, None),
            Progress::Dispatched => (MotionState::Dispatched, None, None, None, None),
            Progress::Ended { at, end } => {
                let (state, text, code, outcome) = match end {
                    End::Accepted => (
                        MotionState::Accepted,
                        Some(protocol::Reply::Accepted.text().to_owned()),
                        None,
                        None,
                    ),
                    End::Rejected { text } => (
                        MotionState::Rejected,
                        Some((*text).to_owned()),
                        Some(ProblemCode::ControllerRejected),
                        Some(Outcome::Rejected),
                    ),
                    End::NotExecuted { code } => (
                        MotionState::NotExecuted,
                        None,
                        Some(*code),
                        Some(Outcome::NotSent),
                    ),
                    End::InDoubt { code, text } => (
                        MotionState::InDoubt,
                        text.clone(),
                        Some(*code),
                        Some(Outcome::Unknown),
                    ),
                };
                (state, Some(*at), text, code, outcome)
            }
        };
        Motion {
            id: self.id,
            cell: plan.cell.clone(),
            robot: plan.id.clone(),
            motion_type: self.prepared.motion_type,
            state,
            completion: api::Completion::NotObservable,
            tier: plan.tier,
            target: pose_body(&sent_point(&self.prepared.wire)),
            expected_joints: joints_body(&self.prepared.joints),
            speed_mm_s: self.prepared.wire.command().speed.0,
            created_at: self.created_at,
            ended_at,
            controller_text,
            code,
            outcome,
            request_id: self.request_id.to_string(),
            reason: self.reason.clone(),
        }
    }
}

fn new_id(ids: &ContextV7, at: Timestamp) -> Uuid {
    let seconds = u64::try_from(at.as_second()).unwrap_or(0);
    let nanos = u32::try_from(at.subsec_nanosecond()).unwrap_or(0);
    Uuid::new_v7(uuid::Timestamp::from_unix(ids, seconds, nanos))
}

#[cfg(test)]
mod tests {
    use axum::http::HeaderMap;
    use kinematics::ArmModel;
    use protocol::MoveCommand;
    use units::{Degrees, Millimeters, MmPerSec};

    use super::*;

    /// A clock that goes backwards.
    #[derive(Debug)]
    struct Backwards(Mutex<i64>);

    impl WallClock for Backwards {
        fn now(&self) -> Timestamp {
            let mut second = self.0.lock().unwrap();
            *second -= 1;
            Timestamp::from_second(*second).unwrap()
        }
    }

    fn store() -> MotionStore {
        MotionStore::new(Arc::new(Backwards(Mutex::new(1_800_000_000))))
    }

    fn queue(store: &MotionStore) -> Uuid {
        let wire = MoveCommand {
            x: Millimeters(1.0),
            y: Millimeters(2.0),
            z: Millimeters(3.0),
            w: Degrees(4.0),
            p: Degrees(5.0),
            r: Degrees(6.0),
            speed: MmPerSec(7.0),
        };
        let prepared = Prepared {
            motion_type: api::MotionType::Joint,
            wire: wire.to_wire().unwrap(),
            joints: ArmModel::builtin("fanuc-m20ia").unwrap().home(),
        };
        let request_id = RequestId::of(&HeaderMap::new(), || Timestamp::UNIX_EPOCH);
        store.queue(prepared, request_id, None)
    }

    #[test]
    fn ids_sort_by_creation_even_where_the_clock_goes_backwards() {
        let store = store();
        let ids: Vec<_> = (0..100).map(|_| queue(&store)).collect();
        assert!(ids.is_sorted());
        assert!(ids.iter().all(|id| store.get(*id).is_some()));
    }

    #[test]
    fn the_oldest_motion_that_ended_is_forgotten_and_one_that_has_not_is_kept() {
        let store = store();
        let pending = queue(&store);
        let ended: Vec<_> = (1..CAPACITY).map(|_| queue(&store)).collect();
        for id in &ended {
            let _at = store.end(*id, End::Accepted);
        }
        let newest = queue(&store);
        assert!(store.get(pending).is_some());
        assert!(store.get(ended[0]).is_none());
        assert!(store.get(ended[1]).is_some());
        let (all, more) = store.page(None, CAPACITY + 1);
        assert_eq!((all.len(), more), (CAPACITY, false));
        assert_eq!(all[0].id, newest);
    }

    #[test]
    fn a_page_goes_on_where_the_one_before_ended() {
        let store = store();
        let ids: Vec<_> = (0..3).map(|_| queue(&store)).collect();
        let (page, more) = store.page(None, 2);
        assert_eq!((page[0].id, page[1].id, more), (ids[2], ids[1], true));
        let (page, more) = store.page(Some(ids[1]), 2);
        assert_eq!((page.len(), page[0].id, more), (1, ids[0], false));
    }
}
