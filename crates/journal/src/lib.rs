//! What was meant to be done and what became of it: durable, in order, tamper-evident.
//!
//! A motion's intent is in the journal before its first byte leaves, and its outcome after its evidence. If the
//! journal cannot be written, nothing moves. [`Journal`] is what the logic sees; [`SqliteJournal`] is the product's
//! store, [`MemoryJournal`] the one of the tests, with every failure at will.
//!
//! ```text
//! append(record) ─▶ bounded queue ─▶ one writer task ─▶ rules ─▶ row + index, one transaction ─▶ fsync ─▶ receipt
//!                                    (owns the connection; one transaction for all that wait: group commit)
//! hash(n) = BLAKE3(hash(n - 1), n, body(n))                        a receipt is a place, a hash, and an epoch
//! ```
//!
//! # Example
//! ```
//! # use std::time::Duration;
//! # use journal::*;
//! # fn now() -> Clocks { Clocks { wall: "2026-11-22T11:00:05Z".parse().unwrap(), monotonic: Duration::from_secs(5) } }
//! # fn intent(epoch: Epoch) -> Intent {
//! #     let target = Target { x_um: 600_000, y_um: 0, z_um: 600_000, w_mdeg: 180_000, p_mdeg: 0, r_mdeg: 0 };
//! #     Intent { motion: MotionId(uuid::Uuid::from_u128(1)), cell: "c1".into(), robot: "r1".into(), epoch, seq: 1, target,
//! #         speed_um_s: 200_000, class: Repeatability::AbsoluteFree, request_id: "q1".into(), claim: None, job: None,
//! #         reason: None, asked: None }
//! # }
//! # #[tokio::main(flavor = "current_thread")] async fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let directory = tempfile::tempdir()?;
//! # let path = directory.path().join("cell.journal");
//! // The product leaves this at `Checked`; the directory for temporary files may be in memory.
//! let options = SqliteOptions { filesystem: Filesystem::Trusted, ..SqliteOptions::default() };
//! let opening = Opening { at: now(), program: "robocell 0.1.0".into(), keys: KeyRetention::default() };
//! let journal = SqliteJournal::open(&path, &opening, &options).await?;
//!
//! let Begun::New(permission) = journal.begin_motion(now(), intent(journal.epoch())).await? else { return Ok(()) };
//! // The intent is durable: only now may the bytes leave, and `permission` is what the link wants to see.
//! let outcome = Outcome { motion: permission.motion(), end: End::Rejected { text: "ERROR: POINT UNREACHABLE".into() } };
//! let _receipt = journal.append(now(), Record::Outcome(outcome)).await?;
//!
//! let head = journal.head();
//! journal.close().await;
//! let report = verify(&path, Some(head)).await?;
//! assert_eq!(report.head, head);
//! # Ok(())
//! # }
//! ```

mod chain;
mod digest;
mod envelope;
mod error;
mod export;
mod id;
mod idempotency;
mod index;
mod journal;
mod memory;
mod opening;
mod record;
mod rules;
mod sqlite;

pub use chain::{Broken, Head, Row, Walker};
pub use digest::{Digest, DigestError};
pub use envelope::{DecodeError, MAX_BODY, Stored, TooLarge, VERSION};
pub use error::{AppendError, Cause, Effect, LookupError, ReadError};
pub use export::{LineError, read_line, write_line};
pub use id::{Clocks, DecisionId, Epoch, JobId, MotionId, Position, SignalId};
pub use idempotency::{Claim, IdempotencyKey, KeyError, KeyRetention};
pub use journal::{
    Appended, Begun, DurableIntent, Journal, Kept, MAX_PAGE, MotionStory, NewSnapshot, Pruning,
    Receipt, Replay, Retained, Room, Snapshot,
};
pub use memory::{Fault, MemoryDisk, MemoryJournal, MemoryOpenError};
pub use opening::Opening;
pub use record::{
    Accepted, Answer, Arrival, Asked, Audit, AuditResult, CellDecided, Completion, Decision, End,
    Hold, Intent, JobCreated, JobEnd, JobEnded, JobStep, Mode, NoMotion, Observation, Outcome,
    OutputLevel, Pruned, Record, Repeatability, ServerStarted, SignalReceived, SnapshotTaken,
    Standstill, StepState, Subject, Target,
};
pub use rules::{JobEntry, KeyEntry, MotionEntry, MotionPhase, Refusal};
pub use sqlite::{
    Filesystem, History, OpenError, Report, SqliteJournal, SqliteOptions, VerifyError, export,
    import, verify, verify_archives,
};
