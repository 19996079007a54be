//! The server as shipped, in front of trivial robots.

use std::net::Ipv4Addr;
use std::sync::Arc;

use anyhow::Result;
use server::config::{CellSection, RobotSection, ServerSection};
use server::{Plan, Seams, SharedJournal, SystemClock, TcpConnector};
use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use crate::processes;

/// Serves until the parent goes away. Robot `i` is the trivial robot on port `first_port + i`.
pub(crate) async fn run(first_port: u16, robots: usize) -> Result<()> {
    // The subscriber of the shipped binary, at its default level: logging is part of the cost.
    tracing_subscriber::fmt()
        .with_env_filter("info")
        .with_writer(std::io::stderr)
        .init();
    let mut sections = Vec::new();
    for index in 0..robots {
        let address = format!("127.0.0.1:{}", first_port + u16::try_from(index)?);
        let mut robot = RobotSection::new(format!("r{index}"), "fanuc-m20ia", address);
        // Every connection of the load may wait: this measures throughput, not refusals.
        robot.queue_capacity = 1_000;
        sections.push(robot);
    }
    let cell = CellSection {
        id: "bench".to_owned(),
        name: None,
        setup: None,
        push_urls: std::collections::BTreeMap::new(),
        robots: sections,
    };
    let server = ServerSection {
        demo: true,
        legacy_robot: Some("bench/r0".to_owned()),
        // The whole load comes from one address, and may begin all at once.
        max_waiting_per_address: 1_000,
        ..ServerSection::default()
    };
    let plan = Plan::try_new(&server, &[cell])?;
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
    let port = listener.local_addr()?.port();
    let stop = CancellationToken::new();
    let seams = Seams {
        connector: TcpConnector::default(),
        clock: Arc::new(SystemClock),
        journal: SharedJournal::volatile(),
    };
    let served = tokio::spawn(server::run(listener, plan, seams, stop.clone()));
    processes::announce_and_wait(port).await?;
    stop.cancel();
    served.await??;
    Ok(())
}
