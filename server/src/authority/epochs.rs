//! The hook for epochs that survive a restart.

use std::collections::HashMap;
use std::fmt;
use std::pin::Pin;
use std::sync::{Mutex, PoisonError};

use crate::identity::NotRecorded;

/// A number that is greater than every one before, once it is durable.
pub type NextEpoch<'a> = Pin<Box<dyn Future<Output = Result<u64, NotRecorded>> + Send + 'a>>;

/// Gives each lease of a cell its epoch.
pub trait EpochStore: fmt::Debug + Send + Sync + 'static {
    /// A number greater than every one given for this cell before, also before a restart, and durable already.
    fn next(&self, cell: &str) -> NextEpoch<'_>;
}

/// Counts from 1 at each start.
///
/// A lease does not outlive its server, and its id is random, so an old token does not fit a new lease even so; what
/// is lost is that epochs of two runs can be compared.
#[derive(Debug, Default)]
pub struct MemoryEpochs(Mutex<HashMap<String, u64>>);

impl EpochStore for MemoryEpochs {
    fn next(&self, cell: &str) -> NextEpoch<'_> {
        let mut epochs = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let epoch = epochs.entry(cell.to_owned()).or_default();
        *epoch += 1;
        Box::pin(std::future::ready(Ok(*epoch)))
    }
}
