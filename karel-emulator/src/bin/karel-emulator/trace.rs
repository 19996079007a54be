//! `karel-emulator trace`: the lines that programs execute.

#![expect(
    clippy::indexing_slicing,
    reason = "a JSON value is null where it has no such key"
)]

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use serde_json::{Value, json};

use crate::http::{Panel, clean, escape, put};
use crate::remote::word;

/// Trace the lines that the programs of a running controller execute.
///
/// The trace is switched on, what was executed is printed for some time, and the trace is switched off. A traced task
/// costs more of this machine's time and no controller time.
#[derive(Debug, clap::Args)]
pub(crate) struct Trace {
    #[command(flatten)]
    panel: Panel,
    /// Only this task.
    #[arg(long, value_name = "NAME")]
    task: Option<String>,
    /// For so many seconds, up to 86400.
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=86_400))]
    seconds: u64,
    /// End after so many lines.
    #[arg(long, value_name = "N")]
    lines: Option<u64>,
    /// A source whose text is shown beside its lines; can be given several times.
    #[arg(long = "source", value_name = "FILE")]
    sources: Vec<PathBuf>,
    /// Print a JSON object for each line instead.
    #[arg(long)]
    json: bool,
}

/// How often is asked for new lines.
const LOOK: Duration = Duration::from_millis(100);

impl Trace {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        let sources = self.read_sources()?;
        let mut on = json!({"on": true});
        if let Some(task) = &self.task {
            on["task"] = json!(task);
        }
        let first = self.panel.put("/api/v1/trace", &on)?;
        let before = first["next"].as_u64().unwrap_or(0);
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .context("starting the runtime")?;
        let followed = runtime.block_on(self.follow(before, &sources));
        let off = self.panel.put("/api/v1/trace", &json!({"on": false}));
        followed?;
        let _off = off?;
        Ok(ExitCode::SUCCESS)
    }

    async fn follow(&self, mut after: u64, sources: &Sources) -> anyhow::Result<()> {
        let end = tokio::time::Instant::now() + Duration::from_secs(self.seconds);
        let mut left = self.lines.unwrap_or(u64::MAX);
        let interrupted = tokio::signal::ctrl_c();
        tokio::pin!(interrupted);
        loop {
            let path = format!("/api/v1/trace?after={}", escape(&after.to_string()));
            let list = self.panel.get(&path)?;
            let dropped = list["dropped"].as_u64().unwrap_or(0);
            if dropped > after && !self.json {
                put(&format!(".. {} lines were not kept\n", dropped - after));
            }
            for line in list["lines"].as_array().into_iter().flatten() {
                if left == 0 {
                    return Ok(());
                }
                left -= 1;
                self.show(line, sources);
            }
            after = list["next"].as_u64().unwrap_or(after);
            let now = tokio::time::Instant::now();
            if left == 0 || now >= end {
                return Ok(());
            }
            tokio::select! {
                _ = &mut interrupted => return Ok(()),
                () = tokio::time::sleep_until((now + LOOK).min(end)) => {}
            }
        }
    }

    fn show(&self, line: &Value, sources: &Sources) {
        if self.json {
            put(&format!("{line}\n"));
            return;
        }
        let program = word(&line["program"]);
        let number = line["line"].as_u64().unwrap_or(0);
        let text = sources
            .get(&(program.clone(), number))
            .map_or("", String::as_str);
        let shown = format!(
            "{:>10.3} s  {:<12} {program}:{number:<5} {}",
            line["time_s"].as_f64().unwrap_or(0.0),
            word(&line["task"]),
            clean(text),
        );
        put(&format!("{}\n", shown.trim_end()));
    }

    fn read_sources(&self) -> anyhow::Result<Sources> {
        let mut sources = Sources::new();
        for path in &self.sources {
            let bytes =
                std::fs::read(path).with_context(|| format!("reading {}", path.display()))?;
            let text: String = bytes.iter().map(|&byte| char::from(byte)).collect();
            let name = program_of(&text).unwrap_or_default();
            for (line, number) in text.lines().zip(1..) {
                let _new = sources.insert((name.clone(), number), line.trim_end().to_owned());
            }
        }
        Ok(sources)
    }
}

/// Lines by program and number.
type Sources = BTreeMap<(String, u64), String>;

/// The name after PROGRAM, upper case.
fn program_of(text: &str) -> Option<String> {
    let mut lines = text.lines().map(|line| line.trim().to_ascii_uppercase());
    lines.find_map(|line| {
        let name = line.strip_prefix("PROGRAM")?.trim();
        let name: String = name
            .chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect();
        (!name.is_empty()).then_some(name)
    })
}
