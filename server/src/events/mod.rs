//! What happens, told to whoever listens: a projection of the journal's records.
//!
//! Nothing is an event that is not a record, so a listener that was away reads on where it was, over a restart too.
//! One task reads each new record once and keeps the events of the newest for all streams; a stream that begins
//! further back reads the journal itself until it has caught up.
//!
//! ```text
//! journal ── tailer ─▶ events of one record ─▶ ring (bounded, shared) ──┬─▶ stream ─▶ 8 chunks at most ─▶ socket
//!    └──────────────── older ones, a page at a time ────────────────────┘
//! ```

mod body;
mod id;
mod known;
mod motions;
mod project;
mod ring;
mod sentence;
mod status;
mod stream;

pub(crate) use body::stream_body;
pub(crate) use id::EventId;
pub(crate) use ring::Events;
pub(crate) use stream::{Asked, CHUNKS, Filter};
