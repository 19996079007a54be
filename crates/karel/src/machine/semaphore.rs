//! Semaphores, which tasks share.

/// `PEND_SEMA`, `POST_SEMA` and `CLEAR_SEMA` act on one of these counts.
///
/// ASSUMPTION: there are 32, and a count stops at the largest INTEGER.
#[derive(Debug)]
pub(crate) struct Semaphores([i32; Semaphores::COUNT]);

impl Semaphores {
    pub(crate) const COUNT: usize = 32;

    /// The count of semaphore `n`, from 1; `None` if there is no such semaphore.
    pub(crate) fn count(&mut self, n: i32) -> Option<&mut i32> {
        let index = usize::try_from(n).ok()?.checked_sub(1)?;
        self.0.get_mut(index)
    }
}

impl Default for Semaphores {
    fn default() -> Semaphores {
        Semaphores([0; Semaphores::COUNT])
    }
}
