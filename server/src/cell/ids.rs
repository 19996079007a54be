use std::sync::Arc;

use uuid::{ContextV7, Uuid};
use workflow::IdSource;

use crate::clock::WallClock;

/// Identifiers that sort by creation.
#[derive(Debug)]
pub(super) struct Ids {
    context: ContextV7,
    clock: Arc<dyn WallClock>,
}

impl Ids {
    pub(super) fn new(clock: Arc<dyn WallClock>) -> Self {
        Self {
            context: ContextV7::new(),
            clock,
        }
    }
}

impl IdSource for Ids {
    fn next_id(&mut self) -> Uuid {
        let at = self.clock.now();
        let seconds = u64::try_from(at.as_second()).unwrap_or(0);
        let nanos = u32::try_from(at.subsec_nanosecond()).unwrap_or(0);
        Uuid::new_v7(uuid::Timestamp::from_unix(&self.context, seconds, nanos))
    }
}
