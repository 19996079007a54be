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
use crate::error::{Cause, is_full};
use crate::rules::Verdict;
use crate::{
    AppendError, Appended, Clocks, Effect, Head, KeyEntry, Position, Receipt, Record, Refusal,
    Replay, Room, Row, Stored,
};

/// Requests of one transaction.
const MAX_GROUP: usize = 256;

#[derive(Debug)]
pub(super) struct Request {
    pub(super) at: Clocks,
    pub(super) record: Record,
    pub(super) answer: oneshot::Sender<Result<Appended, AppendError>>,
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
type Admitted = Result<Appended, AppendError>;

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
        for Request { at, record, .. } in group {
            results.push(admit(store, *at, record, no_room.as_ref()).await?);
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
) -> Result<Admitted, Failure> {
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

fn row(store: &Store, at: Clocks, record: &Record) -> Result<Row, Refusal> {
    let position: Position = store.head.position.next();
    let stored = Stored {
        position,
        epoch: store.epoch,
        at,
        record: record.clone(),
    };
    let body = stored.encode().map_err(Refusal::TooLarge)?.into_bytes();
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

fn answer(request: Request, result: Result<Appended, AppendError>) {
    // Whoever has gone away learns it from a read.
    let _gone = request.answer.send(result);
}
