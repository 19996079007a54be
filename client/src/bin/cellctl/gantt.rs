//! The phases of a job over time, as a drawing.

use std::fmt::Write as _;

use api::{JobReport, JobSimulation, PhaseKind, PhaseReport};

use crate::job::seconds;
use crate::text::{whole_seconds, word};

/// All in pixels.
const ROW: f64 = 26.0;
const BAR: f64 = 16.0;
const LEFT: f64 = 300.0;
const CHART: f64 = 720.0;
const RIGHT: f64 = 90.0;
const TOP: f64 = 64.0;
/// Between two marks of the axis, at least.
const MARK: f64 = 70.0;
/// A bar is never thinner than this: what was short was there all the same.
const THIN: f64 = 2.0;

/// Colors that differ in lightness, too, so that they are told apart in gray.
const KINDS: [(PhaseKind, &str, &str); 6] = [
    (PhaseKind::Prepare, "#8a8f98", "prepare"),
    (PhaseKind::MobileRobot, "#e0a030", "mobile robot"),
    (PhaseKind::HandOver, "#7fc4a8", "hand-over"),
    (PhaseKind::Arm, "#2f6db5", "arm"),
    (PhaseKind::Close, "#c9cdd3", "close"),
    (PhaseKind::Undo, "#b5432f", "undo"),
];

/// The phases of a job that ran.
pub(crate) fn svg(report: &JobReport) -> String {
    let Job { cell, begun } = Job::of(report);
    drawing(
        report,
        &format!("job {} in cell {cell}, begun {begun}", report.job),
    )
}

/// The phases of a job that was played in virtual time: a drawing must not pass for what really was.
pub(crate) fn svg_of_simulation(simulation: &JobSimulation) -> String {
    let violations = match simulation.violations.len() {
        0 => "no violation".to_owned(),
        count => format!("violations: {count}"),
    };
    let Job { cell, begun } = Job::of(&simulation.report);
    drawing(
        &simulation.report,
        &format!("SIMULATED in cell {cell}, from its state at {begun}; {violations}"),
    )
}

/// What both drawings say of their job.
struct Job<'a> {
    cell: &'a str,
    /// To the second: more is in the report.
    begun: String,
}

impl<'a> Job<'a> {
    fn of(report: &'a JobReport) -> Self {
        Self {
            cell: &report.cell,
            begun: whole_seconds(report.begun_at),
        }
    }
}

/// One bar a phase, its attempts side by side; the axis is in seconds from the job's beginning.
fn drawing(report: &JobReport, subtitle: &str) -> String {
    let rows = rows(report.phases.len());
    let bottom = TOP + rows * ROW;
    let (width, height) = (LEFT + CHART + RIGHT, bottom + 70.0);
    let (step, end) = axis(report.total_ms);
    let x = |ms: u64| LEFT + CHART * millis(ms) / millis(end);
    let mut svg = String::new();
    let mut line = |text: String| {
        svg.push_str(&text);
        svg.push('\n');
    };
    line(format!(
        r##"<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" viewBox="0 0 {width} {height}" font-family="system-ui, sans-serif" font-size="13" fill="#1c2026">"##
    ));
    line(format!(
        r##"<rect width="{width}" height="{height}" fill="#ffffff"/>"##
    ));
    let mut title = format!(
        "{}, {}: {} s",
        word(report.workflow),
        word(report.state),
        seconds(report.total_ms),
    );
    if report.queued_ms > 0 {
        let _ = write!(
            title,
            ", of these {} s in the queue",
            seconds(report.queued_ms)
        );
    }
    line(format!(
        r#"<text x="16" y="26" font-size="15" font-weight="600">{}</text>"#,
        escaped(&title)
    ));
    line(format!(
        r##"<text x="16" y="46" font-size="12" fill="#5a6069">{}</text>"##,
        escaped(subtitle)
    ));
    let mut mark = 0;
    while mark <= end {
        let at = x(mark);
        line(format!(
            r##"<line x1="{at:.1}" y1="{TOP}" x2="{at:.1}" y2="{bottom}" stroke="#e3e6ea"/>"##
        ));
        line(format!(
            r##"<text x="{at:.1}" y="{:.1}" text-anchor="middle" font-size="12" fill="#5a6069">{}</text>"##,
            bottom + 18.0,
            mark_text(mark, step)
        ));
        mark += step;
    }
    line(format!(
        r##"<text x="{:.1}" y="{:.1}" font-size="12" fill="#5a6069">seconds</text>"##,
        LEFT + CHART + 24.0,
        bottom + 18.0
    ));
    for (phase, row) in report.phases.iter().zip(0_u32..) {
        for text in bar(phase, TOP + f64::from(row) * ROW, &x) {
            line(text);
        }
    }
    let mut at = LEFT;
    for (kind, color, name) in KINDS {
        if report.phases.iter().any(|phase| phase.kind == kind) {
            let y = bottom + 36.0;
            line(format!(
                r#"<rect x="{at:.1}" y="{y:.1}" width="12" height="12" rx="2" fill="{color}"/>"#
            ));
            line(format!(
                r#"<text x="{:.1}" y="{:.1}" font-size="12">{name}</text>"#,
                at + 18.0,
                y + 10.5
            ));
            at += 112.0;
        }
    }
    line("</svg>".to_owned());
    svg
}

/// The name, the bars, and how long it took.
fn bar(phase: &PhaseReport, top: f64, x: &impl Fn(u64) -> f64) -> Vec<String> {
    let base = top + ROW / 2.0 + 4.5;
    let mut name = format!(
        "{} {}",
        phase.code,
        phase.phase.to_lowercase().replace('_', " ")
    );
    if let Some(place) = &phase.place {
        let _ = write!(name, ", {place}");
    }
    let color = KINDS.iter().find(|(kind, _, _)| *kind == phase.kind);
    let color = color.map_or("#1c2026", |(_, color, _)| *color);
    let mut lines = vec![format!(
        r#"<text x="{:.1}" y="{base:.1}" text-anchor="end">{}</text>"#,
        LEFT - 10.0,
        escaped(&shortened(&name))
    )];
    let mut end = x(phase.begin_ms);
    for attempt in &phase.attempts {
        let from = x(attempt.begin_ms);
        let to = x(attempt.begin_ms + attempt.duration_ms).max(from + THIN);
        let failed = matches!(
            attempt.end.as_deref(),
            Some("FAILED" | "RETRIABLE" | "REPEATED")
        );
        let outline = if failed {
            r##" fill-opacity="0.35" stroke="#b5432f" stroke-dasharray="3 2""##
        } else {
            ""
        };
        lines.push(format!(
            r#"<rect x="{from:.1}" y="{:.1}" width="{:.1}" height="{BAR}" rx="2" fill="{color}"{outline}><title>{}</title></rect>"#,
            top + (ROW - BAR) / 2.0,
            to - from,
            escaped(&format!(
                "{name}: {} s, {}",
                seconds(attempt.duration_ms),
                attempt.end.as_deref().unwrap_or("runs")
            ))
        ));
        end = end.max(to);
    }
    let tries = match phase.attempts.len() {
        0 | 1 => String::new(),
        tries => format!(", {tries} tries"),
    };
    lines.push(format!(
        r##"<text x="{:.1}" y="{base:.1}" font-size="12" fill="#5a6069">{}{tries}</text>"##,
        end + 6.0,
        seconds(phase.duration_ms)
    ));
    lines
}

/// The distance of the axis' marks and its end, in milliseconds: a round number of seconds, and few enough marks.
fn axis(total_ms: u64) -> (u64, u64) {
    let total = total_ms.max(1);
    let fits = |step: &u64| millis(total) / millis(*step) * MARK <= CHART;
    let steps = (2..9).flat_map(|power| [1, 2, 5].map(|digit| digit * 10_u64.pow(power)));
    let step = steps.clone().find(fits).or_else(|| steps.last());
    let step = step.unwrap_or(1_000);
    (step, total.div_ceil(step) * step)
}

fn mark_text(ms: u64, step: u64) -> String {
    if step.is_multiple_of(1_000) {
        (ms / 1_000).to_string()
    } else {
        seconds(ms)
    }
}

#[expect(
    clippy::cast_precision_loss,
    reason = "a picture does not need more than 52 bits"
)]
fn millis(ms: u64) -> f64 {
    ms as f64
}

fn rows(count: usize) -> f64 {
    f64::from(u16::try_from(count.max(1)).unwrap_or(u16::MAX))
}

/// As much of a name as there is room for.
fn shortened(name: &str) -> String {
    const ROOM: usize = 43;
    if name.chars().count() <= ROOM {
        return name.to_owned();
    }
    let mut short: String = name.chars().take(ROOM - 1).collect();
    short.push('…');
    short
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use api::{AttemptReport, JobState, WorkflowName};
    use jiff::Timestamp;
    use uuid::Uuid;

    use super::*;

    fn report(phases: Vec<PhaseReport>, total_ms: u64) -> JobReport {
        JobReport {
            job: Uuid::nil(),
            cell: "c".into(),
            workflow: WorkflowName::DeliveryAndPlacement,
            state: JobState::Complete,
            created_at: Timestamp::UNIX_EPOCH,
            run: 1,
            begun_at: Timestamp::UNIX_EPOCH,
            ended_at: None,
            total_ms,
            queued_ms: 0,
            cycle_ms: total_ms,
            states: Vec::new(),
            phases,
            faults: Vec::new(),
            decisions: Vec::new(),
            restarts: 0,
        }
    }

    fn phase(place: &str, attempts: &[(u64, u64)]) -> PhaseReport {
        PhaseReport {
            step: 0,
            code: "A9".into(),
            phase: "GRIP".into(),
            kind: PhaseKind::Arm,
            item: None,
            place: Some(place.into()),
            begin_ms: attempts[0].0,
            duration_ms: attempts.iter().map(|(_, took)| took).sum(),
            end: Some("SUCCEEDED".into()),
            attempts: attempts
                .iter()
                .map(|(begin_ms, duration_ms)| AttemptReport {
                    begin_ms: *begin_ms,
                    duration_ms: *duration_ms,
                    end: Some("SUCCEEDED".into()),
                    text: String::new(),
                })
                .collect(),
        }
    }

    #[test]
    fn the_axis_has_round_marks_and_not_too_many() {
        for total in [0, 1, 99, 1_000, 12_345, 61_000, 3_600_000, 90_000_000] {
            let (step, end) = axis(total);
            assert!(end >= total && end % step == 0, "{total}");
            assert!(end / step <= 11, "{total}: {} marks", end / step);
        }
        assert_eq!(axis(9_000), (1_000, 9_000));
        assert_eq!(axis(95_000), (10_000, 100_000));
    }

    #[test]
    fn every_attempt_is_a_bar_inside_the_chart_and_every_name_is_text() {
        let drawn = svg(&report(
            vec![
                phase("<rack> & \"a\"", &[(0, 500), (700, 0)]),
                phase("b", &[(900, 100)]),
            ],
            1_000,
        ));
        assert_eq!(drawn.matches(r#"height="16""#).count(), 3);
        assert!(drawn.contains("A9 grip, &lt;rack&gt; &amp; &quot;a&quot;"));
        assert!(drawn.contains("0.5, 2 tries"));
        for rect in drawn.lines().filter(|line| line.contains(r#"height="16""#)) {
            let number = |key: &str| -> f64 {
                let rest = rect.split_once(&format!(" {key}=\"")).unwrap().1;
                rest.split_once('"').unwrap().0.parse().unwrap()
            };
            let (from, width) = (number("x"), number("width"));
            assert!(
                from >= LEFT && from + width <= LEFT + CHART + THIN,
                "{rect}"
            );
            assert!(width >= THIN, "{rect}");
        }
    }

    #[test]
    fn a_job_that_never_began_has_an_empty_drawing() {
        let drawn = svg(&report(Vec::new(), 0));
        assert!(drawn.starts_with("<svg") && drawn.ends_with("</svg>\n"));
        assert!(!drawn.contains("NaN") && !drawn.contains("inf"));
    }
}
