//! Cases in `tests/cases`: a program, `.kl` or `.ls`, and what the whole controller makes of it, `.out`.
//!
//! Beside what the program writes to the screen there is what the controller wants done outside, what the arm did, the
//! alarms and how the tasks stand after a minute. Times are left out. Lines of the source that begin with `-->` (in a
//! listing, with `!-->` as a remark) are the script, done one after the other: `load FILE` (of `more`, before the start), `advance MS`,
//! `set ITEM=VALUE`, `connect TAG`, `send TEXT` (`\n`, `\r`), `close`, `operate JSON`, `fault JSON`. `UPDATE_GOLDEN=1` rewrites.

#![expect(
    clippy::unwrap_used,
    reason = "helpers of tests, where a failure is a failed test"
)]

use std::fmt::Write as _;
use std::fs;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use karel_emulator::controller::Advance;
use karel_emulator::effects::{ConnectionId, Effect, Event, Tag};
use karel_emulator::{Controller, ControllerConfig, ProgramSource, ScreenSink};
use kinematics::ArmModel;

#[test]
fn golden_cases_give_what_they_gave() {
    let mut cases: Vec<PathBuf> = fs::read_dir(folder())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    cases.retain(|path| {
        path.extension()
            .is_some_and(|end| end == "kl" || end == "ls")
    });
    cases.sort();
    assert!(cases.len() >= 8, "the cases are missing");
    let update = std::env::var_os("UPDATE_GOLDEN").is_some();
    let mut differences = String::new();
    for path in cases {
        let found = outcome(&path);
        let golden = path.with_extension("out");
        if update {
            fs::write(&golden, &found).unwrap();
            continue;
        }
        let expected = fs::read_to_string(&golden).unwrap_or_default();
        if expected != found {
            let name = path.display();
            let _ = writeln!(
                differences,
                "== {name}\n-- expected\n{expected}-- found\n{found}"
            );
        }
    }
    assert!(differences.is_empty(), "{differences}");
}

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases")
}

fn source(path: &Path) -> ProgramSource {
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    ProgramSource::new(name, fs::read(path).unwrap())
}

/// The lines of the script.
fn script(text: &[u8]) -> Vec<String> {
    let text = String::from_utf8_lossy(text).into_owned();
    let lines = text.lines().filter_map(|line| line.split_once("--> "));
    lines
        .map(|(_, step)| step.trim_end_matches([' ', ';']).to_owned())
        .collect()
}

struct Case {
    core: Controller,
    written: Arc<Mutex<Vec<u8>>>,
    shown: usize,
    ledger: u64,
    open: u64,
    now: Duration,
    out: String,
}

fn outcome(path: &Path) -> String {
    let model = ArmModel::builtin("fanuc-m20ia").unwrap();
    let program = source(path);
    let steps = script(&program.text);
    let mut config = ControllerConfig::new("golden", model).with_program(program);
    for step in &steps {
        if let Some(file) = step.strip_prefix("load ") {
            config
                .programs
                .push(source(&folder().join("more").join(file)));
        }
    }
    let written = Arc::new(Mutex::new(Vec::new()));
    let sink = written.clone();
    config.screen = Some(ScreenSink(Arc::new(move |bytes: &[u8]| {
        sink.lock().unwrap().extend_from_slice(bytes);
    })));
    let mut case = Case {
        core: Controller::try_new(&config).unwrap_or_else(|error| panic!("{error}")),
        written,
        shown: 0,
        ledger: 0,
        open: 0,
        now: Duration::ZERO,
        out: String::new(),
    };
    case.advance(0);
    for step in steps.iter().filter(|step| !step.starts_with("load ")) {
        let _ = writeln!(case.out, "> {step}");
        case.step(step);
    }
    case.advance(60_000);
    case.end()
}

impl Case {
    fn step(&mut self, step: &str) {
        let (word, rest) = step.split_once(' ').unwrap_or((step, ""));
        match word {
            "advance" => return self.advance(rest.parse().unwrap()),
            "set" => {
                let (item, value) = rest.split_once('=').unwrap();
                self.core.set_item(item, value).unwrap();
            }
            "operate" => {
                let operation = serde_json::from_str(rest).unwrap();
                if let Err(refused) = self.core.operate(operation) {
                    let _ = writeln!(self.out, "refused: {refused}");
                }
            }
            "fault" => {
                let _id = self
                    .core
                    .inject(serde_json::from_str(rest).unwrap())
                    .unwrap();
            }
            "connect" => {
                self.open += 1;
                self.core.event(Event::Connected {
                    tag: Tag::parse(rest).unwrap(),
                    connection: ConnectionId(self.open),
                    peer: SocketAddr::from(([127, 0, 0, 1], 4000)),
                });
            }
            "send" => {
                let text = rest.replace("\\n", "\n").replace("\\r", "\r");
                self.core.event(Event::Bytes {
                    connection: ConnectionId(self.open),
                    bytes: text.into_bytes(),
                    request_id: None,
                });
            }
            "close" => self.core.event(Event::PeerClosed {
                connection: ConnectionId(self.open),
            }),
            other => panic!("unknown step {other:?}"),
        }
        self.advance(0);
    }

    fn advance(&mut self, ms: u64) {
        self.now += Duration::from_millis(ms);
        while self.core.advance(self.now) == Advance::Worked {
            self.note();
        }
        self.note();
    }

    /// What happened since it was looked last.
    fn note(&mut self) {
        let written = self.written.lock().unwrap();
        let new = written.get(self.shown..).unwrap_or_default();
        if !new.is_empty() {
            for line in new.split_inclusive(|byte| *byte == b'\n') {
                let _ = writeln!(self.out, "screen: {}", line.escape_ascii());
            }
            self.shown = written.len();
        }
        drop(written);
        for effect in self.core.take_effects() {
            let line = match effect {
                Effect::Accept { tag, port } => format!("accept {tag} {port}"),
                Effect::Connect { tag, server } => format!("connect {tag} {server}"),
                Effect::Keep { name, bytes } => {
                    let size = bytes.map_or("gone".to_owned(), |b| format!("{} bytes", b.len()));
                    format!("keep {name} {size}")
                }
                Effect::StopAccepting { tag } => format!("stop accepting {tag}"),
                Effect::StopListening { tag } => format!("stop listening {tag}"),
                Effect::Send { connection, bytes } => {
                    format!("send {} {}", connection.0, bytes.escape_ascii())
                }
                Effect::Reset { connection } => format!("reset {}", connection.0),
                Effect::Close { connection } => format!("close {}", connection.0),
            };
            let _ = writeln!(self.out, "{line}");
        }
        for entry in self.core.ledger(self.ledger) {
            self.ledger = entry.seq;
            let event = format!("{:?}", entry.event).to_lowercase();
            let place = format!("{:?} {:?}", entry.program, entry.line);
            let place = place.replace("Some(", "").replace([')', '"'], "");
            let _ = writeln!(self.out, "arm: {event} {} {place}", entry.motion);
        }
    }

    fn end(mut self) -> String {
        for alarm in self.core.alarms() {
            let severity = format!("{:?}", alarm.severity).to_lowercase();
            let _ = writeln!(self.out, "alarm ({severity}): {}", alarm.headline());
        }
        let state = self.core.state();
        for task in state.tasks {
            let word = format!("{:?}", task.state).to_lowercase();
            let detail = task
                .detail
                .map_or(String::new(), |detail| format!(": {detail}"));
            let _ = writeln!(
                self.out,
                "task {} {word} line {}{detail}",
                task.name, task.line
            );
        }
        // Not -0.0: which side of zero a rounding falls on is the processor's business.
        let [x, y, z] = [state.pose.x_mm, state.pose.y_mm, state.pose.z_mm]
            .map(|mm| (mm * 10.0).round() / 10.0 + 0.0);
        let _ = writeln!(self.out, "tool at {x:.1} {y:.1} {z:.1}");
        self.out
    }
}
