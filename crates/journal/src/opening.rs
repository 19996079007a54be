use crate::{Clocks, KeyRetention};

/// What is said when a journal is opened for writing.
#[derive(Clone, Debug)]
pub struct Opening {
    /// When.
    pub at: Clocks,
    /// The program and its version, for people.
    pub program: String,
    /// How long keys are remembered from here on.
    pub keys: KeyRetention,
}
