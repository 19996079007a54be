//! What other parts keep in the journal: who did what, and which lease of control came when.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use journal::{Audit, Record};

use super::SharedJournal;
use crate::authority::{EpochStore, NextEpoch};
use crate::clock::WallClock;
use crate::identity::{AuditSink, NotRecorded, Recorded, TracingAudit};

/// Leases one start of the server may give; more would run into the epochs of the next start.
const LEASES: u64 = 1_000_000;

/// Keeps entries in the journal, and shows them in the log.
#[derive(Debug)]
pub(crate) struct JournalAudit {
    pub(crate) journal: SharedJournal,
    pub(crate) clock: Arc<dyn WallClock>,
}

impl AuditSink for JournalAudit {
    fn record(&self, entry: Audit) -> Recorded<'_> {
        Box::pin(async move {
            let kept = self
                .journal
                .append(self.clock.now(), Record::Audit(entry.clone()))
                .await;
            let _appended = kept.map_err(|trouble| NotRecorded {
                reason: trouble.to_string(),
            })?;
            TracingAudit.record(entry).await
        })
    }
}

/// Numbers leases in the journal's own epoch, so that a later start of the server gives higher numbers.
#[derive(Debug)]
pub(crate) struct JournalEpochs {
    journal: SharedJournal,
    given: AtomicU64,
}

impl JournalEpochs {
    pub(crate) fn new(journal: SharedJournal) -> Self {
        Self {
            journal,
            given: AtomicU64::new(0),
        }
    }
}

impl EpochStore for JournalEpochs {
    fn next(&self, _cell: &str) -> NextEpoch<'_> {
        let number = self.given.fetch_add(1, Ordering::SeqCst) + 1;
        let epoch = if number < LEASES {
            Ok(self.journal.epoch().0 * LEASES + number)
        } else {
            Err(NotRecorded {
                reason: format!("this start of the server has given {LEASES} leases, and no more"),
            })
        };
        Box::pin(std::future::ready(epoch))
    }
}
