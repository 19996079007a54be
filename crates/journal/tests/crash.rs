//! The process is killed at any moment; what it was told is durable is there.
//!
//! The child is this test binary, started again with the name of the test that plays it.
#![allow(
    clippy::unwrap_used,
    clippy::indexing_slicing,
    clippy::print_stdout,
    reason = "a test's helpers fail as its tests do"
)]

mod common;

use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};
use std::sync::Arc;

use common::{at, audit, directory, intent, open};
use journal::{Begun, Epoch, Head, Journal, Position, verify};

const LOOPS: u32 = 30;
const PATH: &str = "JOURNAL_CRASH_PATH";

/// Not a test by itself: appends for ever, four at a time, and prints each head it was given.
#[test]
fn child() {
    let Some(path) = std::env::var_os(PATH) else {
        return;
    };
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .enable_all()
        .worker_threads(2)
        .build()
        .unwrap();
    runtime.block_on(async {
        let journal = Arc::new(open(path.as_ref()).await);
        let tasks: Vec<_> = (0..4)
            .map(|task| tokio::spawn(append_for_ever(Arc::clone(&journal), task)))
            .collect();
        for task in tasks {
            task.await.unwrap();
        }
    });
}

async fn append_for_ever(journal: Arc<impl Journal>, task: u128) {
    let epoch = journal.epoch();
    for n in 0_u64.. {
        let name = (u128::from(epoch.0) << 64) | (task << 60) | u128::from(n);
        let mut intent = intent(epoch, 1, None);
        intent.motion = common::motion(name);
        let Begun::New(permission) = journal.begin_motion(at(n), intent).await.unwrap() else {
            panic!("no key was given");
        };
        println!(
            "{}",
            serde_json::to_string(&permission.receipt().head).unwrap()
        );
        let appended = journal.append(at(n), audit(n)).await.unwrap();
        let journal::Appended::New(receipt) = appended else {
            panic!("no key was given");
        };
        println!("{}", serde_json::to_string(&receipt.head).unwrap());
    }
}

/// Covers: P2, D6.
#[test]
fn every_confirmed_record_is_there_after_the_process_was_killed() {
    let (_directory, path) = directory();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    // Different numbers of lines are different moments: within an append, a group, a copy of the log.
    let mut state = 0x2545_f491_u32;
    for round in 1..=LOOPS {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let lines = 1 + (state >> 16) % 200;
        let confirmed = run_and_kill(&path, lines);
        runtime.block_on(check(&path, &confirmed, Epoch(round.into())));
    }
}

/// Runs the child until it has printed so many lines, kills it, and returns every head it printed.
fn run_and_kill(path: &std::path::Path, lines: u32) -> Vec<Head> {
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["child", "--exact", "--nocapture"])
        .env(PATH, path)
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let output = BufReader::new(child.stdout.take().unwrap());
    let mut confirmed = Vec::new();
    for line in output.lines() {
        // The test harness prints lines of its own, and the last one may be cut.
        let line = line.unwrap();
        let Some(json) = line.find('{').map(|start| &line[start..]) else {
            continue;
        };
        let Ok(head) = serde_json::from_str::<Head>(json) else {
            continue;
        };
        confirmed.push(head);
        if u32::try_from(confirmed.len()).unwrap() == lines {
            child.kill().unwrap();
        }
    }
    assert!(!child.wait().unwrap().success());
    assert!(u32::try_from(confirmed.len()).unwrap() >= lines);
    confirmed
}

async fn check(path: &std::path::Path, confirmed: &[Head], epoch: Epoch) {
    let known = confirmed.iter().max_by_key(|head| head.position).copied();
    let report = verify(path, known).await.unwrap();
    assert_eq!(report.epoch, epoch);
    let mut lines = Vec::new();
    let _head = journal::export(path, &mut lines).await.unwrap();
    let rows: Vec<_> = lines
        .split(|byte| *byte == b'\n')
        .filter(|line| !line.is_empty())
        .zip(1..)
        .map(|(line, number)| journal::read_line(line, number).unwrap())
        .collect();
    for head in confirmed {
        let Position(place) = head.position;
        let row = &rows[usize::try_from(place).unwrap() - 1];
        assert_eq!((row.position, row.hash), (head.position, head.hash));
    }
}
