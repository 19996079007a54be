//! What the server's process holds.

use crate::plant::LoadedPlant;
use crate::worker::Done;

/// What may be held more after the second and third third of the work than after the first.
///
/// What is kept of the past has a bound each, and is filled by work: the ring of events (8 MiB), 1,000 motions of each
/// of the 8 arms, 256 jobs, sessions and questions of each of the 4 cells, and the journal's cache of pages (2 MiB).
const FILLING_MIB: f64 = 16.0;

#[derive(Clone, Debug)]
pub(crate) struct Usage {
    pub(crate) resident_mib: f64,
    pub(crate) files: usize,
    pub(crate) threads: usize,
    pub(crate) tasks: u64,
    #[expect(dead_code, reason = "shown in the report")]
    pub(crate) journal_mib: f64,
}

impl Usage {
    pub(crate) async fn of(plant: &LoadedPlant) -> Self {
        let process = plant.server_process();
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap();
        let metrics = plant.text("/metrics").await;
        let count = |folder: &str| {
            let entries = std::fs::read_dir(format!("/proc/{process}/{folder}"));
            entries.unwrap().count()
        };
        Self {
            resident_mib: number(&status, "VmRSS:") / 1024.0,
            files: count("fd"),
            threads: count("task"),
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "a count"
            )]
            tasks: number(&metrics, "robocell_tasks") as u64,
            #[expect(clippy::cast_precision_loss, reason = "for people")]
            journal_mib: plant.journal_bytes() as f64 / 1_048_576.0,
        }
    }

    pub(crate) fn assert_no_leak_since(&self, early: &Self, done: &Done) {
        let grown = self.resident_mib - early.resident_mib;
        assert!(
            grown <= FILLING_MIB,
            "{grown:.1} MiB more after {} jobs",
            done.jobs
        );
        // All work is over at the end, so there may be fewer: a connection of each mobile robot, and of this test, may
        // have been renewed at the moment of looking.
        let renewed = 16;
        assert!(
            self.files <= early.files + renewed,
            "{self:?}, before {early:?}"
        );
        assert!(
            self.tasks <= early.tasks + renewed as u64,
            "{self:?}, before {early:?}"
        );
        // Threads for blocking work come and go with it, and are bounded by what can wait for the disk.
        assert!(
            self.threads <= early.threads + 8,
            "{self:?}, before {early:?}"
        );
    }
}

/// The number behind a name at the beginning of a line.
fn number(text: &str, name: &str) -> f64 {
    let mut lines = text.lines();
    let line = lines.find_map(|line| line.strip_prefix(name)).expect(name);
    let word = line.split_whitespace().next().expect("a number");
    word.parse().expect("a number")
}
