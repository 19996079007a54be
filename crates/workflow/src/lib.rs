//! State machines of the cell: jobs, hand-over sessions, permits, custody. No I/O, no clock, no randomness.
//!
//! ```text
//! input ─▶ Cell::decide ─▶ facts ─▶ (journal, one record) ─▶ Cell::apply ─▶ effects ─▶ arms, mobile robots, people
//!             pure            serde                              fold              the driver carries them out
//! ```
//!
//! `decide` works on a copy and folds each fact it finds before it looks for the next one, so that a decision and its
//! replay cannot differ. Timers and permits are derived from the state and never kept: after a restart both permits
//! are 0 and every wait is armed anew.
//!
//! # Example
//! ```
//! use workflow::{Cell, CountingIds, Input, Setup};
//!
//! let mut cell = Cell::new(Setup { arms: vec!["r1".into()], ..Setup::default() });
//! let mut ids = CountingIds::default();
//! // After a start: replay what the journal kept, then recover. Nothing else is possible before.
//! assert!(cell.decide(0, Input::Tick, &mut ids).is_err());
//! let decision = cell.decide(0, Input::Recover, &mut ids)?;
//! for fact in &decision.facts {
//!     // Keep it if `fact.is_durable()`; then fold it, and carry out what follows.
//!     let effects = cell.apply(0, fact);
//!     assert!(effects.is_empty());
//! }
//! assert!(cell.violations().is_empty());
//! # Ok::<(), workflow::Refusal>(())
//! ```

mod answer;
mod book;
mod by_hand;
mod cell;
mod claims;
mod commands_in;
mod custody;
mod definition;
mod effect;
mod evidence;
mod fact;
mod faults;
mod fold;
mod ids;
mod input;
mod instant;
mod intervention;
mod invariants;
mod job;
mod late_mobile;
mod loads_in;
mod matching;
mod permits;
mod prefetch;
mod queue;
mod react;
pub mod reconcile;
mod recover;
mod schedule;
mod session;
mod session_run;
mod setup;
mod signal;
mod signals_in;
mod snapshot;
mod supervise;
mod timers;
mod timers_in;
mod transport;
mod triggers;
pub mod view;
mod words;
mod work;

pub use book::OpState;
pub use cell::Cell;
pub use claims::{Holder, Resource};
pub use custody::{Evidence, Load, Location};
pub use definition::Definition;
pub use effect::{Action, Effect, GripAction, Interpolation, Speed, Target};
pub use fact::{Fact, Rewind};
pub use faults::Fault;
pub use ids::{CountingIds, IdSource, Millis};
pub use input::{
    ArmSeen, Command, Decision, Input, OpResult, PoseFailure, Principal, Refusal, Reply, Role,
    Safety,
};
pub use intervention::{Allowed, Answer, Decided, Detail, Question};
pub use invariants::Violation;
pub use job::params::{CompleteOn, ItemParams, NewJob, OnCancel, Workflow};
pub use job::phase::{Phase, Recovery};
pub use job::{Compensation, FaultNote, Item, JobState, PlannedStep, StepState, Why};
pub use permits::Permit;
pub use session::SessionState;
pub use setup::{
    BasePose, LoadSetup, MobileRobotSetup, Place, PlaceKind, PlaceRef, Point, Setup, SetupError,
    Taught, Tolerance, Trigger,
};
pub use signal::{
    InstantAction, Message, MobileError, MobileMode, MobileState, OutMessage, Signal, SignalAnswer,
    SignalKind, SlotLoad,
};
pub use snapshot::Snapshot;
pub use timers::{Running, TimerKey, Timers};
pub use words::word;
