//! A driver with arms that do what a test says.

use std::collections::BTreeMap;
use std::sync::Arc;

use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use workflow::Setup;

use super::arm::ArmPort;
use super::clock::CellClock;
use super::driver::Driver;
use super::handle::CellHandle;
use super::recovered::Recovered;
use crate::clock::{SystemClock, WallClock};
use crate::journal::SharedJournal;

/// The cell `c1` with these arms, recovered from a journal.
pub(crate) async fn handle(
    journal: &SharedJournal,
    arms: BTreeMap<String, Arc<dyn ArmPort>>,
) -> CellHandle {
    handle_at(journal, arms, Arc::new(SystemClock)).await
}

/// The same by another clock.
pub(crate) async fn handle_at(
    journal: &SharedJournal,
    arms: BTreeMap<String, Arc<dyn ArmPort>>,
    wall: Arc<dyn WallClock>,
) -> CellHandle {
    let recovered = Recovered::read("c1", Setup::default(), journal, wall.now())
        .await
        .unwrap();
    Driver {
        id: "c1".to_owned(),
        journal: journal.clone(),
        clock: CellClock::new(&wall, 1.0),
        wall,
        arms,
        tracker: TaskTracker::new(),
        stop: CancellationToken::new(),
    }
    .spawn(recovered)
}
