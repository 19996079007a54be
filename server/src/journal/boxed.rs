//! The journal's trait with boxed futures, so that the server is not generic over its store.

use std::future::Future;
use std::pin::Pin;

use journal::{
    AppendError, Appended, Begun, Claim, Clocks, Epoch, Head, Intent, Journal, Kept, LookupError,
    MotionEntry, MotionId, MotionPhase, MotionStory, NewSnapshot, Position, Pruning, ReadError,
    Receipt, Record, Replay, Retained, Room, Row, Stored,
};

type Boxed<'a, T> = Pin<Box<dyn Future<Output = T> + Send + 'a>>;

macro_rules! any_journal {
    ($($name:ident($($argument:ident: $type:ty),*) -> $output:ty;)*) => {
        /// [`Journal`], as an object.
        #[expect(clippy::elidable_lifetime_names, reason = "the methods that borrow an argument need the name")]
        pub(super) trait AnyJournal: Send + Sync {
            fn epoch(&self) -> Epoch;
            fn head(&self) -> Head;
            fn room(&self) -> Room;
            $(fn $name<'a>(&'a self, $($argument: $type),*) -> Boxed<'a, $output>;)*
        }

        #[expect(clippy::elidable_lifetime_names, reason = "the methods that borrow an argument need the name")]
        impl<J: Journal> AnyJournal for J {
            fn epoch(&self) -> Epoch {
                Journal::epoch(self)
            }

            fn head(&self) -> Head {
                Journal::head(self)
            }

            fn room(&self) -> Room {
                Journal::room(self)
            }

            $(fn $name<'a>(&'a self, $($argument: $type),*) -> Boxed<'a, $output> {
                Box::pin(Journal::$name(self, $($argument),*))
            })*
        }
    };
}

any_journal! {
    append(at: Clocks, record: Record) -> Result<Appended, AppendError>;
    begin_motion(at: Clocks, intent: Intent) -> Result<Begun, AppendError>;
    keep_snapshot(at: Clocks, snapshot: NewSnapshot) -> Result<Receipt, AppendError>;
    snapshot(cell: &'a str) -> Result<Option<Kept>, ReadError>;
    rows(after: Position, limit: usize) -> Result<Vec<Row>, ReadError>;
    retained(now: Clocks) -> Result<Retained, ReadError>;
    prune(at: Clocks, through: Position, archive: Option<String>) -> Result<Pruning, AppendError>;
    page(after: Position, limit: usize) -> Result<Vec<Stored>, ReadError>;
    lookup(claim: &'a Claim, now: Clocks) -> Result<Option<Replay>, LookupError>;
    motion(motion: MotionId) -> Result<Option<MotionStory>, ReadError>;
    motions(phases: &'a [MotionPhase], after: Position, limit: usize) -> Result<Vec<MotionEntry>, ReadError>;
    latest_motions(before: Position, limit: usize) -> Result<Vec<MotionEntry>, ReadError>;
    audits(before: Position, limit: usize) -> Result<Vec<Stored>, ReadError>;
    decided(cell: &'a str, after: Position, limit: usize) -> Result<Vec<Stored>, ReadError>;
}
