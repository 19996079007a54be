//! Runs every variant in turn, again and again, and prints the table.

use std::time::Duration;

use anyhow::Result;

use crate::load::{self, Sample};
use crate::processes;

/// The command every request carries: the thesis's home pose.
const MOVE: &str = r#"{"x":985,"y":0,"z":940,"w":-180,"p":0,"r":0}"#;
const MOTION: &str = r#"{"type":"JOINT","target":{"pose":{"x_mm":985,"y_mm":0,"z_mm":940,"w_deg":-180,"p_deg":0,"r_deg":0}},"speed_mm_s":200}"#;

/// Measures and prints.
#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
pub(crate) async fn compare(connections: &[usize], repeats: usize, slice: Duration) -> Result<()> {
    println!(
        "requests a second (p50 / p99 in ms), median of {repeats} repeats of {:.1} s each; ratios are medians of the repeats' ratios",
        slice.as_secs_f64()
    );
    println!(
        "{:>5} {:>7}  {:>24} {:>24} {:>24} {:>24}  {:>9} {:>9} {:>9}",
        "conns",
        "robots",
        "raw TCP",
        "POST /fanuc/move",
        "POST motions",
        "bare axum",
        "move/raw",
        "mot./raw",
        "move/axum"
    );
    let bare = processes::start(&["bare".to_owned()]).await?;
    for &connections in connections {
        let mut layouts = vec![1, connections];
        layouts.dedup();
        for robots in layouts {
            row(bare.port, connections, robots, repeats, slice).await?;
        }
    }
    println!(
        "one robot: its link carries one command at a time, raw TCP does not; a robot for each connection: like for like."
    );
    Ok(())
}

#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
async fn row(
    bare: u16,
    connections: usize,
    robots: usize,
    repeats: usize,
    slice: Duration,
) -> Result<()> {
    let robot = processes::start(&["robot".to_owned(), robots.to_string()]).await?;
    let arguments = [
        "served".to_owned(),
        robot.port.to_string(),
        robots.to_string(),
    ];
    let served = processes::start(&arguments).await?;
    let legacy = |_worker| "/fanuc/move?velocity=200".to_owned();
    let motions = |worker| format!("/api/v1/cells/bench/robots/r{}/motions", worker % robots);
    let hello = |_worker| "/".to_owned();
    let (mut raw, mut moved, mut motion, mut axum) = (vec![], vec![], vec![], vec![]);
    for _ in 0..repeats {
        raw.push(load::raw_tcp(robot.port, robots, connections, slice).await?);
        // The thesis's routes drive one robot; with several, only the versioned route spreads over them.
        if robots == 1 {
            moved.push(
                load::over_http(served.port, legacy, Some(MOVE), 200, connections, slice).await?,
            );
        }
        motion.push(
            load::over_http(served.port, motions, Some(MOTION), 202, connections, slice).await?,
        );
        axum.push(load::over_http(bare, hello, None, 200, connections, slice).await?);
    }
    println!(
        "{connections:>5} {robots:>7}  {:>24} {:>24} {:>24} {:>24}  {:>9} {:>9} {:>9}",
        figures(&raw),
        figures(&moved),
        figures(&motion),
        figures(&axum),
        ratio(&moved, &raw),
        ratio(&motion, &raw),
        ratio(&moved, &axum),
    );
    Ok(())
}

fn figures(samples: &[Sample]) -> String {
    if samples.is_empty() {
        return "-".to_owned();
    }
    let milliseconds = |part: fn(&Sample) -> Duration| {
        median(
            samples
                .iter()
                .map(|sample| part(sample).as_secs_f64() * 1e3)
                .collect(),
        )
    };
    format!(
        "{:.0} ({:.2} / {:.2})",
        median(samples.iter().map(|sample| sample.per_second).collect()),
        milliseconds(|sample| sample.p50),
        milliseconds(|sample| sample.p99),
    )
}

fn ratio(ours: &[Sample], theirs: &[Sample]) -> String {
    if ours.is_empty() {
        return "-".to_owned();
    }
    let ratios = ours
        .iter()
        .zip(theirs)
        .map(|(ours, theirs)| ours.per_second / theirs.per_second);
    format!("{:.0} %", 100.0 * median(ratios.collect()))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
