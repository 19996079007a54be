//! Who may hold a connection, and for how long.
//!
//! The server has a number of places for connections (`max_connections`). A caller who is slow on purpose can fill
//! any number of them, so a place is never kept by whoever came first: as long as the server waits for the peer, the
//! place is on loan, and the next caller may get it. Every connection's `Standing` says whose turn it is:
//!
//! ```text
//!  Accepted ─► Arriving ─┐
//!                        ├─► Body ─► Handling ─► Answering ─► Sent ─► Idle ─┐
//!                  Head ─┘                  └──► Streaming                  │
//!                   ▲                                                       │
//!                   └────────────────────── first byte ─────────────────────┘
//!
//!  the peer's turn: Arriving, Head, Body; Answering and Sent while the peer takes nothing
//!  ours:            Accepted (not looked at yet), Handling; Answering while it goes
//! ```
//!
//! When a caller arrives and every place is taken, one connection is closed for it ([`choice`]):
//!
//! 1. one whose peer keeps the server waiting, for more than a moment if there is such a one: of the address that has
//!    most of them, the one that waits longest;
//! 2. else one that is idle between two requests: of the address that has most of them, the one idle longest;
//! 3. else one whose request has been worked on for more than a second. Its command stays: a caller who goes away does
//!    not take it along, and its idempotency key tells what became of it.
//!
//! So 256 slow connections from one address or from 256 cost an honest caller nothing: its head and body arrive within
//! a round trip, and by then it is neither the oldest nor of the address with most. There is no fixed share an address
//! may hold, because behind one address there may be a whole plant (a reverse proxy) or the whole cell (the demo on
//! loopback). What an address cannot have is more than `max_waiting_per_address` connections that keep the server
//! waiting: its next one takes the place of its own oldest.
//!
//! Event streams are long by nature and have places of their own (`max_event_streams`).
//!
//! The standings cost a request a few stores into one word. A sweep every quarter of the shortest limit closes what
//! took too long, so no timer is set for any request.

mod choice;
mod descriptors;
mod exchange;
mod listener;
mod socket;
mod standing;
mod table;

pub use listener::Listener;

pub(crate) use exchange::{StreamPlace, answer};
pub(crate) use listener::AcceptFailures;
pub(crate) use socket::Watched;
pub(crate) use table::Table;
