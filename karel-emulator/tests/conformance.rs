//! This project's own programs, observed as the three public drivers are, of which nothing is part of this repository:
//! `cargo xtask conformance --sources DIR` runs those.

#[path = "../examples/conformance/checks/mod.rs"]
mod checks;

use std::path::{Path, PathBuf};

use checks::mappdk::{Programs, with_called};
use checks::rig::Files;
use checks::table::Table;
use checks::{mappdk, seed};

fn programs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../programs")
}

fn everything_holds(table: &Table) {
    let failed: Vec<String> = table
        .failed()
        .map(|row| {
            format!(
                "{} {}: expected {:?}, seen {:?}",
                row.id, row.what, row.expected, row.seen
            )
        })
        .collect();
    assert!(failed.is_empty(), "{failed:#?}");
}

#[tokio::test]
async fn the_pose_server_is_what_its_client_expects() {
    let files = Files::read(&programs(), &["sock_server.kl"]).unwrap();
    let table = seed::observe(&files).await.unwrap();
    everything_holds(&table);
    assert!(table.rows().len() > 15);
}

/// Every public method of the client, and its errors.
#[tokio::test]
async fn the_real_fanucpy_speaks_with_our_mappdk_server() {
    let Some(python) = std::env::var_os("FANUCPY_PYTHON") else {
        eprintln!(
            "SKIPPED: FANUCPY_PYTHON names no Python with fanucpy 0.1.14; `cargo xtask test` sets it."
        );
        return;
    };
    let names = [
        "mappdk.ls",
        "mappdk_server.kl",
        "mappdk_logger.kl",
        "mappdk_move.ls",
        "mappdk_movel.ls",
    ];
    let files = with_called(Files::read(&programs(), &names).unwrap());
    let table = mappdk::observe(&files, Programs::Ours, Path::new(&python)).await;
    let table = table.unwrap();
    everything_holds(&table);
    assert!(table.rows().len() > 60);
}
