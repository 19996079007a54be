//! What became of the motions of one robot: the last thousand, in memory.
//!
//! It is what every read and every wait looks at; what must survive is in the journal. Motions that are not final are
//! never forgotten; there are at most as many as the robot's queue holds, and one. A motion in doubt is forgotten
//! last.

use std::collections::{BTreeSet, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use jiff::{SignedDuration, Timestamp};
use tokio::sync::Notify;
use tokio::time::{Instant, timeout_at};
use uuid::{ContextV7, Uuid};

use super::record::{Asked, End, Progress, Record};
use crate::request_id::RequestId;

/// How many motions a robot remembers.
pub(crate) const CAPACITY: usize = 1_000;

/// The motions of one robot, oldest first; ids sort by creation.
#[derive(Debug)]
pub(crate) struct Book {
    kept: Mutex<Kept>,
}

#[derive(Debug)]
struct Kept {
    ids: ContextV7,
    /// No id is older than this: the wall clock may have been set back while the server was down.
    floor: Timestamp,
    slots: VecDeque<Slot>,
    doubts: BTreeSet<Uuid>,
    /// One more at each change: the revision of what is known here.
    revision: u64,
}

/// A motion and those who wait for it: a change wakes nobody who waits for another motion.
#[derive(Debug)]
struct Slot {
    record: Record,
    changed: Arc<Notify>,
}

/// A motion that is about to be entered.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub(crate) asked: Asked,
    pub(crate) request_id: RequestId,
    pub(crate) principal: Arc<str>,
    pub(crate) reason: Option<String>,
    pub(crate) not_after: Option<Timestamp>,
}

impl Default for Book {
    fn default() -> Self {
        Self {
            kept: Mutex::new(Kept {
                ids: ContextV7::new(),
                floor: Timestamp::UNIX_EPOCH,
                slots: VecDeque::new(),
                doubts: BTreeSet::new(),
                revision: 0,
            }),
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
    }

    /// Takes up a motion of an earlier process.
    pub(crate) fn restore(&self, record: Record) {
        let mut kept = self.lock();
        // By the id, which is later than the record where the clock had gone back; and a millisecond on: within one, the
        // order of ids is only known to the process that made them.
        let named = named_at(record.id).unwrap_or(record.created_at);
        let behind = named.max(record.created_at);
        let behind = behind
            .checked_add(SignedDuration::from_millis(1))
            .unwrap_or(behind);
        kept.floor = kept.floor.max(behind);
        if record.progress.is_in_doubt() {
            let _new = kept.doubts.insert(record.id);
        }
        kept.make_room();
        kept.insert(record);
    }

    /// Changes a motion's progress if `change` says how, and returns whether it did.
    pub(crate) fn update(
        &self,
        id: Uuid,
        change: impl FnOnce(&Progress) -> Option<Progress>,
    ) -> bool {
        self.lock().update(id, change)
    }

    /// Changes a record as a whole.
    pub(crate) fn amend(&self, id: Uuid, change: impl FnOnce(&mut Record)) {
        let _is_known = self.lock().amend(id, |record| {
            change(record);
            true
        });
    }

    pub(crate) fn get(&self, id: Uuid) -> Option<Record> {
        self.look(id, Record::clone)
    }

    /// What `look` sees in a motion.
    pub(crate) fn look<T>(&self, id: Uuid, look: impl FnOnce(&Record) -> T) -> Option<T> {
        let kept = self.lock();
        let index = kept.position(id)?;
        kept.slots.get(index).map(|slot| look(&slot.record))
    }

    /// Up to `limit` motions, newest first, all older than `before`, and whether there are more.
    pub(crate) fn page(&self, before: Option<Uuid>, limit: usize) -> (Vec<Record>, bool) {
        let kept = self.lock();
        let mut older = kept
            .slots
            .iter()
            .rev()
            .map(|slot| &slot.record)
            .skip_while(|record| before.is_some_and(|before| record.id >= before));
        let page: Vec<_> = older.by_ref().take(limit).cloned().collect();
        (page, older.next().is_some())
    }

    /// The motions in doubt nobody has decided about, oldest first.
    pub(crate) fn doubts(&self) -> Vec<Record> {
        let kept = self.lock();
        let ids = kept.doubts.iter();
        ids.filter_map(|id| kept.slots.get(kept.position(*id)?))
            .map(|slot| slot.record.clone())
            .collect()
    }

    pub(crate) fn first_doubt(&self) -> Option<Uuid> {
        self.lock().doubts.first().copied()
    }

    /// The newest motion of `principal` that may have moved the arm, and how it ended. `None` while any motion is
    /// under way, and where there was none.
    pub(crate) fn left_by(&self, principal: &str) -> Option<(Uuid, Asked, End)> {
        let kept = self.lock();
        let newest_first = || kept.slots.iter().rev().map(|slot| &slot.record);
        if newest_first().any(|record| record.progress.end().is_none()) {
            return None;
        }
        newest_first()
            .filter(|record| &*record.principal == principal && record.asked.output.is_none())
            .find_map(|record| match record.progress.end()? {
                // The arm stayed where it was.
                End::Rejected { .. } | End::NotExecuted { .. } => None,
                end @ (End::Accepted
                | End::Succeeded { .. }
                | End::Interrupted { .. }
                | End::InDoubt { .. }) => Some((record.id, record.asked, end.clone())),
            })
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
        self.lock().revision
    }

    /// Waits until `done` is true of a motion, or until `limit`; returns the motion as it is then.
    pub(crate) async fn wait(
        &self,
        id: Uuid,
        limit: Instant,
        done: impl Fn(&Progress) -> bool,
    ) -> Option<Record> {
        let wake_up = self.lock().wake_up(id)?;
        loop {
            // Counts from here on: a change between the look and the wait is not missed.
            let changed = wake_up.notified();
            let record = self.look(id, |record| done(&record.progress).then(|| record.clone()))?;
            if record.is_some() {
                return record;
            }
            if timeout_at(limit, changed).await.is_err() {
                return self.get(id);
            }
        }
    }

    fn those(&self, which: impl Fn(&Progress) -> bool) -> Vec<Uuid> {
        let kept = self.lock();
        let records = kept.slots.iter().map(|slot| &slot.record);
        records
            .filter(|record| which(&record.progress))
            .map(|record| record.id)
            .collect()
    }

    fn lock(&self) -> MutexGuard<'_, Kept> {
        // A panic while the lock is held leaves the records as they are: each change is one assignment.
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Kept {
    fn position(&self, id: Uuid) -> Option<usize> {
        self.place_of(id).ok()
    }

    /// Where a motion is, or would be. Nearly every call is about one of the newest, so the search begins there and
    /// goes back in steps that double: the slots of a thousand motions are not all in the cache.
    fn place_of(&self, id: Uuid) -> Result<usize, usize> {
        let older = |index: usize| {
            self.slots
                .get(index)
                .is_some_and(|slot| slot.record.id < id)
        };
        let (mut end, mut step) = (self.slots.len(), 1);
        let mut begin = end.saturating_sub(step);
        while begin > 0 && !older(begin) {
            end = begin + 1;
            step *= 2;
            begin = begin.saturating_sub(step);
        }
        while begin < end {
            let middle = begin.midpoint(end);
            if older(middle) {
                begin = middle + 1;
            } else {
                end = middle;
            }
        }
        match self.slots.get(begin) {
            Some(slot) if slot.record.id == id => Ok(begin),
            Some(_) | None => Err(begin),
        }
    }

    fn wake_up(&self, id: Uuid) -> Option<Arc<Notify>> {
        let slot = self.slots.get(self.position(id)?)?;
        Some(Arc::clone(&slot.changed))
    }

    fn insert(&mut self, record: Record) {
        // Nearly always at the end: two motions may wait for the journal in another order than they got their names.
        if let Err(index) = self.place_of(record.id) {
            let changed = Arc::default();
            self.slots.insert(index, Slot { record, changed });
            self.revision += 1;
        }
    }

    fn update(&mut self, id: Uuid, change: impl FnOnce(&Progress) -> Option<Progress>) -> bool {
        self.amend(id, |record| match change(&record.progress) {
            Some(progress) => {
                record.progress = progress;
                true
            }
            None => false,
        })
    }

    /// Changes a record and tells those who wait for it, if `change` says that it did.
    fn amend(&mut self, id: Uuid, change: impl FnOnce(&mut Record) -> bool) -> bool {
        let Some(index) = self.position(id) else {
            return false;
        };
        let Some(slot) = self.slots.get_mut(index) else {
            return false;
        };
        if !change(&mut slot.record) {
            return false;
        }
        slot.changed.notify_waiters();
        let in_doubt = slot.record.progress.is_in_doubt();
        self.revision += 1;
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
        if self.slots.len() < CAPACITY {
            return;
        }
        let find = |which: &dyn Fn(&Progress) -> bool| {
            self.slots
                .iter()
                .position(|slot| which(&slot.record.progress))
        };
        let oldest = find(&|progress| progress.end().is_some() && !progress.is_in_doubt())
            .or_else(|| find(&|progress| progress.end().is_some()));
        if let Some(slot) = oldest.and_then(|index| self.slots.remove(index)) {
            slot.changed.notify_waiters();
            self.note_doubt(slot.record.id, false);
        }
    }

    fn new_id(&mut self, at: Timestamp) -> Uuid {
        let at = at.max(self.floor);
        let seconds = u64::try_from(at.as_second()).unwrap_or(0);
        let nanos = u32::try_from(at.subsec_nanosecond()).unwrap_or(0);
        Uuid::new_v7(uuid::Timestamp::from_unix(&self.ids, seconds, nanos))
    }
}

/// When an id was made, by itself.
fn named_at(id: Uuid) -> Option<Timestamp> {
    let (seconds, nanos) = id.get_timestamp()?.to_unix();
    Timestamp::new(i64::try_from(seconds).ok()?, i32::try_from(nanos).ok()?).ok()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

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

    /// T1: the clock went back by 99 s, then the server was started again a second later.
    #[test]
    fn t1_ids_after_a_restart_sort_behind_those_made_while_the_clock_had_gone_back() {
        let book = Book::default();
        let (_first, last) = (enter(&book, 1_099), enter(&book, 1_000));
        let after_a_restart = Book::default();
        after_a_restart.restore(book.get(last).unwrap());
        assert!(enter(&after_a_restart, 1_001) > last);
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
    fn every_motion_has_its_place_and_so_has_one_that_is_not_there() {
        let mut kept = Book::default().kept.into_inner().unwrap();
        let at = |n: u128| Uuid::from_u128(2 * n);
        for count in 0..70 {
            for n in 0..count {
                assert_eq!(kept.place_of(at(n)), Ok(usize::try_from(n).unwrap()));
                let between = Uuid::from_u128(2 * n + 1);
                assert_eq!(kept.place_of(between), Err(usize::try_from(n).unwrap() + 1));
            }
            let behind = usize::try_from(count).unwrap();
            assert_eq!(kept.place_of(at(count)), Err(behind));
            let book = Book::default();
            let mut record = book.get(enter(&book, 1)).unwrap();
            record.id = at(count);
            kept.insert(record);
        }
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

    #[tokio::test(start_paused = true)]
    async fn a_change_of_one_motion_does_not_wake_those_who_wait_for_another() {
        let book = Arc::new(Book::default());
        let (one, other) = (enter(&book, 1), enter(&book, 1));
        let looks = AtomicUsize::new(0);
        let limit = Instant::now() + std::time::Duration::from_secs(1);
        let ended = |progress: &Progress| {
            let _before = looks.fetch_add(1, Ordering::Relaxed);
            progress.end().is_some()
        };
        let (record, ()) = tokio::join!(book.wait(one, limit, ended), async {
            end(&book, other, End::Accepted);
            let _new = enter(&book, 2);
            // Lets the waiting one run, if it was woken.
            tokio::task::yield_now().await;
            assert_eq!(looks.load(Ordering::Relaxed), 1);
            end(&book, one, End::Accepted);
        });
        assert!(record.unwrap().progress.end().is_some());
        assert_eq!(looks.load(Ordering::Relaxed), 2);
    }
}
