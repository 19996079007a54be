//! What computes for long: off the threads that answer, one at a time.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use api::ProblemCode;

use crate::problem::Problem;
use crate::state::App;

/// Whoever waits for an answer; gone once this is dropped.
#[derive(Debug, Default)]
struct Caller {
    gone: Arc<AtomicBool>,
}

impl Drop for Caller {
    fn drop(&mut self) {
        self.gone.store(true, Ordering::Relaxed);
    }
}

/// Does `work` where it keeps nobody waiting, and only while the caller does; the flag tells it that the caller is gone.
///
/// Who goes away before it begins is not waited for, and nobody computes for them.
pub(crate) async fn compute<T: Send + 'static>(
    app: &App,
    work: impl FnOnce(&AtomicBool) -> Result<T, Problem> + Send + 'static,
) -> Result<T, Problem> {
    let Ok(place) = Arc::clone(&app.computing).acquire_owned().await else {
        unreachable!("the place for computing is never closed");
    };
    let caller = Caller::default();
    let given_up = Arc::clone(&caller.gone);
    let computing = tokio::task::spawn_blocking(move || {
        let _until_the_end = place;
        work(&given_up)
    });
    computing.await.unwrap_or_else(|_| {
        Err(Problem::new(
            ProblemCode::Internal,
            "the computation ended early; the server's log says more",
        ))
    })
}
