//! Runs every variant in turn, again and again, and prints the table.

use std::time::Duration;

use anyhow::Result;

use benches::control;
use clap::ValueEnum;

use crate::load::{self, Request, Sample};
use crate::processes::{self, Part};

/// The command every request carries: the thesis's home pose, in the words of each route.
const LEGACY: &str = r#"{"x":985,"y":0,"z":940,"w":-180,"p":0,"r":0}"#;
const MOTION: &str = r#"{"type":"JOINT","target":{"pose":{"x_mm":985,"y_mm":0,"z_mm":940,"w_deg":-180,"p_deg":0,"r_deg":0}},"speed_mm_s":200}"#;
const MINIMAL: &str = "[985,0,940,-180,0,0]";

/// What is measured in turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Variant {
    /// Connect, send, receive, without a server.
    Raw,
    /// The least that can be called a bridge.
    Minimal,
    /// The tier-0 route.
    Move,
    /// The versioned route.
    Motions,
    /// A bare route.
    Bare,
}

/// What is measured, and for how long.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) repeats: usize,
    pub(crate) slice: Duration,
    pub(crate) only: Vec<Variant>,
}

/// How the connections are spread.
#[derive(Clone, Copy)]
struct Layout {
    connections: usize,
    robots: usize,
}

/// Measures and prints.
#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
pub(crate) async fn compare(connections: &[usize], plan: &Plan) -> Result<()> {
    println!(
        "requests a second (p50 / p99 in ms), medians of {} repeats of {:.1} s; ratios are medians of the repeats' ratios",
        plan.repeats,
        plan.slice.as_secs_f64()
    );
    let bare = processes::start(&["bare".to_owned()]).await?;
    for &connections in connections {
        let mut robots = vec![1, connections];
        robots.dedup();
        for robots in robots {
            let layout = Layout {
                connections,
                robots,
            };
            measure(&bare, layout, plan).await?;
        }
    }
    println!(
        "\nOne robot: its link carries one command at a time, in order, as the controller does; raw TCP and the minimal bridge do not.\n\
         A robot for each connection: like for like."
    );
    Ok(())
}

#[expect(clippy::print_stdout, reason = "this is a command-line tool's report")]
async fn measure(bare: &Part, layout: Layout, plan: &Plan) -> Result<()> {
    let Layout {
        connections,
        robots,
    } = layout;
    let slice = plan.slice;
    let wanted = |variant| plan.only.is_empty() || plan.only.contains(&variant);
    let robot = processes::start(&["robot".to_owned(), robots.to_string()]).await?;
    let first = robot.port.to_string();
    let served =
        processes::start(&["served".to_owned(), first.clone(), robots.to_string()]).await?;
    let minimal = processes::start(&["minimal".to_owned(), first]).await?;

    let legacy = |_worker| "/fanuc/move?velocity=200".to_owned();
    let motions = |worker| format!("/api/v1/cells/bench/robots/r{}/motions", worker % robots);
    let forwarded = |worker| format!("/move/{}", worker % robots);
    let hello = |_worker| "/".to_owned();
    let mut samples: [Vec<Sample>; 5] = Default::default();
    for _ in 0..plan.repeats {
        let [raw, least, moved, motion, axum] = &mut samples;
        if wanted(Variant::Raw) {
            raw.push(load::raw_tcp(robot.port, robots, connections, slice).await?);
        }
        let http = |server, path: &dyn Fn(usize) -> String, request| {
            let paths = (0..connections).map(path).collect();
            load::over_http(server, paths, request, slice)
        };
        let posted = |body, status| Request {
            body: Some(body),
            status,
            ..Request::default()
        };
        if wanted(Variant::Minimal) {
            least.push(http(&minimal, &forwarded, posted(MINIMAL, 200)).await?);
        }
        // The thesis's routes drive one robot; with several, only the versioned route spreads over them.
        if robots == 1 && wanted(Variant::Move) {
            moved.push(http(&served, &legacy, posted(LEGACY, 200)).await?);
        }
        if wanted(Variant::Motions) {
            // The thesis's routes are for whoever finds the cell free, the versioned ones for whoever has control.
            let control = control::hold(served.port, "bench").await?;
            let request = Request {
                control: Some(control.token()),
                ..posted(MOTION, 202)
            };
            motion.push(http(&served, &motions, request).await?);
            let _free = control.release().await?;
        }
        if wanted(Variant::Bare) {
            let page = Request {
                status: 200,
                ..Request::default()
            };
            axum.push(http(bare, &hello, page).await?);
        }
    }

    let plural = if robots == 1 { "" } else { "s" };
    println!("\n{connections} connections, {robots} robot{plural}");
    println!(
        "  {:<34} {:>9}  {:>15}  {:>7}  {:>10}  {:>10}",
        "", "req/s", "p50 / p99 ms", "of raw", "of minimal", "cpu us/req"
    );
    let names = [
        "raw TCP connect, send, receive",
        "minimal axum bridge",
        "POST /fanuc/move",
        "POST /api/v1/../motions",
        "bare axum route",
    ];
    let [raw, least, ..] = &samples;
    for (name, variant) in names.iter().zip(&samples) {
        if !variant.is_empty() {
            let figures = Figures::of(variant);
            println!(
                "  {name:<34} {:>9.0}  {:>6.2} / {:>6.2}  {:>6.0}%  {:>9.0}%  {:>10.1}",
                figures.per_second,
                figures.p50_ms,
                figures.p99_ms,
                ratio(variant, raw),
                ratio(variant, least),
                figures.cpu_us,
            );
        }
    }
    Ok(())
}

struct Figures {
    per_second: f64,
    p50_ms: f64,
    p99_ms: f64,
    cpu_us: f64,
}

impl Figures {
    fn of(samples: &[Sample]) -> Self {
        let middle = |part: fn(&Sample) -> f64| median(samples.iter().map(part).collect());
        Self {
            per_second: middle(|sample| sample.per_second),
            p50_ms: middle(|sample| sample.p50.as_secs_f64() * 1e3),
            p99_ms: middle(|sample| sample.p99.as_secs_f64() * 1e3),
            cpu_us: middle(|sample| sample.cpu_us),
        }
    }
}

/// The median of the repeats' ratios, in percent.
fn ratio(these: &[Sample], those: &[Sample]) -> f64 {
    let ratios = these
        .iter()
        .zip(those)
        .map(|(this, that)| this.per_second / that.per_second);
    100.0 * median(ratios.collect())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
