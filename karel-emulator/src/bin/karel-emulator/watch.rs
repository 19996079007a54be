//! `karel-emulator watch`: the controller on a terminal, as it happens.

#![expect(
    clippy::indexing_slicing,
    reason = "a JSON value is null where it has no such key"
)]

use std::fmt::Write as _;
use std::io::IsTerminal as _;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use serde_json::Value;
use tokio::signal::unix::{SignalKind, signal};

use crate::http::{LinkError, Panel, clean, put};
use crate::remote::word;

/// Watch a running controller: tasks, joints, connections, I/O, alarms, faults, until Ctrl-C.
///
/// On a terminal the picture stays in place; elsewhere each picture follows the one before, when something has changed.
#[derive(Debug, clap::Args)]
pub(crate) struct Watch {
    #[command(flatten)]
    panel: Panel,
    /// Milliseconds between two looks, 50 to 60000.
    #[arg(long, default_value_t = 250, value_name = "MS", value_parser = clap::value_parser!(u64).range(50..=60_000))]
    interval_ms: u64,
    /// Only so many looks.
    #[arg(long, value_name = "N")]
    count: Option<u64>,
}

/// The other screen of the terminal, without a cursor.
const ENTER: &str = "\x1b[?1049h\x1b[?25l";
const LEAVE: &str = "\x1b[?25h\x1b[?1049l";
/// To the first place; and from there everything is gone.
const HOME: &str = "\x1b[H";
const REST: &str = "\x1b[J";
/// The rest of the line is gone.
const LINE_REST: &str = "\x1b[K";

impl Watch {
    pub(crate) fn run(&self) -> anyhow::Result<ExitCode> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .context("starting the runtime")?;
        let terminal = std::io::stdout().is_terminal();
        if terminal {
            put(ENTER);
        }
        let watched = runtime.block_on(self.watch(terminal));
        if terminal {
            put(LEAVE);
        }
        watched
    }

    async fn watch(&self, terminal: bool) -> anyhow::Result<ExitCode> {
        let mut interrupt = signal(SignalKind::interrupt()).context("listening for interrupts")?;
        let mut terminate = signal(SignalKind::terminate()).context("listening for termination")?;
        let mut ticks = tokio::time::interval(Duration::from_millis(self.interval_ms));
        ticks.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        let mut last = String::new();
        let mut looks = 0;
        loop {
            tokio::select! {
                _ = interrupt.recv() => return Ok(ExitCode::SUCCESS),
                _ = terminate.recv() => return Ok(ExitCode::SUCCESS),
                _ = ticks.tick() => {}
            }
            let picture = page(self.panel)?;
            if terminal {
                put(&in_place(&picture, size()));
            } else if picture != last {
                put(&picture);
                put("\n");
                last = picture;
            }
            looks += 1;
            if self.count.is_some_and(|count| looks >= count) {
                return Ok(ExitCode::SUCCESS);
            }
        }
    }
}

/// Columns and rows of the terminal.
fn size() -> (usize, usize) {
    let size = rustix::termios::tcgetwinsize(std::io::stdout()).ok();
    let size = size.filter(|size| size.ws_col > 0 && size.ws_row > 0);
    size.map_or((100, 40), |size| (size.ws_col.into(), size.ws_row.into()))
}

/// The picture over the one before: lines are cut at the edge, and what does not fit says so.
fn in_place(picture: &str, (columns, rows): (usize, usize)) -> String {
    let lines: Vec<&str> = picture.lines().collect();
    let fits = lines.len() <= rows;
    let room = if fits { rows } else { rows.saturating_sub(1) };
    let mut text = HOME.to_owned();
    for (index, line) in lines.iter().take(room).enumerate() {
        if index > 0 {
            text.push('\n');
        }
        text.extend(line.chars().take(columns));
        text.push_str(LINE_REST);
    }
    if !fits {
        let more = format!("\n.. {} more lines", lines.len() - room);
        text.extend(more.chars().take(columns + 1));
        text.push_str(LINE_REST);
    }
    text.push_str(REST);
    text
}

/// Notes that are shown, the newest.
const NOTES: u64 = 5;

/// The controller as text.
pub(crate) fn page(panel: Panel) -> Result<String, LinkError> {
    let state = panel.get("/api/v1/state")?;
    let tasks = panel.get("/api/v1/tasks")?;
    let alarms = panel.get("/api/v1/alarms?limit=5")?;
    let faults = panel.get("/api/v1/faults")?;
    let screen = panel.get("/api/v1/screen")?;
    let mut text = picture(&state, &tasks, &alarms, &faults, &screen);
    if let Some(newest) = state["note_seq"].as_u64().filter(|newest| *newest > 0) {
        let after = newest.saturating_sub(NOTES);
        let notes = panel.get(&format!("/api/v1/notes?after={after}"))?;
        note_lines(&mut text, &notes);
    }
    hint_lines(&mut text, &state);
    Ok(text)
}

/// What a kind controller has said.
fn note_lines(text: &mut String, notes: &Value) {
    line(text, "NOTES");
    for note in list(notes, "notes") {
        let time = note["time_s"].as_f64().unwrap_or(0.0);
        let place = match note["program"].as_str() {
            Some(program) => format!("{program}:{}  ", word(&note["line"])),
            None => String::new(),
        };
        let times = note["times"].as_u64().filter(|times| *times > 1);
        let times = times.map_or(String::new(), |times| format!("  ({times} times)"));
        let told = word(&note["text"]);
        line(text, &format!("  {time:>9.3} s  {place}{told}{times}"));
    }
}

/// Why what tasks of a kind controller wait for may take long.
fn hint_lines(text: &mut String, state: &Value) {
    for task in list(state, "tasks") {
        if let Some(hint) = task["hint"].as_str() {
            line(text, &format!("  {} waits: {hint}", word(&task["name"])));
        }
    }
}

fn picture(state: &Value, tasks: &Value, alarms: &Value, faults: &Value, screen: &Value) -> String {
    let mut text = String::new();
    heading(&mut text, state);
    joints(&mut text, state);
    task_lines(&mut text, tasks);
    let tags = list(state, "tags");
    if !tags.is_empty() {
        line(&mut text, "CONNECTIONS");
        for tag in tags {
            let port = word(&tag["port"]);
            let peer = word(&tag["peer"]);
            line(
                &mut text,
                &format!(
                    "  {:<4} port {port:<6} {:<10} {peer}",
                    word(&tag["tag"]),
                    word(&tag["state"])
                ),
            );
        }
    }
    let ports = list(state, "ports");
    if !ports.is_empty() {
        line(&mut text, "I/O THAT IS NOT OFF");
        let ports: Vec<String> = ports
            .iter()
            .map(|port| format!("{}={}", word(&port["port"]), word(&port["value"])))
            .collect();
        for row in ports.chunks(6) {
            line(&mut text, &format!("  {}", row.join("  ")));
        }
    }
    let alarms = list(alarms, "alarms");
    line(
        &mut text,
        &format!("ALARMS  {} active", word(&state["active_alarms"])),
    );
    for alarm in alarms.iter().rev() {
        let mark = if alarm["active"] == true { "!" } else { " " };
        let number = alarm["number"].as_u64().unwrap_or(0);
        line(
            &mut text,
            &format!(
                "{mark} {:>9.3} s  {}-{number:03}  {:<5}  {}",
                alarm["time_s"].as_f64().unwrap_or(0.0),
                word(&alarm["facility"]),
                word(&alarm["severity"]),
                word(&alarm["text"]),
            ),
        );
    }
    let faults = list(faults, "faults");
    if !faults.is_empty() {
        line(&mut text, "FAULTS THAT WERE INJECTED");
        for fault in faults {
            line(&mut text, &format!("  {}", crate::fault::in_words(fault)));
        }
    }
    let screen = list(screen, "lines");
    if !screen.is_empty() {
        line(&mut text, "USER SCREEN");
        for shown in screen.iter().rev().take(5).rev() {
            line(&mut text, &format!("  {}", word(shown)));
        }
    }
    text
}

fn heading(text: &mut String, state: &Value) {
    let mut lamps = vec![
        word(&state["mode"]),
        format!("override {} %", word(&state["override_percent"])),
    ];
    for (key, wanted, lamp) in [
        ("moving", true, "MOVES"),
        ("held", true, "HELD"),
        ("hold", true, "HOLD"),
        ("emergency_stop", true, "EMERGENCY STOP"),
        ("pendant_enabled", true, "PENDANT"),
        ("servo_power", false, "SERVO OFF"),
        ("power_on", false, "POWER OFF"),
        ("single_step", true, "STEP"),
        ("idle", true, "idle"),
    ] {
        if state[key] == wanted {
            lamps.push(lamp.to_owned());
        }
    }
    let time = state["time_s"].as_f64().unwrap_or(0.0);
    line(
        text,
        &format!(
            "{} ({})  {time:.3} s  {}",
            word(&state["controller"]),
            word(&state["model"]),
            lamps.join("  ")
        ),
    );
}

fn joints(text: &mut String, state: &Value) {
    let degrees = |joint: &str| unsigned_zero(state["joints_deg"][joint].as_f64());
    let all = ["j1", "j2", "j3", "j4", "j5", "j6"];
    let shown: Vec<String> = all
        .iter()
        .map(|joint| format!("{} {:>8.3}", joint.to_uppercase(), degrees(joint)))
        .collect();
    line(text, &format!("JOINTS  {} deg", shown.join("  ")));
    let part = |key: &str| unsigned_zero(state["pose"][key].as_f64());
    line(
        text,
        &format!(
            "POSE    X {:.3}  Y {:.3}  Z {:.3} mm  W {:.3}  P {:.3}  R {:.3} deg  {}",
            part("x_mm"),
            part("y_mm"),
            part("z_mm"),
            part("w_deg"),
            part("p_deg"),
            part("r_deg"),
            word(&state["configuration"]),
        ),
    );
}

fn task_lines(text: &mut String, tasks: &Value) {
    line(text, "TASKS");
    for task in list(tasks, "tasks") {
        let stack: Vec<String> = list(task, "calls")
            .iter()
            .map(|call| {
                let (program, routine) = (word(&call["program"]), word(&call["routine"]));
                let place = if program == routine {
                    program
                } else {
                    format!("{program}.{routine}")
                };
                format!("{place}:{}", word(&call["line"]))
            })
            .collect();
        line(
            text,
            &format!(
                "  {:<14} {:<8} {}  {}",
                word(&task["name"]),
                word(&task["state"]),
                stack.join(" < "),
                word(&task["detail"]),
            ),
        );
    }
}

/// What rounds to nothing has no sign.
fn unsigned_zero(value: Option<f64>) -> f64 {
    let value = value.unwrap_or(0.0);
    if value.abs() < 0.000_5 { 0.0 } else { value }
}

fn list<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

fn line(text: &mut String, line: &str) {
    // Writing to a String does not fail.
    let _ = writeln!(text, "{}", clean(line).trim_end());
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_cut_at_the_edges_of_the_terminal() {
        let text = in_place("abcdef\nsecond\nthird\n", (3, 2));
        assert_eq!(text, format!("{HOME}abc{LINE_REST}\n.. {LINE_REST}{REST}"));
        let text = in_place("a\nb\n", (10, 2));
        assert_eq!(text, format!("{HOME}a{LINE_REST}\nb{LINE_REST}{REST}"));
    }

    #[test]
    fn words_of_others_move_no_cursor() {
        let screen = serde_json::json!({"lines": ["a\u{1b}[2Jb"]});
        let empty = Value::Null;
        let text = picture(&empty, &empty, &empty, &empty, &screen);
        assert!(!text.contains('\u{1b}'), "{text:?}");
    }
}
