//! The plug pulled in each row of a workflow, of a server in this process or of one of its own.

use serde_json::Value;

use crate::kit::{A_JOB, SETUP, TestCell};

/// Rows of workflow A as a job shows them.
const A: [&str; 15] = [
    "A1", "A2", "A3", "A4", "A5", "A6", "A7", "A8", "A9", "A10", "A12", "A13", "A14", "A15", "A16",
];
/// Rows of workflow B. All of the arm's way to a load and back is B4.
const B: [&str; 13] = [
    "B1", "B2", "B3", "B5", "B6", "B7", "B8", "B9", "B10", "B11", "B12", "B13-B14", "B15",
];

/// Whether a job is at a row, or past it.
fn is_at(job: &Value, code: &str) -> bool {
    let steps: Vec<_> = job["steps"].as_array().into_iter().flatten().collect();
    let step = steps.iter().find(|step| step["code"] == code);
    step.is_some_and(|step| step["state"] != "PENDING")
}

/// Pulls the plug at each row of a job.
async fn at_every_row(cell: &mut TestCell, job: &str, rows: &[&str]) -> Vec<String> {
    let mut shown = Vec::new();
    for row in rows {
        let path = format!("/jobs/{job}");
        let at = cell
            .wait(&format!("row {row}"), A_JOB, async |cell| {
                let _said = cell.answer_everything().await;
                let job = cell.get(&path).await;
                let over = matches!(job["state"].as_str(), Some("COMPLETE" | "STOPPED"));
                (over || is_at(&job, row)).then_some(job)
            })
            .await;
        shown.push(format!("{row}: {}", at["code"]));
        cell.crash().await;
    }
    shown
}

/// A set-up for [`pickup`]: a mobile robot gives away all it has at a destination, so here it comes empty.
pub(crate) fn empty_mobile_robot() -> String {
    let on = "on = { mobile_robot = \"mr1\", slot = \"left\" }";
    assert!(SETUP.contains(on), "load-1 is on mr1");
    SETUP.replace(on, "place = \"rack/d\"")
}

/// A crash in each row of a delivery.
pub(crate) async fn delivery(mut cell: TestCell) {
    let job = cell.delivery("rack/d").await;
    survives(&mut cell, &job, &A).await;
}

/// A crash in each row of a pickup.
pub(crate) async fn pickup(mut cell: TestCell) {
    let job = cell.pickup().await;
    survives(&mut cell, &job, &B).await;
}

async fn survives(cell: &mut TestCell, job: &str, rows: &[&str]) {
    let shown = at_every_row(cell, job, rows).await;
    let (ended, said) = cell.see_through(job).await;
    eprintln!("{shown:?}\n{said:#?}");
    assert_eq!(ended["state"], "COMPLETE", "{ended:#}");
    let story = cell.assert_story(job).await;
    assert!(
        story.permits_withdrawn > 0 && story.asked_after > 0,
        "{story:?}"
    );
    cell.assert_sound().await;
}
