//! What became of the motions of one robot: the last thousand, in memory.
//!
//! It is what every read and every wait looks at; what must survive is in the journal. Motions that are not final are
//! never forgotten; there are at most as many as the robot's queue holds, and one. A motion in doubt is forgotten
//! last.

use std::collections::{BTreeSet, VecDeque};
use std::sync::{Mutex, MutexGuard, PoisonError};

use jiff::{SignedDuration, Timestamp};
use tokio::sync::watch;
use tokio::time::{Instant, timeout_at};
use uuid::{ContextV7, Uuid};

use super::record::{Asked, Progress, Record};
use crate::request_id::RequestId;

/// How many motions a robot remembers.
pub(crate) const CAPACITY: usize = 1_000;

/// The motions of one robot, oldest first; ids sort by creation.
#[derive(Debug)]
pub(crate) struct Book {
    kept: Mutex<Kept>,
    /// One more at each change: the revision of what is known here.
    changed: watch::Sender<u64>,
}

#[derive(Debug)]
struct Kept {
    ids: ContextV7,
    /// No id is older than this: the wall clock may have been set back while the server was down.
    floor: Timestamp,
    records: VecDeque<Record>,
    doubts: BTreeSet<Uuid>,
}

/// A motion that is about to be entered.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) asked: Asked,
    pub(crate) request_id: RequestId,
    pub(crate) principal: std::sync::Arc<str>,
    pub(crate) reason: Option<String>,
    pub(crate) not_after: Option<Timestamp>,
}

impl Default for Book {
    fn default() -> Self {
        Self {
            kept: Mutex::new(Kept {
                ids: ContextV7::new(),
                floor: Timestamp::UNIX_EPOCH,
                records: VecDeque::new(),
                doubts: BTreeSet::new(),
            }),
            changed: watch::Sender::new(0),
        }
    }
}

impl Book {
    /// A name for a motion; later ones sort behind it.
    pub(crate) fn new_id(&self, at: Timestamp) -> Uuid {
        self.lock().new_id(at)
    }

    /// Enters a motion that is about to wait for the link, under a name of [`Self::new_id`] that the
    /// journal knows, or under a new one.
    pub(crate) fn enter(&self, entry: Entry, id: Option<Uuid>, created_at: Timestamp) -> Uuid {
        let in_journal = id.is_some();
        let id = {
            let mut kept = self.lock();
            let id = id.unwrap_or_else(|| kept.new_id(created_at));
            kept.make_room();
            kept.insert(Record {
                id,
                asked: entry.asked,
                created_at,
                request_id: entry.request_id,
                principal: entry.principal,
                reason: entry.reason,
                not_after: entry.not_after,
                progress: Progress::Queued,
                decision: None,
                in_journal,
            });
            id
        };
        self.tell();
        id
    }

    /// Takes up a motion of an earlier process.
    pub(crate) fn restore(&self, record: Record) {
        let mut kept = self.lock();
        // A millisecond on: within one, the order of ids is only known to the process that made them.
        let after = SignedDuration::from_millis(1);
        let behind = record
            .created_at
            .checked_add(after)
            .unwrap_or(record.created_at);
        kept.floor = kept.floor.max(behind);
        if record.progress.is_in_doubt() {
            let _new = kept.doubts.insert(record.id);
        }
        kept.make_room();
        kept.insert(record);
        drop(kept);
        self.tell();
    }

    /// Changes a motion's progress if `change` says how, and returns whether it did.
    pub(crate) fn update(
        &self,
        id: Uuid,
        change: impl FnOnce(&Progress) -> Option<Progress>,
    ) -> bool {
        let changed = self.lock().update(id, change);
        if changed {
            self.tell();
        }
        changed
    }

    /// Changes a record as a whole.
    pub(crate) fn amend(&self, id: Uuid, change: impl FnOnce(&mut Record)) {
        {
            let mut kept = self.lock();
            let Some(index) = kept.position(id) else {
                return;
            };
            if let Some(record) = kept.records.get_mut(index) {
                change(record);
                let in_doubt = record.progress.is_in_doubt();
                kept.note_doubt(id, in_doubt);
            }
        }
        self.tell();
    }

    pub(crate) fn get(&self, id: Uuid) -> Option<Record> {
        self.look(id, Record::clone)
    }

    /// What `look` sees in a motion.
    pub(crate) fn look<T>(&self, id: Uuid, look: impl FnOnce(&Record) -> T) -> Option<T> {
        let kept = self.lock();
        let index = kept.position(id)?;
        kept.records.get(index).map(look)
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

    /// The motions in doubt nobody has decided about, oldest first.
    pub(crate) fn doubts(&self) -> Vec<Record> {
        let kept = self.lock();
        let ids = kept.doubts.iter();
        ids.filter_map(|id| kept.records.get(kept.position(*id)?))
            .cloned()
            .collect()
    }

    pub(crate) fn first_doubt(&self) -> Option<Uuid> {
        self.lock().doubts.first().copied()
    }

    /// The motions that wait for the link.
    pub(crate) fn queued(&self) -> Vec<Uuid> {
        self.those(|progress| matches!(progress, Progress::Queued))
    }

    /// The motions that are not at their end.
    pub(crate) fn open(&self) -> Vec<Uuid> {
        self.those(|progress| progress.end().is_none())
    }

    /// How often anything here has changed.
    pub(crate) fn revision(&self) -> u64 {
        *self.changed.borrow()
    }

    /// Waits until `done` is true of a motion, or until `limit`; returns the motion as it is then.
    pub(crate) async fn wait(
        &self,
        id: Uuid,
        limit: Instant,
        done: impl Fn(&Progress) -> bool,
    ) -> Option<Record> {
        let mut changes = self.changed.subscribe();
        loop {
            drop(changes.borrow_and_update());
            let record = self.get(id)?;
            if done(&record.progress) || timeout_at(limit, changes.changed()).await.is_err() {
                return Some(record);
            }
        }
    }

    fn those(&self, which: impl Fn(&Progress) -> bool) -> Vec<Uuid> {
        let kept = self.lock();
        let records = kept.records.iter();
        records
            .filter(|record| which(&record.progress))
            .map(|record| record.id)
            .collect()
    }

    fn tell(&self) {
        self.changed.send_modify(|revision| *revision += 1);
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

    fn insert(&mut self, record: Record) {
        // Nearly always at the end: two motions may wait for the journal in another order than they got their names.
        match self
            .records
            .binary_search_by(|known| known.id.cmp(&record.id))
        {
            Ok(_) => {}
            Err(index) => self.records.insert(index, record),
        }
    }

    fn update(&mut self, id: Uuid, change: impl FnOnce(&Progress) -> Option<Progress>) -> bool {
        let Some(index) = self.position(id) else {
            return false;
        };
        let Some(record) = self.records.get_mut(index) else {
            return false;
        };
        let Some(progress) = change(&record.progress) else {
            return false;
        };
        let in_doubt = progress.is_in_doubt();
        record.progress = progress;
        self.note_doubt(id, in_doubt);
        true
    }

    fn note_doubt(&mut self, id: Uuid, in_doubt: bool) {
        if in_doubt {
            let _new = self.doubts.insert(id);
        } else if !self.doubts.is_empty() {
            let _was = self.doubts.remove(&id);
        }
    }

    fn make_room(&mut self) {
        if self.records.len() < CAPACITY {
            return;
        }
        let find = |which: &dyn Fn(&Progress) -> bool| {
            self.records
                .iter()
                .position(|record| which(&record.progress))
        };
        let oldest = find(&|progress| progress.end().is_some() && !progress.is_in_doubt())
            .or_else(|| find(&|progress| progress.end().is_some()));
        if let Some(record) = oldest.and_then(|index| self.records.remove(index)) {
            self.note_doubt(record.id, false);
        }
    }

    fn new_id(&mut self, at: Timestamp) -> Uuid {
        let at = at.max(self.floor);
        let seconds = u64::try_from(at.as_second()).unwrap_or(0);
        let nanos = u32::try_from(at.subsec_nanosecond()).unwrap_or(0);
        Uuid::new_v7(uuid::Timestamp::from_unix(&self.ids, seconds, nanos))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use axum::http::HeaderMap;
    use kinematics::ArmModel;

    use super::super::record::{End, Speed};
    use super::*;

    fn enter(book: &Book, second: i64) -> Uuid {
        let entry = Entry {
            asked: Asked {
                motion_type: api::MotionType::Joint,
                point: [1_000, 2_000, 3_000, 4_000, 5_000, 6_000],
                speed: Speed::MmPerSec(7),
                joints: ArmModel::builtin("fanuc-m20ia").unwrap().home(),
                to_joints: false,
                output: None,
                from: None,
            },
            request_id: RequestId::of(&HeaderMap::new(), || Timestamp::UNIX_EPOCH),
            principal: Arc::from("local"),
            reason: None,
            not_after: None,
        };
        book.enter(entry, None, Timestamp::from_second(second).unwrap())
    }

    fn end(book: &Book, id: Uuid, end: End) {
        let at = Timestamp::UNIX_EPOCH;
        assert!(book.update(id, |_| Some(Progress::Ended { at, end })));
    }

    fn doubt() -> End {
        End::InDoubt {
            code: api::ProblemCode::ControllerTimeout,
            text: None,
            why: None,
            seen: None,
        }
    }

    /// T1: the wall clock goes backwards, by a second each time and by a day at the restart.
    #[test]
    fn ids_sort_by_creation_even_where_the_clock_goes_backwards() {
        let book = Book::default();
        let ids: Vec<_> = (0..100).rev().map(|s| enter(&book, 1_000 + s)).collect();
        assert!(ids.is_sorted());
        assert!(ids.iter().all(|id| book.get(*id).is_some()));
        let after_a_restart = Book::default();
        let mut old = book.get(ids[99]).unwrap();
        old.created_at = Timestamp::from_second(200_000).unwrap();
        old.id = Book::default().new_id(old.created_at);
        after_a_restart.restore(old.clone());
        assert!(enter(&after_a_restart, 100_000) > old.id);
    }

    #[test]
    fn the_oldest_motion_that_ended_is_forgotten_and_one_that_has_not_or_is_in_doubt_is_kept() {
        let book = Book::default();
        let (pending, doubtful) = (enter(&book, 1), enter(&book, 1));
        end(&book, doubtful, doubt());
        let ended: Vec<_> = (2..CAPACITY).map(|_| enter(&book, 1)).collect();
        for id in &ended {
            end(&book, *id, End::Accepted);
        }
        let newest = enter(&book, 1);
        assert!(book.get(pending).is_some());
        assert_eq!(book.first_doubt(), Some(doubtful));
        assert!(book.get(ended[0]).is_none());
        assert!(book.get(ended[1]).is_some());
        let (all, more) = book.page(None, CAPACITY + 1);
        assert_eq!((all.len(), more), (CAPACITY, false));
        assert_eq!(all[0].id, newest);
    }

    #[test]
    fn a_page_goes_on_where_the_one_before_ended() {
        let book = Book::default();
        let ids: Vec<_> = (0..3).map(|_| enter(&book, 1)).collect();
        let (page, more) = book.page(None, 2);
        assert_eq!((page[0].id, page[1].id, more), (ids[2], ids[1], true));
        let (page, more) = book.page(Some(ids[1]), 2);
        assert_eq!((page.len(), page[0].id, more), (1, ids[0], false));
    }

    #[tokio::test(start_paused = true)]
    async fn whoever_waits_for_a_motion_sees_its_end_or_the_time_run_out() {
        let book = Arc::new(Book::default());
        let id = enter(&book, 1);
        let limit = || Instant::now() + std::time::Duration::from_secs(1);
        let ended = |progress: &Progress| progress.end().is_some();
        let late = book.wait(id, limit(), ended).await.unwrap();
        assert!(late.progress.end().is_none());
        let (record, ()) = tokio::join!(book.wait(id, limit(), ended), async {
            end(&book, id, End::Accepted);
        });
        assert!(record.unwrap().progress.end().is_some());
    }
}
