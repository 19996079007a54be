//! The server as shipped, with the limits as shipped.

use std::net::Ipv4Addr;
use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use benches::processes;
use server::config::{CellSection, JournalSection, RobotSection, ServerSection};
use server::{Plan, Seams, SystemClock, TcpConnector};
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

/// The cell's id.
pub(crate) const CELL: &str = "bench";

/// Serves until the parent goes away. Robot `r0` is at the first port, and so on.
pub(crate) async fn run(ports: &[u16], journal: &Path) -> Result<()> {
    // The subscriber of the shipped binary, at its default level: logging is part of the cost.
    tracing_subscriber::fmt()
        .with_env_filter("info")
        .with_writer(std::io::stderr)
        .init();
    let robots = ports
        .iter()
        .enumerate()
        .map(|(index, port)| {
            let address = format!("127.0.0.1:{port}");
            let mut robot = RobotSection::new(format!("r{index}"), "fanuc-m20ia", address);
            // A dead robot keeps its queue full for as long as it may.
            robot.connect_timeout_ms = 30_000;
            robot.reply_timeout_ms = 60_000;
            robot.deadline_ms = 60_000;
            robot
        })
        .collect();
    let cell = CellSection {
        id: CELL.to_owned(),
        name: None,
        robots,
        setup: None,
        push_urls: std::collections::BTreeMap::new(),
    };
    let server = ServerSection {
        demo: true,
        legacy_robot: Some(format!("{CELL}/r0")),
        ..ServerSection::default()
    };
    let plan = Plan::try_new(&server, &[cell])?;
    let section = JournalSection {
        path: Some(journal.to_owned()),
        // The report shows what this disk's fsync takes.
        allow_volatile_filesystem: true,
        ..JournalSection::default()
    };
    let seams = Seams {
        connector: TcpConnector::default(),
        clock: Arc::new(SystemClock),
        journal: server::open_journal(&section, Path::new("."), &SystemClock).await?,
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
    let port = listener.local_addr()?.port();
    let stop = CancellationToken::new();
    let served = tokio::spawn(server::run(listener, plan, seams, stop.clone()));
    processes::announce_and_wait(port).await?;
    stop.cancel();
    served.await??;
    Ok(())
}
