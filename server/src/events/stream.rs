//! One stream of events: what it was asked for, what it has sent, and what it sends next.

use std::sync::Arc;
use std::time::Duration;

use api::{EventGap, GapReason};
use bytes::{Bytes, BytesMut};
use journal::Position;
use tokio::sync::{mpsc, watch};
use tokio::time::{Instant, sleep_until};
use uuid::Uuid;

use super::id::EventId;
use super::project::{Batch, Projector, Ready, Resume};
use super::ring::{Ahead, Events};
use super::status::status;
use crate::cell::CellHandle;

/// How long a stream is silent at most.
const HEARTBEAT: Duration = Duration::from_secs(15);
/// Records of one chunk, and chunks that may wait for a slow reader.
const RECORDS: usize = 64;
pub(crate) const CHUNKS: usize = 8;
/// The state of the cell is sent so often at most.
const STATUS: Duration = Duration::from_millis(250);
/// Timers run while nothing else changes.
const STATUS_AT_LEAST: Duration = Duration::from_secs(1);

/// What a stream is to send.
#[derive(Clone, Debug, Default)]
pub(crate) struct Filter {
    /// Beginnings of kinds; none: all.
    pub(crate) types: Vec<String>,
    pub(crate) job: Option<Uuid>,
}

impl Filter {
    fn admits(&self, event: &Ready) -> bool {
        let fits = |wanted: &String| {
            let rest = event.kind.strip_prefix(wanted.as_str());
            rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
        };
        let of_type = self.types.is_empty() || self.types.iter().any(fits);
        of_type && self.job.is_none_or(|job| event.job == Some(job))
    }
}

/// What was asked for.
#[derive(Debug)]
pub(crate) struct Asked {
    pub(crate) cell: Arc<str>,
    /// Everything behind this; absent: from now on.
    pub(crate) from: Option<EventId>,
    pub(crate) filter: Filter,
    /// Also the state of this cell.
    pub(crate) status: Option<CellHandle>,
}

/// The caller went away, or the server is stopping.
struct Over;

struct Stream {
    events: Events,
    asked: Asked,
    chunks: mpsc::Sender<Bytes>,
    /// Everything up to here was sent, or left out by the filter.
    sent: EventId,
    /// It has had the newest once. From then on it keeps up, or hears that it did not.
    live: bool,
    /// For what the ring does not have any more.
    reader: Option<Projector>,
}

impl Events {
    /// Sends what was asked for until the other side goes away or the server stops.
    pub(crate) async fn send(self, asked: Asked, chunks: mpsc::Sender<Bytes>) {
        let stop = self.stop().clone();
        let news = self.listen();
        let now = *news.borrow();
        let stream = Stream {
            sent: now,
            live: asked.from.is_none(),
            reader: None,
            events: self,
            asked,
            chunks,
        };
        let _ended = stop.run_until_cancelled(stream.run(now, news)).await;
    }
}

impl Stream {
    async fn run(mut self, now: EventId, mut news: watch::Receiver<EventId>) -> Result<(), Over> {
        self.begin(now).await?;
        let mut cell = self.asked.status.as_ref().map(CellHandle::watch);
        let mut beat = Instant::now() + HEARTBEAT;
        let (mut status_due, mut status_sent) = (cell.as_ref().map(|_| Instant::now()), None);
        loop {
            news.mark_unchanged();
            self.catch_up().await?;
            if status_due.is_some_and(|due| due <= Instant::now()) {
                if let Some(cell) = &mut cell {
                    cell.mark_unchanged();
                }
                let now = self.status();
                if now.is_some() && now != status_sent {
                    self.put(format!(
                        "event: status\ndata: {}\n\n",
                        now.as_deref().unwrap_or("")
                    ))
                    .await?;
                    status_sent = now;
                }
                status_due = Some(Instant::now() + STATUS_AT_LEAST);
            }
            tokio::select! {
                biased;
                () = self.chunks.closed() => return Err(Over),
                () = sleep_until(beat) => {
                    // The id, too: a filter may have left out everything for long.
                    self.put(format!(":hb\nid: {}\n\n", self.sent)).await?;
                    beat = Instant::now() + HEARTBEAT;
                }
                changed = news.changed() => changed.map_err(|_| Over)?,
                changed = changed(&mut cell) => {
                    if !changed {
                        cell = None;
                    }
                    let soon = Instant::now() + STATUS;
                    status_due = status_due.map(|due| due.min(soon));
                }
                () = due(status_due) => {}
            }
        }
    }

    /// The first lines: how soon to come back, and from where on if nothing happens until then.
    async fn begin(&mut self, now: EventId) -> Result<(), Over> {
        self.put(":robocell\nretry: 1000\n\n".to_owned()).await?;
        let Some(from) = self.asked.from else {
            return self.put(format!("id: {now}\n\n")).await;
        };
        let reader = self.events.projector();
        match reader.resume(from).await {
            Resume::After(position) => {
                self.sent = EventId { position, ..from };
                self.reader = Some(reader);
                Ok(())
            }
            Resume::Gap(reason) => self.gap(reason, from, now).await,
        }
    }

    /// Sends everything up to the newest.
    async fn catch_up(&mut self) -> Result<(), Over> {
        loop {
            match self.events.behind(self.sent.position, RECORDS) {
                Ahead::Batches(batches) if batches.is_empty() => {
                    self.live = true;
                    self.reader = None;
                    return Ok(());
                }
                Ahead::Batches(batches) => self.send(&batches).await?,
                Ahead::Lapped if self.live => {
                    let now = self.events.newest();
                    self.gap(GapReason::Slow, self.sent, now).await?;
                }
                Ahead::Lapped => self.read_back().await?,
            }
        }
    }

    /// Sends a page from the journal itself.
    async fn read_back(&mut self) -> Result<(), Over> {
        let page = self
            .events
            .journal()
            .page(self.sent.position, RECORDS)
            .await;
        let page = match page {
            Ok(page) if !page.is_empty() => page,
            Ok(_) | Err(_) => {
                let now = self.events.newest();
                return self.gap(GapReason::Forgotten, self.sent, now).await;
            }
        };
        let events = self.events.clone();
        let reader = self.reader.get_or_insert_with(|| events.projector());
        let mut batches = Vec::with_capacity(page.len());
        for stored in &page {
            batches.push(Arc::new(reader.events(stored).await));
        }
        let forgotten = |first: &Arc<Batch>| first.id.position > self.sent.position.next();
        if self.sent.position > Position::START
            && let Some(first) = batches.first().filter(|first| forgotten(first))
        {
            let to = EventId {
                position: Position(first.id.position.0 - 1),
                ..first.id
            };
            self.gap(GapReason::Forgotten, self.sent, to).await?;
        }
        self.send(&batches).await
    }

    async fn send(&mut self, batches: &[Arc<Batch>]) -> Result<(), Over> {
        let mut chunk = BytesMut::new();
        for batch in batches {
            let shown = batch.events.iter().filter_map(|event| {
                let admitted = self.asked.filter.admits(event);
                let mut json = event.json.iter().filter(|_| admitted);
                json.find(|(cell, _)| *cell == self.asked.cell)
            });
            let mut shown = shown.map(|(_, json)| json).peekable();
            while let Some(json) = shown.next() {
                // Only with its last event a record is done with; after a break in the middle it comes again, and each
                // event in it is known by its own id.
                if shown.peek().is_none() {
                    chunk.extend_from_slice(format!("id: {}\n", batch.id).as_bytes());
                }
                chunk.extend_from_slice(b"data: ");
                chunk.extend_from_slice(json);
                chunk.extend_from_slice(b"\n\n");
            }
            self.sent = batch.id;
        }
        if chunk.is_empty() {
            return Ok(());
        }
        self.chunks.send(chunk.freeze()).await.map_err(|_| Over)
    }

    async fn gap(&mut self, reason: GapReason, from: EventId, to: EventId) -> Result<(), Over> {
        self.sent = to;
        let gap = EventGap {
            reason,
            from: from.to_string(),
            to: to.to_string(),
        };
        let gap = serde_json::to_string(&gap).unwrap_or_default();
        self.put(format!("event: gap\nid: {to}\ndata: {gap}\n\n"))
            .await
    }

    fn status(&self) -> Option<String> {
        let cell = self.asked.status.as_ref()?;
        serde_json::to_string(&status(&cell.view(), cell.clock().now())).ok()
    }

    async fn put(&self, text: String) -> Result<(), Over> {
        self.chunks.send(Bytes::from(text)).await.map_err(|_| Over)
    }
}

/// Waits for a change of the cell; false once there are no more.
async fn changed(cell: &mut Option<tokio::sync::watch::Receiver<Arc<workflow::Cell>>>) -> bool {
    match cell {
        Some(cell) => cell.changed().await.is_ok(),
        None => std::future::pending().await,
    }
}

async fn due(at: Option<Instant>) {
    match at {
        Some(at) => sleep_until(at).await,
        None => std::future::pending().await,
    }
}
