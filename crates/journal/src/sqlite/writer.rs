//! The one task that writes.
//!
//! It takes one request, and whatever else waits by then, and makes one transaction of them: with one writer each
//! append costs an fsync, with many they share it.

use std::sync::Arc;
use std::time::Duration;

use sqlx::Connection as _;
use tokio::sync::{mpsc, oneshot, watch};

use super::lock::Lock;
use super::reader;
use super::reserve::Reserve;
use super::store::{CommitError, Store};
use crate::envelope::encode;
use crate::error::{Cause, is_full};
use crate::rules::Verdict;
use crate::{
    AppendError, Appended, Clocks, Effect, Head, KeyEntry, NewSnapshot, Position, Pruned, Pruning,
    Receipt, Record, Refusal, Replay, Room, Row,
};

/// Requests of one transaction.
const MAX_GROUP: usize = 256;

#[derive(Debug)]
pub(super) struct Request {
    pub(super) at: Clocks,
    pub(super) work: Work,
    pub(super) answer: oneshot::Sender<Admitted>,
}

/// What is to be written.
#[derive(Debug)]
pub(super) enum Work {
    Record(Box<Record>),
    Snapshot(Box<NewSnapshot>),
    Prune {
        through: Position,
        archive: Option<String>,
    },
}

/// What was written.
#[derive(Debug)]
pub(super) enum Done {
    Appended(Appended),
    Snapshot(Receipt),
    Pruned(Pruning),
}

impl Done {
    pub(super) fn appended(self) -> Option<Appended> {
        if let Self::Appended(appended) = self {
            Some(appended)
        } else {
            None
        }
    }

    pub(super) fn snapshot(self) -> Option<Receipt> {
        if let Self::Snapshot(receipt) = self {
            Some(receipt)
        } else {
            None
        }
    }

    pub(super) fn pruned(self) -> Option<Pruning> {
        if let Self::Pruned(pruning) = self {
            Some(pruning)
        } else {
            None
        }
    }
}

#[derive(Debug)]
pub(super) struct Writer {
    pub(super) store: Store,
    pub(super) publish: watch::Sender<Head>,
    pub(super) room: watch::Sender<Room>,
    pub(super) reserve: Reserve,
    pub(super) look_for_room: Duration,
    /// Held until the connection is closed.
    pub(super) lock: Lock,
}

/// What became of one request of a transaction.
pub(super) type Admitted = Result<Done, AppendError>;

/// The transaction failed, and with it every request in it.
#[derive(Debug)]
struct Failure {
    step: &'static str,
    effect: Effect,
    source: sqlx::Error,
}

impl Writer {
    pub(super) async fn run(mut self, mut requests: mpsc::Receiver<Request>) {
        let mut group = Vec::with_capacity(MAX_GROUP);
        let mut poison = None;
        while poison.is_none() && self.receive(&mut requests, &mut group).await > 0 {
            poison = self.write(&mut group).await;
        }
        // Closing may fail for the reason the write did; there is nothing more to lose then.
        let _closed = self.store.connection.close().await;
        drop(self.lock);
        if let Some(cause) = poison {
            while let Some(request) = requests.recv().await {
                answer(request, Err(AppendError::Poisoned(Arc::clone(&cause))));
            }
        }
    }

    /// Waits for requests; meanwhile, on the reserve, looks whether there is room again.
    async fn receive(
        &mut self,
        requests: &mut mpsc::Receiver<Request>,
        group: &mut Vec<Request>,
    ) -> usize {
        while self.reserve.room() != Room::Free {
            let receive = requests.recv_many(group, MAX_GROUP);
            match tokio::time::timeout(self.look_for_room, receive).await {
                Ok(received) => return received,
                Err(_nobody_asks) => {
                    // A failure says that there is still none.
                    let _unknown = self.reserve.close(&mut self.store).await;
                    let _before = self.room.send_replace(self.reserve.room());
                }
            }
        }
        requests.recv_many(group, MAX_GROUP).await
    }

    /// Writes a group, on the reserve where there is no other room.
    ///
    /// A write that found no room is not an fsync that failed: SQLite has not put the end of the transaction into its
    /// log, so that undoing it and reading the head again shows what is on the disk.
    async fn attempt(&mut self, group: &[Request]) -> Result<Vec<Admitted>, Failure> {
        let failure = match self.transaction(group).await {
            Ok(results) => return Ok(results),
            Err(failure) => failure,
        };
        if !is_full(&failure.source) {
            return Err(failure);
        }
        match self.reserve.open(&mut self.store).await {
            Ok(true) => {
                let _before = self.room.send_replace(self.reserve.room());
                self.transaction(group).await
            }
            Ok(false) | Err(_) => Err(failure),
        }
    }

    /// Writes a group and answers each of it; the cause, if the journal is of no more use.
    async fn write(&mut self, group: &mut Vec<Request>) -> Option<Cause> {
        match self.attempt(group).await {
            Ok(results) => {
                let _before = self.publish.send_replace(self.store.head);
                for (request, result) in group.drain(..).zip(results) {
                    answer(request, result);
                }
                None
            }
            Err(failure) => {
                let cause: Cause = Arc::new(failure.source);
                for request in group.drain(..) {
                    answer(
                        request,
                        Err(AppendError::Failed {
                            step: failure.step,
                            effect: failure.effect,
                            source: Arc::clone(&cause),
                        }),
                    );
                }
                Some(cause)
            }
        }
    }

    async fn transaction(&mut self, group: &[Request]) -> Result<Vec<Admitted>, Failure> {
        let mut results = Vec::with_capacity(group.len());
        let no_room = self.reserve.room().refusal();
        let store = &mut self.store;
        store.begin().await.map_err(before("beginning"))?;
        for Request { at, work, .. } in group {
            let done = match work {
                Work::Record(record) => {
                    let admitted = admit(store, *at, record, no_room.as_ref()).await?;
                    admitted.map(Done::Appended)
                }
                // The reserve is for what ends or tells.
                Work::Snapshot(snapshot) => match &no_room {
                    Some(no_room) => Err(no_room.clone()),
                    None => keep_snapshot(store, *at, snapshot)
                        .await?
                        .map(Done::Snapshot),
                },
                Work::Prune { through, archive } => {
                    let pruned = prune(store, *at, *through, archive.as_ref()).await?;
                    pruned.map(Done::Pruned)
                }
            };
            results.push(done);
        }
        store.commit().await.map_err(|error| match error {
            CommitError::Before(source) => before("writing the head")(source),
            CommitError::At(source) => Failure {
                step: "committing",
                effect: Effect::Unknown,
                source,
            },
        })?;
        Ok(results)
    }
}

/// Writes the first record of an opening, before there is a task.
pub(super) async fn write_opening(
    store: &mut Store,
    at: Clocks,
    record: &Record,
) -> Result<(), AppendError> {
    let Record::ServerStarted(started) = record else {
        return Ok(());
    };
    let failed = |step, effect, source: sqlx::Error| AppendError::Failed {
        step,
        effect,
        source: Arc::new(source),
    };
    let unwritten = |source| failed("writing the opening", Effect::None, source);
    store.begin().await.map_err(unwritten)?;
    store.start(started);
    let row = row(store, at, record).map_err(AppendError::Refused)?;
    store
        .keep(row, crate::rules::Change::default(), &at)
        .await
        .map_err(unwritten)?;
    store.commit().await.map_err(|error| match error {
        CommitError::Before(source) => unwritten(source),
        CommitError::At(source) => failed("committing the opening", Effect::Unknown, source),
    })
}

async fn admit(
    store: &mut Store,
    at: Clocks,
    record: &Record,
    no_room: Option<&AppendError>,
) -> Result<Result<Appended, AppendError>, Failure> {
    let verdict = store
        .judge(record, at)
        .await
        .map_err(before("looking up what is known"))?;
    let change = match verdict {
        Ok(Verdict::Keep(change)) => change,
        Ok(Verdict::Replay(entry)) => {
            let replay = replay(store, &entry).await?;
            return Ok(Ok(Appended::Replayed(Box::new(replay))));
        }
        Err(refusal) => return Ok(Err(AppendError::Refused(refusal))),
    };
    if let Some(no_room) = no_room
        && record.begins_work()
    {
        return Ok(Err(no_room.clone()));
    }
    let row = match row(store, at, record) {
        Ok(row) => row,
        Err(refusal) => return Ok(Err(AppendError::Refused(refusal))),
    };
    store
        .keep(row, change, &at)
        .await
        .map_err(before("writing the record"))?;
    Ok(Ok(Appended::New(Receipt {
        head: store.head,
        epoch: store.epoch,
    })))
}

async fn keep_snapshot(
    store: &mut Store,
    at: Clocks,
    snapshot: &NewSnapshot,
) -> Result<Result<Receipt, AppendError>, Failure> {
    let judged = store
        .judge_snapshot(snapshot)
        .await
        .map_err(before("looking up what a snapshot covers"))?;
    let record = match judged {
        Ok(record) => record,
        Err(refusal) => return Ok(Err(AppendError::Refused(refusal))),
    };
    let kept = keep_own(store, at, &record).await?;
    if kept.is_ok() {
        store
            .keep_snapshot(&snapshot.cell, snapshot.covers.position, &snapshot.body)
            .await
            .map_err(before("writing the snapshot"))?;
    }
    Ok(kept)
}

async fn prune(
    store: &mut Store,
    at: Clocks,
    through: Position,
    archive: Option<&String>,
) -> Result<Result<Pruning, AppendError>, Failure> {
    let (retained, last) = store
        .removable(at, through)
        .await
        .map_err(before("looking up what may be removed"))?;
    let Some(last) = last else {
        return Ok(Ok(Pruning {
            base: retained.base,
            removed: 0,
        }));
    };
    // Of a cell that decides nothing the snapshot stays the same, and is told of again where its record goes.
    let told = store
        .snapshots_told_by(last.head.position)
        .await
        .map_err(before("looking up snapshots"))?;
    for (cell, record) in told {
        if let Err(refused) = keep_own(store, at, &record).await? {
            return Ok(Err(refused));
        }
        let retold = store.retell_snapshot(&cell).await;
        retold.map_err(before("writing the snapshot"))?;
    }
    let removed = last.head.position.0 - retained.base.position.0;
    let record = Record::Pruned(Pruned {
        through: last.head,
        records: removed,
        epoch: last.epoch,
        keys: last.keys,
        archive: archive.cloned(),
    });
    if let Err(refused) = keep_own(store, at, &record).await? {
        return Ok(Err(refused));
    }
    store
        .remove_through(last)
        .await
        .map_err(before("removing old records"))?;
    Ok(Ok(Pruning {
        base: last.head,
        removed,
    }))
}

/// Keeps a record of the journal's own.
async fn keep_own(
    store: &mut Store,
    at: Clocks,
    record: &Record,
) -> Result<Result<Receipt, AppendError>, Failure> {
    let row = match row(store, at, record) {
        Ok(row) => row,
        Err(refusal) => return Ok(Err(AppendError::Refused(refusal))),
    };
    store
        .keep(row, crate::rules::Change::default(), &at)
        .await
        .map_err(before("writing the record"))?;
    Ok(Ok(Receipt {
        head: store.head,
        epoch: store.epoch,
    }))
}

fn row(store: &Store, at: Clocks, record: &Record) -> Result<Row, Refusal> {
    let position: Position = store.head.position.next();
    let body = encode(position, store.epoch, at, record)
        .map_err(Refusal::TooLarge)?
        .into_bytes();
    let head = store.head.extend(&body);
    Ok(Row {
        position,
        previous: store.head.hash,
        body,
        hash: head.hash,
    })
}

async fn replay(store: &mut Store, entry: &KeyEntry) -> Result<Replay, Failure> {
    reader::replay(&mut store.connection, entry)
        .await
        .map_err(|error| Failure {
            step: "reading what the key stands for",
            effect: Effect::None,
            source: sqlx::Error::Decode(Box::new(error)),
        })
}

fn before(step: &'static str) -> impl Fn(sqlx::Error) -> Failure {
    move |source| Failure {
        step,
        effect: Effect::None,
        source,
    }
}

fn answer(request: Request, result: Admitted) {
    // Whoever has gone away learns it from a read.
    let _gone = request.answer.send(result);
}
