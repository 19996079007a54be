//! `cellctl watch`: what happens in the cell, as it happens.

use std::fmt::Write as _;
use std::io::{self, IsTerminal as _, Write as _};

use api::{CellEvent, CellStatus, EventsQuery, GapReason, JobStatus, PointStatus, TimerStatus};
use clap::Args;
use client::Told;
use uuid::Uuid;

use crate::context::Context;
use crate::failure::Failure;
use crate::job::JobRef;
use crate::report::{Exit, Report};

/// Follow what happens in the cell, one line for each event, until Ctrl-C.
///
/// On a terminal the state of the cell stands below: each job with its phase and the waits that run, both permits of
/// each point, and where the loads are. A lost connection is made again, and goes on where it was. With --json each
/// event is one line.
///
/// Examples:
///   cellctl watch
///   cellctl watch --job 12 --from 0-0
///   cellctl --json watch --types robocell.motion,robocell.load | jq .data.text
#[derive(Args, Debug)]
#[command(verbatim_doc_comment)]
pub(crate) struct WatchArgs {
    /// Only what belongs to this job: its number, or its id.
    #[arg(long, value_name = "JOB")]
    job: Option<JobRef>,
    /// Begin behind this event, `<epoch>-<position>`; 0-0 begins with the oldest that is kept.
    #[arg(long, value_name = "ID")]
    from: Option<String>,
    /// Only these types, with a comma between; `robocell.job` stands for `robocell.job.state` and all its kind.
    #[arg(long, value_name = "TYPES")]
    types: Option<String>,
}

pub(crate) async fn run(args: WatchArgs, context: &Context) -> Result<Report, Failure> {
    let cell = context.cell().await?;
    let job = match args.job {
        Some(job) => Some(job.id(&context.client.jobs(&cell)).await?),
        None => None,
    };
    let live = !context.json() && io::stdout().is_terminal();
    let query = EventsQuery {
        from: args.from,
        types: args.types,
        job,
        status: live,
    };
    let mut stream = context.client.events(&cell, query);
    let mut screen = Screen {
        json: context.json(),
        job,
        ..Screen::default()
    };
    loop {
        let told = tokio::select! {
            told = stream.next() => told?,
            _asked = tokio::signal::ctrl_c() => break,
        };
        // A reader that has gone away has seen enough.
        if screen.show(told).is_err() {
            break;
        }
    }
    Ok(Report::text(Exit::Done, ""))
}

/// What stands on the terminal.
#[derive(Debug, Default)]
struct Screen {
    json: bool,
    job: Option<Uuid>,
    status: String,
    /// Lines of the status that stand below the events.
    drawn: usize,
    lost: bool,
}

impl Screen {
    fn show(&mut self, told: Told) -> io::Result<()> {
        match told {
            Told::Event(event) if self.json => {
                let line = serde_json::to_string(&event).unwrap_or_default();
                self.line(&line)
            }
            Told::Event(event) => self.line(&line_of(&event)),
            Told::Gap(gap) => {
                let why = match gap.reason {
                    GapReason::Forgotten => "they are no longer kept",
                    GapReason::OtherJournal => "the server has another journal than before",
                    GapReason::Slow => "this terminal reads too slowly",
                };
                let text = format!("events from {} to {} are missing: {why}", gap.from, gap.to);
                self.aside(&text)
            }
            Told::Status(status) => {
                self.status = lines_of(&status, self.job);
                self.draw("")
            }
            Told::Lost(error) => {
                let first = !std::mem::replace(&mut self.lost, true);
                if first {
                    self.aside(&format!("the connection is lost, and made again: {error}"))
                } else {
                    Ok(())
                }
            }
            Told::Connected => {
                if std::mem::take(&mut self.lost) {
                    self.aside("connected again")
                } else {
                    Ok(())
                }
            }
        }
    }

    fn line(&mut self, text: &str) -> io::Result<()> {
        self.draw(&format!("{}\n", plain(text)))
    }

    /// What is no event; for programs on the other stream.
    fn aside(&mut self, text: &str) -> io::Result<()> {
        if self.json {
            return writeln!(io::stderr(), "{}", plain(text));
        }
        self.line(&format!("-- {text}"))
    }

    /// Writes `above` where the status stands, and the status below it.
    fn draw(&mut self, above: &str) -> io::Result<()> {
        let mut text = String::new();
        if self.drawn > 0 {
            // Up to the status's first line, and clear to the end of the screen.
            let _ = write!(text, "\x1b[{}A\x1b[J", self.drawn);
        }
        text.push_str(above);
        text.push_str(&self.status);
        self.drawn = self.status.lines().count();
        let mut out = io::stdout().lock();
        out.write_all(text.as_bytes())?;
        out.flush()
    }
}

/// Words of controllers, people and robots stand in events; none of them may move the cursor.
fn plain(text: &str) -> String {
    let shown = |c: char| if c.is_control() { '\u{fffd}' } else { c };
    text.chars().map(shown).collect()
}

fn line_of(event: &CellEvent) -> String {
    let time = event.time.strftime("%H:%M:%S%.3f");
    let job = event.data.job.map(|job| {
        let id = job.simple().to_string();
        format!("job ..{} ", id.get(26..).unwrap_or(&id))
    });
    format!("{time} {}{}", job.unwrap_or_default(), event.data.text)
}

/// The state of the cell in a few lines, none wider than a terminal usually is.
fn lines_of(status: &CellStatus, only: Option<Uuid>) -> String {
    let mut text = String::from("----\n");
    let jobs = status.jobs.iter();
    for job in jobs.filter(|job| only.is_none_or(|only| only == job.job)) {
        line(&mut text, &job_line(job));
    }
    for point in &status.points {
        line(&mut text, &point_line(point));
    }
    let loads = status.loads.iter();
    let loads: Vec<_> = loads
        .map(|load| format!("{}: {}", load.load, load.at))
        .collect();
    rows(&mut text, "loads", &loads);
    for question in &status.questions {
        line(&mut text, &format!("a person is needed: {question}"));
    }
    text
}

const WIDTH: usize = 78;

fn line(text: &mut String, line: &str) {
    let line = plain(line);
    let cut: String = line.chars().take(WIDTH).collect();
    text.push_str(&cut);
    if line.chars().count() > WIDTH {
        text.push('\u{2026}');
    }
    text.push('\n');
}

/// As many items a line as it holds, each line under the first.
fn rows(text: &mut String, name: &str, items: &[String]) {
    let indent = " ".repeat(name.len());
    let mut row = String::new();
    let mut name = name;
    for item in items {
        if !row.is_empty() && row.chars().count() + 3 + item.chars().count() > WIDTH {
            line(text, &row);
            row.clear();
        }
        if row.is_empty() {
            row = format!("{name}  {item}");
            name = &indent;
        } else {
            row = format!("{row} | {item}");
        }
    }
    if !row.is_empty() {
        line(text, &row);
    }
}

fn job_line(job: &JobStatus) -> String {
    let mut text = format!("job {}  {}", job.number, job.state);
    if let Some(phase) = &job.phase {
        let code = job.code.as_deref().unwrap_or("");
        let _ = write!(text, "  {code} {phase}");
    }
    for timer in &job.timers {
        let _ = write!(text, "  {}", timer_text(timer));
    }
    text
}

fn timer_text(timer: &TimerStatus) -> String {
    let seconds = |ms: u64| ms.div_ceil(1_000);
    let (left, total) = (seconds(timer.left_ms), seconds(timer.total_ms));
    format!("{} {left}/{total} s", timer.timer)
}

fn point_line(point: &PointStatus) -> String {
    let flag = |permit: bool| u8::from(permit);
    let mut text = format!(
        "point {}  ARM_ENTRY={} MR_MOVE={}",
        point.point,
        flag(point.arm_entry_permit),
        flag(point.mr_move_permit)
    );
    if let Some(session) = &point.session {
        let _ = write!(text, "  {session}");
    }
    text
}

#[cfg(test)]
mod tests {
    use api::LoadStatus;

    use super::*;

    #[test]
    fn a_status_is_a_few_lines_and_moves_no_cursor() {
        let status = CellStatus {
            jobs: vec![JobStatus {
                job: Uuid::from_u128(1),
                number: 3,
                state: "EXECUTE".to_owned(),
                phase: Some("APPROACH".to_owned()),
                code: Some("A8".to_owned()),
                timers: vec![TimerStatus {
                    timer: "operation".to_owned(),
                    left_ms: 4_001,
                    total_ms: 30_000,
                }],
            }],
            points: vec![PointStatus {
                point: "handover/front".to_owned(),
                arm_entry_permit: true,
                mr_move_permit: false,
                session: Some("TRANSFERRING".to_owned()),
            }],
            loads: (1..=4)
                .map(|n| LoadStatus {
                    load: format!("load-{n}"),
                    at: "delivered to gate".to_owned(),
                })
                .collect(),
            questions: vec![format!("F4 \x1b[2J{}", "x".repeat(100))],
        };
        let text = lines_of(&status, None);
        let lines: Vec<_> = text.lines().collect();
        assert_eq!(lines[1], "job 3  EXECUTE  A8 APPROACH  operation 5/30 s");
        assert_eq!(
            lines[2],
            "point handover/front  ARM_ENTRY=1 MR_MOVE=0  TRANSFERRING"
        );
        // Nothing of where the loads are is cut off.
        let all = lines[3..5].join(" | ");
        for n in 1..=4 {
            let load = format!("load-{n}: delivered to gate");
            assert!(all.contains(&load), "{text}");
        }
        assert!(lines[4].starts_with("       load-3"), "{text}");
        assert_eq!(lines[5].chars().count(), WIDTH + 1);
        assert!(!text.contains('\x1b'));
        let other = lines_of(&status, Some(Uuid::from_u128(2)));
        assert!(!other.contains("job 3"), "{other}");
    }
}
