//! The threads of a server.

use std::io;

use tokio::runtime::{Builder, Runtime};

/// A runtime as a server is fastest on: one thread turns all its sockets and timers.
///
/// A move crosses three tasks (its connection, the robot's link, and back). On several threads each crossing wakes
/// another core, and that costs more than the work of the task; see `docs/benchmarks.md`. What computes for long and
/// what waits for a disk has threads of its own, so that nothing stands in the way of a stop.
///
/// # Errors
/// The system gives no thread, or no poller.
pub fn runtime() -> io::Result<Runtime> {
    Builder::new_multi_thread()
        .worker_threads(1)
        .thread_name("server")
        .enable_all()
        .build()
}
