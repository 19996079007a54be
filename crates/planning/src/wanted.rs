//! Whether an answer is still wanted.

use std::fmt;

/// What a long search asks now and then: does anybody still wait for the answer?
///
/// A search looks at it at least once for every sample, step, cell or place that it looks at, so that it ends soon after
/// the answer is no longer wanted.
#[derive(Clone, Copy)]
pub struct Wanted<'a>(&'a (dyn Fn() -> bool + Sync));

impl<'a> Wanted<'a> {
    /// Until it is there.
    pub const ALWAYS: Wanted<'static> = Wanted(&|| true);

    /// As long as `still` says so.
    #[must_use]
    pub fn while_true(still: &'a (dyn Fn() -> bool + Sync)) -> Self {
        Wanted(still)
    }

    /// # Errors
    /// Nobody waits for the answer any more.
    pub fn check(self) -> Result<(), BrokenOff> {
        if self.is_over() {
            return Err(BrokenOff);
        }
        Ok(())
    }

    pub(crate) fn is_over(self) -> bool {
        !(self.0)()
    }
}

impl fmt::Debug for Wanted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Wanted").field(&!self.is_over()).finish()
    }
}

/// Nobody waited for the answer any more.
#[derive(Clone, Copy, Debug, Eq, PartialEq, thiserror::Error)]
#[error("broken off: nobody waits for the answer any more")]
pub struct BrokenOff;
