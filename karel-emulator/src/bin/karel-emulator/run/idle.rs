//! `karel-emulator run --until-idle`: a run that ends by itself and says how.

use std::io::Write as _;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Context, anyhow, bail};
use karel_emulator::config::ControllerConfig;
use karel_emulator::state::{TaskState, TaskWord};
use karel_emulator::{Clock, PeerLabels, ScreenSink, State, VirtualController};
use tokio::signal::unix::{SignalKind, signal};

use super::Run;
use crate::http::put;

/// The longest limit: ten controller days.
const MAX_LIMIT_S: f64 = 864_000.0;

impl Run {
    pub(super) async fn until_idle(
        &self,
        config: &mut ControllerConfig,
        clock: Clock,
    ) -> anyhow::Result<ExitCode> {
        if !(self.limit > 0.0 && self.limit <= MAX_LIMIT_S) {
            bail!(
                "the limit is {} s, it must be above 0 and at most {MAX_LIMIT_S}",
                self.limit
            );
        }
        config.stop_after = Some(Duration::from_secs_f64(self.limit));
        config.trace = self.trace.is_some();
        let at_line_start = Arc::new(AtomicBool::new(true));
        config.screen = Some(to_stdout(Arc::clone(&at_line_start)));
        let mut interrupt = signal(SignalKind::interrupt()).context("listening for interrupts")?;
        let mut terminate = signal(SignalKind::terminate()).context("listening for termination")?;
        let controller = VirtualController::start(config, clock, PeerLabels::new())
            .context("the controller does not start")?;
        if let Some(address) = controller.panel_address() {
            tracing::info!("The panel is at http://{address}/.");
        }
        let mut states = controller.subscribe();
        let limit = self.limit;
        let over = |state: &State| state.idle || state.time_s >= limit;
        tokio::select! {
            _ = interrupt.recv() => bail!("it was interrupted"),
            _ = terminate.recv() => bail!("it was terminated"),
            Ok(reason) = controller.port_failure() => {
                return Err(anyhow!("{reason}. Is another controller running? --port-map chooses another port"));
            }
            found = states.wait_for(over) => drop(found.context("the controller stopped")?),
        }
        let state = controller.state().await?;
        if !at_line_start.load(Ordering::Relaxed) {
            put("\n");
        }
        if let Some(path) = &self.ledger {
            write_lines(path, &controller.ledger().await?)?;
        }
        if let Some(path) = &self.trace {
            let (lines, _) = controller.with(|core| core.trace(0, usize::MAX)).await?;
            write_lines(path, &lines)?;
        }
        let alarms = controller.alarms().await?;
        controller.shutdown().await;
        for task in &state.tasks {
            eprintln!("{}", in_words(task));
        }
        let active = alarms.iter().filter(|alarm| alarm.active);
        for alarm in active {
            eprintln!("alarm {}", alarm.headline());
        }
        let aborted = state
            .tasks
            .iter()
            .any(|task| task.state == TaskWord::Aborted);
        if !state.idle {
            eprintln!("still running after {limit} s of controller time");
        }
        Ok(if aborted || state.active_alarms > 0 || !state.idle {
            ExitCode::from(1)
        } else {
            ExitCode::SUCCESS
        })
    }
}

/// What programs write goes out as it comes, without what moves a cursor.
fn to_stdout(at_line_start: Arc<AtomicBool>) -> ScreenSink {
    ScreenSink(Arc::new(move |bytes| {
        let shown = |byte: &&u8| **byte == b'\n' || !byte.is_ascii_control();
        let text: String = bytes
            .iter()
            .filter(shown)
            .map(|&byte| char::from(byte))
            .collect();
        if let Some(last) = text.chars().last() {
            at_line_start.store(last == '\n', Ordering::Relaxed);
            put(&text);
        }
    }))
}

fn in_words(task: &TaskState) -> String {
    let TaskState {
        name,
        program,
        line,
        detail,
        ..
    } = task;
    let detail = detail.as_deref().unwrap_or("runs");
    match task.state {
        TaskWord::Ended => format!("task {name} ended"),
        TaskWord::Aborted => format!("task {name} was aborted: {detail}"),
        TaskWord::Running | TaskWord::Waiting => {
            format!("task {name} {detail}, at line {line} of {program}")
        }
    }
}

/// One JSON object a line.
fn write_lines<T: serde::Serialize>(path: &Path, entries: &[T]) -> anyhow::Result<()> {
    let writing = || format!("writing {}", path.display());
    let file = std::fs::File::create(path).with_context(writing)?;
    let mut file = std::io::BufWriter::new(file);
    for entry in entries {
        let line = serde_json::to_string(entry).with_context(writing)?;
        writeln!(file, "{line}").with_context(writing)?;
    }
    file.flush().with_context(writing)
}
